"""Writes the C of calls to a unit that runs in another process: for the judge, functions that stand in the
unit's place; for the unit's process, what calls the unit's functions in turn (tests/judge/judge.h).

Prototypes and structures are read from the kit's headers. What these do not say stands in
tests/judge/STEM.calls, a line for each pointer that is more than one constant value:

    FUNCTION PARAMETER in|out|inout [NUMBER]  so many values: an expression in C with the other parameters
    FUNCTION PARAMETER added                  counts that the call adds to, whatever they are
    FUNCTION PARAMETER rows NUMBER of LENGTH  pointers to so many rows, which may be NULL
    FUNCTION PARAMETER kept                   a structure with pointers that many calls read
    FUNCTION PARAMETER made MEMBER NUMBER, .. a structure that the call allocates; its pointers, and at most
                                              how many values each has
    FUNCTION returns PARAMETER                a pointer into this array
    FUNCTION together                         no judge can call it
    STRUCTURE MEMBER in NUMBER                a pointer within a structure, with its other members
    STRUCTURE MEMBER none                     one that is NULL for the unit
    ahead FUNCTION [after FUNCTION..] [but CLAIM..]
                                              no answers can be read in its requests, except those of the
                                              functions after which they come: so they may be published
                                              before the answers are known; not in these claims
    include NAME                              the lines of tests/judge/NAME.shared
    together CLAIM                            what needs unit and suite in one process, and why: # ...

What is `out` begins with bytes that are no value; what is to keep its contents is `inout`.
"""

import argparse
import os
import re
import sys

_PROTOTYPE = re.compile(r"^([A-Za-z_][\w ]*?[ *]+)(rk_\w+)\(([^()]*)\);", re.MULTILINE)
_STRUCTURE = re.compile(r"typedef struct (\w+) \{(.*?)\} (\w+);", re.DOTALL)
_INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
_INLINE = re.compile(r"^(?:__attribute__\(\(\w+\)\) )?static inline.*?^\}", re.DOTALL | re.MULTILINE)
_VALUE = re.compile(r"((?:const |unsigned )*\w+)( |[ *]*\*(?:const \*)?)(\w+)(?:\[(.*)\])?")
_ROWS = re.compile(r"(\w+) ?\(\*(\w+)\)\[\w+\]")  # a pointer to arrays
_WAYS = ("in", "out", "inout", "added", "rows", "kept", "made", "none")


class CallsError(Exception):
    """What cannot be written, as a sentence."""


class Value:
    """A parameter or a member: its type without const, its name, how many stars it has, and an array's
    length, or None. `way` is one of _WAYS, or "" if it is not known yet; `number` an expression, "" for one.
    """

    def __init__(self, text):
        found = _VALUE.fullmatch(_ROWS.sub(r"\1 *\2", text.strip()))
        if not found:
            raise CallsError(f"'{text}' is no declaration that is understood")
        kind, stars, self.name, self.length = found.groups()
        self.is_const = kind.startswith("const ")
        self.type, self.stars = kind.removeprefix("const "), stars.count("*")
        self.way, self.number, self.row, self.slot = "in" if self.is_const else "", "", "", 0

    def is_pointer(self):
        return bool(self.stars or self.length)

    def is_out(self):
        return self.way in ("out", "inout")

    def most(self):
        """Of what is made: an expression for each member, of how many values it has at most."""
        return dict(part.strip().split(" ", 1) for part in self.number.split(","))

    def count(self):
        """An expression: how many values a pointer points to."""
        return f"(size_t)({self.number or self.length or 1})"

    def declaration(self):
        stars = "*const *" if self.way == "rows" else "*" * self.stars
        length = f"[{self.length}]" if self.length else ""
        return f"{'const ' if self.is_const else ''}{self.type} {stars}{self.name}{length}"


# --- What the headers and the file of calls say -------------------------------------------------------


def _plain(text):
    """The text without comments and directives but includes."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    return re.sub(r"^#(?!include)(?:.*\\\n)*.*$", "", text, flags=re.MULTILINE)


def _members(body):
    members = []
    for declaration in filter(None, (" ".join(part.split()) for part in body.split(";"))):
        kind, names = re.match(r"((?:const )?\w+(?: \*)?) ?(.*)", declaration).groups()
        members += [Value(f"{kind} {name}".replace("* ", "*")) for name in names.split(", ")]
    return members


def _parameters(text):
    text = " ".join(text.split())
    return [] if text == "void" else [Value(part) for part in text.split(",")]


class Headers:
    """What a header declares, and the structures of those that it includes."""

    def __init__(self, source, name):
        self._source, self._seen, self.structures = source, set(), {}
        self.ahead = {}  # functions, with those that their requests depend on, and exceptions
        self.returned, self.together = {}, set()  # parameters that functions return pointers into
        text = _INLINE.sub("", self._read(name))
        self.functions = [(kind.strip(), function, _parameters(parameters))
                          for kind, function, parameters in _PROTOTYPE.findall(text)]

    def _read(self, name):
        if name in self._seen:
            return ""
        self._seen.add(name)
        with open(os.path.join(self._source, "src", name), encoding="utf-8") as file:
            text = _plain(file.read())
        for included in _INCLUDE.findall(text):
            self._read(included)
        for tag, body, structure in _STRUCTURE.findall(text):
            if tag == structure and "{" not in body:
                self.structures[structure] = _members(body)
        return text

    def apply(self, path):
        """Adds what a file of calls says."""
        owners = [*self.structures.items(), *((name, values) for _, name, values in self.functions)]
        known = {(owner, value.name): value for owner, values in owners for value in values}
        with open(path, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                words = line.split("#")[0].split(None, 3)
                if not words or words[0] == "together":
                    continue
                if words[0] == "include":
                    self.apply(os.path.join(os.path.dirname(path), words[1] + ".shared"))
                    continue
                if words[0] == "ahead":
                    self._apply_ahead(" ".join(words[1:]), f"{path}:{number}")
                    continue
                if words[1:2] == ["returns"]:
                    self.returned[words[0]] = words[2]
                    continue
                if words[1:] == ["together"]:
                    self.together.add(words[0])
                    continue
                value = known.get(tuple(words[:2]))
                if not value or len(words) < 3 or words[2] not in _WAYS:
                    raise CallsError(f"{path}:{number}: there is no such parameter or member, or its way is "
                                     f"none of {', '.join(_WAYS)}")
                value.way = words[2]
                value.number, _, value.row = ("".join(words[3:]).strip()).partition(" of ")

    def _apply_ahead(self, text, where):
        text, _, claims = text.partition(" but ")
        function, _, after = text.partition(" after ")
        numbers = {name: number for number, (_, name, _) in enumerate(self.functions)}
        unknown = [name for name in [function, *after.split()] if name not in numbers]
        if unknown:
            raise CallsError(f"{where}: there is no function {unknown[0]}")
        self.ahead[numbers[function]] = [numbers[name] for name in after.split()], claims.split()

    def after(self, number):
        """Returns a bit for each function whose answers may be read in requests of this one."""
        if number not in self.ahead:
            return (1 << 64) - 1
        taken = {value.type for value in self.functions[number][2]}
        made = [maker for maker, (_, _, values) in enumerate(self.functions)
                if any(value.way == "made" and value.type in taken for value in values)]
        return sum(1 << other for other in {*self.ahead[number][0], *made})

    def finish(self, path):
        """Checks that all is said, and numbers what is kept."""
        kept = [value for _, _, values in self.functions for value in values if value.way == "kept"]
        for slot, value in enumerate(kept):
            value.slot = slot
        for value in (value for _, _, values in self.functions for value in values if value.way == "made"):
            value.counts = {member.name: member.number for member in self.structures[value.type]}
        for kind, function, values in self.functions:
            if "*" in kind and function not in self.returned:
                raise CallsError(f"{function} returns a pointer, which means nothing in another process")
            for value in values:
                if value.is_pointer() and not value.way and function not in self.together:
                    raise CallsError(f"{path}: say whether {function}'s {value.name} is out or inout")
                if value.way in ("in", "out", "inout") and next(self.pointers(value), None):
                    raise CallsError(f"{path}: {function}'s {value.name} has pointers; say that it is kept")

    def pointers(self, value):
        """The pointers in a value's structure: a loop if it is an array of them, the pointer, and the bytes
        that it points to."""
        for member in self.structures.get(value.type, []):
            if member.stars and member.way != "none":
                pointer = f"{value.name}->{member.name}"
                number = re.sub(r"(?<!\()\b([a-z]\w*)\b", rf"{value.name}->\1", member.number)
                each = f"for (size_t i = 0; i < {member.length}; i++)\n        " if member.length else ""
                pointer += "[i]" if member.length else ""
                yield each, pointer, f"(size_t)({number}) * sizeof(*{pointer})"

    def structures_used(self):
        """Structures of parameters and results, those within others first."""
        ordered = []

        def visit(name):
            if name in self.structures and name not in ordered:
                for member in self.structures[name]:
                    if not member.stars:
                        visit(member.type)
                ordered.append(name)

        for kind, _, values in self.functions:
            for name in (kind, *(value.type for value in values if value.way != "added")):
                visit(name.removeprefix("const ").rstrip(" *"))
        return ordered


# --- The judge's side: functions in place of the unit's -----------------------------------------------


def _copier(headers, name):
    """A function that copies a structure member by member. What lies between them is whatever the judge had
    there before; a bool from the unit's process can have other bits than 0 and 1, and a text no end."""
    yield f"static inline void copy_{name}({name} *to, const {name} *from)\n{{"
    for member in headers.structures[name]:
        place, each = member.name, ""
        if member.length:
            place, each = f"{member.name}[i]", f"for (size_t i = 0; i < {member.length}; i++)\n        "
        if member.stars:
            yield f"    {each}to->{place} = NULL;"
        elif member.type in headers.structures:
            yield f"    {each}copy_{member.type}(&to->{place}, &from->{place});"
        elif member.type == "bool":
            yield f"    {each}to->{place} = *(const unsigned char *)&from->{place} != 0;"
        else:
            yield f"    {each}to->{place} = from->{place};"
        if member.type == "char" and member.length:
            yield f"    to->{member.name}[{member.length} - 1] = '\\0';"
    yield "}\n"


def _put(headers, kind, source, number, function):
    if kind not in headers.structures:
        yield f"    {function}({source}, {number} * sizeof *({source}));"
        return
    yield f"    {{\n        {kind} *to = {function}(NULL, {number} * sizeof *to);"
    yield f"        for (size_t i = 0; i < {number}; i++)"
    yield f"            copy_{kind}(&to[i], {source} + i);\n    }}"


def _put_pointer(headers, value):
    name = value.name
    if value.way == "rows":
        yield f"    for (size_t row = 0; row < {value.count()}; row++)"
        yield f"        if (rk_judge_put_whether({name}[row]))"
        yield f"            rk_judge_put_array({name}[row], (size_t)({value.row}) * sizeof *{name}[row]);"
        return
    yield f"    if (rk_judge_put_whether({name})) {{"
    if value.way == "kept":
        pointers = list(headers.pointers(value))
        yield f"        {value.type} part;\n        memset(&part, 0, sizeof part);"
        yield f"        copy_{value.type}(&part, {name});"
        yield "        rk_judge_piece pieces[RK_JUDGE_PIECES] = {{&part, sizeof part}};"
        yield "        size_t piece_count = 1;"
        for each, pointer, size in pointers:
            yield f"    {each}    if ({pointer}) {{ /* whether there is one is sent in its place */"
            yield f"            {pointer.replace(name + '->', 'part.')} = (void *)1;"
            yield f"            pieces[piece_count++] = (rk_judge_piece){{{pointer}, {size}}};\n        }}"
        yield f"        rk_judge_put_kept({value.slot}, pieces, piece_count);"
    elif value.way not in ("out", "made", "added"):
        yield from _put(headers, value.type, name, value.count(), "rk_judge_put_array")
    yield "    }"


def _get(headers, kind, target, number):
    yield f"    rk_judge_get({target}, {number} * sizeof *({target}));"
    if kind in headers.structures:
        yield f"    for (size_t i = 0; i < {number}; i++)"
        yield f"        copy_{kind}({target} + i, {target} + i);"


def _get_made(value):
    """The structure, then what its pointers point to, in memory of the judge's own."""
    name = value.name
    yield f"        {value.type} got;\n        rk_judge_get(&got, sizeof got);"
    yield f"        copy_{value.type}({name}, &got);"
    for member, most in value.most().items():
        yield f"        if (got.{member})"
        yield (f"            {name}->{member} = rk_judge_get_made((size_t)(got.{value.counts[member]}), "
               f"(size_t)({most}), sizeof *{name}->{member});")


def _bytes_of_answer(kind, outs, made):
    """An expression: at most so many, with the allocations, and each value aligned."""
    parts = ["32", *(f"{out.count()} * sizeof *{out.name} + 16" for out in outs)]
    parts += [f"sizeof *{value.name} + 16" for value in made]
    parts += [f"(size_t)({most}) * sizeof *{value.name}->{member} + 48"
              for value in made for member, most in value.most().items()]
    return " + ".join(parts + ([f"sizeof({kind}) + 16"] if kind != "void" else []))


def _disturbed(headers, kind, name, outs, arguments):
    """The reference's answer, made wrong: to see what depends on it."""
    yield f"        {kind + ' result = ' if kind != 'void' else ''}rk_reference_{name}({arguments});"
    for out in outs:
        yield f"        if ({out.name})"
        yield f"            rk_judge_disturb({out.name}, {out.count()} * sizeof *{out.name});"
    if kind != "void" and name not in headers.returned:
        yield "        rk_judge_disturb(&result, sizeof result);"
    yield "        return;\n    }" if kind == "void" else "        return result;\n    }"


def _copied(headers, kind, target, source, number):
    """Values, without what lies between the members of a structure."""
    if kind in headers.structures:
        yield f"        for (size_t i = 0; i < {number}; i++)"
        yield f"            copy_{kind}(({kind} *){target} + i, {source} + i);"
    else:
        yield f"        memcpy({target}, {source}, {number} * sizeof *({source}));"


def _noted(headers, kind, name, values, arguments):
    """The reference's answer, noted as the unit would give it; one with pointers is not."""
    call = f"rk_reference_{name}({arguments});"
    for value in values:
        if value.way == "out":
            byte = 0 if _has_text(headers, value.type) else 255
            yield f"        if ({value.name})"
            yield f"            memset({value.name}, {byte}, {value.count()} * sizeof *{value.name});"
    if not _is_noted(headers, name, values):
        yield f"        {'return ' if kind != 'void' else ''}{call}"
        yield "        return;\n    }" if kind == "void" else "    }"
        return
    added = [value for value in values if value.way == "added"]
    for value in added:
        yield f"        {value.type} before_{value.name};"
        yield f"        memset(&before_{value.name}, 0, sizeof(before_{value.name}));"
        yield f"        if ({value.name})\n            before_{value.name} = *{value.name};"
    yield f"        {kind} result = {call}" if kind != "void" else f"        {call}"
    yield "        void *note;"
    for out in (value for value in values if value.is_out()):
        yield f"        if ({out.name} && (note = rk_judge_note({out.count()} * sizeof *{out.name})))"
        yield from (" " * 4 + line for line in _copied(headers, out.type, "note", out.name, out.count()))
    for value in added:
        yield f"        if ({value.name} && (note = rk_judge_note(sizeof *{value.name}))) {{"
        yield f"            {value.type} added = *{value.name};"
        for member in headers.structures[value.type]:
            change = f"-= before_{value.name}.{member.name}" if member.type == "uint64_t" else "= 0"
            yield f"            added.{member.name} {change};"
        yield "            memcpy(note, &added, sizeof added);\n        }"
    if kind != "void":
        yield "        if ((note = rk_judge_note(sizeof result)))"
        yield from (" " * 4 + line for line in _copied(headers, kind, "note", "&result", "(size_t)1"))
    yield "        (void)note;\n        rk_judge_note_allocations();"
    yield "        return;\n    }" if kind == "void" else "        return result;\n    }"


def _is_noted(headers, name, values):
    return name not in headers.together | set(headers.returned) and all(
        value.way != "made" for value in values)


def _has_text(headers, kind):
    return any(member.type == "char" for member in headers.structures.get(kind, []))


def _stub(headers, number, kind, name, values, disturbs):
    outs = [value for value in values if value.is_out()]
    added = [value for value in values if value.way == "added"]
    made = [value for value in values if value.way == "made"]
    declared = ", ".join(value.declaration() for value in values) or "void"
    arguments = ", ".join(value.name for value in values)
    if name in headers.together:
        yield f"{kind} {name}({declared})\n{{"
        yield from (f"    (void){value.name};" for value in values)
        yield f'    rk_judge_cannot_ask("{name}");\n}}\n'
        return
    yield f"{kind} rk_reference_{name}({declared});"
    yield f"{kind} {name}({declared})\n{{\n    rk_judge_ask({number});"
    for value in values:  # before what pointers point to: they may say how much that is
        if not value.is_pointer():
            yield from _put(headers, value.type, f"&{value.name}", "(size_t)1", "rk_judge_put")
    for value in values:
        if value.is_pointer():
            yield from _put_pointer(headers, value)
    yield f"    if (rk_judge_predicts({_bytes_of_answer(kind, outs + added, made)})) {{"
    if disturbs:
        yield from _disturbed(headers, kind, name, outs, arguments)
    else:
        yield from _noted(headers, kind, name, values, arguments)
    for out in outs:
        yield f"    if ({out.name}) {{"
        yield from _get(headers, out.type, out.name, out.count())
        yield "    }"
    for value in added:
        yield f"    if ({value.name}) {{\n        {value.type} got;\n        rk_judge_get(&got, sizeof got);"
        yield from (f"        {value.name}->{member.name} += got.{member.name};"
                    for member in headers.structures[value.type])
        yield "    }"
    for value in made:
        yield f"    if ({value.name}) {{"
        yield from _get_made(value)
        yield "    }"
    if name in headers.returned:
        array = next(value for value in values if value.name == headers.returned[name])
        yield "    size_t at;\n    rk_judge_get(&at, sizeof at);"
        yield f"    {kind} result = at < {array.count()} ? {array.name} + at : NULL;"
    elif kind != "void":
        yield f"    {kind} result;"
        yield from _get(headers, kind, "&result", "(size_t)1")
    if kind == "bool":
        yield "    result = *(const unsigned char *)&result != 0;"
    yield "    rk_judge_get_allocations();"
    yield "}\n" if kind == "void" else "    return result;\n}\n"


def _ahead(headers):
    yield "const uint64_t rk_judge_after[RK_JUDGE_FUNCTIONS] = {"
    for number, (_, name, _) in enumerate(headers.functions):
        after = headers.after(number)
        yield f"    UINT64_C({after:#x}), /* {name} */"
    yield "};\n\nconst rk_judge_exception rk_judge_exceptions[] = {"
    for number, (_, claims) in headers.ahead.items():
        yield from (f'    {{{number}, "{claim}"}},' for claim in claims)
    yield "    {0, NULL},\n};\n"
    noted = sum(1 << number for number, (_, name, values) in enumerate(headers.functions)
                if _is_noted(headers, name, values))
    yield f"const uint64_t rk_judge_noted = UINT64_C({noted:#x});\n"


def judge(headers, disturbs=False):
    yield '#include "judge/judge.h"\n'
    yield from _ahead(headers)
    for name in headers.structures_used():
        yield from _copier(headers, name)
    for number, (kind, name, values) in enumerate(headers.functions):
        yield from _stub(headers, number, kind, name, values, disturbs)


def trace(headers):
    return judge(headers, True)


# --- The unit's side ----------------------------------------------------------------------------------


def _take_pointer(headers, value):
    kind, name, size = value.type, value.name, f"{value.count()} * sizeof(*{value.name})"
    if value.way == "rows":
        row = f"rk_unit_take_array((size_t)({value.row}) * sizeof(**{name}))"
        yield f"    const {kind} **{name} = rk_unit_room(NULL, {size});"
        yield f"    for (size_t row = 0; row < {value.count()}; row++)"
        yield f"        {name}[row] = rk_unit_takes() ? {row} : NULL;"
        return
    if value.way == "kept":
        yield (f"    const {kind} *{name} = rk_unit_takes() ? "
               f"rk_unit_take_kept(sizeof *{name}, open_{kind}) : NULL;")
        return
    if value.way == "added":  # not from 0: a call that sets counts, or narrows them, is found out
        yield f"    static const {kind} before_{name} = {{"
        yield from (f"        .{member.name} = UINT64_C({number}00000000007),"
                    for number, member in enumerate(headers.structures[kind], 1) if member.type == "uint64_t")
        yield f"    }};\n    {kind} *{name} = rk_unit_takes() ? rk_unit_room(&before_{name}, {size}) : NULL;"
        return
    if value.way == "made":
        yield f"    {kind} *{name} = rk_unit_takes() ? rk_unit_room(NULL, sizeof *{name}) : NULL;"
        yield f"    if ({name})\n        memset({name}, 0, sizeof *{name});"
        return
    if value.way == "in":
        yield f"    const {kind} *{name} = rk_unit_takes() ? rk_unit_take_array({size}) : NULL;"
        return
    contents = "NULL" if value.way == "out" else f"rk_unit_take_array({size})"
    yield f"    {kind} *{name} = rk_unit_takes() ? rk_unit_room({contents}, {size}) : NULL;"
    if value.way == "out" and _has_text(headers, kind):
        yield f"    if ({name})\n        memset({name}, 0, {size}); /* an empty text */"


def _opener(headers, kind):
    """A function that sets the pointers of a structure that is kept, where there are any."""
    value = Value(f"const {kind} *it")
    yield f"static void open_{kind}(void *structure)\n{{\n    {kind} *it = structure;"
    for each, pointer, size in headers.pointers(value):
        yield f"    {each}if ({pointer})\n            {pointer} = rk_unit_kept_piece({size});"
    yield "}\n"


def _give_made(value):
    name = value.name
    yield f"    if ({name}) {{\n        rk_unit_give({name}, sizeof *{name});"
    for member, most in value.most().items():
        yield f"        if ({name}->{member})"
        yield (f"            rk_unit_give_made({name}->{member}, (size_t)({name}->{value.counts[member]}), "
               f"(size_t)({most}), sizeof *{name}->{member});")
    yield "    }"


def _server(headers, kind, name, values):
    if name in headers.together:
        yield f"static void serve_{name}(void)\n{{\n}}\n"
        return
    yield f"static void serve_{name}(void)\n{{"
    for value in values:
        if not value.is_pointer():
            type_ = f"const {value.type}"
            yield f"    {type_} {value.name} = *({type_} *)rk_unit_take(sizeof {value.name});"
    for value in values:
        if value.is_pointer():
            yield from _take_pointer(headers, value)
    call = f"{name}({', '.join(value.name for value in values)});"
    yield "    rk_unit_begin_call();"
    yield f"    {kind} result = {call}" if kind != "void" else f"    {call}"
    yield "    rk_unit_end_call();"
    for value in values:
        if value.is_out():
            yield f"    if ({value.name}) {{"
            yield f"        void *room = rk_unit_give_room({value.count()} * sizeof(*{value.name}));"
            yield from _copied(headers, value.type, "room", value.name, value.count())
            yield "    }"
    for value in values:
        if value.way == "added":
            name = value.name
            yield f"    if ({name}) {{\n        {value.type} added = *{name};"
            yield from (f"        added.{member.name} -= before_{name}.{member.name};"
                        for member in headers.structures[value.type])
            yield "        rk_unit_give(&added, sizeof added);\n    }"
    for value in values:
        if value.way == "made":
            yield from _give_made(value)
    if name in headers.returned:
        array = headers.returned[name]
        yield f"    size_t at = result ? (size_t)(result - {array}) : SIZE_MAX;"
        yield "    rk_unit_give(&at, sizeof at);"
    elif kind != "void":
        yield "    void *room = rk_unit_give_room(sizeof result);"
        yield from _copied(headers, kind, "room", "&result", "(size_t)1")
    yield "    rk_unit_give_allocations();\n}\n"


def unit(headers):
    yield '#include "judge/unit.h"\n'
    for name in headers.structures_used():
        yield from _copier(headers, name)
    for kind in dict.fromkeys(value.type for _, _, values in headers.functions for value in values
                              if value.way == "kept"):
        yield from _opener(headers, kind)
    for kind, name, values in headers.functions:
        yield from _server(headers, kind, name, values)
    yield "void (*const rk_unit_functions[])(void) = {"
    yield from (f"    serve_{name}," for _, name, _ in headers.functions)
    yield "};"


def headers_of(source, stem):
    """Returns what a feature's header and its file of calls say."""
    headers = Headers(source, f"features/{stem}.h")
    calls = os.path.join(source, "tests", "judge", stem + ".calls")
    headers.apply(calls)
    headers.finish(calls)
    return headers


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("stem", metavar="STEM", help="the feature")
    parser.add_argument("side", choices=("judge", "trace", "unit"))
    parser.add_argument("--source", default=".", metavar="DIR", help="the kit's top folder (default: here)")
    arguments = parser.parse_args()
    stem, header = arguments.stem, f"features/{arguments.stem}.h"
    try:
        headers = headers_of(arguments.source, stem)
        text = "\n".join({"judge": judge, "trace": trace, "unit": unit}[arguments.side](headers))
    except (CallsError, OSError) as error:
        print(f"judge_calls: {error}", file=sys.stderr)
        return 1
    print(f'/* Made by tools/judge_calls.py from {header}. */\n#include "{header}"\n\n'
          f"#include <stdbool.h>\n#include <string.h>\n\n{text}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
