#!/usr/bin/env python3
"""Puts verdict files of one or several folders of results into one class.csv: what several machines graded by
themselves is one class. Of two verdicts on the same assignment of a submission, the newer one counts."""

import glob
import os
import sys
import time

from grading import results
from grading import verdict_files
from grading.assignments import Parser, ToolError, choose, read_features, read_points, run_command
from grading.build import Toolchain
from grading.class_table import Table


def _time_of(found):
    return time.mktime(time.strptime(found["graded"], "%Y-%m-%d %H:%M:%S %z"))


def _verdicts(folders):
    """Returns a dictionary from names to dictionaries from assignments to what was found."""
    names = {}
    for folder in folders:
        for path in sorted(glob.glob(os.path.join(glob.escape(folder), "verdicts", "*", "*.json"))):
            found = verdict_files.read_file(path)
            if not found:
                raise ToolError(f"{path} is no verdict file; remove it, and grade that submission again")
            known = names.setdefault(found["submission"], {})
            before = known.get(found["assignment"])
            if not before or _time_of(found) >= _time_of(before):
                known[found["assignment"]] = found
    return names


def _missing(feature):
    """Returns what stands for an assignment that was not graded yet."""
    found = dict.fromkeys(("problem", "graded", "first", "reason"), "")
    return found | {"assignment": feature.stem, "not_graded": "no verdict yet", "passed": False, "notes": [],
                    "maximum": sum(test.points for test in read_points(feature))}


def _merge(arguments):
    names = _verdicts(arguments.folders)
    if not names:
        raise ToolError(f"RESULTS: there are no verdict files in {' or '.join(arguments.folders)}; "
                        "make grade-class and grade-one write them")
    graded = {stem for found in names.values() for stem in found}
    known = read_features(Toolchain(arguments.build).source)
    features = [feature for feature in choose(known, arguments.stems)
                if arguments.stems or feature.stem in graded]
    path = os.path.join(arguments.out, "class.csv")
    results.check_place(path)
    if os.path.exists(path):
        os.unlink(path)
    table = Table(path, [feature.stem for feature in features])
    for name, found in names.items():
        table.put_shown(name, [found.get(feature.stem) or _missing(feature) for feature in features])
    table.write()
    print(f"wrote {path}: {len(names)} submissions")


def main():
    parser = Parser(description=__doc__,
                    epilog="Exit status: 0 the table is written; 2 there is nothing to write.")
    add = parser.add_argument
    add("stems", nargs="*", metavar="STEM", help="features; default: those that were graded")
    add("--folders", nargs="+", required=True, metavar="DIR", help="with results")
    add("--out", required=True, metavar="DIR", help="where class.csv goes, in place of one that is there")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")
    return run_command("class-table", lambda: _merge(arguments), 2)


if __name__ == "__main__":
    sys.exit(main())
