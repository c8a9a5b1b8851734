#!/usr/bin/env python3
"""Grades units against their suites: compiles each once, runs its scored tests in processes of their own
under limits, and reports points.

A test counts as passed only if its process returns from it and proves so (see verdicts.py);
crashes, endless loops, leaks and programs that end early are failed tests with a reason.
"""

import concurrent.futures
import contextlib
import difflib
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading

from grading import bubblewrap
from grading import build
from grading import integrity
from grading import isolate
from grading import judged
from grading import last_check
from grading import private_copy
from grading import results
from grading import sandbox
from grading import unit_rules
from grading.assignments import (
    DEDUCTION, FREES_ALL, KEEPS_NOTHING, MachineError, Parser, ToolError, UngradableError, Unit, UnitError,
    check_impl, choose, choose_format, handed_in, ignored_in, missing_unit, read_features, read_points,
    submitted_unit, unit_beside, units_of_suite,
)
from grading.parallel_jobs import processors, stop_on_signals
from grading.starters import is_starter
from grading.verdicts import Verdict, judge, judge_kept_data, judge_leaks, make_secret, printed_lines

MEGABYTES = 2048  # the suites stay below 300 with the sanitizers
REASON_MAX = 500  # characters; a unit can write a reason of its own
SOON = 3  # seconds; with a record, what takes longer is run again after all others
TIMEOUTS = 2  # so many tests of a suite may take all their time; the others then get a part of it
LOOPS = 6  # after so many that did not end, the others get less again: a loop that all tests run into
TOGETHER = 10  # of a test's seconds, the part that one call may take of a unit that several tests share
IN_ALL = 18  # times the seconds of one test, which all tests of a suite may take; the others get a part, too
DECOYS = 8  # so many passed claims of a suite run again with an end that cannot hold


class Suite:
    """The result of one feature: its unit, its scored tests and a verdict for each. `problem` is the
    reason why nothing ran, `beside` what is to be known of a student's units that it needs, `excused` names
    the claims that fail by these, `is_own` whether who reads the report has graded the unit; `remarks` say
    what was found where, or ignored. `not_graded` says what is to be done before the unit can be graded: its
    points are not 0 but unknown."""

    def __init__(self, feature, unit, tests):
        self.feature, self.unit, self.tests = feature, unit, tests
        self.verdicts, self.warnings, self.problem, self.beside = {}, "", "", ""
        self.program, self.folder, self.source = None, None, ""
        self.unit_program, self.claims_together = None, []
        self.finds_leaks, self.is_own, self.remarks = False, True, []
        self.needed_objects, self.excused, self.not_graded = [], set(), ""
        self.is_slow = False  # from then on its tests run one by one

    def passed(self):
        return all(self.verdicts[test.name].passed for test in self.tests)

    def scores(self):
        """Returns the points of each test by its name: negative for one without points that failed, as
        far as there are points to lose; the reference's work earns none. At home one that did not end costs
        nothing yet: the loop that never ends is the fault to work on."""
        if self.unit.is_reference:
            return {test.name: 0 for test in self.tests}
        scores = {test.name: test.points if self.verdicts[test.name].passed else 0 for test in self.tests}
        left = sum(scores.values())
        for test in self.tests:
            verdict = self.verdicts[test.name]
            if test.points == 0 and not verdict.passed and test.name not in self.excused and not (
                    self.is_own and verdict.timed_out):
                scores[test.name] = -min(DEDUCTION, left)
                left += scores[test.name]
        return scores

    def points(self):
        """The points earned."""
        return sum(self.scores().values())

    def claims(self):
        """The tests that a program runs; the others are the grader's own."""
        return [test for test in self.tests if test.name not in (KEEPS_NOTHING.name, FREES_ALL.name)]

    def costly(self):
        """The claims that failed although they held with the starter."""
        return [test for test in self.claims() if test.points == 0 and not self.verdicts[test.name].passed]

    def points_max(self):
        return sum(test.points for test in self.tests)

    def give_up(self, reason, details=""):
        """Every test fails for the same reason."""
        self.problem = reason
        for test in self.tests:
            self.verdicts[test.name] = Verdict(False, reason, "", details)

    def judged(self):
        """Returns what grading found out, as JSON can hold it."""
        verdicts = {name: [verdict.passed, verdict.reason, verdict.place, verdict.details, verdict.seconds,
                           verdict.timed_out] for name, verdict in self.verdicts.items()}
        return {"problem": self.problem, "warnings": self.warnings, "beside": self.beside,
                "verdicts": verdicts, "excused": sorted(self.excused)}

    def take(self, judged):
        """Takes over what judged() returned in another process."""
        self.problem, self.warnings, self.beside = (str(judged[key])
                                                    for key in ("problem", "warnings", "beside"))
        self.excused = {str(name) for name in judged["excused"]}
        for test in self.tests:
            passed, reason, place, details, seconds, timed_out = judged["verdicts"][test.name]
            verdict = Verdict(passed is True, str(reason), str(place), str(details), float(seconds))
            verdict.timed_out = timed_out is True
            self.verdicts[test.name] = verdict

    def first_limit(self, usual):
        """Returns the seconds after which a claim is left until the others have run: five times as many as
        it took when it last passed, and some more, so that an endless loop shows soon."""
        is_late = sum(verdict.timed_out for verdict in list(self.verdicts.values())) >= TIMEOUTS
        if usual is None:
            return SOON / 5 if is_late else SOON
        return 5 * usual + (0.2 if is_late else 1)

    def hung(self):
        """Returns how many tests did not end, so far."""
        return sum(verdict.timed_out and not verdict.is_open for verdict in list(self.verdicts.values()))

    def limit_of_next_test(self, seconds, counts_calls=False):
        """Returns the limit for the next test, and a phrase for it: short after two that took all of
        theirs, but three times as long as those that passed, and after many that were slow. Where calls are
        counted, a short limit is that of one call."""
        verdicts = list(self.verdicts.values())
        if sum(verdict.worked for verdict in verdicts) > IN_ALL * seconds:
            return seconds / 10, (f"{seconds / 10:.3g} s (a short limit, as the tests before it took more "
                                  f"than {IN_ALL * seconds:.3g} s together)")
        hung = self.hung()
        if hung < TIMEOUTS or counts_calls:
            return seconds, f"{seconds:g} seconds"
        slowest = max((verdict.seconds for verdict in verdicts if verdict.passed), default=0)
        # At home the others are only waited for so long that the student sees which hold.
        longest = seconds / 5 if self.is_own else seconds
        short = min(longest, max(seconds / (10 if hung < LOOPS else 40), 3 * slowest))
        many = f"{TIMEOUTS} tests before it took all of theirs" if hung < LOOPS else (
            f"{LOOPS} tests before it did not end")
        return short, f"{short:.3g} s (a short limit, as {many})"

    def limit_of_one_call(self, seconds):
        """Returns the limit for one call of the next test, where calls are counted, and a phrase for it: none
        before a test did not end, and a short one then, but three times as long as whole tests that passed.
        Who works slowly through many calls has all the time of a test."""
        hung = self.hung()
        if not hung:
            return None, ""
        verdicts = list(self.verdicts.values())
        slowest = max((verdict.seconds for verdict in verdicts if verdict.passed), default=0)
        short = min(seconds, max(seconds / (10 if hung < TIMEOUTS else 40), 3 * slowest))
        return short, f"{short:.3g} s in one call (a short limit, as a test before it did not end)"


def seconds_per_test():
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
    """Returns a unit's object, as the suite links it, the compiler's warnings, and what is in it."""
    if unit.is_reference:
        return toolchain.built(f"src/features/{unit.feature.stem}.o"), "", None
    path, warnings = build.compile_unit(toolchain, unit, folder, toolchain.of_units)
    found = build.check_object(toolchain, unit, path)
    build.check_definitions(toolchain, unit, found)
    build.keep_interface(toolchain, unit.feature, path, for_suite=True)
    return path, warnings, found


def _link(toolchain, suite, units, objects):
    """Returns the programs of the suite with its unit, and of the unit alone, for a judge; None for what no
    claim needs."""
    stem, apart = suite.feature.stem, None
    if toolchain.judges and judged.is_possible(toolchain, stem):
        suite.claims_together = judged.claims_together(toolchain, stem)
        apart = judged.link_unit(toolchain, units, objects, suite.folder)
    together = None
    if not apart or any(claim.name in suite.claims_together for claim in suite.claims()):
        together = build.link_suite(toolchain, units, objects, suite.folder, toolchain.sanitize)
    return together, apart


def build_suite(toolchain, suite, needed_units):
    """Builds the suite's program around the unit, or gives up with the reason."""
    units, objects = [suite.unit, *needed_units], []
    try:
        suite.unit, *needed_units = [private_copy.copy_unit(unit, suite.folder)
                                     for unit in (suite.unit, *needed_units)]
        units = [suite.unit, *needed_units]
        for unit in units:
            path, warnings, found = _object_of(toolchain, unit, suite.folder)
            objects.append((path, found))
            suite.warnings += warnings if unit is suite.unit else ""
        suite.needed_objects = [path for path, _ in objects[1:]]
        suite.source = os.path.join(toolchain.source, "tests", f"test_{suite.feature.stem}.c")
        programs = _link(toolchain, suite, units, [path for path, _ in objects])
        for unit, (_, found) in zip(units, objects):
            if found:
                build.check_names(toolchain, unit, found)
        kept = unit_rules.kept_data(objects[0][1]) if objects[0][1] else []
        suite.verdicts[KEEPS_NOTHING.name] = judge_kept_data(kept)
        suite.program, suite.unit_program = [path and sandbox.Program(path) for path in programs]
    except build.BuildError as error:
        suite.give_up(error.reason, error.details)
    except UnitError as error:
        suite.give_up(str(error))


# --- Running ------------------------------------------------------------------------------------


def _environment(folder, finds_leaks, megabytes):
    """The program's environment, with nothing that leads to the kit."""
    return dict(
        sandbox.bare_environment(folder), CMOCKA_MESSAGE_OUTPUT="TAP", UBSAN_OPTIONS="print_stacktrace=1",
        # 2: the suite's own signal handlers are disabled. The slow unwinder sees through code
        # without frame pointers, so that a leak's trace reaches the unit.
        ASAN_OPTIONS="handle_segv=2:handle_sigbus=2:handle_sigfpe=2:handle_sigill=2:handle_abort=1:"
        "allocator_may_return_null=1:fast_unwind_on_malloc=0:"
        # The suite asks for leaks; a unit that ends the program does not come around that.
        f"detect_leaks={1 if finds_leaks else 0}:leak_check_at_exit=0:"
        # A slow machine takes longer to fill so much than a test may last.
        f"max_allocation_size_mb={megabytes}",
    )


def _with_lines(toolchain, program, text):
    """Adds functions and lines to traces whose program is not found because it is in memory only."""
    unnamed = r"(#\d+ 0x[0-9a-f]+) +\(/memfd:\S+ \(deleted\)\+(0x[0-9a-f]+)\).*"
    addresses = list(dict.fromkeys(address for _, address in re.findall(unnamed, text)))
    finder = shutil.which("addr2line")
    if not addresses or not finder or program.descriptor is None:
        return text
    command = [finder, "-f", "-e", program.path, *addresses]
    if toolchain.sandbox:
        command = toolchain.sandbox.around(command)
    answer = subprocess.run(command, pass_fds=(program.descriptor,), capture_output=True, text=True,
                            errors="replace",
                            check=False).stdout.splitlines()
    names = {address: f"{function} {place}"
             for address, function, place in zip(addresses, answer[::2], answer[1::2])}
    return re.sub(unnamed, lambda match: f"{match[1]} in {names.get(match[2], '?')}", text)


def _options(toolchain, suite, limit, megabytes, options=""):
    """How a program runs, with these options for the address sanitizer beside the usual ones."""
    # In the sandbox, a program has a /tmp of its own.
    folder = suite.folder if toolchain.sandbox else tempfile.mkdtemp(dir=suite.folder)
    environment = _environment("/tmp" if toolchain.sandbox else folder, suite.finds_leaks, megabytes)
    environment["ASAN_OPTIONS"] += options
    return {"seconds": limit, "megabytes": megabytes, "folder": folder, "environment": environment,
            "enclose": toolchain.sandbox and toolchain.sandbox.around,
            "system_calls": toolchain.sandbox.filter if toolchain.sandbox else b""}


def _run(toolchain, suite, name, limit, megabytes, call_limit=None, decoy=False):
    """Runs one claim: with the unit in a process of its own where that can be."""
    options, secret = _options(toolchain, suite, limit, megabytes), make_secret(decoy)
    if _is_apart(suite, name):
        options["asks_where"] = suite.hung() < TIMEOUTS  # it takes time, and two places are enough
        return judged.run(toolchain, suite.feature.stem, [name], suite.unit_program, secret,
                          call_limit, **options)
    options["asks_where"] = suite.hung() < LOOPS
    return sandbox.run(["test_" + suite.feature.stem, "--only", name], program=suite.program, secret=secret,
                       **options)


def _is_apart(suite, name):
    return suite.unit_program and name not in suite.claims_together


def run_test(toolchain, suite, test, seconds, megabytes, record=None):
    """Runs one scored test and returns its Verdict. With a record it is left open if it takes much longer
    than before: a slower unit may be right, and waiting for an endless loop would hold up the others."""
    usual = record and record.usual(test.name)
    soon = suite.first_limit(usual) if record else seconds
    is_apart = _is_apart(suite, test.name)
    limit, phrase = (soon, "") if soon < seconds else suite.limit_of_next_test(seconds, is_apart)
    call_limit, call_phrase = suite.limit_of_one_call(seconds)
    outcome = _run(toolchain, suite, test.name, limit, megabytes, call_limit)
    program = suite.unit_program if is_apart else suite.program
    outcome.output = build.plain(toolchain, suite.unit, _with_lines(toolchain, program, outcome.output))
    verdict = judge(outcome, suite, test.name, call_phrase if outcome.limit == "call" else phrase, megabytes)
    verdict.worked = outcome.worked
    if verdict.timed_out and not phrase:
        before = f" (it took {usual:.2g} s before)" if usual is not None else ""
        verdict.is_open = True
        verdict.reason = f"still running after {soon:.2g} s{before}: perhaps an endless loop"
    if len(verdict.reason) > REASON_MAX:
        verdict.reason = verdict.reason[:REASON_MAX] + " ..."
    return verdict


def hold_together(toolchain, suite, tests, seconds, megabytes):
    """Runs several scored tests with one process of the unit, and fills in their verdicts if all hold and
    nothing is to be said of any. Returns whether it did."""
    if suite.is_slow or len(tests) < 2:
        return False
    outcome = judged.run(toolchain, suite.feature.stem, [test.name for test in tests], suite.unit_program,
                         make_secret(False), seconds / TOGETHER, asks_where=False,
                         **_options(toolchain, suite, seconds, megabytes))
    suite.is_slow |= outcome.limit in ("seconds", "call")
    times = outcome.testimony.split()
    if outcome.limit or outcome.status or not outcome.attested or len(times) != len(tests) or printed_lines(
            outcome.output):
        return False
    for test, time in zip(tests, times):
        verdict = suite.verdicts[test.name] = Verdict(True, seconds=float(time))
        verdict.worked = outcome.worked / len(tests)
    return True


def _groups(suite):
    """Returns the tests that are tried together, as lists: those of a step that a judge runs."""
    groups = {}
    for test in suite.claims():
        groups.setdefault(test.step if _is_apart(suite, test.name) else test.name, []).append(test)
    return list(groups.values())


def _about_needs(suite, units):
    """Says what may fail a suite beside its own unit: in a pack, needed units are the student's, too."""
    for unit in units_of_suite(suite.feature, units):
        stem = unit.feature.stem
        if unit.is_reference or suite.passed() or suite.problem or is_starter(suite.unit):
            continue
        if is_starter(unit):
            return f"it needs {stem}, which is still the starter: solve that first"
        return f"it calls your {stem}, too: if make check-{stem} fails, mend that first"
    return ""


def _excuse(toolchain, suite, units, seconds, megabytes):
    """What held with the starter is not this unit's fault where it fails with the starter, too: then a needed
    unit that is the student's own breaks it. In a pack the starter is what stands in for the reference."""
    needed = [unit for unit in units_of_suite(suite.feature, units) if not unit.is_reference]
    if not needed or suite.problem or not suite.costly():
        return
    starter = os.path.join(suite.folder, "starter")
    os.mkdir(starter)
    objects = [toolchain.built(f"src/features/{suite.feature.stem}.o"), *suite.needed_objects]
    program = build.link_suite(toolchain, [suite.unit, *needed], objects, starter, toolchain.sanitize)
    with contextlib.closing(sandbox.Program(program)) as program:
        for test in suite.costly():
            outcome = sandbox.run(["test_" + suite.feature.stem, "--only", test.name], program=program,
                                  secret=make_secret(False), **_options(toolchain, suite, seconds, megabytes))
            if not outcome.attested:
                suite.excused.add(test.name)


def _can_find_leaks(toolchain, suites, seconds, megabytes):
    """Whether the leak sanitizer works here: it fails where processes may not be traced. Asked of a run
    that calls no unit's code."""
    suite = next(iter(suites), None)
    if not suite or not toolchain.finds_leaks():
        return False
    options = _options(toolchain, suite, seconds, megabytes, ":detect_leaks=1:leak_check_at_exit=1")
    program = suite.program or suite.unit_program
    return sandbox.run(["program", "--list"], program=program, **options).status == 0


def _judge_leaks(suite):
    """A failed test leaves its memory behind, so leaks count in passed ones. Together they are a claim; if
    one test was asked for, it is that test's fault."""
    leaks = [(test.name, suite.verdicts[test.name]) for test in suite.claims()
             if suite.verdicts[test.name].leak]
    suite.verdicts[FREES_ALL.name] = judge_leaks(leaks)
    if FREES_ALL.name not in [test.name for test in suite.tests]:
        suite.verdicts.update((name, judge_leaks([(name, verdict)])) for name, verdict in leaks)
    elif not suite.finds_leaks:
        suite.warnings = "\n".join(filter(None,
                                          [suite.warnings,
                                           f"{FREES_ALL.name} is not judged: the leak sanitizer "
                                                 "does not work here"]))


def _run_decoys(toolchain, suite, count, seconds, megabytes):
    """Runs some of the passed claims again, as decoys: after the claim the suite fails, whatever the unit
    did. A unit that sends the secret in place of the suite passes these, too, and loses everything."""
    passed = [test for test in suite.claims()
              if suite.verdicts[test.name].passed and not _is_apart(suite, test.name)]
    for test in random.SystemRandom().sample(passed, min(count, len(passed))):
        if _run(toolchain, suite, test.name, seconds, megabytes, decoy=True).attested:
            suite.give_up("attests a claim that cannot hold, so none of its verdicts counts: "
                          "the code sends them in place of the suite")
            return


def grade(toolchain, suites, units, seconds, megabytes=MEGABYTES, progress=None, decoys=DECOYS, record=None):
    """Builds all suites, then runs them, on all processors or as many as the toolchain says, with `units` for
    what they need beside their own; fills in their verdicts. All are built before any unit runs, and so could
    meddle. `progress` is called with the numbers of tests that ran and will run. A Record chooses the order,
    and what it leaves open runs again, after all others, as without it."""
    workers = toolchain.workers or processors()

    def run_into(suite, test, is_again=False):
        suite.verdicts[test.name] = run_test(toolchain, suite, test, seconds, megabytes,
                                             None if is_again else record)
        if record:
            record.add(test.name, suite.verdicts[test.name])

    def run_all_into(suite, tests):
        if not hold_together(toolchain, suite, tests, seconds, megabytes):
            for test in tests:
                run_into(suite, test)

    def finish(futures, tell=None):
        for number, done in enumerate(concurrent.futures.as_completed(futures), 1):
            done.result()
            if tell:
                tell(number, len(futures))

    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        try:
            finish([pool.submit(build_suite, toolchain, suite, units_of_suite(suite.feature, units))
                    for suite in suites if not suite.problem])
            built = [suite for suite in suites if suite.program or suite.unit_program]
            finds_leaks = _can_find_leaks(toolchain, built, seconds, megabytes)
            for suite in built:
                suite.finds_leaks = finds_leaks
            runs = [(suite, group) for suite in built for group in _groups(suite)]
            if record:
                runs = [(suite, [test]) for suite, group in runs for test in group]
                runs.sort(key=lambda run: record.urgency(run[1][0].name), reverse=True)
            if progress:
                progress(0, len(runs))
            finish([pool.submit(run_all_into, suite, group) for suite, group in runs], progress)
            left_open = [(suite, test) for suite in built for test in suite.claims()
                         if suite.verdicts[test.name].is_open]
            for suite, test in left_open:
                del suite.verdicts[test.name]
            finish([pool.submit(run_into, suite, test, True) for suite, test in left_open])
            for suite in built:
                _judge_leaks(suite)
            finish([pool.submit(_run_decoys, toolchain, suite, decoys, seconds, megabytes)
                    for suite in built])
            finish([pool.submit(_excuse, toolchain, suite, units, seconds, megabytes) for suite in built])
            for suite in suites:
                suite.beside = _about_needs(suite, units)
        except BaseException:
            sandbox.stop.set()
            pool.shutdown(cancel_futures=True)
            raise
        finally:
            for program in [program for suite in suites for program in (suite.program, suite.unit_program)]:
                if program:
                    program.close()


# --- The command --------------------------------------------------------------------------------


def _arguments():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog="Exit status: 0 all tests passed, or FILE was written; 1 some test failed; "
        "2 nothing could be graded.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    add = parser.add_argument
    add("--impl", required=True, metavar="FILE_OR_DIR", help="a C file, or a folder with STEM.c")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    add("--format", metavar="FORMAT", default="text",
        help=f"of the report: {', '.join(sorted(results.FORMATS))}")
    add("--out", metavar="FILE", help="write the report there instead of standard output")
    add("--test", metavar="NAME", help="only this test")
    add("--own", action="store_true", help="a student's own check: brief, and files are named as IMPL does")
    add("--kept", metavar="DIR",
        help="with --own: keep there what makes the next check faster, and a record of this one")
    add("--all", action="store_true", help="with --own: not brief")
    return parser.parse_args()


def _not_handed_in(unit):
    """Says which files a right solution would miss where only its .c is handed in."""
    try:
        headers = private_copy.own_headers(unit) if unit.path and not unit.is_reference else []
    except OSError:  # told when the unit is copied
        headers = []
    file = os.path.basename(unit.path or "")
    return [f"it includes {' and '.join(headers)}: where only {file} is handed in, that is missing and "
            "nothing compiles; move these lines into it"] if headers else []


def _other_names(unit):
    """A hard link to another's file is that file."""
    names = os.stat(unit.path).st_nlink if unit.path and not unit.is_reference else 1
    return [f"{unit.feature.stem}.c has {names} names on this disk (hard links): is it another's file?"] if (
        names > 1) else []


def _prepare_suite(feature, impl, own, only):
    """Returns the suite of one feature; one that has given up where there is nothing to judge."""
    listed = [KEEPS_NOTHING, *read_points(feature), FREES_ALL]
    # Whether all memory is freed shows in all tests.
    tests = [test for test in listed if only in (None, test.name, FREES_ALL.name)]
    if not tests:
        names = [test.name for test in listed]
        near = [name for name in names if only in name] or difflib.get_close_matches(only, names, 3, 0.3)
        hint = f"they stand in {feature.points_table}"
        if near:
            hint = "do you mean " + " or ".join(near[:3]) + "?"
        raise ToolError(f"{feature.stem} has no test {only}; {hint}")
    try:
        unit, remarks = (submitted_unit(feature, impl), []) if own else handed_in(feature, impl)
        if not own and not unit.is_reference:
            unit.shown = results.name_of(unit.path)
        suite = Suite(feature, unit, tests)
        remarks += _other_names(unit) if not own else []
        missed = _not_handed_in(unit)
        suite.remarks += remarks + (missed if own else [])
        return suite
    except UnitError as error:
        suite = Suite(feature, Unit(feature, None, feature.stem + ".c", False), tests)
        suite.not_graded = str(error) if isinstance(error, UngradableError) else ""
        suite.give_up(f"not graded: {error}" if suite.not_graded and not own else str(error))
        return suite


def prepare_suites(features, chosen, impl, own, only=None):
    """Returns the suites to grade."""
    check_impl(features, impl, [feature.stem for feature in chosen], may_be_empty=not own)
    suites = [_prepare_suite(feature, impl, own, only) for feature in chosen]
    for suite in suites:
        suite.is_own = own
    paths = [suite.unit.path for suite in suites if suite.unit.path]
    folders = {os.path.dirname(path) for path in paths}
    if not own and os.path.isdir(impl) and len(folders) == 1:
        suites[0].remarks += ignored_in(features, folders.pop(), map(os.path.basename, paths))
    return suites


class Record:
    """The claims of one check, a line of JSON for each as it ends, in a file that the next check finds. What
    failed runs first then, and what took long before the rest, so that all processors are done at about the
    same time."""

    def __init__(self, folder):
        self._path, self._before, self._lock = os.path.join(folder, "claims"), {}, threading.Lock()
        # This file outlasts checks that do not compile, or are ended.
        self._usual_path, self._usual = os.path.join(folder, "usual"), {}
        try:
            with open(self._usual_path, encoding="utf-8") as file:
                self._usual = json.load(file)
            with open(self._path, encoding="utf-8") as file:
                self._before = {claim["name"]: claim for claim in map(json.loads, file)}
        except (OSError, ValueError, KeyError):
            pass  # the first check, or one that was ended meanwhile
        with open(self._path, "w", encoding="utf-8"):
            pass

    def add(self, name, verdict):
        claim = {"name": name, **{key: getattr(verdict, key)
                                  for key in ("passed", "seconds", "reason", "place", "is_open")}}
        with self._lock:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write(json.dumps(claim) + "\n")
            if verdict.passed:
                self._usual[name] = verdict.seconds
                with open(self._usual_path, "w", encoding="utf-8") as file:
                    json.dump(self._usual, file)

    def urgency(self, name):
        before = self._before.get(name, {"passed": True, "seconds": 0})
        return not before["passed"], before["seconds"]

    def usual(self, name):
        """Returns the seconds that the claim took when it last passed, None if it never did."""
        return self._usual.get(name)


def _grade_here(toolchain, features, suites, impl, decoys=DECOYS, progress=None, kept=None):
    """Grades suites on copies of the kit and the units; with `kept`, on the kit's copy in this folder."""
    units = {stem: unit_beside(feature, impl, toolchain.handed_out) for stem, feature in features.items()}
    seconds = seconds_per_test()
    sandbox.prepare()
    work = private_copy.make_folder()
    try:
        copied = private_copy.kit_in(toolchain.kit_copy, toolchain) if toolchain.kit_copy else (
            private_copy.update_kit if kept else private_copy.copy_kit)(
                toolchain, features, [suite.feature.stem for suite in suites], kept or work)
        for suite in suites:
            suite.folder = os.path.join(work, suite.feature.stem)
            os.mkdir(suite.folder)
        grade(copied, suites, units, seconds, progress=progress, decoys=decoys,
              record=Record(kept) if kept else None)
    finally:
        sandbox.end_strays()
        shutil.rmtree(work, ignore_errors=True)
    return [suite.judged() for suite in suites]


def grade_impl(build_folder, stems, impl, own=False, only=None, progress=None, kept=None):
    """Grades one's own work; returns (toolchain, suites), or raises ToolError. At home nobody needs decoys.
    `kept` is a folder that makes the next check faster."""
    toolchain = build.Toolchain(build_folder)
    features = read_features(toolchain.source)
    suites = prepare_suites(features, choose(features, stems), impl, own, only)
    suites[0].remarks += toolchain.left_out()
    _grade_here(toolchain, features, suites, impl, 0 if own or only else DECOYS, progress, kept)
    return toolchain, suites


def require_units(build_folder, stems, impl):
    """Raises ToolError if a unit is missing, with the file that was probably meant."""
    features = read_features(build.Toolchain(build_folder).source)
    check_impl(features, impl, stems)
    for feature in choose(features, stems):
        name = feature.stem + ".c"
        try:
            submitted_unit(feature, impl)
        except UnitError as error:
            if os.path.lexists(os.path.join(impl, name)) or not os.path.isdir(impl):
                raise
            raise missing_unit(feature, impl) from error


def _grade_apart(toolchain, features, suites, impl, decoys, progress):
    """Grades in a separate process. If a unit ends it, each feature gets one of its own, and a unit
    that ends it again gets no verdicts."""
    try:
        judged = isolate.call(_grade_here, toolchain, features, suites, impl, decoys, progress)
        for suite, found in zip(suites, judged, strict=True):
            suite.take(found)
    except isolate.Ended as ended:
        if len(suites) > 1:
            for suite in suites:
                _grade_apart(toolchain, features, [suite], impl, decoys, progress)
        elif toolchain.sandbox and str(ended) != "SIGXCPU":  # no signal comes out of there
            raise MachineError(f"the grader was ended by {ended}") from ended
        else:
            suites[0].give_up("takes the grader too long to read, so no claim has a verdict"
                              if str(ended) == "SIGXCPU" else
                              f"ended its grader, by {ended}, so no claim has a verdict: does the code send "
                              "signals?")
    except (ValueError, TypeError, KeyError) as error:
        raise ToolError("the grader's answer is damaged, "
                        "so no verdict on this submission is believed") from error


def grade_submission(toolchain, stems, impl, only=None, progress=None):
    """Returns the suites of somebody else's work, which runs in the toolchain's sandbox."""
    suites = prepare_submission(toolchain, stems, impl, only)
    grade_prepared(toolchain, suites, impl, 0 if only else DECOYS, progress)
    return suites


def prepare_submission(toolchain, stems, impl, only=None):
    """Returns the suites of somebody else's work, without verdicts where they are to be graded."""
    toolchain.judges = True
    features = read_features(toolchain.source)
    suites = prepare_suites(features, choose(features, stems), impl, False, only)
    suites[0].remarks += ["graded " + toolchain.remark] if toolchain.remark else []
    suites[0].remarks += ["graded " + remark for remark in toolchain.left_out()]
    suites[0].remarks += [f"random cases of SEED={sandbox.seed()}"] if sandbox.seed() else []
    return suites


def grade_prepared(toolchain, suites, impl, decoys=DECOYS, progress=None):
    """Grades these suites of prepare_submission."""
    _grade_apart(toolchain, read_features(toolchain.source), suites, impl, decoys, progress)


def check_seed():
    """Raises ToolError if SEED is no number that the suites can take."""
    if not re.fullmatch(r"[0-9]{0,10}", sandbox.seed()) or int(sandbox.seed() or 0) >= 1 << 32:
        raise ToolError(f"SEED: {sandbox.seed()} is no whole number from 0 to 4294967295, from which the "
                        "suites draw their random cases")


def show_progress(done, total):
    """For a terminal: one line that is overwritten, and cleared in the end."""
    text = f"running test {done + 1} of {total}" if done < total else ""
    print(f"\r{text:<40}" + ("" if text else "\r"), end="", file=sys.stderr, flush=True)


def tell_progress(done, total):
    """For a pipe or a file: a line now and then, as the build has them."""
    if done % 50 == 0 and done < total:
        print(f"  TEST     {done} of {total}", file=sys.stderr, flush=True)


def _check(arguments, progress):
    """Grades one's own work; what fails first is kept for the list of hints."""
    features = read_features(build.Toolchain(arguments.build).source)
    states = [last_check.state_of(feature, arguments.impl) for feature in choose(features, arguments.stems)]
    _, suites = grade_impl(arguments.build, arguments.stems, arguments.impl, True, arguments.test, progress,
                           arguments.kept)
    for suite, state in zip(suites, states):
        if state and not arguments.test:
            last_check.write(arguments.build, suite, state)
    return suites


def main():
    arguments = _arguments()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    stop_on_signals()
    progress = show_progress if sys.stderr.isatty() else None
    try:
        choose_format(arguments.format, results.FORMATS)
        check_seed()
        results.check_visibility()
        results.check_place(arguments.out)
        if arguments.own:
            require_units(arguments.build, arguments.stems, arguments.impl)
            suites = _check(arguments, progress)
        else:
            sandbox.prepare()
            toolchain = build.Toolchain(arguments.build)
            toolchain.sandbox, toolchain.remark = bubblewrap.find(toolchain)
            if toolchain.remark:
                print(f"grade: {toolchain.remark}", file=sys.stderr)
            watch = None if toolchain.sandbox else integrity.Watch(toolchain)
            suites = grade_submission(toolchain, arguments.stems, arguments.impl, arguments.test, progress)
            changed = watch.changed() if watch else ""
            if changed:
                raise ToolError(f"meanwhile, {changed} changed, so no verdict is believed; "
                                "bring it back, and grade again")
        results.write(suites, arguments.format, arguments.impl, arguments.out,
                      arguments.own and not arguments.all)
    except ToolError as error:
        print(f"{'check' if arguments.own else 'grade'}: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"grade: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("grade: stopped", file=sys.stderr)
        return 130
    return 0 if arguments.out or all(suite.passed() for suite in suites) else 1


if __name__ == "__main__":
    sys.exit(main())
