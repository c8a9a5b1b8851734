#!/usr/bin/env python3
"""A student's commands, in a pack whose folder has a difficult name, and in a workbook of the whole kit.
Speaks TAP, for make check-student; runs in a build folder."""

import contextlib
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import redirect_stdout
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import draw  # noqa: E402
import grade  # noqa: E402
import handout  # noqa: E402
import hint  # noqa: E402
import pristine  # noqa: E402
import start as leading  # noqa: E402
import watch  # noqa: E402
from grading import originals, results, verdicts  # noqa: E402
from grading.assignments import (DEDUCTION, ScoredTest, ToolError, Unit, read_features,  # noqa: E402
                                 read_looks, read_points)
from grading.build import Toolchain  # noqa: E402
from grading.starters import read_regions, starter_of  # noqa: E402
from handout_text import handout_of, task_of  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

MAKE = os.environ.get("MAKE", "make")
STEM, OTHER = "bvh_median", "bloom"
FEATURES = read_features(SOURCE)
FEATURE = FEATURES[STEM]
STARTER = starter_of(FEATURE.reference)
TESTS = read_points(FEATURE)
SCREEN = 24
NAME = "Übung\t1; (50 %) | ~*"  # a folder's


def make(folder, *arguments):
    return run(folder, MAKE, "-s", "-j2", *arguments)


# --- What is said ---------------------------------------------------------------------------------


class Suite(grade.Suite):
    """A suite with these verdicts."""

    def __init__(self, feature, tests, failing, warnings="", problem="", reason="got 1, want 2", printed=""):
        super().__init__(feature, Unit(feature, "mine/x.c", "mine/x.c", False), tests)
        self.warnings, self.problem = warnings, problem
        self.verdicts = {test.name: verdicts.Verdict(test.name not in failing,
                                                     reason if test.name in failing else "",
                                                     "tests/x.c:1", printed) for test in tests}


def a_verdict_fits_on_a_screen():
    everything = [test.name for test in TESTS]
    told = results.text([Suite(FEATURE, TESTS, everything,
                               "\n".join(f"x.c:{k}: warning: odd" for k in range(90)),
                               reason="a long reason " * 20)], "mine", brief=True)
    lines = told.splitlines()
    check(len(lines) < SCREEN, "with every claim failing and 90 warnings the verdict fits on 24 lines", told)
    first = next((k for k, line in enumerate(lines) if f"work on this one first: {TESTS[0].name}" in line), 0)
    following = next(k for k, line in enumerate(lines) if f"then: {TESTS[1].name}" in line)
    check(0 < first < following
          and lines[following - 1].strip() == f"a hint: make hint-{FEATURE.stem} STEP={TESTS[0].step}",
          "the claim to work on first stands first", told)
    for impl, named in (("mine", "mine"), ("my work", "'my work'")):
        wanted = f" more: make check-{FEATURE.stem} ALL=1 IMPL={named}\n"
        told = results.text([Suite(FEATURE, TESTS, everything)], impl, brief=True)
        check(wanted in told + "\n" and TESTS[-1].name not in told,
              f"the others of {impl} are counted, with the way to see them", told)
    check(f"STEP={TESTS[0].step}" in told, "the step's hints are named", told)
    told = results.text([Suite(FEATURE, TESTS, everything)], "mine")
    check(all(test.name in told for test in TESTS), "in a report all are named", told)
    told = results.text([Suite(FEATURE, TESTS, everything, problem="does not compile: x.c:1: error: odd")],
                        "mine", brief=True)
    check(told.splitlines()[-1].strip() == "does not compile: x.c:1: error: odd",
          "why nothing ran stands last", told)
    error = "x.c:1:2: error: implicit declaration of function 'rk_odd'"
    for own in (True, False):
        suite = Suite(FEATURE, TESTS, everything, printed=f"x.c: In function 'f':\n{error}\n 1 | ;\n",
                      problem=f"does not compile: {error}; #include \"odd.h\" declares it")
        suite.is_own = own
        told = results.text([suite], "mine", brief=own)
        check(told.count(error) == 1 and told.rstrip().endswith('above; #include "odd.h" declares it'),
              f"a compiler's error is shown once, {'at home' if own else 'in a report'}", told)
        check(("0 of " in told) != own, "with points only in a report: at home nothing was checked", told)
    error, hint = "x.c:9:2: error: odd", "; a } is missing in f, which begins in line 3"
    suite = Suite(FEATURE, TESTS, everything, printed=f"{error}\n",
                  problem=f"does not compile: {error}{hint}")
    suite.is_own = True
    told = results.text([suite], "mine", brief=True)
    check(told.count(error) == 1 and told.rstrip().endswith(f"above{hint}"),
          "so it is where a brace is missing, with the function's name", told)
    os.environ["COLUMNS"] = "60"
    told = results.text([Suite(FEATURE, TESTS, everything, reason="a long reason " * 20)], "mine", brief=True)
    del os.environ["COLUMNS"]
    long = [line for line in told.splitlines() if len(line) > 60 and len(line.split()) > 2
            and "reason" in line]
    check(not long, "reasons are as wide as the terminal", long)
    kept = [ScoredTest("it_held", 0, "#"), ScoredTest("it_counts", 100, "#")]
    told = results.text([Suite(FEATURE, kept, ["it_held"])], "mine")
    check(f"{100 - DEDUCTION} of 100 points" in told and f"costs {DEDUCTION}" in told,
          "no failure stands beside full points", told)
    long = "what_held_with_the_starter_and_is_broken_now_by_a_name_as_long_as_this"
    kept = [ScoredTest(long, 0, "#"), ScoredTest("it_counts", 50, "#", 1), ScoredTest("half", 30, "#", 2),
            ScoredTest("other_half", 20, "#", 2)]
    told = results.text([Suite(FEATURE, kept, [long, "half"])], "mine", brief=True).splitlines()
    check(told[1].strip() == f"less {DEDUCTION} for {long}", "what costs points has a line of its own", told)
    check(told[2].strip() == "steps  1 [######]  2 [###...]", "each step has a bar of its claims that hold",
          told)


def what_is_printed_is_shown():
    one = TESTS[:1]
    told = results.text([Suite(FEATURE, one, [], printed="1..1\nhello\nthere\nok 1 - x\n")], "mine",
                        brief=True)
    check("hello\n" in told and "there\n" in told and "1..1" not in told,
          "a claim run alone shows what the code printed", told)


def progress_names_the_next_claim():
    needed, using = FEATURES["bvh_median"], FEATURES["sah_binning"]

    def row(beside, failing=()):
        suites = [Suite(needed, read_points(needed), failing),
                  Suite(using, read_points(using), [test.name for test in read_points(using)])]
        suites[1].beside = beside
        return results.table(suites, "workbook").splitlines()[2]

    first = read_points(using)[0].name
    told = row("it calls your bvh_median, too: if make check-bvh_median fails, mend that first")
    check(told.endswith(f"  {first}"), "progress names the claim, and no needed unit that has all points",
          told)
    beside = "it needs bvh_median, which is still the starter: solve that first"
    told = row(beside, [test.name for test in read_points(needed)])
    check(told.endswith(f"  {first}; {beside}"),
          "of a needed unit that is not solved it says all that the check says", told)


def a_starter_blames_no_needed_unit(folder):
    features = {stem: FEATURES[stem] for stem in ("bvh_median", "sah_binning")}
    using, units = features["sah_binning"], {}
    for stem, text in (("bvh_median", read(features["bvh_median"].reference)),
                       ("sah_binning", starter_of(using.reference))):
        path = os.path.join(folder, stem + ".c")
        write(text, path)
        units[stem] = Unit(features[stem], path, path, False)
    suite = Suite(using, read_points(using), [test.name for test in read_points(using)])
    suite.unit = units["sah_binning"]
    check(grade._about_needs(suite, units) == "", "a unit that is still the starter has no fault elsewhere")
    write(read(suite.unit.path) + "int mine;\n", suite.unit.path)
    check("calls your bvh_median" in grade._about_needs(suite, units),
          "one that was begun may have it in a needed unit")


def added_files_are_named(folder):
    pack = os.path.join(folder, "pack's")
    for name in ("src/scene/light.c", "tests/test_light.c", "tools/hint.py", "assignments/features.tsv"):
        write("", pack, name)
    originals.keep_originals(pack)
    check(originals.added_files(pack) == [], "a pack as it was packed has no added files",
          originals.added_files(pack))
    for name in ("src/features/list.h", "src/scene/light.o", "src/scene/light.c.edited",
                 "src/scene/.mine.c.swp",
                 "assignments/notes.txt", "workbook/mine.c"):
        write("", pack, name)
    check(originals.added_files(pack) == [], "what is built, saved, or a note is none",
          originals.added_files(pack))
    added = ["src/scene/it's mine.c", "tests/mine.h", "tools/mine.py", "assignments/mine.c"]
    for name in added:
        write("", pack, name)
    check(originals.added_files(pack) == added, "code that was added is named", originals.added_files(pack))
    told = pristine.how_to_move(added)
    for command in told[1:]:
        run(pack, "sh", "-c", command)
    check(originals.added_files(pack) == [] and len(os.listdir(os.path.join(pack, "moved"))) == len(added),
          "the commands of make pristine move it away", told)


def a_picture_is_praised_only_while_claims_hold():
    check(draw._PRAISE in read(SOURCE, "src", "driver", "driver_save.c"), "the driver's praise is known")
    for failed, wanted in (
            (("odd", "3"), f"\na claim of step 3 fails: odd (make check-{STEM} IMPL=x.c)\n6.png: the "),
            (("", ""), f"\n6.png: {draw._PRAISE}the picture")):
        told = f"6.png: {draw._PRAISE}the picture differs"
        with contextlib.ExitStack() as stack:
            for name, value in (("made_driver", ("driver", "driver")), ("_draw_both", told),
                                ("_unsolved", [])):
                stack.enter_context(mock.patch.object(draw, name, return_value=value))
            stack.enter_context(mock.patch.object(draw.last_check, "read", return_value=failed))
            said = stack.enter_context(redirect_stdout(io.StringIO()))
            draw.draw(Toolchain("."), "x.c", STEM, "6")
        check(wanted in said.getvalue(),
              "a picture is as good as it can be only while no claim fails, which is told first",
              said.getvalue())


def nothing_waits_for_a_test_that_is_not_there(folder):
    for unit, test, wanted in ((STEM, "no_such_test", "has no test no_such_test"),
                               (f"My_{STEM}", TESTS[0].name, f"rename My_{STEM}.c to {STEM}.c")):
        mine = os.path.join(folder, unit)
        write(STARTER, mine, unit + ".c")
        write("", mine, OTHER + ".c")
        status, said = run(".", "timeout", "20", sys.executable, "-B",
                           os.path.join(SOURCE, "tools", "watch.py"), STEM,
                           "--impl", mine, "--test", test)
        check(status == 1 and wanted in said and len(said.splitlines()) == 1, f"watch ends at once: {wanted}",
              said)
    status, said = make(".", f"diff-{STEM}", f"IMPL={mine}")
    check(status != 0 and f"rename My_{STEM}.c to {STEM}.c" in said, "diff says which file to rename", said)
    os.unlink(os.path.join(mine, OTHER + ".c"))
    status, said = make(".", f"diff-{STEM}", f"IMPL={mine}")
    check(status != 0 and f"rename My_{STEM}.c to {STEM}.c" in said, "so it does where that is the only file",
          said)


def commands_without_a_name(folder):
    for command in ("hint", "draw", "driver", "watch", "debug", "diff", "check-", "hint-"):
        _, said = make(folder, command)
        word = command.rstrip("-")
        more = " STEP=1" if word == "hint" else ""
        check(f"make {word}-STEM{more}, with STEM one of: " in said and STEM in said,
              f"make {command} says which names there are", said)
    status, said = make(folder, "help")
    half_a_terminal = 14
    check(status == 0 and len(said.splitlines()) <= half_a_terminal and "make hint-STEM" in said
          and STEM in said.splitlines()[-1],
          "make help is a short list", said)


def interrupted(folder, module, *command):
    """Returns the status and what is said, where Ctrl-C comes as this text of a module argparse does it."""
    write(module, folder, "interrupts", "argparse.py")
    environment = dict(os.environ, PYTHONPATH=os.path.join(folder, "interrupts"))
    for name in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL"):
        environment.pop(name, None)
    answer = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, check=False,
                            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    return answer.returncode, answer.stdout


def ctrl_c_is_quiet_at_any_moment(folder):
    comes = "os.kill(os.getpid(), 2)\n"
    real = ("import os, sys\nsys.path.remove(os.path.dirname(__file__))\ndel sys.modules['argparse']\n"
            "import argparse\n")
    now, late = f"import os\n{comes}", f"{real}import atexit\natexit.register(os.kill, os.getpid(), 2)\n"
    within = f"{real}def parse_args(*_):\n    {comes}argparse.ArgumentParser.parse_args = parse_args\n"
    tools = os.path.join(SOURCE, "tools")
    launched = [sys.executable, "-B", "-S", os.path.join(tools, "launch.py")]
    names = [name for name in sorted(os.listdir(tools))
             if name.endswith(".py") and "Parser(" in read(tools, name)]
    told = {name: interrupted(folder, now, *launched, os.path.join(tools, name)) for name in names}
    wrong = {name: said for name, said in told.items() if said != (-signal.SIGINT, "")}
    check("start.py" in told and not wrong, "Ctrl-C while a tool is still being read ends it without a word",
          wrong)
    for moment, module, status in (("it has ended", late, -signal.SIGINT), ("its main begins", within, 130)):
        told = interrupted(folder, module, *launched, os.path.join(tools, "hint.py"), STEM, "--step", "1",
                           "--source", SOURCE)
        check(told[0] == status and "Traceback" not in told[1], f"so does Ctrl-C when {moment}", told)
    status, said = interrupted(folder, now, MAKE, "-s", f"hint-{STEM}", "STEP=1")
    check(status != 0 and len(said.splitlines()) <= 1 and "Traceback" not in said, "make starts them so",
          said)
    targets = ("start", "progress", f"hint-{STEM}", f"draw-{STEM}", "album")
    said = make(".", "-n", *targets, f"IMPL={folder}")[1]
    lines = [line for line in said.splitlines() if re.search(r"tools/\w+\.py ", line)]
    check(len(lines) > 3 and all("tools/launch.py" in line for line in lines), "all of them", lines)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def what_is_built_has_a_line_of_its_own(folder):
    write("ready:\n\t@echo '  CC       it.o'\nbroken:\n\t@false\n", folder, "building", "Makefile")
    with redirect_stdout(Terminal()) as told:
        screen = watch.Screen()
        screen.status("save it.c to go on; Ctrl-C ends")
        leading.make(os.path.join(folder, "building"), "ready", "what checks it", screen)
    check("Ctrl-C ends\nbuilding what checks it, once ...\n" in told.getvalue(),
          "what is built is told below the status line", repr(told.getvalue()))
    with redirect_stdout(Terminal()) as told:
        screen.status("save it.c to go on; Ctrl-C ends")
        with contextlib.suppress(ToolError), contextlib.redirect_stderr(sys.stdout):
            leading.make(os.path.join(folder, "building"), "broken", "it", screen)
    check("Ctrl-C ends\nmake" in told.getvalue(), "and why it cannot be built", repr(told.getvalue()))


def a_dry_run_starts_nothing(folder):
    status, said = make(".", "-n", "start", f"IMPL={os.path.join(folder, 'none')}")
    check(status == 0 and "tools/start.py" in said and "start: " not in said,
          "make -n start only prints", said)


def only_what_is_graded_is_made_ready(folder):
    changed = ["-W", os.path.join(os.environ.get("srcdir", "."), "tests", "test.h"), "-W", "tests/test.h"]
    for command in ("grade", "grade-class", "progress"):
        said = make(".", "-n", *changed, command, f"ASSIGNMENTS={STEM} {OTHER}", f"IMPL={folder}")[1]
        suites = set(re.findall(r"tests/test_(\w+)\.o\b", said))
        judges = set(re.findall(r"impl/judge/(\w+)-(?:judge|serve)\b", said))
        check(suites == {STEM, OTHER} and judges <= {STEM, OTHER} and bool(judges) == (
            command != "progress" and sys.platform == "linux"),
              f"make {command} compiles the suites of its assignments alone", (suites, judges))


def hints_come_one_at_a_time():
    hints = hint.hints_of(handout_of(SOURCE, FEATURE))
    check(len(hints) >= 4 and "2" in hints, "a handout's hints are found by their steps", list(hints))
    (first, text), (second, more) = hints["2"][:2]
    told = hint.said(STEM, hints, "2", "1")
    check("nudge" in first and text.split("\n")[0] in told and more.split("\n")[0] not in told
          and "HINT=2" in told,
          "a step's first hint is the nudge, alone", told)
    told = hint.said(STEM, hints, "2", "2")
    check(more.split("\n")[0] in told and second in told and text.split("\n")[0] not in told,
          "HINT=2 is the next", told)
    told = hint.said(STEM, hints, "", "1")
    check(text.split("\n")[0] not in told and first in told, "without a step the hints are only listed", told)
    told = hint.said(STEM, hints, "", "1", ("some_claim", "2")).splitlines()
    marked = [line for line in told if "STEP=2" in line]
    check(marked and marked[0].endswith("<- some_claim fails first") and "".join(told).count("<-") == 1,
          "the step of the first claim that failed is marked", told)
    check(f"make check-{STEM}" in hint.said(STEM, hints, "", "1"), "before a check the list says how", hints)
    check("All claims held" in hint.said(STEM, hints, "", "1", ("", "")), "or that nothing failed", hints)
    for step, number in (("99", "1"), ("2", "9"), ("2", "x")):
        try:
            hint.said(STEM, hints, step, number)
            check(False, f"STEP={step} HINT={number} is refused")
        except ToolError as error:
            check("\n" not in str(error), f"STEP={step} HINT={number} is refused in one sentence", error)
    for feature in FEATURES.values():
        text = handout_of(SOURCE, feature)
        rows = set(re.findall(r"^\| (\d+) \|", text, re.MULTILINE))
        seen, named = {str(look.step)
                       for look in read_looks(feature)}, set(re.findall(r"draw-\w+ (?:IMPL=\w+ )?STEP=(\d+)",
                                                                        text))
        check(named == seen,
              f"the steps of {feature.stem} that its task has drawn are those with something to see",
              named ^ seen)
        check(set(hint.hints_of(text)) <= rows, f"the hints of {feature.stem} are for its steps",
              set(hint.hints_of(text)) - rows)
        unhelped = {str(test.step) for test in read_points(feature) if test.step} - set(hint.hints_of(text))
        check(not unhelped, f"each step of {feature.stem} with a claim has a hint", unhelped)


# --- A pack ---------------------------------------------------------------------------------------


def before_bootstrap(pack):
    for command in ((), (f"check-{STEM}",), ("report",)):
        status, said = run(pack, MAKE, *command)
        check(status != 0 and "run ./bootstrap first" in said and len(said.splitlines()) <= 2,
              f"make {' '.join(command)} before bootstrap says so", said)
    status, said = run(os.path.join(pack, "workbook"), MAKE, f"check-{STEM}")
    check(status != 0 and "run ./bootstrap first" in said, "so it does in the workbook", said)
    folder = os.path.join(os.path.dirname(pack), "begun")
    write("#!/bin/sh\nprintf 'abs_builddir = %s\\nstart:\\n\\t@echo begins\\n' \"$PWD\" >Makefile\n",
          folder, "bootstrap")
    os.chmod(os.path.join(folder, "bootstrap"), 0o755)
    shutil.copy(os.path.join(pack, "GNUmakefile"), folder)
    status, said = run(folder, MAKE, "-n", "start")
    check(status == 0 and not os.path.exists(os.path.join(folder, "Makefile")),
          "make -n start only prints, there, too", said)
    status, said = run(folder, MAKE, "start")
    check(status == 0 and said.splitlines()[-1] == "begins", "make start runs it, and begins", said)
    for name in ("it's", 'a "b"', "a$b", "a#b", "a&b", "a\nb"):
        folder = os.path.join(os.path.dirname(pack), name)
        os.mkdir(folder)
        shutil.copy(os.path.join(pack, "bootstrap"), folder)
        status, said = run(folder, "./bootstrap", "--no-install")
        check(status != 0 and "character that build tools cannot take" in said
              and os.listdir(folder) == ["bootstrap"],
              f"bootstrap refuses a folder called {name!r} at once", said)


def the_pack_builds(pack):
    compiler = " ".join(Toolchain(".").compiler)
    broken = os.path.join(os.path.dirname(pack), "broken")
    write("#!/bin/sh\nexit 1\n", broken, "autoreconf")
    os.chmod(os.path.join(broken, "autoreconf"), 0o755)
    status, said = run(pack, "env", f"PATH={broken}:{os.environ['PATH']}", "./bootstrap", "--no-install",
                       f"CC={compiler}")
    check(status == 0, "its configure is ready; no student's machine makes it again", said)
    check(said.rstrip().splitlines()[-1].startswith("Now: make start"),
          "bootstrap ends with the first command of the pack", said)
    status, said = run(pack, "./bootstrap", "--no-install", f"CC={compiler}")
    check(status == 0 and "make start" in said, "so does a second one", said)
    status, said = make(pack, f"check-{STEM}")
    check(status != 0 and f"first: {TESTS[0].name}" in said and "edited" not in said,
          "the starter is checked", said)
    again = make(pack, f"check-{STEM}")[1]
    check(len(again.splitlines()) < SCREEN, "its verdict fits on 24 lines", again)
    status, said = run(os.path.join(pack, "workbook"), MAKE, "-s", f"check-{STEM}", f"TEST={TESTS[0].name}")
    check(status != 0 and f"first: {TESTS[0].name}" in said and TESTS[1].name not in said,
          "the same in the workbook's own folder", said)
    check(re.search(r"^Error|No rule", said) is None, "without a word about rules", said)
    check("your code printed" not in said, "and nothing that the suite says as if the unit had printed it",
          said)


def names_that_are_nearly_right(pack):
    for command in ("check-median", "check-1", "draw-bvh_med"):
        status, said = make(pack, command)
        check(status != 0 and f"did you mean: {STEM}?" in said, f"{command} is understood as a slip", said)
    said = make(pack, "draw-bvh")[1]
    check(f"did you mean: {STEM} wide_bvh?" in said, "both names that draw-bvh may mean are told", said)
    status, said = make(pack, f"check-{STEM}", f"test={TESTS[0].name}")
    check(status != 0 and "write it in capitals: TEST=" in said, "and test= as one for TEST=", said)


def warnings_tell_of_mistakes_alone(pack):
    unit = read(pack, "workbook", OTHER + ".c")
    write(unit + "int odd(unsigned a, int b);\n"
          "int odd(unsigned a, int b)\n{\n    int c = a + (b != 0);\n    { int b = c; (void)b; }\n"
          "    return 0;\n}\nstatic void later(int unused)\n{\n}\n", pack, "workbook", OTHER + ".c")
    _, said = make(pack, f"check-{OTHER}")
    check("warning" not in said and "first:" in said,
          "signs, shadows and what later steps use are no warnings", said)
    write(unit + "int odd(void);\nint odd(void)\n{\n    int c;\n    return c;\n}\n", pack, "workbook",
          OTHER + ".c")
    _, said = make(pack, f"check-{OTHER}")
    check("uninitialized" in said and said.index("uninitialized") < said.index("first:"),
          "what is probably a mistake is one, before the verdict", said)
    write(unit + "typedef struct pile {\n    int entries[8];\n    unsigned size;\n} pile;\nint odd(int a);\n"
          "int odd(int a)\n{\n    pile p;\n    for (; a > 1; a /= 2)\n        if (a % 3 == 0)\n"
          "            p.entries[p.size++] = a;\n    return p.entries[0];\n}\n",
          pack, "workbook", OTHER + ".c")
    _, said = make(pack, f"check-{OTHER}")
    check(said.count("'p.size' may be used uninitialized") == 1 and
          said.index("uninitialized") < said.index("first:"),
          "a member that is set on some ways only is named, once", said)
    misled = ("int odd(int a);\nint odd(int a)\n{\n    for (; a > 9; a /= 2)\n        a--;\n        a -= 2;\n"
              "    while (a > 1);\n        a--;\n    return a;\n}\n")
    plainly = misled.replace("\n        a -= 2;", "\n    a -= 2;").replace("a > 1);", "a > 1)")
    reports = []
    for text in (plainly, misled):
        write(unit + text, pack, "workbook", OTHER + ".c")
        reports.append(make(pack, f"check-{OTHER}")[1])
    first, second = (f"{OTHER}.c:{unit.count(chr(10)) + line}:" for line in (4, 7))
    check("warning" not in reports[0] and reports[1].endswith(reports[0]),
          "what is indented well has no warning, and the verdict is the same", "\n".join(reports))
    check(first in reports[1] and second in reports[1] and reports[1].count("warning: ") == 2,
          "a statement that is indented as if a loop held it is told, once, and so is a loop of nothing",
          reports[1])
    write(unit, pack, "workbook", OTHER + ".c")


def progress_tests_what_changed(pack):
    def told():
        status, said = make(pack, "progress")
        return status, said, {name: os.stat(os.path.join(kept, name)).st_mtime_ns
                              for name in sorted(os.listdir(kept))}

    kept = os.path.join(pack, "impl", "progress")
    status, said, before = told()
    check(status == 0 and TESTS[0].name in said and list(before) == sorted([STEM + ".json", OTHER + ".json"]),
          "progress shows points, and keeps verdicts", said)
    suites = [name for name in os.listdir(os.path.join(pack, "tests"))
              if name.startswith("test_") and name.endswith(".o")]
    check(sorted(suites) == [f"test_{OTHER}.o", f"test_{STEM}.o"],
          "it compiles no suites but those of its assignments", suites)
    check(re.search(r"^  TEST +0 of \d+$", said, re.MULTILINE), "in a pipe it says that it works", said)
    status, again, after = told()
    # What the first run compiled is of no interest.
    table = [line for line in said.splitlines() if not line.startswith("  ")]
    check(again.splitlines() == table and after == before, "what has not changed is not tested again", again)
    unit = read(pack, "workbook", OTHER + ".c")
    write(unit + "\nint broken = ;\n", pack, "workbook", OTHER + ".c")
    status, said, _ = told()
    check("does not compile" in said and TESTS[0].name in said, "what has changed is", said)
    write(unit + "\n", pack, "workbook", OTHER + ".c")
    status, said, after = told()
    check(after[STEM + ".json"] == before[STEM + ".json"]
          and after[OTHER + ".json"] > before[OTHER + ".json"],
          "and nothing else is", said)
    write("#define odd\n", pack, "workbook", "mine.h")
    check(told()[2][STEM + ".json"] > before[STEM + ".json"], "a header of the student's changes all")
    os.unlink(os.path.join(pack, "workbook", "mine.h"))


def drivers_are_built_alone(pack):
    write("int broken = ;\n", pack, "workbook", OTHER + ".c")
    step = next(step for step in range(1, 99) if step not in [look.step for look in read_looks(FEATURE)])
    status, said = run(pack, MAKE, "-s", f"draw-{STEM}", f"STEP={step}")
    check(status == 0 and f"STEP={step}: {STEM} has no picture of this step; step" in said
          and "CC" not in said,
          "of a step with nothing to see this is said before anything is compiled, and it is no error", said)
    status, said = run(pack, MAKE, "-s", f"draw-{STEM}", "STEP=99")
    check(status != 0 and "STEP=99" in said and "CC" not in said, "a step that there is not is refused", said)
    status, said = make(pack, f"draw-{STEM}")
    check(status == 0 and ".png: the picture " in said, "a picture is drawn before any driver is built", said)
    write(read(pack, "workbook", STEM + ".c") + "\n", pack, "workbook", STEM + ".c")
    make(pack, f"draw-{STEM}")  # it is no starter any more
    write(read(pack, "workbook", STEM + ".c") + "\n", pack, "workbook", STEM + ".c")
    status, said = make(pack, f"draw-{STEM}")
    check(status == 0 and "  CC " not in said, "after a save nothing of the kit is compiled again", said)
    write(STARTER, pack, "workbook", STEM + ".c")
    status, said = make(pack, f"driver-{STEM}")
    path = f"impl/assignments/{FEATURE.folder}/{STEM}"
    driver = os.path.join(pack, path)
    check(status == 0 and os.access(driver, os.X_OK), "a unit that does not compile spoils no other driver",
          said)
    told = said.rstrip().splitlines()[-1]
    check(told.startswith(f"run {path} (--help lists its options); units: workbook") and OTHER not in told,
          "the driver's command is told, without a list of units that are all in one folder", said)
    sets = ("avx512", "avx2", "sse2", "scalar")
    compiled = [isa for isa in sets if " kernel\n" in run(pack, "nm", f"src/accel/kernel/wide_{isa}.o")[1]]
    small = ("--width", "8", "--height", "8", "--quiet", "--out", os.path.join(pack, "small"))
    taken = {place: [isa for isa in sets if run(place, "env", f"RAYKIT_ISA={isa}", where, *small)[0] == 0]
             for place, where in ((pack, driver), (".", "assignments/00_normals/normals"))}
    check(taken["."] and compiled == list(dict.fromkeys([taken["."][0], "scalar"])) == taken[pack],
          "of the traversals it has compiled this machine's fastest and the one in plain C",
          (compiled, taken))
    others = [feature.folder for feature in FEATURES.values() if feature.stem != STEM]
    built = [folder for folder in others for name in os.listdir(os.path.join(pack, "assignments", folder))
             if name.endswith(".o")]
    check(not built, "only one driver is built", built)
    status, said = run(pack, driver, "--scene", "cornell", "--width", "16", "--height", "16")
    check(status == 0, "it draws", said)
    for command in ("check", "draw", "driver", *(["debug"] if shutil.which("gdb") else [])):
        status, said = make(pack, f"{command}-{OTHER}")
        check(status != 0 and "does not compile" in said and said.count("error: expected") == 1,
              f"make {command} of the unit that does not compile shows why, once", said)
    shutil.copyfile(os.path.join(pack, "src", "features", OTHER + ".c"),
                    os.path.join(pack, "workbook", OTHER + ".c"))


def the_debugger_stops_where_arguments_are(pack):
    if not shutil.which("gdb"):
        check(True, "the first stop shows arguments # SKIP no gdb")
        return
    write("#include \"features/bloom.h\"\n\n"
          + "float rk_bloom_luminance(rk_vec3 colour)\n{\n    return colour.x + colour.y;\n}\n"
          + starter_of(FEATURES[OTHER].reference).split("#include \"features/bloom.h\"")[1].replace(
              "rk_bloom_luminance(rk_vec3 colour)\n{",
              "rk_bloom_other(rk_vec3 colour);\nfloat rk_bloom_other(rk_vec3 colour)\n{", 1),
          pack, "workbook", OTHER + ".c")
    test = "luminance_weighs_green_most"
    answer = subprocess.run([MAKE, "-s", f"debug-{OTHER}", f"TEST={test}"], cwd=pack, text=True,
                            stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, input="print colour\ndelete\ninfo breakpoints\nquit\n",
                            check=False,
                            env={name: value for name, value in os.environ.items()
                                 if name not in ("MAKEFLAGS", "MAKELEVEL")})
    check("rk_bloom_luminance (colour=(3, 2, 1))" in answer.stdout, "the first stop shows true arguments",
          answer.stdout)
    check("$1 = (3, 2, 1)" in answer.stdout, "values are printed as vectors", answer.stdout)
    check("No breakpoints" in answer.stdout and "y or n" not in answer.stdout,
          "gdb does not ask before it deletes or quits", answer.stdout)


def kit_files_are_put_back(pack):
    place = os.path.join(pack, "src", "base", "box.h")
    original = read(place)
    write(original + "/* mine */\n", place)
    os.unlink(os.path.join(pack, "src", "base", "sphere.h"))
    _, said = make(pack, f"check-{STEM}", f"TEST={TESTS[0].name}")
    check("edited outside of the workbook: src/base/box.h" in said and "make pristine" in said,
          "the check says that a file of the kit was edited", said)
    status, said = run(pack, MAKE, "-s", f"driver-{STEM}")
    check("src/base/box.h" in said and "does not" not in said,
          "so does the driver, though it cannot be built", said)
    status, said = make(pack, "pristine")
    check(status == 0 and read(place) == original and read(place + ".edited").endswith("mine */\n")
          and os.path.exists(os.path.join(pack, "src", "base", "sphere.h")) and "box.h" in said,
          "make pristine puts it back, and what was removed, and keeps the edited text", said)
    status, said = make(pack, "pristine")
    check(status == 0 and "nothing" in said, "a second one has nothing to do", said)
    write("int broken = ;\n", pack, "src", "scene", "mine.c")
    status, said = make(pack, f"check-{STEM}")
    check(status != 0 and "added outside of the workbook: src/scene/mine.c; make pristine" in said,
          "the check names an added file", said)
    status, said = make(pack, "pristine")
    check(status == 0 and "mv -i src/scene/mine.c moved" in said and "nothing" not in said,
          "make pristine says how to move it", said)
    os.unlink(os.path.join(pack, "src", "scene", "mine.c"))
    make(pack, f"check-{STEM}")
    os.unlink(place + ".edited")


def a_file_in_the_wrong_place_is_told(pack):
    place = os.path.join(pack, "src", "features", STEM + ".c")
    write("int mine;\n", place)
    for command in (f"draw-{STEM}", f"driver-{STEM}", f"diff-{STEM}", "start"):
        status, said = make(pack, command)
        check(status != 0 and "make pristine" in said and "Traceback" not in said,
              f"make {command} says how to put an overwritten file back", said)
    make(pack, "pristine")
    os.unlink(place + ".edited")
    mine = os.path.join(pack, "workbook", OTHER + ".c")
    os.rename(mine, mine + ".away")
    status, said = make(pack, "start")
    check(status != 0 and f"there is no workbook/{OTHER}.c; make workbook" in said and "points" not in said,
          "make start does not forget a file that was removed", said)
    os.rename(mine + ".away", mine)


def editors_find_headers(pack):
    compiler = Toolchain(".").compiler
    for folder in ("", "workbook"):
        flags = read(pack, folder, "compile_flags.txt").split("\n")[:-1]
        status, said = run(os.path.join(pack, folder), *compiler, *flags, "-fsyntax-only",
                           os.path.join(pack, "workbook", STEM + ".c"))
        check(status == 0, f"compile_flags.txt in the {folder or 'top'} folder leads to the headers", said)
    settings = json.loads(read(pack, ".vscode", "settings.json"))
    check(settings["C_Cpp.default.includePath"] == ["${workspaceFolder}/src"], "VS Code finds them, too",
          settings)
    text = re.sub(r"^\s*//.*$", "", read(pack, ".vscode", "tasks.json"), flags=re.MULTILINE)
    made = {task["args"][0].partition("-")[0] for task in json.loads(text)["tasks"]}
    check(made == {"check", "watch", "start", "live", "draw", "hint", "driver", "debug"},
          "and has a task for each command of the loop", made)


def a_folder_that_is_read_only_is_told(pack):
    place = os.path.join(pack, "impl")
    kept = place + "-kept"
    os.rename(place, kept)
    write("", place)  # a file: no folder can be made here, whoever asks
    status, said = make(pack, f"check-{STEM}")
    os.unlink(place)
    os.rename(kept, place)
    check(status != 0 and "cannot be written to" in said and "run ./bootstrap in the copy" in said,
          "a pack that cannot be written to says what to do", said)


def git_keeps_sources(pack):
    git = shutil.which("git")
    workbook = os.path.join(pack, "workbook")
    write("", workbook, "bloom.o")
    if git:
        run(workbook, git, "init", "-q")
        run(workbook, git, "add", "-A")
        _, said = run(workbook, git, "ls-files")
        check(not [name for name in said.split() if name.endswith((".o", ".Po")) or ".deps" in name]
              and STEM + ".c" in said,
              "git add in the workbook takes sources alone", said)
        shutil.rmtree(os.path.join(workbook, ".git"))
    os.unlink(os.path.join(workbook, "bloom.o"))


def a_renamed_file_stops_the_check(pack):
    os.rename(os.path.join(pack, "workbook", STEM + ".c"), os.path.join(pack, "workbook", "Bvh_Median.c"))
    status, said = make(pack, f"check-{STEM}")
    check(status != 0 and f"rename Bvh_Median.c to {STEM}.c" in said and len(said.splitlines()) <= 2,
          "a file with another name stops the check in one line", said)
    os.rename(os.path.join(pack, "workbook", "Bvh_Median.c"), os.path.join(pack, "workbook", f"my_{STEM}.c"))
    for command in ("draw", "driver"):
        status, said = make(pack, f"{command}-{STEM}")
        check(status != 0 and f"rename my_{STEM}.c to {STEM}.c" in said and "No rule" not in said,
              f"so it does {command}", said)
    os.rename(os.path.join(pack, "workbook", f"my_{STEM}.c"), os.path.join(pack, "workbook", "gone"))
    status, said = make(pack, f"check-{STEM}")
    check(status != 0 and "make workbook DIR=workbook" in said and len(said.splitlines()) <= 2,
          "one that is missing says how to get it back", said)
    before = sorted(os.listdir(os.path.join(pack, "workbook")))
    status, said = make(pack, "workbook", "DIR=workbook")
    check(status == 0 and read(pack, "workbook", STEM + ".c") == STARTER, "which it does", said)
    after = sorted(os.listdir(os.path.join(pack, "workbook")))
    check(after == sorted([*before, STEM + ".c"]) and "kept" not in said and "IMPL=" not in said,
          "it adds nothing else, and the next command needs no IMPL", [said, *after])
    said = make(pack, "workbook", "DIR=workbook")[1]
    check("no starter is missing" in said, "a second time there is nothing to do", said)
    os.rename(os.path.join(pack, "workbook", "gone"), os.path.join(pack, "workbook", STEM + ".c"))


def solved_in_part(path, count):
    """Returns a reference's text with the starters in place of all regions but the first `count`."""
    text, number = "", 0
    for kind, line in read_regions(path):
        number += kind == "marker" and "/* solution */" in line
        text += line if kind in ("common", "solution" if number <= count else "starter") else ""
    return text


class Started:
    """make start in a pack, and what it says."""

    def __init__(self, pack, target="start"):
        environment = {name: value for name, value in os.environ.items()
                       if name not in ("MAKEFLAGS", "MAKELEVEL", "DISPLAY", "WAYLAND_DISPLAY", "BROWSER")}
        self._process = subprocess.Popen([MAKE, "-s", target], cwd=pack, text=True, env=environment,
                                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                         start_new_session=True)

    def until(self, words):
        """Returns what is said from now on up to the line that has these words, or to the end."""
        said = ""
        for line in self._process.stdout:
            said += line
            if words in line:
                break
        return said

    def interrupted(self):
        """Returns what is said after Ctrl-C."""
        os.killpg(self._process.pid, signal.SIGINT)
        return self._process.communicate(timeout=60)[0]

    def end(self):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)


def a_file_that_is_removed_ends_the_loop(pack):
    """Where it waits for the next assignment; STEM is solved."""
    loop, mine = Started(pack, f"start-{STEM}"), os.path.join(pack, "workbook", OTHER + ".c")
    try:
        loop.until(f"save {OTHER}.c to go on")
        os.rename(mine, mine + ".away")
        said = loop.until("there is no")
        check(f"there is no workbook/{OTHER}.c; make workbook" in said and "Traceback" not in said,
              "a file that is removed while the loop waits for it is named", said)
    finally:
        loop.end()
        os.rename(mine + ".away", mine)


def start_leads_through_the_course(pack):
    write(STARTER, pack, "workbook", STEM + ".c")
    loop, counts = Started(pack), [0]
    try:
        said = loop.until("Ctrl-C ends")
        check(f"Assignment {int(FEATURE.folder[:2])}: " in said and f"edit  workbook/{STEM}.c" in said
              and f"read  {FEATURE.chapter}{TESTS[0].section}" in said
              and f"hint  make hint-{STEM} STEP={TESTS[0].step}" in said
              and f"task  assignments/{FEATURE.folder}/handout.md" in said
              and "page  http://127.0.0.1:" in said,
              "make start says what to read, the task, the file to edit, how to get a hint, and the page",
              said)
        check(f"work on this one first: {TESTS[0].name}" in said, "and it checks the starter", said)
        gaps = read(FEATURE.reference).count("/* solution */")
        for regions in (1, gaps // 2, gaps):
            write(solved_in_part(FEATURE.reference, regions), pack, "workbook", STEM + ".c")
            said = loop.until("Ctrl-C ends")
            counts.append(int((re.search(r"(\d+) of 100 points", said) or [0, -1])[1]))
        check(counts[-1] == 100 and counts == sorted(counts) and len(set(counts)) > 2,
              "gap by gap the points grow to 100",
              [counts, *said.splitlines()])
        check(f"edit  workbook/{OTHER}.c" in said and f"save {OTHER}.c to go on" in said,
              "at 100 points it names the next assignment", said)
        os.utime(os.path.join(pack, "workbook", OTHER + ".c"))
        said = loop.until(f"save {OTHER}.c for")
        check(f"FAIL  {OTHER}" in said, "saving that goes on to it", said)
        said = loop.interrupted()
        check("Traceback" not in said and "Interrupt" not in said and len(said.splitlines()) < 3,
              "Ctrl-C ends it quietly", said)
    finally:
        loop.end()
    a_file_that_is_removed_ends_the_loop(pack)
    status, said = make(os.path.join(pack, "workbook"), "start-median")
    check(status != 0 and f"did you mean: {STEM}?" in said, "a slip in a name is understood", said)


def the_album_grows(pack):
    status, said = make(pack, "album", f"ASSIGNMENTS={STEM}")
    page = os.path.join(pack, "impl", "out", "album", "index.html")
    steps = len(read_looks(FEATURE))
    check(status == 0 and f"album: {steps} pictures: file://" in said
          and read(page).count('alt="yours"') == steps,
          "the album has a picture of each step that has something to see", said)
    status, said = make(pack, "album", f"ASSIGNMENTS={STEM}")
    check(status == 0 and "step" not in said, "a picture whose unit has not changed is not drawn again", said)
    unit = os.path.join(pack, "workbook", STEM + ".c")
    solved = read(unit)
    write(starter_of(FEATURE.reference), pack, "workbook", STEM + ".c")
    status, said = make(pack, "album", f"ASSIGNMENTS={STEM}")
    check(status == 0 and "album: 0 pictures" in said and "still the starter" in read(page),
          "and says of a starter that it is one", said)
    write(solved, pack, "workbook", STEM + ".c")


def what_to_hand_in_is_said(pack):
    starter = read(pack, "workbook", OTHER + ".c")
    write(read(FEATURES[OTHER].reference).replace("#include", '#include "own.h"\n#include', 1), pack,
          "workbook", OTHER + ".c")
    write("", pack, "workbook", "own.h")
    for command in ("start", "progress"):
        status, said = make(pack, command)
        check(status == 0 and f"hand in workbook/{STEM}.c, workbook/{OTHER}.c and workbook/own.h, "
              "nothing else" in said, f"make {command} says at the end what to hand in", said)
        check(command != "start" or said.startswith(f"looking at what is done so far: {STEM} ...\n"),
              f"make {command} says at once what it does", said)
    os.unlink(os.path.join(pack, "workbook", "own.h"))
    write(starter, pack, "workbook", OTHER + ".c")


def the_tables_of_a_task_can_be_read():
    for feature in FEATURES.values():
        text = handout_of(SOURCE, feature)
        steps = [int(number) for number in re.findall(r"^\| (\d+) \|", text, re.MULTILINE)]
        read_out = [task_of(text, step) for step in steps]
        check(all(write for write, _ in read_out) and any(given for _, given in read_out),
              f"{feature.stem}: each step says what to write, and what is given", read_out)
    write, given = task_of(handout_of(SOURCE, FEATURE), 5)
    check("push_far_return_near" in write and any("rk_box_enter" in row[0] for row in given)
          and not any("rk_hash" in row[0] for row in given), "a range of steps has those between", given)


def the_pack_is_solved(pack):
    shutil.copyfile(FEATURE.reference, os.path.join(pack, "workbook", STEM + ".c"))
    status, said = make(pack, f"check-{STEM}")
    check(status == 0 and "100 of 100 points" in said, "the solution has all points", said)
    check(f"hand in workbook/{STEM}.c, nothing else" in said, "and the check says what to hand in", said)
    process = subprocess.Popen([MAKE, "-s", f"watch-{STEM}"], cwd=pack, text=True, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT)
    try:
        said = ""
        for line in process.stdout:
            said += line
            if "waiting for you to save" in line:
                break
    finally:
        process.terminate()
        process.wait()
    check("100 of 100 points" in said, "watch shows the same", said)
    the_album_grows(pack)
    what_to_hand_in_is_said(pack)
    status, said = make(pack, "report", f"ONLY={STEM}", "QUICK=1")
    page = os.path.join(pack, "reports", "out.some", "report.html")
    if Toolchain(".").source and shutil.which("pandoc"):
        check(status == 0 and os.path.exists(page), "make report ONLY=... draws its section", said)


# --- A workbook of the whole kit ------------------------------------------------------------------


def a_workbook_is_at_home_anywhere(folder):
    mine = os.path.join(folder, "Übung $1 it's")
    status, said = make(".", "workbook", f"DIR={mine}")
    check(status == 0, "a workbook's name may hold anything", said)
    status, said = run(mine, MAKE, "-s", f"diff-{STEM}")
    check(status == 0 and "unchanged" in said, "make works in it", said)
    flags = read(mine, "compile_flags.txt").split("\n")[:-1]
    status, said = run(mine, *Toolchain(".").compiler, *flags, "-fsyntax-only", STEM + ".c")
    check(status == 0, "an editor finds the headers from there", said)
    status, said = make(".", "pristine")
    check(status != 0 and "git" in said, "the whole kit has no copies of its files", said)


def main():
    folder = tempfile.mkdtemp(prefix="raykit-test-student-")
    try:
        a_verdict_fits_on_a_screen()
        what_is_printed_is_shown()
        progress_names_the_next_claim()
        a_starter_blames_no_needed_unit(folder)
        a_picture_is_praised_only_while_claims_hold()
        ctrl_c_is_quiet_at_any_moment(folder)
        what_is_built_has_a_line_of_its_own(folder)
        a_dry_run_starts_nothing(folder)
        only_what_is_graded_is_made_ready(folder)
        hints_come_one_at_a_time()
        the_tables_of_a_task_can_be_read()
        added_files_are_named(folder)
        nothing_waits_for_a_test_that_is_not_there(folder)
        commands_without_a_name(".")
        a_workbook_is_at_home_anywhere(folder)
        os.mkdir(os.path.join(folder, NAME))
        pack = os.path.join(folder, NAME, "raykit")
        with redirect_stdout(io.StringIO()):
            handout.make_handout(SOURCE, [STEM, OTHER], folder=pack, book=False)
        for part in (before_bootstrap, the_pack_builds,
                     names_that_are_nearly_right, warnings_tell_of_mistakes_alone,
                     progress_tests_what_changed, drivers_are_built_alone,
                     the_debugger_stops_where_arguments_are, editors_find_headers,
                     a_folder_that_is_read_only_is_told, git_keeps_sources,
                     a_renamed_file_stops_the_check, start_leads_through_the_course,
                     the_pack_is_solved, kit_files_are_put_back,
                     a_file_in_the_wrong_place_is_told):
            part(pack)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
