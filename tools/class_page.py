#!/usr/bin/env python3
"""Writes RESULTS/class.html, what a class has learned, from the verdicts that grading has left in RESULTS:
what to teach on Monday, where those who have begun are stuck, and whom to talk to."""

import json
import os
import sys

from grading import class_page, results
from grading.assignments import Parser, ToolError, choose, read_features, read_points, run_command
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


def write_page(source, build, stems, folder):
    """Writes the page, and keeps this run's points for the next."""
    if not os.path.isdir(os.path.join(folder, "verdicts")):
        raise ToolError(f"RESULTS: there is no folder {folder}/verdicts; make grade-class writes it"
                        if folder else "say where the results are: make class-page RESULTS=results")
    assignments, unread = [], []
    for feature in choose(read_features(source), stems):
        works, damaged = read_works(os.path.join(folder, "verdicts", feature.stem))
        unread += damaged
        if works:
            assignments.append(class_page.Assignment(feature, read_points(feature), works))
    if not assignments:
        raise ToolError(f"RESULTS: no verdict in {folder} can be read")
    kept = os.path.join(folder, "class_page.json")
    last = _load(kept, _is_history, {})
    histories = {one.feature.stem: class_page.history(one, last.get(one.feature.stem, {}))
                 for one in assignments}
    path = os.path.join(folder, "class.html")
    results.write_whole(path, class_page.page(assignments, histories, unread,
                                              Pictures(source, build).of))
    results.write_whole(kept, json.dumps({**last, **histories}, indent=1) + "\n")
    works = sum(len(assignment.works) for assignment in assignments)
    print(results.printable(f"class-page: {works} verdicts: file://{os.path.abspath(path)}"))


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--results", required=True, metavar="DIR", help="where grading wrote its results")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")
    return run_command("class-page", lambda: write_page(arguments.source, arguments.build, arguments.stems,
                                                        arguments.results), 2)


if __name__ == "__main__":
    sys.exit(main())
