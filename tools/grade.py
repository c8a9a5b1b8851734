#!/usr/bin/env python3
"""Grades units against their suites: compiles each once, runs every scored test in a process of its
own under limits, and reports points.

A test counts as passed only when its process came back from it and proved so (see verdicts.py);
crashes, endless loops, leaks and programs that end early are failed tests with a reason.
"""

import argparse
import concurrent.futures
import os
import shutil
import signal
import sys
import tempfile
import threading

import building
import guarded
import results
from assignments import (
    ToolError, check_impl, choose, find_unit, read_features, read_points, reference_unit, unit_beside,
)
from verdicts import Verdict, judge

MEGABYTES = 2048  # the suites stay below 300 with the sanitizers


class Suite:
    """What became of one feature: its unit, its scored tests and a verdict for each. `problem` is
    why nothing ran, `fallback` says that the reference stood in."""

    def __init__(self, feature, unit, tests, fallback=False):
        self.feature, self.unit, self.tests, self.fallback = feature, unit, tests, fallback
        self.verdicts, self.warnings, self.problem = {}, "", ""
        self.program, self.folder = None, None

    def passed(self):
        return all(self.verdicts[test.name].passed for test in self.tests)

    def points(self):
        """The points earned; nobody earns any with the reference's work."""
        if self.unit.is_reference:
            return 0
        return sum(test.points for test in self.tests if self.verdicts[test.name].passed)

    def points_max(self):
        return sum(test.points for test in self.tests)

    def give_up(self, reason, details=""):
        """Every test fails for the same reason."""
        self.problem = reason
        for test in self.tests:
            self.verdicts[test.name] = Verdict(False, reason, "", details)


def time_limit():
    """Seconds that one test may take."""
    text = os.environ.get("RAYKIT_TEST_SECONDS", "10")
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0
    if not seconds > 0:
        raise ToolError(f"RAYKIT_TEST_SECONDS is \"{text}\"; give a number of seconds above 0")
    return seconds


# --- Building -----------------------------------------------------------------------------------


def _object_of(toolchain, unit, folder):
    """Returns a unit's object, as the suite links it, and the compiler's warnings."""
    if unit.is_reference:
        return toolchain.built(f"src/features/{unit.feature.stem}.o"), ""
    flags = [*toolchain.sanitize, "-g1", "-O1"]
    path, warnings = building.compile_unit(toolchain, unit, folder, flags)
    building.check_no_early_code(toolchain, unit, path)
    building.keep_interface(toolchain, unit.feature, path)
    return path, warnings


def build(toolchain, suite, needed_units):
    """Builds the suite's program around the unit, or gives up with the reason."""
    try:
        objects = []
        for unit in [suite.unit, *needed_units]:
            path, warnings = _object_of(toolchain, unit, suite.folder)
            objects.append(path)
            suite.warnings += warnings if unit is suite.unit else ""
        suite.program = building.link_suite(
            toolchain, [suite.unit, *needed_units], objects, suite.folder, toolchain.sanitize
        )
    except building.BuildError as error:
        suite.give_up(error.reason, error.details)


# --- Running ------------------------------------------------------------------------------------


def _environment(toolchain, folder, look_for_leaks):
    """What the program sees: nothing of the caller's but where programs and libraries are."""
    kept = ("PATH", "LD_LIBRARY_PATH", "RAYKIT_ISA", "ASAN_SYMBOLIZER_PATH")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    leaks = os.path.join(toolchain.source, "tests", "leaks.txt")
    environment.update(
        HOME=folder, TMPDIR=folder, LC_ALL="C", CMOCKA_MESSAGE_OUTPUT="TAP",
        RAYKIT_HELPERS=toolchain.build, UBSAN_OPTIONS="print_stacktrace=1",
        LSAN_OPTIONS=f"suppressions={leaks}:print_suppressions=0",
        # 2: the suite's own signal handlers stand back. The slow unwinder sees through code
        # without frame pointers, so that a leak's trace reaches the unit.
        ASAN_OPTIONS="handle_segv=2:handle_sigbus=2:handle_sigfpe=2:handle_sigill=2:handle_abort=1:"
        "allocator_may_return_null=1:fast_unwind_on_malloc=0:"
        f"detect_leaks={1 if look_for_leaks else 0}",
    )
    return environment


def run_test(toolchain, suite, test, seconds, megabytes):
    """Runs one scored test and returns its Verdict."""
    for look_for_leaks in (True, False):
        folder = tempfile.mkdtemp(dir=suite.folder)
        outcome = guarded.run(
            [suite.program, "--only", test.name], seconds=seconds, megabytes=megabytes,
            folder=folder, environment=_environment(toolchain, folder, look_for_leaks), attest=True,
        )
        # Where processes may not be traced, the leak sanitizer itself fails.
        if "LeakSanitizer has encountered a fatal error" not in outcome.output:
            break
    return judge(outcome, suite.unit, seconds, megabytes)


def grade(toolchain, suites, units, seconds, megabytes=MEGABYTES):
    """Builds and runs all suites on all processors, with `units` for what they need beside their
    own; fills in their verdicts."""
    workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()

    def run_into(suite, test):
        suite.verdicts[test.name] = run_test(toolchain, suite, test, seconds, megabytes)

    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        try:
            building_now = {
                pool.submit(build, toolchain, suite, [units[stem] for stem in suite.feature.needs]): suite
                for suite in suites if not suite.problem
            }
            running = []
            for done in concurrent.futures.as_completed(building_now):
                done.result()
                suite = building_now[done]
                if suite.program:
                    running += [pool.submit(run_into, suite, test) for test in suite.tests]
            for done in concurrent.futures.as_completed(running):
                done.result()
        except BaseException:
            guarded.stop.set()
            pool.shutdown(cancel_futures=True)
            raise


# --- The command --------------------------------------------------------------------------------


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; none means all of them")
    add = parser.add_argument
    add("--impl", required=True, metavar="FILE_OR_DIR", help="a C file, or a folder with STEM.c")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    add("--format", choices=sorted(results.FORMATS), default="text", help="of the report")
    add("--out", metavar="FILE", help="write the report there instead of standard output")
    add("--test", metavar="NAME", help="only this test")
    add("--fallback", action="store_true", help="for units that are not there run the reference, without points")
    return parser.parse_args()


def prepare_suites(features, chosen, impl, fallback, only=None):
    """Returns the suites to grade."""
    check_impl(features, impl, [feature.stem for feature in chosen])
    suites = []
    for feature in chosen:
        tests = [test for test in read_points(feature) if only in (None, test.name)]
        if not tests:
            raise ToolError(f"{feature.stem} has no scored test {only}; see {feature.points_table}")
        unit = find_unit(feature, impl)
        absent = unit.path is None
        stand_in = absent and fallback
        suite = Suite(feature, reference_unit(feature) if stand_in else unit, tests, stand_in)
        if absent and not fallback:
            suite.give_up(f"there is no {unit.shown}")
        suites.append(suite)
    return suites


def grade_impl(build_folder, stems, impl, fallback=False, only=None):
    """Grades and returns (toolchain, suites); raises ToolError."""
    toolchain = building.Toolchain(build_folder)
    features = read_features(toolchain.source)
    suites = prepare_suites(features, choose(features, stems), impl, fallback, only)
    units = {stem: unit_beside(feature, impl, toolchain.handed_out) for stem, feature in features.items()}
    seconds = time_limit()
    guarded.prepare()
    work = tempfile.mkdtemp(prefix="raykit-grade-")
    try:
        for suite in suites:
            suite.folder = os.path.join(work, suite.feature.stem)
            os.mkdir(suite.folder)
        grade(toolchain, suites, units, seconds)
    finally:
        guarded.end_strays()
        shutil.rmtree(work, ignore_errors=True)
    return toolchain, suites


def stop_on_signals():
    """SIGTERM and SIGHUP end a script as Ctrl-C does: with everything that it started."""

    def interrupt(_number, _frame):
        raise KeyboardInterrupt

    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, interrupt)


def main():
    arguments = _arguments()
    stop_on_signals()
    try:
        _, suites = grade_impl(
            arguments.build, arguments.stems, arguments.impl, arguments.fallback, arguments.test
        )
        results.write(suites, arguments.format, arguments.impl, arguments.out)
    except ToolError as error:
        print(f"grade: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"grade: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("grade: stopped", file=sys.stderr)
        return 130
    return 0 if all(suite.passed() for suite in suites) else 1


if __name__ == "__main__":
    sys.exit(main())
