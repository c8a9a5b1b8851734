"""Builds a student's unit, alone or into a suite: exactly one object for each feature, so that a
missing function is missing, and never silently taken from the reference.

The build's compiler and flags are in DIR/impl/toolchain, which the Makefile writes.
"""

import concurrent.futures
import functools
import os
import re
import shlex
import subprocess

from grading import sandbox
from grading import unit_rules
from grading import volatile_constants
from grading.assignments import MachineError, ToolError, archive_in
from grading.c_source import functions_of, line_of, tokens_of

_SECONDS = 30
_BYTES_LEFT = 1 << 20  # a disk with less is full, whatever a tool says that failed there
_MEGABYTES = 4096
# What ends a compiler: limits, and signals by its own words.
_ENDS = {
    "seconds": f"took more than {_SECONDS} seconds of processor time",
    "memory": f"took more than {_MEGABYTES} MB of memory",
    "stopped": "was stopped",
    "processes": "started too many processes",
    "output": "printed megabytes of output",
    "File size limit exceeded": f"wrote a file of more than {sandbox.FILE_BYTES_MAX >> 20} MB",
    "Segmentation fault": "ended by itself: what is nested too deeply takes all of its stack",
}


class BuildError(Exception):
    """A unit that cannot be built: `reason` is one sentence, `details` the tools' output."""

    def __init__(self, reason, details=""):
        super().__init__(reason)
        self.reason, self.details = reason, details


def without_what_is_shown(reason, shown):
    """Returns the reason without the compiler's error in it, if that was shown in full above."""
    beginning, _, error = reason.partition(": ")
    hint = re.search(r"; (#include|a } is missing)|$", error)
    error, hint = error[:hint.start()], error[hint.start():]
    return f"{beginning}; the errors are above{hint}" if error and error in shown else reason


class Toolchain:
    """The contents of DIR/impl/toolchain: one NAME=VALUE per line."""

    def __init__(self, build):
        path = os.path.join(build, "impl", "toolchain")
        try:
            with open(path, encoding="utf-8") as file:
                values = dict(line.rstrip("\n").split("=", 1) for line in file if "=" in line)
        except OSError as error:
            raise ToolError(
                f"{path} cannot be read ({error.strerror}); run make check-... or make grade there once"
            ) from error
        self.build = os.path.abspath(build)
        self.source = os.path.join(self.build, values["source"])  # relative in a grading kit
        self.handed_out = values["handed_out"].split()  # features without a reference, in a pack
        self.compiler = shlex.split(values["cc"])
        self.flags = ["-I" + os.path.join(self.source, "src"), *shlex.split(values["flags"]), "-Wno-error"]
        self.base_sanitize = shlex.split(values["base_sanitize"])
        self.sanitize = shlex.split(values["sanitize"])
        self.fill = shlex.split(values["fill"])  # variables that are given no value
        self.of_units = [*self.sanitize, *self.fill, "-g1", "-O1"]  # as suites link them
        self.grade_link = shlex.split(values["grade_link"])
        self.link_flags = shlex.split(values["link_flags"])
        self.drivers = values["drivers"].split()  # the objects of all, from the build folder
        self.libraries = shlex.split(values["libraries"])
        self.tools = {name: values[name] for name in ("ar", "nm", "objcopy", "objdump")}
        self.kit = self.source  # where it stands; in a private copy, `source` is the copy
        self.sandbox, self.remark = None, ""  # or a Bubblewrap; what is to be said without one
        self.judges = False  # whether units run apart from their suites: at home they need not
        self.kit_copy = None  # a folder with a copy of the kit (private_copy) that several gradings share
        self.workers = None  # so many processors; None for all
        tools = os.path.realpath(os.path.join(os.path.dirname(__file__), "..", ".."))
        if os.path.realpath(self.source) != tools:
            raise ToolError(f"{path} was made for the kit in {self.source}, but this one stands in {tools}: "
                            "run ./bootstrap there, or configure in the build folder, again")

    def finds_leaks(self):
        """Whether units are built with the address sanitizer, and so with the leak sanitizer."""
        return any("address" in flag for flag in self.sanitize)

    def left_out(self):
        """Returns remarks on what a check here cannot find, and one elsewhere may."""
        return [] if self.sanitize else [
            "without sanitizers, which this compiler lacks: wrong memory accesses, undefined behaviour and "
            "leaks were not looked for"]

    def built(self, path):
        """Returns the absolute path of a file in the build folder, which must exist."""
        path = os.path.join(self.build, path)
        if not os.path.exists(path):
            raise ToolError(f"{path} is missing; run make there")
        return path


def _run_tool(toolchain, command, folder):
    environment, enclose = dict(os.environ, LC_ALL="C", TMPDIR=folder), None
    if toolchain.sandbox:  # assembler can include /proc/self/environ
        environment = dict(sandbox.bare_environment(folder), CCACHE_DISABLE="1",
                           PATH=os.environ.get("PATH", os.defpath))
        enclose = functools.partial(toolchain.sandbox.around_compiler, folder=folder, kit=toolchain.source)
        command = [_without_ccache(command[0]), *command[1:]]
    try:
        outcome = sandbox.run(
            command, seconds=_SECONDS, megabytes=_MEGABYTES, folder=os.getcwd(),
            environment=environment, output_bytes=4 << 20, enclose=enclose,
        )
    except OSError as error:
        raise MachineError(f"{command[0]} cannot be run: {error.strerror}") from error
    if outcome.status != 0:
        _check_disk(folder)
    return outcome


@functools.lru_cache
def _without_ccache(compiler):
    """Returns the compiler for which ccache stands in PATH: in a sandbox ccache could keep nothing."""
    found = [os.path.join(folder, compiler) for folder in os.get_exec_path()]
    found = [path for path in found if os.access(path, os.X_OK)]
    if not found or os.path.basename(os.path.realpath(found[0])) != "ccache":
        return compiler
    return next((path for path in found if os.path.basename(os.path.realpath(path)) != "ccache"), compiler)


def _check_disk(folder):
    """Raises MachineError if the disk is full. Not by what tools say: a unit can have them say that."""
    room = os.statvfs(folder)
    if room.f_bavail * room.f_frsize < _BYTES_LEFT or room.f_files and room.f_favail == 0:
        raise MachineError(f"the disk of {folder} is full; free some space, or choose another by TMPDIR")


def _around_tool(toolchain, path):
    """Returns the function that puts a tool which reads or changes this object into the sandbox, or None."""
    return toolchain.sandbox and functools.partial(toolchain.sandbox.around_compiler,
                                                   folder=os.path.dirname(path), kit=toolchain.source)


def global_symbols(toolchain, path):
    """Returns the global names that an object defines."""
    return unit_rules.global_names(toolchain.tools["objdump"], path)


# --- Compiling ----------------------------------------------------------------------------------


def compile_unit(toolchain, unit, folder, extra_flags=()):
    """Compiles the unit to an object in `folder`, by way of its preprocessed text and its assembly, which
    must keep the rules for units. Returns the object's path and the compiler's warnings."""
    base = os.path.join(folder, unit.feature.stem)
    # An object for link-time optimization would not tell what it uses.
    flags = [*toolchain.flags, *extra_flags, "-fno-lto", "-Werror=implicit-function-declaration"]
    source, constants = unit.path, set()
    if not unit.is_reference:
        _check_text(unit)
        _check_no_header_hides(toolchain, unit)
        # What is checked is what is compiled: a second look at the source could see another text.
        listing, source = base + ".included", base + ".i"
        # -g0: with -g3, macros would be defined again in the text, for the debugger.
        _compile(toolchain, unit, folder,
                 [*flags, "-g0", "-E", "-MD", "-MF", listing, unit.path, "-o", source])
        _check_included(toolchain, unit, listing)
        text = unit_rules.without_version(_read(source))
        if text != _read(source):
            with open(source, "w", encoding="utf-8") as file:
                file.write(text)
        _refuse(unit, unit_rules.fault_in_source(text, lambda name: _with_line(unit, name)))
        constants = volatile_constants.names_in(text)
        flags += ["-fdata-sections"] if constants else []
    of_text = flags if unit.is_reference else flags_of_text(flags)
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        is_at_home = not unit.is_reference and not toolchain.judges
        layout = pool.submit(_about_layout, toolchain, unit, folder, flags) if is_at_home else None
        warnings = _assemble(toolchain, unit, folder,
                             [*of_text, *(_NO_LAYOUT if layout else []), "-S", source], base)
    if layout:
        warnings = "\n".join(filter(None, [layout.result(), warnings]))
    if not unit.is_reference:
        _refuse(unit, unit_rules.fault_in_assembly(_read(base + ".s")))
    if constants:
        volatile_constants.place(base + ".s", constants)
    _compile(toolchain, unit, folder, [*of_text, "-c", base + ".s", "-o", base + ".o"])
    return base + ".o", warnings


def flags_of_text(flags):
    """Returns the flags without those for the preprocessor, of which clang warns where it has none to run."""
    kept, left = [], iter(flags)
    for flag in left:
        if flag in ("-I", "-include"):
            next(left, None)
        elif not flag.startswith("-I"):
            kept.append(flag)
    return kept


_LAYOUT = "misleading-indentation", "empty-body"
_NO_LAYOUT = [f"-Wno-{name}" for name in _LAYOUT]


def _about_layout(toolchain, unit, folder, flags):
    """Returns the compiler's warnings about indentation, which it has for the file itself only: gcc does not
    see the layout of preprocessed text. Others are left out, because it gives some without being asked."""
    command = [*toolchain.compiler, *(flag for flag in flags if not flag.startswith(("-W", "-fsanitize"))),
               *(f"-W{name}" for name in _LAYOUT), "-fsyntax-only", unit.path]
    said = plain(toolchain, unit, _run_tool(toolchain, command, folder).output)
    said = re.sub(r"^(.*: In function .*:|\d+ warnings? generated\.)\n", "", said, flags=re.MULTILINE)
    findings = re.split(r"^(?=.+: (?:warning|error): )", said, flags=re.MULTILINE)
    return "".join(text for text in findings
                   if re.match(rf".+\[-W({'|'.join(_LAYOUT)})\]\n", text)).strip()


def _assemble(toolchain, unit, folder, arguments, base):
    """Makes the unit's assembly; returns the compiler's warnings. With sanitizers, compilers do not see which
    variables have no value: the warnings are then those of another run without, at the same time."""
    plainly = [flag for flag in arguments if not flag.startswith(("-fsanitize", "-fno-sanitize"))]
    if plainly == arguments:
        return _compile(toolchain, unit, folder, [*arguments, "-o", base + ".s"])
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        read = pool.submit(_compile, toolchain, unit, folder, [*plainly, "-o", base + ".plain.s"])
        made = pool.submit(_compile, toolchain, unit, folder, [*arguments, "-w", "-o", base + ".s"])
        warnings = read.result()
        made.result()
    return warnings


def _read(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def _refuse(unit, fault):
    if fault:
        raise BuildError(f"{unit.shown} {fault}")


# How files begin that are no text.
_PROGRAMS = b"\x7fELF", b"\xcf\xfa\xed\xfe", b"!<arch>\n"


def _wide_encoding(text):
    """Returns the encoding of a text whose characters have two or four bytes each, of which mostly all but
    one are 0; "" for another text."""
    if text.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return "UTF-32"
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "UTF-16"
    quarters = [text[place::4] for place in range(4)]
    is_zero = [2 * quarter.count(0) > len(quarter) for quarter in quarters]
    if sum(is_zero) == 3:
        return "UTF-32"
    return "UTF-16" if sum(is_zero) == 2 and is_zero[0] == is_zero[2] else ""


def _check_text(unit):
    with open(unit.path, "rb") as file:
        text = file.read()
    if not text.strip():
        raise BuildError(f"{unit.shown} is empty")
    if archive_in(text):
        raise BuildError(f"{unit.shown} is an archive ({archive_in(text)}); unpack it")
    if text.startswith(_PROGRAMS):
        raise BuildError(f"{unit.shown} is a compiled program; hand in the text that it was made of")
    wide = _wide_encoding(text)
    if wide:
        raise BuildError(f"{unit.shown} is text in {wide}; save it in UTF-8")


def _compile(toolchain, unit, folder, arguments):
    """Returns the compiler's warnings, or raises BuildError."""
    outcome = _run_tool(toolchain, [*toolchain.compiler, *arguments], folder)
    said = plain(toolchain, unit, outcome.output)
    cause = outcome.limit or _signal_of(said)
    if cause:
        raise BuildError(f"{unit.shown} could not be compiled: the compiler {_ENDS.get(cause, cause)}; is "
                         "there a huge array, or a macro that grows?")
    if outcome.status != 0:
        absent = re.search(r"fatal error: (.+): No such file", said)
        if absent:
            name = f"{absent.group(1)}, which {'was not handed in' if toolchain.judges else 'is not there'}"
            raise BuildError(_not_to_include(unit, name), said)
        first = next((line for line in said.splitlines() if "error:" in line), None)
        brace = _missing_brace(unit, said)
        hint = brace or first and _header_to_include(toolchain, first)
        reason = f"does not compile: {first}{hint}" if first else f"{unit.shown} does not compile"
        raise BuildError(reason, _up_to_second_error(said) if brace else said)
    return said.strip()


def _signal_of(said):
    """Returns which signal ended the compiler itself, which calls it an error of its own, or ""."""
    found = re.search(r"internal compiler error: (.+) signal terminated program", said)
    return found[1] if found and found[1] in _ENDS else ""


def _missing_brace(unit, said):
    """Names the function that is not closed, if that is why the compiler has errors. gcc takes the functions
    after it for functions within it, and complains of each."""
    if not re.search(r"error: (invalid storage class for function|function definition is not allowed here"
                     r"|expected .* at end of input|expected '}')", said):
        return ""
    text = _read(unit.path)
    tokens = tokens_of(text)
    words, functions = [token.text for token in tokens], functions_of(tokens)
    if words.count("{") <= words.count("}") or not functions:
        return ""
    name, (begin, _) = list(functions.items())[-1]  # all that follow are within it
    return f"; a }} is missing in {name}, which begins in line {line_of(text, tokens[begin])}"


def _up_to_second_error(said):
    return "".join(re.split(r"^(?=.+: error: )", said, flags=re.MULTILINE)[:2])


def _header_to_include(toolchain, error):
    """Names the kit's header that declares a function which is called without a declaration."""
    called = re.search(r"implicit declaration of function '(rk_\w+)'|undeclared function '(rk_\w+)'", error)
    for header in _headers(toolchain) if called else []:
        if re.search(rf"\b{called[1] or called[2]}\(", _read(os.path.join(toolchain.source, "src", header))):
            return f"; #include \"{header}\" declares it"
    return ""


def _headers(toolchain):
    """Returns the kit's headers as units include them."""
    top = os.path.join(toolchain.source, "src")
    return [os.path.relpath(os.path.join(folder, name), top)
            for folder, _, names in os.walk(top) for name in names if name.endswith(".h")]


def _check_no_header_hides(toolchain, unit):
    """Headers beside a unit are found before the kit's."""
    for header in _headers(toolchain):
        if os.path.exists(os.path.join(os.path.dirname(unit.path), header)):
            raise BuildError(f"the folder of {unit.shown} has a {header} of its own, which hides the kit's; "
                             "remove it")


def plain(toolchain, unit, text):
    """Shortens paths in the tools' output: the unit's to unit.shown, the kit's to begin at its top."""
    text = text.replace(unit.path, unit.shown)
    own, shown = os.path.dirname(unit.path), os.path.dirname(unit.shown)
    shorter = {os.path.realpath(own): shown, os.path.abspath(own): shown, own: shown}
    shorter |= {path: "" for kit in (toolchain.source, toolchain.kit)
                for path in (os.path.realpath(kit), kit)}
    for path, short in shorter.items():
        if path.strip("/"):
            text = re.sub(rf"(?<![\w./-]){re.escape(path)}/+", lambda _, s=short: s and s + "/", text)
    return text


def _is_below(path, folder):
    """Both are real paths."""
    return path == folder or path.startswith(folder.rstrip("/") + "/")


def _check_included(toolchain, unit, listing):
    """A solution may include the kit's headers, the system's, and headers beside it."""
    with open(listing, encoding="utf-8", errors="replace") as file:
        # In make's syntax: blanks in names are escaped, quotes are ordinary characters.
        words = [re.sub(r"\\([ \t#])", r"\1", word).replace("$$", "$")
                 for word in re.findall(r"(?:\\.|\S)+", file.read().replace("\\\n", " "))]
    kit, itself = os.path.realpath(toolchain.source), os.path.realpath(unit.path)
    own = os.path.realpath(os.path.dirname(os.path.abspath(unit.path)))
    source, tests = os.path.realpath(os.path.join(kit, "src")), os.path.realpath(os.path.join(kit, "tests"))
    for word in words[1:]:
        path = os.path.realpath(word)
        is_header = path.endswith(".h") and (_is_below(path, source) or _is_below(path, own))
        is_systems = path.startswith(("/usr/", "/opt/", "/nix/", "/Library/")) and not path.endswith(".c")
        is_suites = _is_below(path, tests)
        if path != itself and (is_suites or not (is_header or is_systems)):
            raise BuildError(_not_to_include(unit, plain(toolchain, unit, word)))


def _not_to_include(unit, name):
    return (f"{unit.shown} includes {name}: a unit may include the kit's headers, the system's, "
            "and headers (.h) beside it")


def check_object(toolchain, unit, path):
    """Raises BuildError if the unit's object has more than functions and data. Returns what it has, a
    unit_rules.Object."""
    found = unit_rules.Object(toolchain.tools["objdump"], path, _around_tool(toolchain, path))
    _refuse(unit, unit_rules.fault_in_object(found, toolchain.finds_leaks()))
    return found


def check_definitions(toolchain, unit, found):
    """Raises BuildError if the unit leaves out what the linker would then find in the kit's library, which
    has the triangle test for all traversals, or defines it so that what is found there takes its place."""
    there = set(global_symbols(toolchain, toolchain.built("librkbase.a")))
    interface = global_symbols(toolchain, toolchain.built(f"src/features/{unit.feature.stem}.o"))
    defined = {name: flags for flags, *_, name in found.symbols if flags[0] != "l"}
    missing = [name for name in interface if name in there and name not in defined]
    weak = [name for name in interface if name in there and "w" in defined.get(name, "")]
    if missing:
        raise BuildError(f"your file does not define {_some(missing)}, which the suite calls")
    if weak:
        raise BuildError(f"{unit.shown} defines {_some(weak)} as weak, so that another definition could take "
                         "its place; leave the attribute weak out")


def check_names(toolchain, unit, found):
    """Raises BuildError if the unit uses what a unit may not. Asked after linking, which finds names that
    nothing defines."""
    kit = set(unit_rules.pure_names(toolchain.tools["objdump"], toolchain.built("librkbase.a")))
    for stem in unit.feature.needs + unit.feature.uses:
        kit.update(global_symbols(toolchain, toolchain.built(f"src/features/{stem}.o")))
    _refuse(unit, unit_rules.fault_in_names(found, kit, lambda name: _with_line(unit, name)))


def _with_line(unit, name):
    """Returns a name with the first line of the unit that has it, if one has."""
    text = _read(unit.path)
    token = next((token for token in tokens_of(text) if token.text == name), None)
    return f"{name} (line {line_of(text, token)})" if token else name


def keep_interface(toolchain, feature, path, for_suite=False):
    """Makes all names of an object local except the feature's interface: a helper without `static`,
    a `main` for trying things, or a function called `malloc` then changes nothing elsewhere. In a suite the
    unit's calls of malloc and related functions become those of tests/count_allocations.c, which can fail."""
    names = global_symbols(toolchain, toolchain.built(f"src/features/{feature.stem}.o"))
    keep = [f"--keep-global-symbol={name}" for name in names]
    scarce = [f"--redefine-sym={name}=rk_scarce_{name}"
              for name in ("malloc", "calloc", "realloc", "aligned_alloc")]
    command = [toolchain.tools["objcopy"], *keep, *(scarce if for_suite else []), path]
    around = _around_tool(toolchain, path)
    command = around(command) if around else command
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode:
        _check_disk(os.path.dirname(path))
        raise ToolError(f"{command[0]} failed on {path}: {answer.stderr.strip()}")


# --- Linking ------------------------------------------------------------------------------------


def link(toolchain, output, parts, folder):
    """Links a program with the build's own flags, or raises BuildError."""
    command = [*toolchain.compiler, *toolchain.base_sanitize, *toolchain.link_flags, *parts, "-o", output]
    outcome = _run_tool(toolchain, command, folder)
    if outcome.status != 0 or outcome.limit:
        raise BuildError(f"{os.path.basename(output)} could not be linked", outcome.output)


def link_suite(toolchain, units, objects, folder, sanitize):
    """Links the suite of the first unit's feature with the units' objects. Returns the program's
    path."""
    stem = units[0].feature.stem
    parts = [toolchain.built(f"tests/test_{stem}.o"), *objects]
    return link_program(toolchain, units, parts, os.path.join(folder, "test_" + stem), sanitize)


def link_program(toolchain, units, parts, output, sanitize):
    """Links a program of these parts and the libraries of suites. Returns its path."""
    # The allocation counter must be built like the program, so the archive's copy will not do.
    counter = toolchain.built("impl/count_allocations.o")
    command = [*toolchain.compiler, *sanitize, *toolchain.grade_link, *toolchain.flags, *toolchain.link_flags,
               *parts, counter, toolchain.built("librktest.a"),
               toolchain.built("librkbase.a"), *toolchain.libraries, "-o", output]
    outcome = _run_tool(toolchain, command, os.path.dirname(output))
    if outcome.status != 0 or outcome.limit:
        raise _not_linked(toolchain, outcome.output, units)
    return output


def _some(names):
    """Returns "a", "a and b", or "a, b, c and 4 more"."""
    shown = names if len(names) < 5 else [*names[:3], f"{len(names) - 3} more"]
    return " and ".join(filter(None, [", ".join(shown[:-1]), shown[-1]]))


def _not_linked(toolchain, said, units):
    """Returns a BuildError with the cause in place of what the linker said, as far as it is known."""
    names = list(dict.fromkeys(
        re.findall(r"undefined (?:reference to|symbol:) [`'\"]?(\w+)", said)
    ))
    for unit in units:
        interface = global_symbols(toolchain, toolchain.built(f"src/features/{unit.feature.stem}.o"))
        missing = sorted(name for name in names if name in interface)  # the linker's order tells nothing
        if missing:
            whose = "your file" if unit is units[0] else unit.shown
            return BuildError(f"{whose} does not define {_some(missing)}, which the suite calls")
    if names:
        uses = _some([_with_line(units[0], name) for name in names])
        return BuildError(f"your file uses {uses}, which nothing defines")
    return BuildError(f"{units[0].shown} could not be linked with its suite", said)
