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
import shutil
import tempfile

from test_judge import APART, FEATURES, SOURCE, grade, text_of  # noqa: E402
from grading import build, bubblewrap, sandbox  # noqa: E402
from grading.mutants import mutate, read_mutants  # noqa: E402
from tap import check, finish, start  # noqa: E402

OTHERS = 3  # claims that the mistake need not fail
MISUSE = "goes beyond the end", "caller's data, which is constant"


def _verdicts(stem, unit, apart, names):
    """Returns whether it passed, and the reason, of each of these claims by its name."""
    toolchain = build.Toolchain(".")
    toolchain.sandbox = bubblewrap.find(toolchain)[0] if apart else None
    toolchain.judges = apart
    suites = grade.prepare_suites(FEATURES, [FEATURES[stem]], unit, False, None)
    suites[0].tests = [test for test in suites[0].tests if test.name in names]
    suites[0].take(grade._grade_here(toolchain, FEATURES, suites, unit, 0)[0])
    return {name: (suites[0].verdicts[name].passed, suites[0].verdicts[name].reason) for name in names}


def _differences(stem, mutant, folder):
    unit = os.path.join(folder, mutant.name, stem + ".c")
    os.mkdir(os.path.dirname(unit))
    with open(unit, "w", encoding="utf-8") as file:
        file.write(mutate(mutant, text_of(stem), stem + ".c"))
    others = [test.name for test in grade.read_points(FEATURES[stem]) if test.name not in mutant.fails]
    names = [*mutant.fails, *random.Random(mutant.name).sample(others, min(OTHERS, len(others)))]
    apart, together = (_verdicts(stem, unit, where, names) for where in (True, False))
    differ = [name for name in names if apart[name] != together[name]]
    for name in differ:
        print(f"# {mutant.name}: {name}: apart {apart[name]}, together {together[name]}", flush=True)
    is_told = not all(passed for passed, _ in together.values())
    return [f"{mutant.name}: {name}" for name in differ if apart[name][0] != together[name][0]
            and not (is_told and together[name][0] and any(text in apart[name][1] for text in MISUSE))]


def main():
    stems = os.environ.get("RAYKIT_STEMS", "").split() or APART
    every = int(os.environ.get("RAYKIT_EVERY") or 1)
    sandbox.prepare()
    folder = tempfile.mkdtemp(prefix="raykit-same-")
    try:
        for stem in stems:
            os.mkdir(os.path.join(folder, stem))
            path = os.path.join(SOURCE, "tests", "mutants", stem + ".mutants")
            mutants = read_mutants(path, os.path.relpath(path, SOURCE))[::every]
            differ = [line for mutant in mutants
                      for line in _differences(stem, mutant, os.path.join(folder, stem))]
            check(mutants and not differ, f"{stem}: {len(mutants)} mistakes have the same verdicts apart",
                  differ)
    finally:
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
