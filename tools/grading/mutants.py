"""The known mistakes of a feature, tests/mutants/STEM.mutants, and how they are made in its unit.

    # A comment: a line that begins so.
    mutant upper_half_is_larger
    mistake: Of an odd number of triangles the upper half gets one more.
    fails: five_triangles_split_three_to_two
        levels_and_leaves_follow_from_halving
    in split_at_median
    - count - count / 2
    + count / 2

Each block makes one mistake. `mistake` is a sentence, `fails` the tests that must fail, separated by
spaces; either goes on in lines that are indented. A line `says: it is twice the wanted` may follow: these
words stand in the message of the first claim of the assignment that fails. Then come one or more changes:
`in` the function in which the text stands, "- " before the text to find, "+ " before the text instead.
Both may have several lines, each with its sign; a "+" alone stands for no text. A further change in the
same place needs no `in` of its own. Instead of a function's name, `in` takes "struct NAME", "enum NAME",
or "file" for all that stands outside of functions.

What counts is C's tokens, so line breaks, spaces and comments may differ from the source's. The text
must stand exactly once in its place. "..." in it stands for anything up to the text that follows, so
that the first and the last statement are enough to name a long passage.
"""

import collections
import re

from grading.c_source import closing, functions_of, line_of, tokens_of

Mutant = collections.namedtuple("Mutant", "file line name mistake fails fails_line says changes")
Change = collections.namedtuple("Change", "line place find instead")


class MutantError(Exception):
    """What is wrong, in one sentence with file, line and remedy."""


# --- Places ----------------------------------------------------------------------------------------


def _place(tokens, name):
    """Returns the ranges of tokens that the place consists of; none if it is not there."""
    functions = functions_of(tokens)
    if name == "file":
        ends = [0, *(edge for span in functions.values() for edge in span), len(tokens)]
        return list(zip(ends[::2], ends[1::2]))
    words = name.split()
    if len(words) == 1:
        return [functions[name]] if name in functions else []
    texts = [token.text for token in tokens]
    return [(at, closing(tokens, at + 2) + 1) for at in range(len(texts) - 2)
            if texts[at : at + 3] == [*words, "{"]]


# --- Reading --------------------------------------------------------------------------------------

_LINE = re.compile(r"(mutant|mistake:|fails:|says:|in|-|\+)(?:$|\s+(.*))|(\s+)(\S.*)")
_PLACE = re.compile(r"file|(?:(?:struct|enum) )?[A-Za-z_]\w*")


class _Reader:
    """Takes a file's lines one by one; `block` is the mutant that they belong to."""

    def __init__(self, file):
        self.file, self.mutants, self.block, self.last = file, [], None, None

    def fault(self, line, said):
        raise MutantError(f"{self.file}:{line}: {said}")

    def line(self, number, text):
        match = _LINE.fullmatch(text)
        if not match:
            self.fault(number, f"\"{text}\" is no line of a mutant; begin it with \"mutant\", \"mistake:\", "
                       "\"fails:\", \"says:\", \"in\", \"-\", \"+\" or, for a comment, with \"#\"")
        word, rest, indented, more = match.groups()
        if indented:
            self.go_on(number, more)
        elif word == "mutant":
            self.begin(number, rest or "")
        elif not self.block:
            self.fault(number, f"\"{word}\" belongs to no mutant; write \"mutant NAME\" above it")
        elif word in "-+":
            self.change(number, word, rest or "")
        elif word == "in":
            self.place(number, " ".join((rest or "").split()))
        else:
            self.say(number, word.rstrip(":"), rest or "")
        self.last = word or self.last

    def begin(self, number, name):
        self.end()
        if not re.fullmatch(r"\w+", name):
            self.fault(number,
                       "a mutant has no name; write \"mutant NAME\", the name of letters, digits and _")
        if any(name == mutant.name for mutant in self.mutants):
            self.fault(number, f"there are two mutants {name}; rename this one")
        self.block = {"line": number, "name": name, "changes": []}
        self.where = None

    def say(self, number, key, text):
        if key in self.block:
            self.fault(number, f"{self.block['name']} has two lines \"{key}:\"; remove one")
        self.block[key], self.block[key + "_line"] = text, number

    def go_on(self, number, text):
        if self.last not in ("mistake:", "fails:", "says:"):
            self.fault(number,
                       "only \"mistake:\", \"fails:\" and \"says:\" go on in indented lines; begin it with "
                       "\"-\" or \"+\" if it is text of the unit")
        self.block[self.last.rstrip(":")] += " " + text

    def place(self, number, name):
        if not _PLACE.fullmatch(name):
            self.fault(number,
                       f"\"in {name}\" names no place; write after \"in\" a function's name, "
                       "\"struct NAME\", \"enum NAME\" or \"file\"")
        self.where = name

    def change(self, number, sign, text):
        changes = self.block["changes"]
        if not self.where:
            self.fault(number, "in which function does this text stand? Write \"in FUNCTION\" above it")
        if sign == "-" and self.last != "-":
            changes.append({"line": number, "place": self.where, "-": [], "+": []})
        if sign == "+" and self.last not in ("-", "+"):
            self.fault(number,
                       "this text stands instead of none; write the text to find above it, with \"- \"")
        changes[-1][sign].append(text)

    def end(self):
        """Notes the block that is complete."""
        block, self.last = self.block, None
        if not block:
            return
        for key, remedy in (("mistake", "one sentence"), ("fails", "the tests that must fail")):
            if not block.get(key, "").strip():
                self.fault(block["line"], f"{block['name']} has no line \"{key}: {remedy}\"; write it")
        if not block.get("says", "something").strip():
            self.fault(block["says_line"],
                       f"{block['name']} has a line \"says:\" of nothing; write the words of the message, or "
                       "remove it")
        if not block["changes"]:
            self.fault(block["line"],
                       f"{block['name']} changes nothing; say where by \"in FUNCTION\", and what by "
                       "\"- text to find\" and \"+ text instead\"")
        self.mutants.append(Mutant(self.file, block["line"], block["name"], block["mistake"],
                                   self.claims(block),
                                   block["fails_line"], block.get("says"),
                                   [self.whole(change) for change in block["changes"]]))

    def claims(self, block):
        claims = block["fails"].split()
        for claim in claims:
            if claims.count(claim) > 1:
                self.fault(block["fails_line"], f"{claim} stands there twice; remove one")
        return claims

    def whole(self, change):
        find = [token.text for token in tokens_of("\n".join(change["-"]))]
        if not find or find[0] == "..." or find[-1] == "...":
            self.fault(change["line"],
                       "the text to find neither is empty nor begins or ends with \"...\"; write what "
                       "stands in the unit")
        if not change["+"]:
            self.fault(change["line"],
                       "what stands instead of this text? Write it below, with \"+ \", or a \"+\" "
                       "alone")
        instead = "\n".join(change["+"])
        if find == [token.text for token in tokens_of(instead)]:
            self.fault(change["line"], "the text instead is the same; change it")
        return Change(change["line"], change["place"], find, instead)


def read_mutants(path, file):
    """Returns the mutants of a file, in its order; errors call it `file`."""
    reader = _Reader(file)
    with open(path, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            if line.strip() and line[0] != "#":
                reader.line(number, line.rstrip())
    reader.end()
    return reader.mutants


# --- Making a mistake -----------------------------------------------------------------------------


def _runs(texts, part, begin, end):
    return [at for at in range(begin, end - len(part) + 1) if texts[at : at + len(part)] == part]


def _parts(find):
    parts = [[]]
    for text in find:
        if text == "...":
            parts.append([])
        else:
            parts[-1].append(text)
    return parts


def _matches(texts, parts, begin, end):
    """Returns all ranges in which the parts stand one after the other."""
    found = []
    for at in _runs(texts, parts[0], begin, end):
        after = at + len(parts[0])
        if len(parts) == 1:
            found.append((at, after))
        else:
            found += [(at, last) for _, last in _matches(texts, parts[1:], after, end)]
    return found


def _find(change, tokens, text, said, source):
    """Returns the one range of characters that the change means; `said` begins its faults."""
    spans = _place(tokens, change.place)
    where = change.place if " " in change.place or change.place == "file" else f"function {change.place}"
    if not spans:
        raise MutantError(f"{said}{source} has no {where}; write after \"in\" where the text stands now")
    texts = [token.text for token in tokens]
    found = [match for span in spans for match in _matches(texts, _parts(change.find), *span)]
    if not found:
        raise MutantError(f"{said}this text does not stand in {where} of {source}; "
                          "copy from there what is to be changed")
    if len(found) > 1:
        lines = ", ".join(str(line_of(text, tokens[first])) for first, _ in found)
        raise MutantError(f"{said}this text stands {len(found)} times in {where} of {source} (lines "
                          f"{lines}); take in so much of what surrounds it that it stands there once")
    first, end = found[0]
    return tokens[first].start, tokens[end - 1].end


_RUN_TOGETHER = re.compile(r"\w\w|[^\w\s]{2}")


def _padded(before, text, after):
    """Keeps the text's tokens apart from those around it."""
    left = " " if _RUN_TOGETHER.match(before[-1:] + text[:1]) else ""
    right = " " if _RUN_TOGETHER.match(text[-1:] + after[:1]) else ""
    ends_a_line = "//" in text or "#" in text
    return left + text + ("\n" if ends_a_line else right)


def mutate(mutant, text, source):
    """Returns the unit's text with the mistake in it; errors call the unit `source`."""
    tokens = tokens_of(text)
    spans = []
    for change in mutant.changes:
        said = f"{mutant.file}:{change.line}: "
        spans.append((*_find(change, tokens, text, said, source), change))
    spans.sort(key=lambda span: span[:2])
    for (_, end, _), (begin, _, change) in zip(spans, spans[1:]):
        if begin < end:
            raise MutantError(f"{mutant.file}:{change.line}: this text overlaps another that {mutant.name} "
                              "changes; make one change of both")
    for begin, end, change in reversed(spans):
        text = text[:begin] + _padded(text[:begin], change.instead, text[end:]) + text[end:]
    return text
