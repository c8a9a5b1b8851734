"""What is measured: cases, which are scenes with a feature, and methods, from two tables in tests/bench.

cases.tsv has a row for each case: the options of its pictures; two ways to make its reference; the goal, how
many times less time than the classic method to an error of 1 %; and the slope of its error, where these are
set. methods.tsv has its methods, the first of which is the classic one. {n} stands for the number of samples;
a method with {kind} in its options is one for each kind of sampler. A method that chooses the number of
samples by itself has {error}, 1 / (16 n), the error that it is asked for; its number of samples is then that
of camera rays per pixel. Options are the drivers' own: see any driver's --help."""

import os

from grading.assignments import ToolError, read_table


PARTS = ("frames", "growth", "startup", "profile")  # names beside those of cases, which the drivers measure


class Settings:
    """How much is measured. `dearest` is the processor time in seconds that one picture may take; `reference`
    is the samples of a reference's picture, `pictures` the pictures of each half; `runs` are those of
    what has no seeds."""

    def __init__(self, side, most, seeds, dearest, reference, pictures, runs):
        self.side, self.most, self.seeds, self.dearest, self.runs = side, most, seeds, dearest, runs
        self.reference, self.pictures = reference, pictures

    def counts(self):
        """The numbers of samples: powers of 2."""
        return [2 ** k for k in range(self.most.bit_length())]


FULL = Settings(side=48, most=4096, seeds=16, dearest=1.0, reference=1024, pictures=8, runs=7)
QUICK = Settings(side=24, most=64, seeds=16, dearest=0.02, reference=256, pictures=4, runs=1)

# Seeds of the references, beyond those of measured pictures: picture k of seed s has the seed s * SEED_STEP +
# k.
SEED_STEP = 10000
FIRST_SEED, SECOND_SEED = 2000 * SEED_STEP, 3000 * SEED_STEP

# A method that is asked for a larger error stops after its first few samples.
LARGEST_ERROR = 1 / 16


class Case:
    def __init__(self, row, settings):
        self.name, self.title = row["case"], row["title"]
        self.goal = float(row["goal"]) if row["goal"] else None
        self.slope = float(row["slope"]) if row["slope"] else None
        self.options = f"{row['options']} --width {settings.side} --height {settings.side}"
        self.reference = " | ".join(
            f"--pictures {settings.pictures} {row[half].format(n=settings.reference)} --seed {seed}"
            for half, seed in (("first", FIRST_SEED), ("second", SECOND_SEED)))
        self.methods = []


class Method:
    def __init__(self, case, name, options):
        self.case, self.name, self._options = case, name, options
        self.counts_samples = "{error}" not in options

    def options(self, samples, seed):
        """Those of one picture."""
        return f"{self._options.format(n=samples, error=LARGEST_ERROR / samples)} --seed {seed * SEED_STEP}"


def _rows(path, columns):
    return [dict(zip(columns, row)) for row in read_table(path, columns)]


def read_cases(folder, settings, kinds, names=()):
    """The cases with these names, or all, with their methods."""
    cases = {}
    for row in _rows(os.path.join(folder, "cases.tsv"),
                     ["case", "title", "options", "first", "second", "goal", "slope"]):
        cases[row["case"]] = Case(row, settings)
    methods = os.path.join(folder, "methods.tsv")
    for row in _rows(methods, ["case", "method", "options"]):
        if row["case"] not in cases:
            raise ToolError(f"{methods}: there is no case {row['case']} in cases.tsv")
        case = cases[row["case"]]
        for kind in kinds if "{kind}" in row["options"] else [""]:
            case.methods.append(Method(case, row["method"].replace("{kind}", kind),
                                       row["options"].replace("{kind}", kind)))
    for name in names:
        if name not in cases:
            raise ToolError(f"CASES: there is no case {name}; choose from {' '.join([*cases, *PARTS])}")
    return [case for case in cases.values() if not names or case.name in names]
