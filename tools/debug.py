#!/usr/bin/env python3
"""Starts gdb on a unit, stopped at the first of its functions that the test calls.

The unit is built without optimization and with the sanitizers that grade it into
impl/debug/test_STEM: a stray index stops where it occurs, and not where its effect shows. The commands for
gdb are in impl/debug/STEM.gdb, for editors with their own interface to gdb. It stops once in each function
that students write, but not in given ones."""

import os
import re
import shutil
import subprocess
import sys

from grading import build
from grading.assignments import (
    Parser, ToolError, check_impl, choose, find_unit, missing_unit, read_features, read_points,
    reference_unit,
    unit_beside, units_of_suite,
)
from grade import grade_impl, stop_on_signals
from grading.starters import read_regions

# A report aborts, where gdb stops; leaks cannot be detected under a debugger. The suite's own signal
# handlers are disabled, as in grading.
_ASAN_OPTIONS = "abort_on_error=1:detect_leaks=0:handle_segv=0:handle_abort=0:allow_user_segv_handler=1"
_UBSAN_OPTIONS = "abort_on_error=1:handle_abort=0:print_stacktrace=0"


def functions_to_write(path):
    """Returns the names of the functions that hold a region to solve, in the order of the file."""
    names, function = [], None
    for kind, line in read_regions(path):
        head = re.match(r"[a-z].*?(\w+)\(", line)
        if kind != "marker" and head:
            function = head.group(1)
        if kind == "marker" and function and function not in names:
            names.append(function)
    return names


def tests_of(toolchain, stem):
    """Returns the names of all tests of the suite, those without points too."""
    with open(os.path.join(toolchain.source, "tests", f"test_{stem}.c"), encoding="utf-8") as file:
        return re.findall(r"^ *cmocka_unit_test\((\w+)\)", file.read(), re.MULTILINE)


def _functions_in(toolchain, path):
    """Returns a dictionary from an object's functions to their addresses, in the order of these."""
    answer = subprocess.run([toolchain.tools["nm"], "-n", path], capture_output=True, text=True, check=True)
    return {line.split()[-1]: int(line.split()[0], 16) for line in answer.stdout.splitlines()
            if re.search(" [Tt] ", line)}


def first_lines(toolchain, path, name):
    """Returns a dictionary from an object's functions to the first line of their bodies, where arguments have
    their values: the sanitizer moves them after the place where gdb stops by itself. `name` is the
    source's."""
    command = [toolchain.tools["objdump"], "--dwarf=decodedline", path]
    answer = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    rows = sorted((int(address, 16), int(line)) for line, address in
                  re.findall(rf"^(?:\S*/)?{re.escape(name)} +(\d+) +(0x[0-9a-f]+|0) ", answer.stdout,
                             re.MULTILINE))
    functions = _functions_in(toolchain, path)
    starts, found = [*functions.values(), float("inf")], {}
    for (function, start), end in zip(functions.items(), starts[1:]):
        lines = [line for address, line in rows if start <= address < end]
        body = [line for line in lines if line > lines[0]]
        if body:
            found[function] = body[0]
    return found


def build_for_debugging(toolchain, feature, features, impl):
    """Builds impl/debug/test_STEM and STEM.gdb; returns their absolute paths and the unit."""
    unit = find_unit(feature, impl) if impl else reference_unit(feature)
    if unit.path is None:
        raise missing_unit(feature, impl)
    folder = os.path.join(toolchain.build, "impl", "debug")
    os.makedirs(folder, exist_ok=True)
    flags = [*toolchain.sanitize, *toolchain.fill, "-O0", "-g3"]
    path, warnings = build.compile_unit(toolchain, unit, folder, flags)
    if warnings:
        print(warnings, file=sys.stderr)
    build.keep_interface(toolchain, feature, path, for_suite=True)
    beside = {stem: unit_beside(features[stem], impl, toolchain.handed_out)
              for stem in feature.needs + feature.uses}
    needed = units_of_suite(feature, beside)
    objects = [path]
    for other in needed:
        objects.append(toolchain.built(f"src/features/{other.feature.stem}.o") if other.is_reference
                       else build.compile_unit(toolchain, other, folder, flags)[0])
    program = build.link_suite(toolchain, [unit, *needed], objects, folder, toolchain.sanitize)
    script = os.path.join(folder, feature.stem + ".gdb")
    with open(script, "w", encoding="utf-8") as file:
        file.write(f"source {toolchain.source}/tools/gdb_raykit.py\n")
        file.write("set breakpoint pending on\nset confirm off\nset print pretty on\n")
        file.write(f"set environment ASAN_OPTIONS {_ASAN_OPTIONS}\n")
        file.write(f"set environment UBSAN_OPTIONS {_UBSAN_OPTIONS}\n")
        name = os.path.basename(unit.path)
        file.write(f"python stop_in({name!r})\n")
        present, lines = _functions_in(toolchain, path), first_lines(toolchain, path, name)
        yours = [function for function in functions_to_write(feature.reference) if function in present]
        for function in yours or build.global_symbols(toolchain, path):
            place = f"tbreak '{name}':{lines.get(function, function)}"
            file.write(f"python gdb.execute({place!r}, to_string=True)\n")
    return program, script, unit


def _first_failing(build, feature, impl, test):
    """Returns the given test, else the first that fails, else the first of all."""
    tests = [scored.name for scored in read_points(feature)]
    if test:
        return test
    if not impl:
        return tests[0]
    _, suites = grade_impl(build, [feature.stem], impl)
    failing = [name for name in tests if not suites[0].verdicts[name].passed]
    return failing[0] if failing else tests[0]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument(
        "--impl", default="", metavar="FILE_OR_DIR", help="the work; default: the reference"
    )
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--test", metavar="NAME", help="the test to run; default: the first that fails")
    parser.add_argument("--prepare", action="store_true", help="only build, for an editor's debugger")
    arguments = parser.parse_args()
    stop_on_signals()
    try:
        toolchain = build.Toolchain(arguments.build)
        features = read_features(toolchain.source)
        feature = choose(features, [arguments.stem])[0]
        if arguments.impl:
            check_impl(features, arguments.impl, [arguments.stem])
        tests = tests_of(toolchain, feature.stem)
        if arguments.test and arguments.test not in tests:
            raise ToolError("\n    ".join([f"there is no test {arguments.test}; TEST is one of:", *tests]))
        debugger = shutil.which("gdb")
        if not debugger and not arguments.prepare:
            raise ToolError("gdb is missing; install the package gdb")
        program, script, unit = build_for_debugging(toolchain, feature, features, arguments.impl)
        if arguments.prepare:
            return 0
        test = _first_failing(arguments.build, feature, arguments.impl, arguments.test)
    except ToolError as error:
        print(f"debug: {error}", file=sys.stderr)
        return 1
    except build.BuildError as error:
        reason = build.without_what_is_shown(error.reason, error.details)
        print(f"{error.details.rstrip()}\ndebug: {reason}".lstrip(), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    keys = ("n(ext), s(tep), p(rint) NAME, bt, c(ontinue to the next function of yours), q(uit); "
            "if it crashes: c until it does, then bt")
    print(f"{unit.shown}, test {test}; in gdb: {keys}", flush=True)
    os.environ["CMOCKA_MESSAGE_OUTPUT"] = "TAP"
    # set startup-with-shell off: avoids quoting and a shell's start files.
    os.execv(debugger, [debugger, "-q", "-ex", "set startup-with-shell off", "-x", script, "-ex", "run",
                        "--args", program, "--only", test])
    return 1


if __name__ == "__main__":
    sys.exit(main())
