#!/usr/bin/env python3
"""The known mistakes of all features (tests/mutants), judged apart from their suites as by make grade,
and beside them without a sandbox, as by make check-STEM: the same claims hold. A unit's process sees in
every claim what goes beyond an array or writes to a constant one; beside their suites, some claims see
it. Where these fail, others may fail for the same reason. Of each mistake, the claims that it has to
fail are run, and some others. What differs is printed, reasons too, such as numbers in memory that was
not set. Speaks TAP, for make check-same-verdicts, which takes an hour. ASSIGNMENTS names some features,
EVERY=10 takes each tenth mistake.
"""

import os
import random
import re
import sys
import tempfile

from test_judge import APART, FEATURES, SOURCE, Grader, grade, text_of
from grading import sandbox
from grading.assignments import ToolError, choose
from grading.mutants import mutate, read_mutants
from tap import check, finish, start

OTHERS = 3  # claims that the mistake need not fail
MISUSE = "goes beyond the end", "caller's data, which is constant"


def _differences(stem, mutant, grader):
    unit = mutate(mutant, text_of(stem), stem + ".c")
    others = [test.name for test in grade.read_points(FEATURES[stem]) if test.name not in mutant.fails]
    names = [*mutant.fails, *random.Random(mutant.name).sample(others, min(OTHERS, len(others)))]
    apart, together = (grader.verdicts(stem, unit, way, names, enclosed=way)[0] for way in (True, False))
    differ = [name for name in names if apart[name] != together[name]]
    for name in differ:
        print(f"# {mutant.name}: {name}: apart {apart[name]}, together {together[name]}", flush=True)
    is_told = not all(passed for passed, _ in together.values())
    return [f"{mutant.name}: {name}" for name in differ if apart[name][0] != together[name][0]
            and not (is_told and together[name][0] and any(text in apart[name][1] for text in MISUSE))]


def main():
    text = os.environ.get("RAYKIT_EVERY") or "1"
    if not re.fullmatch(r"[1-9][0-9]{0,5}", text):
        sys.exit(f"EVERY={text}: give a whole number from 1 on")
    every, stems = int(text), os.environ.get("RAYKIT_STEMS", "").split()
    try:
        choose(FEATURES, stems)
    except ToolError as error:
        sys.exit(str(error))
    sandbox.prepare()
    with tempfile.TemporaryDirectory(prefix="raykit-same-") as folder:
        for stem in stems or APART:
            path = os.path.join(SOURCE, "tests", "mutants", stem + ".mutants")
            mutants = read_mutants(path, os.path.relpath(path, SOURCE))[::every]
            differ = [line for mutant in mutants for line in _differences(stem, mutant, Grader(folder))]
            check(mutants and not differ, f"{stem}: {len(mutants)} mistakes have the same verdicts apart",
                  differ)
    sandbox.end_strays()
    return finish()


if __name__ == "__main__":
    start(main)
