#!/usr/bin/env python3
"""A course from end to end: a pack for students is made, built, failed and solved, and a class of
submissions is graded. Speaks TAP, for make check-handout; runs in a build folder."""

import html
import json
import os
import re
import shutil
import sys
import tempfile
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import handout  # noqa: E402
from grading import leak_check  # noqa: E402
from grading.assignments import ToolError, read_features, read_points  # noqa: E402
from grading.build import Toolchain  # noqa: E402
from grading.mutants import mutate, read_mutants  # noqa: E402
from grading.starters import solution_lines, starter_of  # noqa: E402
from tap import check, finish, run  # noqa: E402

STEM = "bvh_median"
FEATURES = read_features(SOURCE)
FEATURE = FEATURES[STEM]
STARTER = starter_of(FEATURE.reference)
TESTS = read_points(FEATURE)
TOTAL = sum(test.points for test in TESTS)
SECRET = max(sorted(solution_lines(FEATURE.reference)), key=len)
COMMON = "for (uint32_t i = 0; i < count; i++)"


def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


def write(text, *path):
    os.makedirs(os.path.dirname(os.path.join(*path)), exist_ok=True)
    with open(os.path.join(*path), "w", encoding="utf-8") as file:
        file.write(text)


# --- The instructor packs -------------------------------------------------------------------------


def mistakes_are_refused(folder):
    taken = os.path.join(folder, "taken.tar.gz")
    write("mine", taken)
    cases = {
        "no assignment is refused, and all are listed": ([], {}, STEM),
        "an unknown assignment is refused": (["bvh_medina"], {}, "bvh_medina"),
        "a place that is taken is refused": ([STEM], {"out": taken}, "exists"),
        "an archive of another kind is refused": ([STEM], {"out": os.path.join(folder, "pack.zip")}, ".tar.gz"),
        "a place in a folder that is not there is refused": ([STEM], {"folder": os.path.join(folder, "no", "pack")}, "no folder"),
    }
    for name, (stems, place, part) in cases.items():
        try:
            handout.make_handout(SOURCE, stems, book=False, **place)
            check(False, name)
        except ToolError as error:
            check(part in str(error) and "\n" not in str(error), name, error)
    check(os.listdir(folder) == ["taken.tar.gz"] and read(taken) == "mine", "what is refused leaves nothing behind",
          os.listdir(folder))


def the_pack_holds_no_solution(pack):
    check(read(pack, "workbook", STEM + ".c") == STARTER, "the workbook holds the starter")
    everything = b"".join(open(os.path.join(where, name), "rb").read()
                          for where, _, names in os.walk(pack) for name in names)
    check(SECRET.encode() not in everything, "no file holds a line of the solution")
    check(f"{STEM}.mutants" not in os.listdir(os.path.join(pack, "tests", "mutants")),
          "mutants, which hold solutions, are left out")
    check(f"## Hand in\n\n- `workbook/{STEM}.c`\n" in read(pack, "HANDOUT.md"), "HANDOUT.md names the file to hand in")


def texts_speak_of_the_pack(pack):
    task, chapter = read(pack, "assignments", FEATURE.folder, "handout.md"), read(pack, FEATURE.chapter)
    for name, text in (("handout", task), ("chapter", chapter), ("book's first page", read(pack, "docs", "book.md")),
                       ("HANDOUT.md", read(pack, "HANDOUT.md"))):
        check("=mine" not in text and "mine/" not in text and "<!--" not in text,
              f"the {name} speaks of the workbook, not of a folder to be made", text[:2000])
    check(f"make debug-{STEM} TEST=" in chapter, "the chapter's commands are those of the pack")
    check(f"workbook/{STEM}.c" in task and f"(file:workbook/{STEM}.c)" in chapter, "texts name the file to edit")
    try:
        handout.as_packed("one\nmake check IMPL=mine_too DIR=mine\n", "docs/some.md", [STEM])
        check(False, "a text that is true in the kit only is refused")
    except ToolError as error:
        check("docs/some.md:2" in str(error) and "DIR=mine" in str(error),
              "a text that is true in the kit only is refused, with file and line", error)


def handouts_share_sections(folder):
    texts = [handout.handout_of(SOURCE, feature) for feature in FEATURES.values()]
    check(all("## How to start" in text and "## Points and handing in" in text
              and "handout_common" not in text and "{" not in re.sub("`.*?`", "", text) for text in texts),
          "each handout has the sections that all share, filled in")
    write("# All\n\n## More\n", folder, "assignments", "handout_common.md")
    write("[Start](../handout_common.md#start)\n", folder, "assignments", FEATURE.folder, "handout.md")
    try:
        handout.handout_of(folder, FEATURE)
        check(False, "a section that is not there is refused")
    except ToolError as error:
        check(FEATURE.folder in str(error) and "\"start\"" in str(error) and "more" in str(error),
              "a section that is not there is refused, with those that are", error)


def smuggled_lines_are_found(pack):
    secrets, common = leak_check.secret_lines(SOURCE, [FEATURE])
    check(SECRET in secrets and SECRET not in common, "a line that only the solution has is looked for")
    check(COMMON in common, "a line that the kit's other code has, too, says nothing")
    solved = [" ".join(line.split()) for line in read(FEATURE.reference).split("\n")]
    check(leak_check._passages(solved, secrets), "a passage of the solution in the kit's own code is found")
    check(not leak_check._passages(solved[::40], secrets), "its lines one by one, by chance, are none")
    cases = {
        "in a text": ("README.md", "> and then " + SECRET + " it is done"),
        "in a mutant": ("tests/mutants/other.mutants", "- " + SECRET),
        "with other spaces": ("src/scene/bvh.c", "  " + SECRET.replace(" ", "\t ")),
        "coloured in a page": ("docs/handout/more.html", "<b>" + "</b><b>".join(map(html.escape, SECRET))),
        "among bytes that are no text": ("docs/pictures/leaf.dat", "\udcff\udc80 " + SECRET),
        "in the workbook": (f"workbook/{STEM}.c", SECRET),
        "in the workbook, though common elsewhere": (f"workbook/{STEM}.c", COMMON),
    }
    for name, (path, line) in cases.items():
        place = os.path.join(pack, path)
        before = read(place) if os.path.exists(place) else None
        os.makedirs(os.path.dirname(place), exist_ok=True)
        with open(place, "a", encoding="utf-8", errors="surrogateescape") as file:
            file.write("\n" + line + "\n")
        found = leak_check.find_secrets(SOURCE, pack, [FEATURE], secrets, common)
        check(len(found) == 1 and found[0].startswith(path + ":"), f"a solution line is found {name}", found)
        os.unlink(place)
        if before is not None:
            write(before, place)
    try:
        write(SECRET, pack, "leak.txt")
        leak_check.prove(SOURCE, pack, FEATURES, [FEATURE])
        check(False, "a pack with a leak is refused")
    except ToolError as error:
        check("leak.txt:1" in str(error), "a pack with a leak is refused, with file and line", error)
    os.unlink(os.path.join(pack, "leak.txt"))
    check(not leak_check.find_secrets(SOURCE, pack, [FEATURE], secrets, common), "without the leaks the pack is clean again")


def what_the_kit_has_in_common_is_told(pack):
    place, line = os.path.join(pack, "examples", "shared.c"), "    " + SECRET
    write("/* a line by itself */\n" + line + "\n", place)
    found = leak_check.lines_elsewhere(pack, [FEATURE], {SECRET, COMMON})
    os.unlink(place)
    check(found[0] == ("examples/shared.c", 2, SECRET, 1) and found[1][2] == COMMON and found[1][3] > 1,
          "a solution line in the kit's other code is told, with file and line, the rare ones first", found)
    for stem, _, name, beginning in leak_check.SAME_STEPS:
        steps = leak_check.steps_elsewhere(SOURCE, [FEATURES[stem]])
        check(any(step[0] == name and read(SOURCE, name).split("\n")[step[1] - 1].startswith(beginning) for step in steps),
              f"a step of {stem} in other words is found in {name}", steps)
    lens, glossy = FEATURES["depth_of_field"], FEATURES["glossy_reflection"]
    said = "\n".join(leak_check.prove(SOURCE, pack, FEATURES, [FEATURE]))
    check("src/accel/packet.c:" in said and "in other words" in said, "the packing says so", said)
    alike = ("depth_of_field", "a step", "src/features/glossy_reflection.c", "static rk_vec2 concentric(")
    with mock.patch.object(leak_check, "SAME_STEPS", [alike]):
        check(leak_check.steps_elsewhere(SOURCE, [lens]), "what another feature's solution tells is found")
        check(not leak_check.steps_elsewhere(SOURCE, [lens, glossy]), "two that are handed out together do not tell of each other")


# --- The student works ----------------------------------------------------------------------------


def the_pack_is_failed_and_solved(pack):
    make = os.environ.get("MAKE", "make")
    compiler = " ".join(Toolchain(".").compiler)
    status, said = run(pack, "./bootstrap", "--no-install", f"CC={compiler}")
    check(status == 0, "the pack configures without git", said)
    status, said = run(pack, make, "-s", "-j2", f"check-{STEM}")
    check(status != 0 and f"first: {TESTS[0].name}" in said, "the starter fails, and the check says where to begin", said)
    _, said = run(pack, make, "-s", "grade", "FORMAT=tap")
    scored = sum(test.points > 0 for test in TESTS)
    check(said.count("not ok ") == scored, "the starter fails every test that carries points, and no other", said)
    status, said = run(pack, make, "-s", "progress")
    check(status == 0 and f"0 of {TOTAL}" in said, "progress counts no points yet", said)
    status, said = run(pack, make, "-s", f"diff-{STEM}")
    check(status == 0 and "unchanged" in said, "the difference to the starter is none yet", said)
    for target in ("handout", "check-suites"):
        status, said = run(pack, make, "-s", target)
        check(status != 0 and "this is a handout" in said, f"make {target} says that this is a handout", said)
    status, said = run(pack, make, "-s", "-j2", "check-render")
    check(status != 0 and "not ok" not in said, "a suite that uses the student's code fails", said)
    status, said = run(pack, make, "-s", "-j2", "check", "check_PROGRAMS=tests/test_render", "TESTS=tests/test_render")
    told = next((line for line in said.splitlines() if line.startswith(f"red until {STEM} is solved:")), "")
    check(status != 0 and "test_render" in told and "test_vec3" not in told and f"make check-{STEM}" in told,
          "make check names the suites that wait for the student", said)
    shutil.copyfile(FEATURE.reference, os.path.join(pack, "workbook", STEM + ".c"))
    status, said = run(pack, make, "-s", "-j2", f"check-{STEM}")
    check(status == 0 and f"{TOTAL} of {TOTAL}" in said, "the solution passes with all points", said)
    for suite in ("render", "vec3"):
        status, said = run(pack, make, "-s", "-j2", f"check-{suite}")
        check(status == 0, f"the suite {suite} passes with the solution", said)
    status, said = run(pack, make, "-s", "-j2", "all")
    check(status == 0, "the drivers are built from the workbook", said)
    write("int broken = ;\n", pack, "workbook", STEM + ".c")
    status, said = run(pack, make, "-s", f"check-{STEM}")
    check(status != 0 and "does not compile" in said, "a file that does not compile is told as such", said)


# --- The instructor grades ------------------------------------------------------------------------


def mutant(name):
    """The reference with one of the known mistakes."""
    file = f"tests/mutants/{STEM}.mutants"
    known = {mutant.name: mutant for mutant in read_mutants(os.path.join(SOURCE, file), file)}
    return mutate(known[name], read(FEATURE.reference), FEATURE.reference)


def a_class_is_graded(folder):
    start = "uint32_t count = mesh->triangle_count;\n"
    heads = "#include <stdio.h>\n#include <unistd.h>\n"
    oks = "\\n".join(f"ok {number} - {test.name}" for number, test in enumerate(TESTS, 1))
    any_hit = "bool rk_bvh_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)\n{\n"
    reference = read(FEATURE.reference)
    submissions = {  # text, fewest and most points, part of what is said about some test
        "right": (reference, TOTAL, TOTAL, ""),
        "wrong": (mutant("floor_of_the_half"), 1, TOTAL - 1, "got"),
        "crashing": ("static volatile int *volatile nowhere;\n" + reference.replace(start, start + "    *nowhere = 1;\n"), 0, 0, "NULL"),
        "hanging, by O'Brien": (reference.replace(any_hit, any_hit + "    for (volatile int k = 0; k < 2; k = 0) { }\n"), 1, TOTAL - 1, "endless loop"),
        "cheating by what it prints": (heads + STARTER.replace(
            start, start + f'    printf("1..{len(TESTS)}\\n{oks}\\n");\n    fflush(stdout);\n    _Exit(0);\n'), 0, 0, "does not count"),
        "cheating before main": ("#include <stdlib.h>\n__attribute__((constructor)) static void early(void)\n{\n    exit(0);\n}\n"
                                 + STARTER, 0, 0, "constructor"),
        "cheating by the suite's own names": (
            STARTER + "\nint rk_suite_main(void);\nint rk_suite_main(void)\n{\n    return 0;\n}\n"
            "bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)\n{\n"
            "    (void)bvh, (void)mesh, (void)error;\n    return true;\n}\n", 0, 0, ""),
    }
    for name, (text, fewest, most, part) in submissions.items():
        place = os.path.join(folder, "submissions", name)
        write(text, place, STEM + ".c")
        out = place + ".json"
        os.environ["RAYKIT_TEST_SECONDS"] = "2" if "hanging" in name else "60"
        status, said = run(".", sys.executable, "-B", os.path.join(SOURCE, "tools", "grade.py"), STEM,
                           "--impl", place, "--format", "gradescope", "--out", out)
        report = json.loads(read(out)) if os.path.exists(out) else {"score": -1, "tests": []}
        outputs = [test["output"] for test in report["tests"]]
        check(fewest <= report["score"] <= most and status == 0
              and any(part in output for output in outputs), f"a submission that is {name} gets its verdict",
              f"{report['score']} points, status {status}\n{said}\n" + "\n".join(outputs))


def main():
    if "--list" in sys.argv:  # the driver asks for names of tests, which it can do without
        return 0
    folder = tempfile.mkdtemp(prefix="raykit-test-handout-")
    try:
        places = {name: os.path.join(folder, name) for name in ("refused", "shared", "packed", "class")}
        for place in places.values():
            os.mkdir(place)
        mistakes_are_refused(places["refused"])
        handouts_share_sections(places["shared"])
        pack = os.path.join(places["packed"], "pack")
        said = handout.make_handout(SOURCE, [STEM], folder=pack, book=False)
        check(os.listdir(places["packed"]) == ["pack"] and "none is where students write" in said[1],
              "the pack is there with its proof, and nothing beside it", said)
        the_pack_holds_no_solution(pack)
        texts_speak_of_the_pack(pack)
        smuggled_lines_are_found(pack)
        what_the_kit_has_in_common_is_told(pack)
        the_pack_is_failed_and_solved(pack)
        a_class_is_graded(places["class"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    sys.exit(main())
