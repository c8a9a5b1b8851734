#!/usr/bin/env python3
"""Measures what it costs to judge units apart from their suites: `make bench-grade`.

The kit's own units are graded apart, and in one process with their suites, by turns. Prints a line for each
feature: median processor seconds of both, and their ratio; then the sums. ROUNDS=1 is a quick look.
"""

import argparse
import os
import resource
import statistics
import sys

from grading import bubblewrap
from grading import build
from grading import isolate
from grading import judged
from grading import sandbox
from grading.assignments import ToolError, choose, read_features, run_command
import grade


def _processor_seconds():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _seconds(features, feature, folder, apart):
    """Returns what grading the kit's unit takes. Raises ToolError if it does not pass."""
    toolchain = build.Toolchain(folder)
    toolchain.sandbox, _ = bubblewrap.find(toolchain)
    toolchain.judges = apart
    impl = os.path.dirname(feature.reference)
    suites = grade.prepare_suites(features, [feature], impl, False, None)
    began = _processor_seconds()
    suites[0].take(isolate.call(grade._grade_here, toolchain, features, suites, impl)[0])
    seconds = _processor_seconds() - began
    if not suites[0].passed():
        raise ToolError(f"{feature.stem}: the kit's unit does not pass, so its time tells nothing; run "
                        f"make check-{feature.stem}")
    return seconds


def _line(name, seconds):
    return f"{name:20} {seconds[0]:8.2f} {seconds[1]:14.2f} {seconds[0] / seconds[1]:7.2f}"


def _measure(folder, stems, rounds):
    if rounds < 1:
        raise ToolError(f"ROUNDS={rounds}: choose 1 or more")
    sandbox.prepare()
    toolchain = build.Toolchain(folder)
    features = read_features(toolchain.source)
    chosen = choose(features, stems)
    missing = [feature.stem for feature in chosen if not judged.is_possible(toolchain, feature.stem)]
    if missing:
        raise ToolError(f"{missing[0]} has no judge in this build; run make bench-grade, which makes it")
    print(f"{'feature':20} {'apart, s':>8} {'one process, s':>14} {'ratio':>7}", flush=True)
    sums = [0, 0]
    for feature in chosen:
        times = [[_seconds(features, feature, folder, apart) for apart in (True, False)]
                 for _ in range(rounds)]
        medians = [statistics.median(column) for column in zip(*times)]
        print(_line(feature.stem, medians), flush=True)
        sums = [total + median for total, median in zip(sums, medians)]
    print(_line("all", sums))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="times each (default: 5)")
    arguments = parser.parse_args()
    grade.stop_on_signals()
    return run_command("bench-grade", lambda: _measure(arguments.build, arguments.stems, arguments.rounds), 2)


if __name__ == "__main__":
    sys.exit(main())
