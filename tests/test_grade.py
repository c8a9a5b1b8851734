#!/usr/bin/env python3
"""The grader and the workbook, tried on right, wrong and dishonest units of bvh_median. Speaks TAP,
for make check; runs in a build folder."""

import contextlib
import copy
import csv
import errno
import glob
import gzip
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from grading import bubblewrap  # noqa: E402
from grading import build  # noqa: E402
from grading import private_copy  # noqa: E402
from grading import class_table  # noqa: E402
import grade  # noqa: E402
import grade_one  # noqa: E402
from grading import sandbox  # noqa: E402
from grading import results  # noqa: E402
from grading import verdicts  # noqa: E402
from grading.assignments import (DEDUCTION, Feature, ScoredTest, ToolError, Unit,  # noqa: E402
                                 cannot_write, cause_of, check_impl, read_features, read_points)
from grading.starters import is_handed_out, starter_of  # noqa: E402
from workbook import make_workbook  # noqa: E402
from by_address import by_address  # noqa: E402
import tap  # noqa: E402
from tap import check, finish, read, start  # noqa: E402


def _why_no_sandbox():
    """Where bubblewrap makes no sandbox, classes are graded without, as in a container."""
    try:
        bubblewrap.find(build.Toolchain("."))
        return ""
    except ToolError as error:
        os.environ["RAYKIT_SANDBOX"] = "container"
        return str(error)


NO_SANDBOX = _why_no_sandbox()
FEATURES = read_features(SOURCE)
FEATURE = FEATURES["bvh_median"]
with open(FEATURE.reference, encoding="utf-8") as source_file:
    REFERENCE = source_file.read()
STARTER = starter_of(FEATURE.reference)
SOLVED = not is_handed_out(FEATURE.reference)

ONE = "up_to_four_triangles_are_one_leaf"
EMPTY = "no_triangles_give_a_tree_without_nodes"


def unit(build, before="", any_name="rk_bvh_occluded"):
    """A small unit whose build begins so, and which passes EMPTY if it gets beyond that."""
    return f"""
#include "features/bvh_median.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

{before}
void rk_bvh_build_nodes(rk_bvh *bvh, rk_bvh_split split, void *builder)
{{
    (void)bvh, (void)split, (void)builder;
}}

bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{{
    uint32_t count = mesh->triangle_count;
    {build}
    return rk_bvh_init(bvh, count, count, error);
}}

rk_hit rk_bvh_closest(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{{
    (void)bvh, (void)counters;
    return (rk_hit){{ray->t_max, 0, 0, RK_MISS}};
}}

bool {any_name}(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters);
bool {any_name}(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{{
    (void)bvh, (void)ray, (void)counters;
    return false;
}}
"""


# claim: (unit, test, part of the reason); each must fail, with this reason.
BAD = {
    "a wrong answer is told by the claim": (unit(""), ONE, "is not sound"),
    "a NULL pointer is named, with its line": (
        unit("*nowhere = 1;", "static volatile int *volatile nowhere;"), ONE, "NULL pointer"
    ),
    "an array overrun is named, with its line": (
        unit("volatile uint32_t *few = malloc(4 * sizeof *few);\n    few[count + 3] = 1;\n"
             "    free((void *)few);"),
        ONE, "goes beyond",
    ),
    "endless recursion is guessed, with its line": (
        unit("count += deeper(count);",
             "static uint32_t deeper(uint32_t n)\n{\n    volatile char room[1000] = {(char)n};\n"
             "    return n == 12345 ? 0 : deeper(n + 1) + (uint32_t)room[0];\n}"),
        ONE, "endless recursion",
    ),
    "an endless loop is stopped, with its line": (
        unit("for (volatile int k = 0; k < 2; k = 0) { }"), ONE, "endless loop"
    ),
    "an endless allocation is stopped": (
        unit("for (;;)\n        memset(kept = malloc(1 << 22), 1, 1 << 22);", "static void *volatile kept;"),
        ONE, "MB of memory"
    ),
    "an allocation that is too large is named, with its line": (
        unit("memset(kept = malloc(3ull << 30), 1, 3ull << 30);", "static void *volatile kept;"), ONE,
        "asks for 3072 MB of memory at once, and gets NULL"
    ),
    "endless printing is stopped": (
        unit('for (;;) puts("again and again and again and again and again");'), ONE, "printed"
    ),
    "a leak is told, with its line": (unit("void *volatile lost = malloc(100 + count);\n    lost = NULL;"),
                                      EMPTY, "leaks memory"),
    "a missing function is named": (
        unit("", any_name="another"), ONE, "your file does not define rk_bvh_occluded, which the suite calls"
    ),
    "a unit that does not compile shows the first error": (unit("cuont++;"), ONE, "cuont"),
    "what ends the compiler is told as such": (
        unit("", f"int deep = {200000 * '('}1{200000 * ')'};"), ONE, "nested too deeply"
    ),
    "exit in the middle of a test is no pass": (unit("exit(0);", by_address("exit")), ONE,
                                                "in the middle of the test"),
    "_Exit after printing ok is no pass": (
        unit(f'printf("1..1\\nok 1 - {ONE}\\n");\n    fflush(stdout);\n    _Exit(0);', by_address("_Exit")),
        ONE, "its printed output does not count",
    ),
    "exit before main is refused": (
        unit("", "__attribute__((constructor)) static void early(void)\n{\n    exit(0);\n}"), ONE,
        "constructor"
    ),
    "a section that runs before main is refused": (
        unit("", "static void early(void)\n{\n    exit(0);\n}\n"
             '__attribute__((section(".preinit_array"), used)) static void (*entry)(void) = early;'), ONE,
        "uses the attribute section"
    ),
    "a function chosen while loading is refused": (
        unit("", "static int plain(void)\n{\n    return 1;\n}\n"
             "static int (*choose(void))(void)\n{\n    return plain;\n}\n"
             'int chosen(void) __attribute__((ifunc("choose"), used));'), ONE, "attribute ifunc"
    ),
    "a header that is missing is told": ('#include "own.h"\n', ONE, "includes own.h, which "),
    "a unit may not include the reference": ('#include "features/bvh_median.c"\n', ONE, "includes"),
    "a print does not hide what the claim says": (
        unit('puts("I was here");\n    fputs("and here\\n", stderr);'), ONE, "is not sound"
    ),
    "what a unit prints comes after it": (
        unit('puts("I was here");\n    fputs("and here\\n", stderr);'), ONE,
        "\nyour code printed: and here | I was here"
    ),
    "a child that stays behind does not hold up the verdict": (
        unit("if (fork() == 0)\n    {\n        setsid();\n        for (;;)\n            pause();\n    }\n"
             "    _Exit(0);",
             by_address("fork", "setsid", "pause", "_Exit")),
        ONE, "in the middle of the test",
    ),
    "a passed test that ends with a failure is no pass": (
        unit("on_exit(late, NULL);", "int on_exit(void (*function)(int, void *), void *argument);\n"
             + by_address("on_exit", "_exit") + "static void late(int status, void *argument)\n{\n"
             "    (void)status, (void)argument;\n    _exit(3);\n}"), EMPTY, "exit status 3"
    ),
}

GOOD = {
    "a unit's own main, malloc and rk_bvh_validate change nothing elsewhere": unit("", """
int main(void);
int main(void)
{
    return 1;
}
void *malloc(size_t size)
{
    (void)size;
    abort();
}
bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    (void)bvh, (void)mesh, (void)error;
    return false;
}"""),
    "a warning is no error": unit("int unused;"),
    "a unit is told no way to the kit, and cannot write its program": unit(
        'if (getenv("PATH") || getenv("RAYKIT_HELPERS") || getenv("RAYKIT_ATTEST")\n'
        '        || fopen("/proc/self/exe", "r+") || access("../test_bvh_median", F_OK) == 0)\n'
        '        abort();',
        by_address("getenv", "fopen", "access")
    ),
}


def make_suite(folder, number, text, tests):
    """A suite over a unit with this text, in a folder of its own."""
    place = os.path.join(folder, str(number))
    os.mkdir(place)
    path = os.path.join(place, "bvh_median.c")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    suite = grade.Suite(FEATURE, Unit(FEATURE, path, "mine/bvh_median.c", False), tests)
    suite.folder = place
    return suite


def units_are_judged(toolchain, folder):
    """Returns the graded suites of the right unit (or None) and of the starter."""
    tests = read_points(FEATURE)
    cases = [(claim, make_suite(folder, k, text, [ScoredTest(test, 1, "#")]), part)
             for k, (claim, (text, test, part)) in enumerate(BAD.items())]
    good = [(claim, make_suite(folder, f"good{k}", text, [ScoredTest(EMPTY, 1, "#")]))
            for k, (claim, text) in enumerate(GOOD.items())]
    right = make_suite(folder, "right", REFERENCE, tests) if SOLVED else None
    starter = make_suite(folder, "starter", STARTER, tests)
    grade.grade(toolchain, [starter] + ([right] if right else []) + [suite for _, suite in good], {},
                seconds=60)
    # The one that hangs waits for its end; the others take milliseconds.
    grade.grade(toolchain, [suite for _, suite, _ in cases], {}, seconds=3, megabytes=500)
    sandbox.end_strays()
    check(starter.points() == 0, "a starter gets no points", results.text([starter], ""))
    if right:
        check(right.points() == 100 and not right.warnings, "the reference's text gets all 100 points",
              results.text([right], ""))
    for name, suite, part in cases:
        verdict = suite.verdicts[suite.tests[0].name]
        check(not verdict.passed and part in verdict.reason, name,
              f"passed: {verdict.passed}\n{verdict.reason}\n{verdict.place}\n{verdict.details}")
        if "with its line" in name and any("address" in flag for flag in toolchain.sanitize):
            check("mine/bvh_median.c:" in verdict.place, f"{name}: the line is the unit's",
                  f"{verdict.place}\n{verdict.details}")
        if name == "a wrong answer is told by the claim":
            first, last = verdicts._lines_of(ONE, suite.source)
            place, line = verdict.place.split(":")
            check(place == "tests/test_bvh_median.c" and 0 < first <= int(line) <= last,
                  "the place of a failed claim is in the claim, not in a helper", verdict.place)
    for name, suite in good:
        check(suite.passed(), name, results.text([suite], ""))
    trace = ("    #0 0x1 in halve mine/bvh_median.c:9\n    #1 0x2 in qsort (/lib/libc.so)\n"
             "    #2 0x3 in rk_bvh_build_median mine/bvh_median.c:30\n"
             "    #3 0x4 in main tests/test_bvh_median.c:800\n    #0 0x5 in other mine/bvh_median.c:1\n")
    place = verdicts._place_in_unit(trace, starter.unit)
    check(place == "mine/bvh_median.c:9, in halve, on the way from rk_bvh_build_median (line 30)",
          "a place names the function, and the one that led there", place)
    check(not sandbox._children(os.getpid()), "no process is left")
    return right, starter


def reports_can_be_read(suites):
    root = ElementTree.fromstring(results.junit(suites, "mine"))
    claims = sum(len(suite.tests) for suite in suites)
    failed = sum(not suite.verdicts[test.name].passed for suite in suites for test in suite.tests)
    check(len(root.findall("testsuite/testcase")) == claims, "JUnit has a test case for each claim")
    check(len(root.findall("testsuite/testcase/failure")) == failed,
          "JUnit has a failure for each failed claim")
    report = json.loads(results.gradescope(suites, "mine"))
    check(report["score"] == sum(test["score"] for test in report["tests"]) and
          report["score"] == sum(suite.points() for suite in suites),
          "Gradescope's score is the sum of its tests'")
    check(all(test["status"] in ("passed", "failed") and {"name", "max_score", "output"} <= set(test)
              for test in report["tests"]), "Gradescope's tests have all that it asks for")
    lines = results.tap(suites, "mine").splitlines()
    check(lines[0] == f"1..{claims}" and sum(line.startswith(("ok ", "not ok ")) for line in lines) == claims,
          "TAP has as many verdicts as it plans", "\n".join(lines))
    suite = suites[-1]
    suite.is_own = False
    text = results.text([suite], "mine")
    suite.is_own = True
    check(f"first: {ONE}" in text and "read docs/01_bvh_median.md#boxes" in text,
          "the text says what to work on first and where to read", text)


ALLOWED_RAW = re.compile(
    r"[\t\n\x20-\x7e\xa0-\xac\xae-\u200a\u2010-\u2027\u2030-\u205f\u2070-\ud7ff]*")
EVIL = "\033[2J\033]0;x\007\rok 1 - all\u202e\u200b"


def what_code_says_cannot_act(suite):
    """All that comes from outside goes into reports of each format as text of one kind."""
    evil, name = copy.copy(suite), suite.tests[0].name
    evil.verdicts = dict(suite.verdicts)
    evil.verdicts[name] = verdicts.Verdict(False, EVIL, EVIL + "\nok 2 - x", EVIL)
    evil.remarks, evil.warnings, evil.beside = [EVIL + "\nok 3 - y"], EVIL, EVIL
    stopped = copy.copy(evil)
    stopped.problem = EVIL + "\nok 4 - z"
    for suite in (evil, stopped):
        plan = len(suite.tests)
        for form, write in results.FORMATS.items():
            report = write([suite], "mine")
            texts = list(_strings(json.loads(report))) if form == "gradescope" else [report]
            check(all(ALLOWED_RAW.fullmatch(text) for text in texts), f"no report acts: {form}",
                  ascii(report))
            if form == "junit":
                ElementTree.fromstring(report)
            if form == "tap":
                told = [line for line in report.splitlines() if line.startswith(("ok ", "not ok "))]
                check(len(told) == plan, "and none has verdicts of the code's own", ascii(report))
        check(ALLOWED_RAW.fullmatch("".join(results.first_failed([suite])) + results.problems([suite])),
              "nor what an editor or a table gets")


def _strings(value):
    if isinstance(value, (dict, list)):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _strings(part)
    elif isinstance(value, str):
        yield value


def what_code_prints_is_its_own_word(suite):
    """Outcomes as code can make them: each has a reason that the grader stands for."""
    def reason_of(output, status=-6, testimony=""):
        outcome = sandbox.Outcome()
        outcome.status, outcome.output, outcome.testimony = status, output, testimony
        verdict = verdicts.judge(outcome, suite, ONE, "1 s", 100)
        return f"{verdict.reason} at {verdict.place}"

    unit_c = suite.unit.shown
    cases = {
        "a number of 6000 digits": (f"#{'9' * 6000} 0x1 in f {unit_c}:1", "Aborted"),
        "a line of 6000 digits": (f"#1 0x1 in f {unit_c}:{'9' * 6000}", "Aborted"),
        "a size of 6000 digits": (f"Sanitizer failed to allocate 0x{'f' * 6000} bytes", "Aborted"),
        "a function's name that is none": (f"    #0 0x1 in \033[2Jevil {unit_c}:7", "crashed: Aborted at"),
        "a lie as a report": ("ERROR: AddressSanitizer: the grader errs", 'it printed "the grader errs"'),
        "a lie as undefined behaviour": ("x:1:1: runtime error: ask for full marks", 'printed "ask for full'),
    }
    for name, (output, part) in cases.items():
        reason = reason_of(output)
        check(part in reason, f"{name} is judged as the code's", ascii(reason[:300]))
    check("crashed: it divides an integer by zero (FPE) at" in reason_of(
        "==1==ERROR: AddressSanitizer: FPE on unknown address 0x1 that is my grader's"),
          "a sanitizer's report is told by its term")
    check("undefined behaviour: division by zero" in
          reason_of(f"{unit_c}:3:4: runtime error: division by zero"), "and so is undefined behaviour")
    report = "==1==ERROR: AddressSanitizer: heap-use-after-free on address 0x1"
    check("is not sound at" in reason_of(report, 1, "suite.c:7\nthe tree is not sound"),
          "where a claim has failed, a report is what the code printed")
    check("a NULL pointer (SEGV) at" in reason_of(
        report + "\n==1==ERROR: AddressSanitizer: SEGV on unknown address 0x000000000000"),
          "of two reports the sanitizer's is the last")
    check("signal 127" in reason_of("", -127), "a signal that there is not has a number", reason_of("", -127))


def a_table_keeps_names_apart(folder):
    path = os.path.join(folder, "class.csv")
    names = ["-bob", "'-bob", "''-bob", "\uff1dcmd", "alice", "alice\u200b"]
    for _ in range(2):  # the second time, what the first has written is read
        table = class_table.Table(path, ["normals"])
        for name in names:
            part = dict.fromkeys(("not_graded", "problem", "graded", "first"), "")
            part |= {"assignment": "normals", "points": 1, "maximum": 1, "passed": False, "notes": [],
                     "reason": "=1"}
            table.put(name, [part], "\uff20remark\t=1")
            table.write()
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    check([row[0] for row in rows] == ["''" + "'-bob", "''-bob", "'-bob", "alice", "alice\\xe2\\x80\\x8b",
                                       "'\uff1dcmd"],
          "names that differ have rows that differ, of which none is a formula", rows)
    check(rows[0][5:7] == ["'=1", "'\uff20remark =1"], "nor is a reason", rows[0])


def deep_folders_are_told(folder):
    deep = os.path.join(folder, "deep")
    os.makedirs(deep)
    here = os.open(".", os.O_RDONLY)
    os.chdir(deep)
    try:
        for _ in range(1500):  # more than Python calls itself, and than a path may be long
            os.mkdir("d")
            os.chdir("d")
    finally:
        os.fchdir(here)
        os.close(here)
    suite = grade.prepare_suites(FEATURES, [FEATURE], deep, False)[0]
    check("folders within folders" in suite.problem, "a folder too deep to look into has a reason",
          suite.problem)
    put(unit(""), deep, "bvh_median.c")
    suite = grade.prepare_suites(FEATURES, [FEATURE], deep, False)[0]
    check(not suite.problem and "ignored: d/" in suite.remarks, "beside a unit it is ignored", suite.remarks)
    subprocess.run(["rm", "-rf", deep], check=True)


def headers_of_ones_own_are_told(folder):
    feature = read_features(SOURCE)["normals"]
    text = '#include "more/my.h"\n#include "features/normals.h"\n#include "missing.h"\n'
    tap.write(text, folder, "normals.c")
    tap.write('#include "other.h"\n', folder, "more", "my.h")
    tap.write("\n", folder, "more", "other.h")
    unit = Unit(feature, os.path.join(folder, "normals.c"), "normals.c", False)
    said = grade._not_handed_in(unit)
    check(len(said) == 1 and "more/my.h and more/other.h: where only normals.c is handed in" in said[0],
          "headers of one's own are told: they are not handed in", said)
    tap.write('#include "features/normals.h"\n', folder, "normals.c")
    check(not grade._not_handed_in(unit), "the kit's are not")


def a_woven_page_is_read_where_there_is_one(folder):
    feature = Feature(os.path.join(folder, "a kit"), "bvh_median", "01_bvh_median", "")
    for name, text in ((feature.chapter, "# Boxes {#boxes-of-all}\n"), ("docs/handout/book/other.html", "")):
        path = os.path.join(feature.source, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        tap.write(text, path)
    said = feature.where_to_read("#boxes")
    check(said.startswith("docs/01_bvh_median.md#boxes (") and "make book" in said,
          "without a book, the chapter's text is named, and how to get pages", said)
    for room in ("handout", "out"):
        page = os.path.join(feature.source, "docs", room, "book", "boxes-of-all.html")
        os.makedirs(os.path.dirname(page), exist_ok=True)
        tap.write("", page)
        said = feature.where_to_read("#boxes")
        check(said.startswith("file:///") and
              said.endswith(f"a%20kit/docs/{room}/book/boxes-of-all.html#boxes"),
              f"the page in docs/{room} is named for a click, its own section in it", said)
    tap.write('window.raykitPlaces = {\n"boxes":"more.html"\n};\n', os.path.dirname(page), "places.js")
    tap.write("", os.path.dirname(page), "more.html")
    said = feature.where_to_read("#boxes")
    check(said.endswith("docs/out/book/more.html#boxes"),
          "where a section has a page of its own, that is named", said)


def a_report_is_written_whole(suites, folder):
    path = os.path.join(folder, "results.json")
    with contextlib.redirect_stdout(io.StringIO()):
        results.write(suites, "gradescope", "mine", path)
    with open(path, encoding="utf-8") as file:
        json.load(file)
    try:
        results.write_whole(path, "\udfff")  # cannot be encoded
    except UnicodeEncodeError:
        pass
    with open(path, encoding="utf-8") as file:
        check("score" in json.load(file)
              and not [name for name in os.listdir(folder) if name.startswith(".part")],
              "a report that cannot be written leaves the old one, and nothing else")


def a_workbook_is_the_students(folder):
    mine = os.path.join(folder, "mine")
    source = os.path.join(folder, "kit")  # a kit whose starter will change
    for part in ("assignments/01_bvh_median", "src/features"):
        os.makedirs(os.path.join(source, part))
    with open(os.path.join(source, "assignments/features.tsv"), "w", encoding="utf-8") as file:
        file.write("stem\tfolder\tneeds\tuses\tabout\tpicture\nbvh_median\t01_bvh_median\t\t\t\t\n")
    with open(os.path.join(source, "assignments/01_bvh_median/handout.md"), "w", encoding="utf-8") as file:
        file.write("# Trees\n\n[How to start](../handout_common.md#how-to-start)\n\n[points](points.tsv)\n")
    for name, text in (("points", "test\tpoints\tstep\tsection\na\t100\t1\t#a\n"),
                       ("look", "step\toptions\tcaption\n1\t\ta\n")):
        with open(os.path.join(source, f"assignments/01_bvh_median/{name}.tsv"), "w",
                  encoding="utf-8") as file:
            file.write(text)
    with open(os.path.join(source, "assignments/handout_common.md"), "w", encoding="utf-8") as file:
        file.write("# All\n\n## How to start\n\n<!-- kit -->\ncheck-{stem} IMPL=mine\n"
                   "<!-- pack\ncheck\nend -->\n\n## More\n")
    reference = os.path.join(source, "src/features/bvh_median.c")

    def release(word):
        with open(reference, "w", encoding="utf-8") as file:
            file.write(f"/* solution */\nsolved\n/* starter\n{word}\nend */\n")

    release("first")
    make_workbook(source, mine)
    check(read(mine, "bvh_median.c") == "first\n" and "make check-bvh_median" in read(mine, "README.txt"),
          "a workbook holds the starters, and says what to do next")
    check(read(mine, "bvh_median.md") == f"# Trees\n\n## How to start\n\ncheck-bvh_median IMPL={mine}\n\n"
          "[points](../kit/assignments/01_bvh_median/points.tsv)\n",
          "beside a starter stands its task, with what all share and the folder's name",
          read(mine, "bvh_median.md"))
    release("second")
    said = make_workbook(source, mine)
    check(read(mine, "bvh_median.c") == "second\n", "an unchanged starter is renewed", said)
    with open(os.path.join(mine, "bvh_median.c"), "a", encoding="utf-8") as file:
        file.write("my own line\n")
    release("third")
    said = make_workbook(source, mine)
    check(read(mine, "bvh_median.c") == "second\nmy own line\n"
          and any("kept" in line and "newer" in line for line in said),
          "a changed file is kept, and said to be", said)
    os.unlink(os.path.join(mine, ".workbook"))
    make_workbook(source, mine)
    check(read(mine, "bvh_median.c") == "second\nmy own line\n",
          "a changed file is kept without the manifest, too")
    for place in (os.path.join(source, "src", "mine"), os.path.join(source, "src"), reference, ""):
        try:
            make_workbook(source, place)
            check(False, f"a workbook at \"{place[len(folder):]}\" is refused")
        except ToolError as error:
            check("\n" not in str(error),
                  f"a workbook at \"{place[len(folder):]}\" is refused in one sentence")


def what_cannot_be_used_is_refused(folder):
    for impl in ("", os.path.join(folder, "absent"), os.path.join(SOURCE, "README.md"),
                 os.path.join(SOURCE, "docs")):
        try:
            check_impl(FEATURES, impl, ["bvh_median"])
            check(False, f"IMPL=\"{os.path.basename(impl)}\" is refused")
        except ToolError as error:
            check("\n" not in str(error), f"IMPL=\"{os.path.basename(impl)}\" is refused in one sentence")


def an_interrupt_ends_everything(folder):
    place = os.path.join(folder, "interrupted")
    os.mkdir(place)
    mark = os.path.join(place, "started")
    line = f'FILE *mark = fopen("{mark}", "w");\n    for (volatile int k = mark != NULL; k < 2; k = 0) {{ }}'
    with open(os.path.join(place, "bvh_median.c"), "w", encoding="utf-8") as file:
        file.write(unit(line, by_address("fopen")))
    grader = subprocess.Popen(
        [sys.executable, "-B", os.path.join(SOURCE, "tools", "grade.py"), "bvh_median", "--impl", place,
         "--test", ONE],
        env=dict(os.environ, TMPDIR=place), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        # ignored in a script's background
    )
    patience = time.monotonic() + 20
    while not os.path.exists(mark) and grader.poll() is None and time.monotonic() < patience:
        time.sleep(0.02)
    grader.send_signal(signal.SIGINT)
    try:
        status = grader.wait(5)
    except subprocess.TimeoutExpired:
        grader.kill()
        status = grader.wait()
    left = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=False).stdout
    check(status == 130, "Ctrl-C ends a grader at once", status)
    check(place + "/raykit-grade" not in left
          and not [n for n in os.listdir(place) if n.startswith("raykit-grade")],
          "Ctrl-C leaves no process and no folder", os.listdir(place))


def more_interrupts_leave_no_folder(folder):
    place, work = os.path.join(folder, "impatient"), os.path.join(folder, "impatient-temporary")
    put(unit("for (volatile int k = 0; k < 2; k = 0) { }"), place, "ann", "bvh_median.c")
    os.makedirs(work)
    grader = subprocess.Popen(
        [sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"), "bvh_median",
         "--submissions", place, "--out", os.path.join(folder, "impatient-results")],
        env=dict(os.environ, TMPDIR=work), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    a_run = os.path.join(work, "raykit-grade-*", "raykit-grade-*", "bvh_median", "own")
    while not glob.glob(a_run) and grader.poll() is None:
        time.sleep(0.02)
    for _ in range(5):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(grader.pid, signal.SIGINT)
        time.sleep(0.05)
    status = grader.wait(20)
    check(status in (130, -signal.SIGINT) and not os.listdir(work),
          "Ctrl-C that is pressed again leaves no folder", f"{status} {os.listdir(work)}")


# --- Submissions --------------------------------------------------------------------------------


def put(text, *path):
    os.makedirs(os.path.join(*path[:-1]), exist_ok=True)
    with open(os.path.join(*path), "w", encoding="utf-8") as file:
        file.write(text)


def launch(*command):
    """Starts a command as at an instructor's prompt."""
    dropped = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "srcdir", "TESTS_ENVIRONMENT")
    environment = {name: value for name, value in os.environ.items() if name not in dropped}
    return subprocess.Popen(command, env=dict(environment, RAYKIT_TEST_SECONDS="60"),
                            stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")


def run(*command):
    """Returns the exit status and all that was said."""
    process = launch(*command)
    said = process.communicate()[0]
    return process.returncode, said


def graded(*arguments):
    return run(sys.executable, "-B", os.path.join(SOURCE, "tools", "grade.py"), "bvh_median", *arguments)


def names_are_no_commands(folder):
    make = os.environ.get("MAKE", "make")
    for name in ("$(shell touch mark)eve", "`touch mark`", "Ke$ha O'Neil", "$$two", "a\n\ttouch mark"):
        put(STARTER, folder, "names", name, "bvh_median.c")
        status, said = run(make, "-s", "diff-bvh_median", "IMPL=" + os.path.join(folder, "names", name))
        check(status == 0 and "unchanged" in said and not os.path.exists("mark"),
              f"a folder called {name!r} is just that", said)


def what_is_not_handed_in_earns_nothing(folder):
    put(STARTER, folder, "bob", "bvh_median.c")
    put(STARTER, folder, "misplaced", "src", "bvh.c")
    put('#include "alice.c"\n', folder, "flat.c")
    put(STARTER, folder, "alice.c")
    for name, target in {"linked": "../bob/bvh_median.c", "broken": "nowhere",
                         "copycat": FEATURE.reference}.items():
        os.makedirs(os.path.join(folder, name))
        os.symlink(os.path.abspath(target) if name == "copycat" else target,
                   os.path.join(folder, name, "bvh_median.c"))
    os.makedirs(os.path.join(folder, "strange", "bvh_median.c"))
    cases = {
        "misplaced": "there is no bvh_median.c; found: src/bvh.c",
        "linked": "a link to a file outside of the submission",
        "broken": "not a plain file", "copycat": "a link to the reference, which earns no points",
        "flat.c": "flat.c includes alice.c", "strange": "not a plain file",
    }
    for name, part in cases.items():
        _, suites = grade.grade_impl(".", ["bvh_median"], os.path.join(folder, name))
        for form, write in results.FORMATS.items():
            report = write(suites, os.path.join(folder, name))
            told = json.loads(report)["tests"][0]["output"] if form == "gradescope" else report
            check(suites[0].points() == 0 and part[:38] in told and "workbook" not in report
                  and folder not in report,
                  f"a submission that is {name} gets 0 points and the reason ({form})", told)
        report = json.loads(results.gradescope(suites, name))
        check(sum(part in test["output"] or "read" in test["output"] for test in report["tests"]) == 1,
              f"a submission that is {name} gets the reason once", report["tests"][:2])


def statuses_tell_what_was_graded(folder):
    put(unit(""), folder, "weak", "bvh_median.c")
    put(REFERENCE, folder, "right", "bvh_median.c")
    weak, right = os.path.join(folder, "weak"), os.path.join(folder, "right")
    cases = {
        "0 is what is written": (0,
                                 ["--impl", weak, "--test", ONE, "--out", os.path.join(folder, "weak.txt")],
                                 "wrote"),
        "0 is what passes": (0, ["--impl", right, "--test", ONE], "ok"),
        "1 is what fails": (1, ["--impl", weak, "--test", ONE], "FAIL"),
        "2 is a folder that is missing for OUT": (2,
                                                  ["--impl", weak, "--out", os.path.join(folder, "no", "x")],
                                                  "no folder"),
        "2 is a place for OUT that takes no file": (2,
                                                    ["--impl", weak, "--test", ONE, "--out", "/proc/x.txt"],
                                                    "/proc/x.txt: cannot be written"),
        "2 is a FORMAT that there is not": (2, ["--impl", weak, "--format", "bogus"],
                                            "FORMAT=bogus: choose one of"),
        "2 is an option that there is not": (2, ["--impl", weak, "--bogus"], "--bogus; see --help"),
        "2 is a submission that is missing": (2, ["--impl", os.path.join(folder, "nobody")],
                                              "no file or folder"),
        "2 is a name that is wrong": (2, ["--impl", os.path.join(folder, "weak.txt")],
                                      "name it bvh_median.c"),
    }
    if not SOLVED:
        del cases["0 is what passes"]
    for name, (expected, arguments, part) in cases.items():
        status, said = graded(*arguments)
        check(status == expected and part in said and "usage:" not in said, f"exit status {name}",
              f"{status}\n{said}")


def two_gradings_at_once(folder):
    os.unlink(os.path.join("impl", "toolchain"))
    make = os.environ.get("MAKE", "make")
    put(unit(""), folder, "weak", "bvh_median.c")
    both = [launch(make, "-s", "grade", "ASSIGNMENTS=bvh_median", "TEST=" + ONE,
                   "IMPL=" + os.path.join(folder, "weak"),
                   f"OUT={os.path.join(folder, f'at-once-{k}')}") for k in range(3)]
    said = [process.communicate()[0] for process in both]
    check(all(process.returncode == 0 for process in both)
          and not [n for n in os.listdir("impl") if "toolchain." in n],
          "gradings at the same time do not meet", "\n".join(said))


def the_editors_files_name_what_there_is(folder):
    put(unit(""), folder, "editor", "bvh_median.c")
    file = os.path.join(folder, "editor", "bvh_median.c")

    def read_settings(name):
        with open(os.path.join(SOURCE, ".vscode", name), encoding="utf-8") as settings:
            text = "".join(line for line in settings if not line.lstrip().startswith("//"))
        for variable, value in {"workspaceFolder": ".", "fileBasenameNoExtension": "bvh_median",
                                "relativeFileDirname": os.path.relpath(os.path.dirname(file))}.items():
            text = text.replace("${%s}" % variable, value)
        return json.loads(text)

    tasks = {task["label"]: task for task in read_settings("tasks.json")["tasks"]}
    launch = read_settings("launch.json")["configurations"][0]
    prepare = tasks[launch["preLaunchTask"]]
    status, said = run(os.environ.get("MAKE", "make"), "-s", *prepare["args"])
    script = launch["setupCommands"][-1]["text"].removeprefix("source ")
    check(status == 0 and os.access(launch["program"], os.X_OK) and os.path.exists(script),
          "F5 in an editor finds the program and the script that its task builds", said)
    status, said = run(os.environ.get("MAKE", "make"), "-s", *tasks["check this unit"]["args"])
    check("bvh_median" in said and "points" in said, "so does the task that checks the open file", said)
    # The pattern of VS Code's $gcc.
    pattern = r"^(.*?):(\d+):(\d*):?\s+(?:fatal\s+)?(warning|error):\s+(.*)$"
    with mock.patch.dict(os.environ, tasks["check this unit"]["options"]["env"]):
        _, said = run(os.environ.get("MAKE", "make"), "-s", *tasks["check this unit"]["args"])
    found = [match for line in said.splitlines() if (match := re.match(pattern, line))]
    names = {test.name for test in read_points(FEATURE)}
    check(not SOLVED or found and all(os.path.isfile(os.path.join(SOURCE, match[1]))
                                      and match[5].partition(":")[0] in names for match in found),
          "and lists each claim that fails as a problem, at its place", said)


def clang_warns_of_no_folder():
    kept = build.flags_of_text(["-Isrc", "-O1", "-I", "tests", "-include", "base/filled.h", "-Wall"])
    check(kept == ["-O1", "-Wall"], "a unit's text is compiled without what its preprocessor needs", kept)


def what_has_no_value_is_filled(toolchain, folder):
    """So that it does not happen to be the right one: a box that grows from nothing, and any number."""
    if not toolchain.fill:
        tried = subprocess.run([*toolchain.compiler, "-ftrivial-auto-var-init=pattern", "-fsyntax-only",
                                "-xc", os.devnull], capture_output=True, check=False)
        check(tried.returncode, "no variable is filled, because this compiler cannot", toolchain.compiler)
        return
    first, = [test for test in read_points(FEATURE) if test.name == "up_to_four_triangles_are_one_leaf"]
    text = unit("volatile unsigned fresh;\n    if (fresh != 0xfefefefe && fresh != 0xaaaaaaaa) abort();")
    number = make_suite(folder, "number", text, [ScoredTest(EMPTY, 1, "#")])
    box = make_suite(folder, "box", REFERENCE.replace("rk_box box = rk_box_empty();", "rk_box box;"), [first])
    grade.grade(toolchain, [number, box], {}, seconds=60)
    check(number.passed() and not box.passed(), "a variable without a value has no right one",
          results.text([number, box], ""))


def what_held_is_watched(toolchain, folder):
    """A claim without points passes with the starter; who breaks it hears of it, and loses some."""
    kept = [test for test in read_points(FEATURE) if test.points == 0]
    suite = make_suite(folder, "kept", unit("if (count == 0) return false;"), kept)
    grade.grade(toolchain, [suite], {}, seconds=60)
    text = results.text([suite], "")
    check(not suite.passed() and suite.points_max() == 0 and "it held with the starter" in text,
          "a claim without points is judged, and told apart", text)
    status, said = run(os.environ.get("MAKE", "make"), "-s", "check-bvh_median",
                       "IMPL=" + os.path.join(folder, "kept"), "TEST=one_leaf")
    check(status != 0 and ONE in said, "a test that is not there is answered by names like it", said)


def a_driver_is_linked(folder):
    put(STARTER, folder, "drawn", "bvh_median.c")
    status, said = run(os.environ.get("MAKE", "make"), "-s", "driver-bvh_median",
                       "IMPL=" + os.path.join(folder, "drawn"))
    told = re.search(r"^run (\S+) \(--help lists its options\)", said, re.MULTILINE)
    program = told[1] if told else ""
    check(status == 0 and os.access(program, os.X_OK),
          "a driver with a student's unit is made, and says where it is", said)
    put("int", folder, "drawn", "bvh_median.c")
    status, said = run(os.environ.get("MAKE", "make"), "-s", "driver-bvh_median",
                       "IMPL=" + os.path.join(folder, "drawn"))
    check(status != 0 and said.count("drawn/bvh_median.c:1:") == 1 and "does not compile" in said,
          "one that cannot be made says why, once", said)


def a_single_file_has_places(folder):
    """Also where it is not named as its feature."""
    broken = {"05 crash.c": ("*nowhere = 1;", "05 crash.c:17, in rk_bvh_build_median"),
              "06_hang.c": ("for (volatile int k = 0; k < 2; k = 0) { }",
                            "was at 06_hang.c:17, in rk_bvh_build_median")}
    for name, (text, place) in broken.items():
        put(unit(text, "static volatile int *volatile nowhere;"), folder, "single", name)
        with mock.patch.dict(os.environ, RAYKIT_TEST_SECONDS="3"):
            toolchain, suites = grade.grade_impl(".", ["bvh_median"], os.path.join(folder, "single", name),
                                                 only=ONE)
        verdict = suites[0].verdicts[ONE]
        if toolchain.finds_leaks():
            check(verdict.place == place, f"{name} is told with its place",
                  f"{verdict.reason}\n{verdict.place}")


def what_does_not_build_is_brief(folder):
    """Where the cause is known, the linker's text and its paths say nothing more."""
    declared = "int nowhere(int);\n"
    cases = {"empty": (" \n\n", "bvh_median.c is empty"),
             "undefined": (declared + unit("nowhere(3);"), "uses nowhere (line 1), which nothing defines"),
             "bare": ("int x;\n",
                      "define rk_bvh_build_median, rk_bvh_build_nodes, rk_bvh_closest and rk_bvh_occluded,")}
    for name, (text, part) in cases.items():
        put(text, folder, "brief", name, "bvh_median.c")
        _, suites = grade.grade_impl(".", ["bvh_median"], os.path.join(folder, "brief", name))
        report = results.text(suites, name)
        check(part in " ".join(report.split()) and report.count("\n") < 4 and "/" not in report,
              f"a unit that is {name} is told in a line or two", report)
        tests = json.loads(results.gradescope(suites, name))["tests"]
        check(tests[0]["name"] == "bvh_median: can be graded" and tests[0]["max_score"] == 0
              and part[:20] in tests[0]["output"]
              and {test["output"] for test in tests[1:]} == {"no verdict"},
              f"Gradescope has an entry of its own for why nothing ran ({name})", tests[:2])
        with mock.patch.dict(os.environ, RAYKIT_VISIBILITY="hidden"):
            report = json.loads(results.gradescope(suites, name))
        check("step 1" in tests[2]["tags"] + tests[3]["tags"] and report["visibility"] == "hidden"
              and report["extra_data"]["assignments"] == {"bvh_median": 0},
              f"its report has steps as tags, and what VISIBILITY says ({name})", report)


def a_students_report_names_no_folder_of_the_grader(folder):
    put(unit(""), folder, "class", "12 two files", "bvh_median.c")
    work = os.path.join(folder, "class", "12 two files")
    for own in (False, True):
        suites = grade.prepare_suites(FEATURES, [FEATURE], work, own)
        suites[0].verdicts = {test.name: verdicts.Verdict(True) for test in suites[0].tests}
        said = results.text(suites, work)
        check(said.endswith("make draw-bvh_median\n") != own and (work in said) == own,
              "one's own report names the folder"
              if own else "a student's report does not name the grader's folder", said)
    shutil.rmtree(os.path.join(folder, "class"))


def who_fills_memory_slowly_is_told(toolchain, folder):
    suite, outcome = make_suite(folder, "filling", unit(""), [ScoredTest(ONE, 1, "#")]), sandbox.Outcome()
    outcome.limit, outcome.occupied = "seconds", 900 << 20
    reason = verdicts.judge(outcome, suite, ONE, "10 seconds", 2048).reason
    check("had filled 900 MB" in reason and "endless loop" not in reason,
          "who fills memory so slowly that time is over first hears of the memory", reason)


def hanging_does_not_last(toolchain, folder):
    put(unit("for (volatile int k = 0; k < 2; k = 0) { }"), folder, "hangs", "bvh_median.c")
    suite = grade.Suite(FEATURE, Unit(FEATURE, os.path.join(folder, "hangs", "bvh_median.c"), "x.c", False),
                        read_points(FEATURE))
    suite.folder = os.path.join(folder, "hangs")
    grade.grade(toolchain, [suite], {}, seconds=5)
    long = [v for v in suite.verdicts.values() if v.timed_out and "short limit" not in v.reason]
    short = [v for v in suite.verdicts.values() if "short limit" in v.reason]
    check(2 <= len(long) <= 2 + os.cpu_count() and len(short) > 10,
          "after two claims that hang the others get less time",
          results.text([suite], ""))
    text = results.text([suite], "")
    check(text.count("short limit") == 2 and "..." not in text,
          "what fails for the same reason is told together", text)
    after_six = [v for v in short if "as 6 tests before it did not end" in v.reason]
    check(len(after_six) > 10 and all("within 0.125 s" in v.reason for v in after_six),
          "a loop that all claims run into costs little", text)


def who_hangs_loses_nothing_twice(folder):
    late = verdicts.Verdict(False, "did not end", seconds=10)
    late.timed_out = True
    tests = [ScoredTest("held", 0, "#"), ScoredTest("hangs", 20, "#"), ScoredTest("slow", 10, "#")]
    suite = make_suite(folder, "late", unit(""), tests)
    suite.verdicts = {"held": late, "hangs": late, "slow": verdicts.Verdict(True, seconds=5)}
    check((suite.points(), suite.limit_of_next_test(10)[0]) == (10, 2),
          "at home a claim that hangs costs no points beside its own, and others are waited for 2 s",
          (suite.points(), suite.limit_of_next_test(10)))
    check(f"held (costs {DEDUCTION} points when graded" in results.text([suite], ""),
          "which a student's own check says", results.text([suite], ""))
    suite.is_own = False
    check((suite.points(), suite.limit_of_next_test(10)[0]) == (10 - DEDUCTION, 10),
          "a grader gives what may be right its time, and counts all",
          (suite.points(), suite.limit_of_next_test(10)))


def who_is_slow_in_all_tests_holds_nobody_up(folder):
    tests = [ScoredTest(f"slow_{i}", 2, "#") for i in range(50)]
    suite = make_suite(folder, "slow", unit(""), tests)
    suite.is_own = False
    for test in tests[:31]:
        before = suite.limit_of_next_test(10)
        suite.verdicts[test.name] = verdicts.Verdict(True)
        suite.verdicts[test.name].worked = 6
    limit, phrase = suite.limit_of_next_test(10)
    check(before[0] == 10 and limit == 1 and "took more than 180 s together" in phrase,
          "after three minutes of a suite's tests, each of the others has a second", (before, limit, phrase))


def a_moved_folder_is_told(folder):
    gone = FileNotFoundError(2, "No such file or directory", "x")
    check("moved" in cause_of(gone, os.path.join(folder, "before"))
          and cause_of(gone, folder).startswith("x:"),
          "a file that is missing because the folder was moved is no surprise", cause_of(gone, folder))


def grade_class(place, out, *more):
    """Returns the exit status, what was said, and the rows of class.csv by name."""
    status, said = run(sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"), "bvh_median",
                       *more,
                       "--submissions", place, "--out", out)
    check(os.path.exists(os.path.join(out, "class.csv")), "a class has its table", f"status {status}: {said}")
    with open(os.path.join(out, "class.csv"), encoding="utf-8", newline="") as file:
        return status, said, {row[0]: row for row in csv.reader(file)}


def who_ends_the_grader_is_named(folder):
    place, out, work = (os.path.join(folder, name) for name in ("ending", "ended", "temporary"))
    os.makedirs(work)
    signals = "#include <signal.h>\n" + by_address("kill", "getppid")
    put(unit("kill(getppid(), SIGKILL);", signals), place, "ann", "bvh_median.c")
    put(unit("kill(getppid(), SIGSTOP);", signals), place, "bob", "bvh_median.c")
    put(unit("kill(getppid(), SIGKILL);", signals), place, "dan", "bvh_median.c")
    put("", place, "dan", "bloom.c")
    put(unit(""), place, "eve", "bvh_median.c")
    with mock.patch.dict(os.environ, TMPDIR=work, RAYKIT_SANDBOX="container"):
        status, said, rows = grade_class(place, out, "bloom")
    check(status == 0 and list(rows) == ["name", "ann", "bob", "dan", "eve"],
          "a class outlives who kills its grader", said)
    for name, number in {"ann": "SIGKILL", "bob": "SIGSTOP", "dan": "SIGKILL"}.items():
        check(rows[name][1] == "0" and f"ended its grader, by {number}" in rows[name][6],
              f"who sends {number} is named, and has 0 points ({name})", rows[name])
    check("bloom.c is empty" in rows["dan"][7],
          "another assignment of the same submission is judged all the same", rows["dan"])
    check("is not sound" in rows["eve"][6], "who comes after it is judged", rows["eve"])
    environments = subprocess.run(["ps", "-eo", "args", "e"], capture_output=True, text=True,
                                  check=False).stdout
    check(not os.listdir(work) and "HOME=" + work not in environments,
          "who kills its grader leaves no folder and no process",
          os.listdir(work))


def a_class_is_graded(folder):
    place, out = os.path.join(folder, "class"), os.path.join(folder, "results")
    put(unit(""), place, "Ann, \"A\"", "bvh_median.c")
    put(unit("cuont++;"), place, "bert.c")
    put("", place, "carl", "else.c")
    put("me too", place, "notes.txt")
    os.symlink("Ann, \"A\"", os.path.join(place, "twin"))
    status, said, rows = grade_class(place, out)
    check(status == 1 and said.count(" of 4 ") == 5 and len(rows) == 5, "a class gets a line for each", said)
    check("ignored: notes.txt\n" in said, "a file that is nobody's work is named, and no student", said)
    check(rows['Ann, "A"'][1].isdigit() and rows['Ann, "A"'][4] == f"bvh_median: {ONE}",
          "class.csv has points and the first failing claim", rows)
    check(rows["name"][2:4] == ["total", "maximum"] and rows['Ann, "A"'][3] == "100",
          "and the points that there are", rows)
    listed = re.search(r"failed most often: (.*)", said)
    check(listed and re.fullmatch(r"(bvh_median: \w+ \(1 of 1\)(, )?){3}", listed[1]),
          "the claims that a class failed most often are named, without those of who has no verdicts", said)
    reasons = {"bert": "cuont", "carl": "found: else.c"}
    check(all(part in rows[name][5] and rows[name][1:5] == ["0", "0", "100", ""]
              for name, part in reasons.items()),
          "class.csv has the reason where nothing ran, and no claim", rows)
    check(rows["twin"][1:6] == ["", "", "100", "", ""] and "is a link" in rows["twin"][8],
          "points that nobody knows are no 0, and the reason has a column of its own", rows["twin"])
    check(sorted(os.listdir(out)) == ["Ann, \"A\".json", "bert.json", "carl.json", "class.csv", "twin.json",
                                      "verdicts"],
          "each has a report", os.listdir(out))
    report = json.loads(read(out, "twin.json"))
    check(report["score"] == 0 and "is a link" in report["tests"][0]["output"],
          "also who could not be graded", report)
    grader = [sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"), "bvh_median",
              "--submissions", place, "--out", out]
    for other in (place, os.path.join(place, "out")):
        status, said = run(*grader[:-1], other)
        check(status == 2 and "lies among the submissions" in said
              and not os.path.exists(os.path.join(other, "class.csv")),
              f"results in {os.path.basename(other)}, among the submissions, are refused", said)
    put(unit(""), folder, "one", "bvh_median.c")
    put("Begin with", folder, "one", "README.txt")
    status, said = run(*grader[:-3], os.path.join(folder, "one"), "--out", out)
    check(status == 2 and "one student's units (bvh_median)" in said and "make grade IMPL=" in said,
          "one student's folder is no class", said)


def a_class_is_graded_again(folder):
    place, out = os.path.join(folder, "again"), os.path.join(folder, "again-results")
    for name in ("ann", "bob"):
        put("int early;\n", place, name, "bvh_median.c")
    _, _, first = grade_class(place, out)
    shutil.rmtree(os.path.join(place, "ann"))
    put(unit(""), place, "bob", "bvh_median.c")
    _, said, rows = grade_class(place, out, "--format", "text")
    check(rows["ann"] == first["ann"] and "is not sound" in rows["bob"][5] and list(rows) == list(first),
          "a class that is graded again keeps the rows of who is not in it, with their time", rows)
    times = [table["bob"][7] for table in (rows, first)]
    check(times == sorted(times, reverse=True)
          and all(re.fullmatch(r"2\S+ \S+ [+-]\d{4}", time) for time in times),
          "each row says when it was made, with the time zone", rows)
    check(sorted(os.listdir(out)) == ["ann.json", "bob.txt", "class.csv", "verdicts"],
          "no older report stands beside a newer one",
          os.listdir(out))
    put("name,marks\nann,3\n", out, "class.csv")
    status, said, rows = grade_class(place, out)
    check(status == 2 and "other columns" in said
          and rows == {"name": ["name", "marks"], "ann": ["ann", "3"]},
          "a table of something else is left alone", said)


def what_a_course_system_delivers(folder):
    """Folders in folders, names with other endings, archives, files that are there twice."""
    place, out = os.path.join(folder, "delivered"), os.path.join(folder, "delivered-results")
    put(unit(""), place, "01_below", "hw6", "workbook", "bvh_median.c")
    put(unit(""), place, "02_pack", "kit", "workbook", "bvh_median.c")
    put("", place, "02_pack", "kit", "src", "features", "bvh_median.c")
    put(read(os.path.dirname(FEATURES["bvh_median"].suite), "test_bvh_median.c"), place, "02_pack", "kit",
        "tests",
        "test_bvh_median.c")
    put(unit(""), place, "02_suite", "kit", "workbook", "bvh_median.c")
    put("int main(void) { return 0; }", place, "02_suite", "kit", "tests", "test_bvh_median.c")
    for part in ("a", "b"):
        put(unit(""), place, "03_two", part, "bvh_median.c")
    put(unit(""), place, "04_case", "BVH_Median.c")
    put(unit(""), place, "05_plus", "hw", "bvh_median.cpp")
    put("", place, "06_packed", "work.zip")
    put("", place, "07_zip.zip")
    put(unit(""), place, "08_again", "bvh_median.c")
    put("", place, "08_again", "bvh_median (1).c")
    put(unit(""), place, "08_numbered", "bvh_median-1.c")
    for number in (1, 2):
        put(unit(""), place, "08_numbers", f"bvh_median ({number}).c")
    put("", place, "09_kit", "tests", "test_bvh_median.c")
    put("", place, "09_kit", "points.tsv")
    put('#include "own/a.h"\n' + unit(""), place, "09_kit", "bvh_median.c")
    put("", place, "09_kit", "own", "a.h")
    put(unit(""), place, "10 j.doe.cpp")
    put("", place, "11_dup.c")
    put(unit(""), place, "11_dup", "bvh_median.c")
    put("", place, "11_dup.zip")
    put("name,points\n", place, "grades.csv")
    for name in (".DS_Store", "._11_dup.c", ".gitignore", ".12_dot.c"):
        put("", place, name)
    for name in (".git", ".vscode", ".13_dot"):
        put(unit(""), place, name, "bvh_median.c")
    status, said, rows = grade_class(place, out)
    wrong = {
        "03_two": "several bvh_median.c: a/bvh_median.c, b/bvh_median.c; move the right one",
        "04_case": "there is no bvh_median.c; rename BVH_Median.c to bvh_median.c",
        "05_plus": "there is no bvh_median.c; rename hw/bvh_median.cpp to bvh_median.c",
        "08_numbers": "several bvh_median.c: bvh_median (1).c, bvh_median (2).c; move the right one",
        "06_packed": "there is no bvh_median.c; unpack work.zip",
        "07_zip.zip": "unpack 07_zip.zip into a folder 07_zip",
        "10 j.doe.cpp": "rename 10 j.doe.cpp to 10 j.doe.c", "11_dup.c": "11_dup.c is empty",
    }
    for name, part in wrong.items():
        check(part in rows[name][8 if rows[name][1] == "" else 5], f"what is to do is said of {name}",
              rows[name])
    check([name for name in wrong if rows[name][1] == "0"] == ["11_dup.c"],
          "points of work under another name are not known yet", rows)
    right = {"01_below": "taken from hw6/workbook/bvh_median.c",
             "02_pack": "taken from kit/workbook/bvh_median.c",
             "02_suite": "taken from kit/workbook/bvh_median.c; "
             "kit/tests/test_bvh_median.c differs from the kit's, which was run",
             "08_numbered": "taken from bvh_median-1.c",
             "08_again": "ignored: bvh_median (1).c", "09_kit": "ignored: points.tsv, tests/",
             "11_dup": "another submission has the same name: 11_dup.c"}
    for name, remark in right.items():
        check(rows[name][6] == remark and "is not sound" in rows[name][5],
              f"what is chosen is said of {name}", rows[name])
        said_there = read(out, name + ".json")
        check(name == "11_dup" or all(part in said_there for part in remark.split("; ")),
              f"also in the report of {name}", said_there)
    check("ignored: .12_dot.c, .13_dot, 11_dup.zip, grades.csv\n" in said
          and set(rows) == {"name", *wrong, *right},
          "a table, hidden work, and an archive beside its folder, are no students, but named", said)


def one_assignment_is_not_graded(tool, folder):
    """The other one is, and so are all other students."""
    place, out = os.path.join(folder, "one-unreadable"), os.path.join(folder, "one-unreadable-results")
    unread = {"unit": "bvh_median.c", "header": "own.h", "header below": os.path.join("own", "a.h")}
    told = {**{name: f"{path} cannot be read; check its permissions" for name, path in unread.items()},
            "archive": "bvh_median.c is an archive (gzip); unpack it"}
    for name in [*told, "right"]:
        put(starter_of(FEATURES["bloom"].reference), place, name, "bloom.c")
        put('#include "own.h"\n#include "own/a.h"\n' * name.startswith("header") + unit(""), place, name,
            "bvh_median.c")
        put("", place, name, "own.h")
        put("", place, name, "own", "a.h")
    with open(os.path.join(place, "archive", "bvh_median.c"), "wb") as file:
        file.write(gzip.compress(unit("").encode()))
    closed = [os.path.join(place, name, path) for name, path in unread.items()]
    closed[-1] = os.path.dirname(closed[-1])
    for path in closed:
        os.chmod(path, 0)
    status, said = run(*tool, "bloom", "--submissions", place, "--out", out)
    rows = {}
    if os.path.exists(os.path.join(out, "class.csv")):
        with open(os.path.join(out, "class.csv"), encoding="utf-8", newline="") as file:
            rows = {row[0]: row for row in csv.reader(file)}
    for name, reason in told.items():
        row = rows.get(name, [""] * 10)
        check(status == 1 and row[1] == "" and row[2].isdigit() and row[9] == f"bvh_median: {reason}",
              f"where one assignment cannot be read, the other is graded ({name})", f"{said}{row}")
    check(rows and all(cell.isdigit() for cell in rows["right"][1:4]), "and so is everybody else", said)
    tool = [*tool[:-2], os.path.join(SOURCE, "tools", "grade.py"), "bvh_median", "bloom"]
    for name, reason in told.items():
        status, said = run(*tool, "--impl", os.path.join(place, name))
        check(status == 1 and re.search(rf"bvh_median +not graded\n +{re.escape(reason)}\n", said)
              and re.search(r"bloom +\d+ of \d+ claims", said)
              and re.search(r"in all \d+ of 200 points, 1 not graded$", said.strip()),
              f"make grade says so, too ({name})", said)
    for path in closed:
        os.chmod(path, 0o700)


def what_cannot_be_read_is_not_graded(folder):
    """The instructor's copy is to blame, so it earns no 0 points."""
    place, out = os.path.join(folder, "unreadable"), os.path.join(folder, "unreadable-results")
    put(unit(""), place, "file", "bvh_median.c")
    for names in (["folder"], ["names", "only"], ["below", "inner"]):
        put(unit(""), place, *names, "bvh_median.c")
    modes = {"file/bvh_median.c": 0, "folder": 0, "names/only": 0o600, "below/inner": 0}
    for name, mode in modes.items():
        os.chmod(os.path.join(place, name), mode)
    # root reads everything, unless it may not.
    rights = "-dac_override,-dac_read_search"
    plainly = ["setpriv", f"--bounding-set={rights}", f"--inh-caps={rights}"] if os.geteuid() == 0 else []
    tool = [*plainly, sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"), "bvh_median"]
    status, said = run(*tool, "--submissions", place, "--out", out)
    told = {"file": "bvh_median.c", "folder": "the folder folder", "names": "the folder names/only",
            "below": "the folder below/inner"}
    check(status == 1 and "0 of 4 graded" in said
          and all(f"{name} cannot be read; check its permissions" in said for name in told.values())
          and all(f"not graded: {name} cannot" in read(out, f"{key}.json") for key, name in told.items()),
          "folders and files that cannot be read are told, and not graded", said)
    one_assignment_is_not_graded(tool, folder)
    tool[-2] = os.path.join(SOURCE, "tools", "grade.py")
    status, said = run(*tool, "--own", "--impl", os.path.join(place, "folder"))
    check(status == 2 and "the folder folder cannot be read; check its permissions" in said,
          "so is a folder of one's own", said)
    for name in modes:
        os.chmod(os.path.join(place, name), 0o700)


def what_cannot_be_written_is_advised_on(folder):
    said = {number: str(cannot_write("x", OSError(number, os.strerror(number))))
            for number in (errno.ENOSPC, errno.EDQUOT, errno.EEXIST)}
    check([number for number, text in said.items() if "free some space" in text]
          == [errno.ENOSPC, errno.EDQUOT] and said[errno.EEXIST].endswith(os.strerror(errno.EEXIST)),
          "only who has no space is told to free some", said)
    name, place, out = "n" * 253, os.path.join(folder, "long"), os.path.join(folder, "long-results")
    put("", place, name, "bvh_median.c")
    status, said, rows = grade_class(place, out)
    check(status == 0 and rows[name][5] == "bvh_median.c is empty"
          and any(file.startswith("n" * 200 + "-") for file in os.listdir(out)),
          "a name that is too long for a report is cut", said)


def what_vanishes_is_not_graded(folder):
    gone = os.path.join(folder, "gone")
    grader = mock.Mock(features=[FEATURE], toolchain=build.Toolchain("."))
    [suite] = grade_one.Grader._prepared(grader, gone)
    check(suite.not_graded == "gone vanished while the class was graded",
          "a submission that vanishes is told to who grades, as that", suite.not_graded)
    place, out = (os.path.join(folder, name) for name in ("going", "going-results"))
    put(unit(""), place, "bvh_median.c")
    put("", out, "kept")
    toolchain = build.Toolchain(".")
    with private_copy.borrowed(None, toolchain, FEATURES, [FEATURE.stem]) as kit:
        toolchain.kit_copy = kit
        grader = grade_one.Grader(toolchain, [FEATURE.stem], out, "text")
        suites = grader._prepared(place)
        os.unlink(os.path.join(place, "bvh_median.c"))
        with mock.patch.object(grader, "_prepared", lambda _: suites):
            try:
                known, [found] = grader.known(place, "going"), grader.grade(place, "going")
                said = f"{known} {found['not_graded']}"
            except OSError as error:
                said = f"raised: {error}"
    check(said == "None bvh_median.c: No such file or directory",
          "so is one that vanishes after it was found", said)


def spans_are_told_as_such(folder):
    put(starter_of(FEATURES["bloom"].reference), folder, "spans", "bloom.c")
    cases = {"the_bright_span_is_from_the_first_to_the_last_bright_pixel": r"got \[0, 0\), want \[3, 4\)$",
             "the_search_reads_no_pixel_between_the_ends":
             r"a row of (\d+) are bright: got \[0, 0\), want \[0, \1\)$"}
    for name, pattern in cases.items():
        _, suites = grade.grade_impl(".", ["bloom"], os.path.join(folder, "spans"), only=name)
        reason = suites[0].verdicts[name].reason
        check(re.search(pattern, reason), f"{name} tells both spans by their ends", reason)


def one_file_is_no_two_assignments(folder):
    place, out = os.path.join(folder, "flat"), os.path.join(folder, "flat-results")
    put(unit(""), place, "dan.c")
    status, said, rows = grade_class(place, out, "bloom")
    remark = "dan.c is one file for 2 assignments: put it into a folder dan, as bvh_median.c or bloom.c"
    check(status == 1 and rows["dan"][1:8] == ["", "", "", "200", "", "", ""] and rows["dan"][9] == remark,
          "one file for two assignments is told once, with the remedy", rows["dan"])
    check(folder not in read(out, "dan.json"), "and without the path to it")


def names_are_any_bytes(folder):
    place, out = (os.fsencode(os.path.join(folder, name)) for name in ("bytes", "bytes-results"))
    names = [b"M\xfcller", b"M\\xfcller", b"a\nb\rc\td\\ e", b"=1+2", b"-rf", b"flat\xfc.c"]
    for name in names:
        path = os.path.join(place, name)
        if not name.endswith(b".c"):
            os.makedirs(path)
            path = os.path.join(path, b"bvh_median.c")
        with open(path, "w", encoding="utf-8") as file:
            file.write(unit("") if not SOLVED else REFERENCE)
    status, said, rows = grade_class(os.fsdecode(place), os.fsdecode(out))
    check(status == 0 and len(rows) == 1 + len(names) and "M\\xfcller" in rows and "'=1+2" in rows,
          "a folder's name can be any bytes; class.csv tells them apart, and holds no formulas", said)
    check(all(row[1] == ("100" if SOLVED else "0") for name, row in rows.items() if name != "name"),
          "right code gets all points, whatever its folder is called", rows)
    status, said = graded("--impl", os.fsdecode(os.path.join(place, names[0])), "--own", "--test", EMPTY)
    check(status == 0, "so does a student's own check", said)


def opening(path):
    return unit(f'FILE *file = fopen("{path}", "w");\n    if (file)\n        fclose(file);',
                by_address("fopen", "fclose"))


def what_changes_without_a_sandbox_is_told(folder):
    """Not who did it: it may have been the instructor."""
    place, out = os.path.join(folder, "changing"), os.path.join(folder, "changed")
    planted = os.path.abspath(os.path.join("tests", "planted.o"))
    put(opening(planted), place, "ann", "bvh_median.c")
    put(unit(""), place, "bob", "bvh_median.c")
    with mock.patch.dict(os.environ, RAYKIT_SANDBOX="container"):
        status, said, rows = grade_class(place, out)
        remarks = [rows[name][6] for name in ("ann", "bob")]
        check(status == 1 and all(planted in remark and "may be wrong" in remark for remark in remarks)
              and "is not sound" in rows["bob"][5],
              "a change to the kit is told from then on, and the class goes on",
              rows)
        os.unlink(planted)
        status, said = graded("--impl", os.path.join(place, "ann"))
        check(status == 2 and planted in said, "a single verdict is then not believed", said)
        os.unlink(planted)
    put(opening(f"{place}/bob/bvh_median.c"), place, "ann", "bvh_median.c")
    with mock.patch.dict(os.environ, RAYKIT_SANDBOX="container"):
        status, said, rows = grade_class(place, out)
    check(status == 1 and "bob/bvh_median.c changed" in rows["bob"][6],
          "so is a change to another's submission", rows)


def a_copied_build_is_told(folder):
    put(read("impl", "toolchain").replace("source=", f"source={folder}/"), folder, "moved", "impl",
        "toolchain")
    status, said = graded("--impl", folder, "--build", os.path.join(folder, "moved"))
    check(status == 2 and "but this one stands in" in said and "run ./bootstrap" in said,
          "a build that was copied elsewhere does not grade with the old place", said)


def a_used_unit_is_the_kits(toolchain, folder):
    """Only in a pack that hands it out there is none but the student's."""
    features = read_features(SOURCE)
    using, place = features["sah_binning"], os.path.join(folder, "using")
    put(read(using.reference), place, "sah_binning.c")
    put("not yet C\n", place, "bvh_median.c")
    first = read_points(using)[0].name

    def graded_with(needs, uses, handed_out):
        using.needs, using.uses = needs, uses
        in_pack = copy.copy(toolchain)
        in_pack.handed_out = handed_out
        [suite] = grade.prepare_suites(features, [using], place, True, first)
        grade._grade_here(in_pack, features, [suite], place, decoys=0)
        return suite

    for needs, uses in ((["bvh_median"], []), ([], ["bvh_median"])):
        suite = graded_with(needs, uses, ["bvh_median"])
        check("does not compile" in suite.problem, "what is handed out is the student's own", suite.problem)
        suite = graded_with(needs, uses, [])
        check(suite.passed() and not suite.beside, "what is not is the kit's, and nothing is said of it",
              [suite.problem, suite.beside, *(verdict.reason for verdict in suite.verdicts.values())])


def a_needed_starter_costs_nothing(toolchain, folder):
    """A claim without points that a needed starter breaks is not the fault of the unit that calls it."""
    features = read_features(SOURCE)

    def graded_in_pack(stem, unit, needed, text):
        place = tempfile.mkdtemp(dir=folder)
        put(unit, place, f"{stem}.c")
        put(text, place, f"{needed}.c")
        [suite] = grade.prepare_suites(features, [features[stem]], place, True)
        in_pack = copy.copy(toolchain)
        in_pack.handed_out = [stem, needed]
        grade._grade_here(in_pack, features, [suite], place, decoys=0)
        return suite

    lens = features["depth_of_field"]
    suite = graded_in_pack(lens.stem, read(lens.reference), "glossy_reflection",
                           starter_of(features["glossy_reflection"].reference))
    disks = [test.name for test in suite.tests if test.section == "#lens-disk"]
    check(suite.excused == set(disks) and min(suite.scores().values()) == 0,
          "what a needed starter breaks costs nothing", [suite.problem, suite.scores()])
    report = results.text([suite], "mine")
    check("costs 0" in report and "less" not in report, "and the report says so", report)
    tree, unit = features["sah_binning"], read(features["sah_binning"].reference)
    suite = graded_in_pack(tree.stem, unit.replace("        rk_bvh_free(bvh);\n", "", 1), "bvh_median",
                           read(features["bvh_median"].reference) + "\n/* Mine. */\n")
    check(suite.scores()["where_memory_runs_out_nothing_is_kept"] == -DEDUCTION and not suite.excused,
          "what one's own unit breaks does, also beside another's", [suite.problem, suite.scores()])


def main():
    sandbox.prepare()
    toolchain = build.Toolchain(".")
    folder = tempfile.mkdtemp(prefix="raykit-test-grade-")
    try:
        right, starter = units_are_judged(toolchain, folder)
        graded = [suite for suite in (right, starter) if suite]
        reports_can_be_read(graded)
        what_code_says_cannot_act(starter)
        what_code_prints_is_its_own_word(starter)
        a_table_keeps_names_apart(folder)
        deep_folders_are_told(folder)
        headers_of_ones_own_are_told(os.path.join(folder, "headers"))
        a_woven_page_is_read_where_there_is_one(os.path.join(folder, "kit"))
        a_report_is_written_whole(graded, folder)
        a_workbook_is_the_students(folder)
        what_cannot_be_used_is_refused(folder)
        names_are_no_commands(folder)
        what_is_not_handed_in_earns_nothing(os.path.join(folder, "odd"))
        statuses_tell_what_was_graded(folder)
        two_gradings_at_once(folder)
        clang_warns_of_no_folder()
        what_has_no_value_is_filled(toolchain, folder)
        what_held_is_watched(toolchain, folder)
        a_driver_is_linked(folder)
        a_single_file_has_places(folder)
        what_does_not_build_is_brief(folder)
        a_students_report_names_no_folder_of_the_grader(folder)
        who_fills_memory_slowly_is_told(toolchain, folder)
        hanging_does_not_last(toolchain, folder)
        who_hangs_loses_nothing_twice(folder)
        who_is_slow_in_all_tests_holds_nobody_up(folder)
        a_moved_folder_is_told(folder)
        the_editors_files_name_what_there_is(folder)
        who_ends_the_grader_is_named(folder)
        a_class_is_graded(folder)
        a_class_is_graded_again(folder)
        what_a_course_system_delivers(folder)
        what_cannot_be_read_is_not_graded(folder)
        what_vanishes_is_not_graded(folder)
        what_cannot_be_written_is_advised_on(folder)
        spans_are_told_as_such(folder)
        one_file_is_no_two_assignments(folder)
        names_are_any_bytes(folder)
        what_changes_without_a_sandbox_is_told(folder)
        a_copied_build_is_told(folder)
        a_used_unit_is_the_kits(toolchain, folder)
        a_needed_starter_costs_nothing(toolchain, folder)
        an_interrupt_ends_everything(folder)
        more_interrupts_leave_no_folder(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
