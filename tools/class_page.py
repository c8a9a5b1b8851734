#!/usr/bin/env python3
"""Writes class.html, what a class has learned, from the verdicts that grading has left in RESULTS: what to
teach on Monday, where those who have begun are stuck, and whom to talk to.

RESULTS is a folder of make grade-class, or several, separated by spaces: of two verdicts on the same
assignment of a submission, the newer one counts, so they should be of one class. ROSTER is the collected.csv
of make collect, one for each assignment: with it, students have their names on the page, and those who handed
in nothing are counted and named. The page goes into the folder OUT, by default the first one of RESULTS; the
file class_page.json beside it keeps what the next page tells changes by.
"""

import argparse
import json
import os
import sys

from grading import class_page, results
from grading.assignments import Parser, ToolError, choose, read_features, read_points, run_command
from grading.class_roster import read_rosters
from wrong import read_wrong

_SHAPE = {"submission": str, "key": str, "graded": str, "points": (int, float), "maximum": (int, float),
          "problem": str, "not_graded": str, "is_starter": bool, "claims": list}
_CLAIM = {"name": str, "step": int, "passed": bool, "reason": str}
_ROW = {"run": list, "points": (int, float), "stuck": str, "times": int,
        "before": (int, float, type(None))}


def _fits(value, shape):
    return isinstance(value, dict) and all(isinstance(value.get(name), kind) for name, kind in shape.items())


def _load(path, is_right, otherwise=None):
    """Returns what a JSON file holds, or `otherwise` if it is damaged or something else."""
    try:
        with open(path, encoding="utf-8") as file:
            value = json.load(file)
    except (OSError, ValueError, RecursionError):
        return otherwise
    return value if is_right(value) else otherwise


def _is_verdict(value):
    return _fits(value, _SHAPE) and all(_fits(claim, _CLAIM) for claim in value["claims"])


def read_works(folder):
    """Returns a list of an assignment's works, and names of files that hold none."""
    works, unread = [], []
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if name.endswith(".json") and not name.startswith("."):
            verdict = _load(os.path.join(folder, name), _is_verdict)
            if verdict:
                works.append(class_page.Work(verdict))
            else:
                unread.append(results.name_of(name))
    return works, unread


def _newest(works):
    """Returns one work of each submission, the newest."""
    newest = {}
    for work in works:
        old = newest.get(work.name)
        if not old or class_page.moment_of(work.when) >= class_page.moment_of(old.when):
            newest[work.name] = work
    return list(newest.values())


def _is_history(value):
    return isinstance(value, dict) and all(
        isinstance(rows, dict) and all(_fits(row, _ROW) for row in rows.values()) for rows in value.values())


class Pictures:
    """Pictures of known mistakes, as `make book` has drawn them."""

    def __init__(self, source, build):
        self._source = source
        self._folder = os.path.join(build, "docs", "out", "figures")
        self._rows = {}

    def of(self, feature, claim):
        """Returns (mistake, caption, PNG's bytes or None) of one that fails the claim, best as its first."""
        if feature.stem not in self._rows:
            self._rows[feature.stem] = read_wrong(self._source, feature)
        rows = [row for row in self._rows[feature.stem] if claim in row.mutant.fails]
        if not rows:
            return None
        row = min(rows, key=lambda row: row.mutant.fails.index(claim))
        try:
            name = f"wrong_{feature.stem}_{row.mutant.name}.png"
            with open(os.path.join(self._folder, name), "rb") as file:
                return row.mutant.mistake, row.caption, file.read()
        except OSError:
            return row.mutant.mistake, row.caption, None


def _names_in(text):
    """Returns the names in a list of files or folders; one that is there may have spaces."""
    return [text] if os.path.exists(text) else text.split()


def _all_works(folders, stem):
    """Returns what read_works does, of several folders."""
    found = [read_works(os.path.join(folder, "verdicts", stem)) for folder in folders]
    return _newest([work for works, _ in found for work in works]), [name for _, names in found
                                                                     for name in names]


def write_page(source, build, stems, results_in, roster="", out=""):
    """Writes the page, and keeps this run's points for the next. `results_in` and `roster` may each name
    several."""
    folders = _names_in(results_in)
    if not folders:
        raise ToolError("say where the results are: make class-page RESULTS=results")
    for folder in folders:
        if not os.path.isdir(os.path.join(folder, "verdicts")):
            raise ToolError(f"RESULTS: there is no folder {folder}/verdicts; make grade-class writes it")
    out = out or folders[0]
    results.check_place(os.path.join(out, "class.html"))
    chosen, unread = [], []
    for feature in choose(read_features(source), stems):
        works, damaged = _all_works(folders, feature.stem)
        unread += damaged
        chosen += [(feature, works)] if works else []
    if not chosen:
        raise ToolError(f"RESULTS: no verdict in {' or '.join(folders)} can be read")
    rosters = read_rosters(_names_in(roster), [feature.stem for feature, _ in chosen])
    assignments = [class_page.Assignment(feature, read_points(feature), works, rosters.get(feature.stem))
                   for feature, works in chosen]
    kept = os.path.join(out, "class_page.json")
    last = _load(kept, _is_history, {})
    histories = {one.feature.stem: class_page.history(one, last.get(one.feature.stem, {}))
                 for one in assignments}
    path = os.path.join(out, "class.html")
    results.write_whole(path, class_page.page(assignments, histories, unread,
                                              Pictures(source, build).of))
    results.write_whole(kept, json.dumps({**last, **histories}, indent=1) + "\n")
    works = sum(len(assignment.works) for assignment in assignments)
    missing = sum(len(table.missing) for table in rosters.values())
    told = f", {missing} missing" if rosters else ""
    print(results.printable(f"class-page: {works} verdicts{told}: file://{os.path.abspath(path)}"))


def main():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--results", required=True, metavar="DIRS", help="where grading wrote its results")
    parser.add_argument("--roster", default="", metavar="FILES",
                        help="collected.csv, which make collect wrote")
    parser.add_argument("--out", default="", metavar="DIR", help="where the page goes")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")
    return run_command("class-page", lambda: write_page(arguments.source, arguments.build, arguments.stems,
                                                        arguments.results, arguments.roster,
                                                        arguments.out), 2)


if __name__ == "__main__":
    sys.exit(main())
