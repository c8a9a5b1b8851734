#!/usr/bin/env python3
"""A new feature from nothing: in a copy of the kit its files are made, built and checked. Speaks TAP,
for make check-new-feature; runs in a build folder."""

import os
import shutil
import sys
import tempfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import handout  # noqa: E402
from grading.assignments import ToolError, read_features, read_points  # noqa: E402
from grading.build import Toolchain  # noqa: E402
from new_feature import make_feature  # noqa: E402
from tap import check, finish, read, run, start  # noqa: E402

MAKE = os.environ.get("MAKE", "make")


def files_of(folder):
    """Returns a dictionary from path to content."""
    found = {}
    for where, _, names in os.walk(folder):
        for path in (os.path.join(where, name) for name in names):
            with open(path, "rb") as file:
                found[path] = file.read()
    return found


def bad_names_are_refused(kit):
    before = files_of(kit)
    for name, part in {"": "NAME=fog", "1fog": "identifier", "Fog": "identifier", "../fog": "identifier",
                       "while": "means something in C", "bloom": "such a feature", "render": "rk_render_",
                       "format": "check-format", "motion": "rk_motion_"}.items():
        try:
            make_feature(kit, name)
            check(False, f"the name \"{name}\" is refused")
        except ToolError as error:
            check(part in str(error) and "\n" not in str(error), f"the name \"{name}\" is refused", error)
    check(files_of(kit) == before, "what is refused leaves nothing behind")


def half_a_feature_is_taken_back(kit):
    readme = os.path.join(kit, "README.md")
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    with open(readme, "w", encoding="utf-8") as file:
        file.write(text.replace("<!-- features end -->", ""))
    before = files_of(kit)
    try:
        make_feature(kit, "fog")
        check(False, "without README's table nothing is made")
    except ToolError as error:
        check("features end" in str(error) and files_of(kit) == before,
              "without README's table nothing is made", error)
    with open(readme, "w", encoding="utf-8") as file:
        file.write(text)


def fog_is_made(kit):
    before = files_of(kit)
    status, said = run(kit, MAKE, "-s", "new-feature", "NAME=fog")
    check(status == 0 and "next: make check-fog" in said, "a feature is made, and said what to do next", said)
    after = files_of(kit)
    edited = sorted(os.path.relpath(path, kit) for path in before
                    if before[path] != after[path] and not path.endswith(".log"))
    check(edited == ["README.md", "assignments/features.tsv", "src/render/plan.h"],
          "only the table, README and the options are edited", edited)
    left = [path for path in after if path not in before
            and (b"NN_fog" in after[path] or b"NUMBER" in after[path])]
    check(not left, "its name stands where the pattern's stood", left)
    fog = list(read_features(kit).values())[-1]
    check(fog.stem == "fog" and sum(test.points for test in read_points(fog)) == 100,
          "it has an assignment of 100 points")


def fog_builds_and_says_what_is_missing(kit):
    status, said = run(kit, MAKE, "-s", "-j2", "all")
    check(status == 0, "it builds without a warning", said)
    status, said = run(kit, MAKE, "-s", "-j2", "check-fog")
    check(status != 0 and "1 passed, 1 failed" in said and "tests/test_fog.c" in said and "Next:" in said,
          "its suite fails, and says what to do next", said)
    suites = ("fog_stage", "features", "render", "render_check", "driver")
    _, said = run(kit, MAKE, "-s", "-k", "-j2", *(f"check-{suite}" for suite in suites))
    for suite in suites:
        results = [os.path.join(kit, "tests", f"test_{suite}{end}.trs") for end in ("", ".sh")]
        check(any(os.path.exists(result) and ":recheck: no\n" in read(result) for result in results),
              f"the suite {suite} passes", said)
    driver = next(iter(feature.folder for feature in read_features(kit).values() if feature.stem == "fog"))
    status, said = run(kit, "sh", "-c", f"assignments/{driver}/fog --width 16 --height 16")
    check(status == 0 and os.path.exists(os.path.join(kit, "out", "figures", "fog_cornell.png")),
          "its driver draws", said)
    status, said = run(kit, MAKE, "-s", "handout", "ASSIGNMENTS=fog", "DIR=pack", "BOOK=no")
    check(status == 0 and os.path.exists(os.path.join(kit, "pack", "workbook", "fog.c")),
          "it can be handed out", said)


def main():
    folder = tempfile.mkdtemp(prefix="raykit-test-new-feature-")
    try:
        kit = os.path.join(folder, "kit")
        handout.copy_release(SOURCE, kit)
        check(os.access(os.path.join(kit, "configure"), os.X_OK), "the kit is copied", os.listdir(kit))
        bad_names_are_refused(kit)
        half_a_feature_is_taken_back(kit)
        toolchain = Toolchain(".")
        status, said = run(kit, "./configure", "--quiet", "--enable-werror",
                           f"CC={' '.join(toolchain.compiler)}")
        check(status == 0, "the copy configures", said)
        fog_is_made(kit)
        fog_builds_and_says_what_is_missing(kit)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
