#!/usr/bin/env python3
"""Grades a class: each folder or C file in SUBMISSIONS, one after the other. Writes a report for each
and class.csv, which is rewritten after each, so that an interruption loses no results.

A submission that cannot be graded gets a remark and no points; so does one that adds files to the kit,
which are removed again. One that changes the kit, another's submission or the results stops the
grading, because no later verdict would be reliable.
"""

import csv
import io
import os
import sys

from grading import build
from grading import integrity
from grading import results
from grading.assignments import Parser, ToolError, cannot_write, choose, choose_format, read_features, read_points
from grade import grade_submission, stop_on_signals

_ENDINGS = {"text": ".txt", "table": ".txt", "tap": ".tap", "junit": ".xml", "gradescope": ".json"}


def submissions_in(folder):
    """Returns a dictionary from name to path: all entries but hidden ones."""
    if not folder or not os.path.isdir(folder):
        raise ToolError(f"SUBMISSIONS: there is no folder {folder}" if folder else
                        "say where the submissions are: make grade-class SUBMISSIONS=folder OUT=results")
    found = {}
    for entry in sorted(os.listdir(folder)):
        if not entry.startswith("."):
            stem = entry.removesuffix(".c")
            name = entry if stem != entry and os.path.lexists(os.path.join(folder, stem)) else stem
            found[name] = os.path.join(folder, entry)
    if not found:
        raise ToolError(f"SUBMISSIONS: the folder {folder} is empty")
    return found


def _check_is_a_class(folder, found, features):
    """One student's folder would be graded as students called bloom and so on."""
    work = {name: path for name, path in found.items() if path.endswith(".c") or os.path.isdir(path)}
    if work and all(name in features and os.path.isfile(path) for name, path in work.items()):
        raise ToolError(f"SUBMISSIONS: the folder {folder} holds one student's units ({', '.join(work)}); give the "
                        f"folder that it is in, or grade it by make grade IMPL={folder}")


def _remarks(suites):
    """Remarks for the instructor beside the points."""
    told = next((suite for suite in suites if not suite.passed()), None)  # stands in a column of its own
    remarks = []
    for suite in suites:
        remarks += [f"{suite.feature.stem}: {suite.problem}"] if suite.problem and suite is not told else []
        hung = sum(verdict.timed_out for verdict in suite.verdicts.values())
        remarks += [f"{suite.feature.stem}: {hung} claims timed out"] if hung else []
        if suite.unit.is_reference:
            remarks.append(f"{suite.feature.stem}: this is the reference")
    return "; ".join(remark.replace("\n", " ") for remark in remarks)


class Table:
    """class.csv, a row for each submission."""

    def __init__(self, path, stems):
        self.path = path
        self.rows = [["name", *stems, "total", "first failing claim", "reason", "remarks"]]

    def add(self, name, points, first=("", ""), remarks=""):
        """Adds a row, with empty cells if there are no points, and rewrites the file."""
        cells = [*points, sum(points)] if points else [""] * (len(self.rows[0]) - 4)
        self.rows.append([results.name_of(name), *cells, *first, remarks])
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(self.rows)
        results.write_whole(self.path, text.getvalue())


def grade_class(build_folder, stems, submissions, out, format_name):
    """Grades all; returns how many could not be graded."""
    toolchain = build.Toolchain(build_folder)
    features = choose(read_features(toolchain.source), stems)
    found = submissions_in(submissions)
    _check_is_a_class(submissions, found, read_features(toolchain.source))
    if not out:
        raise ToolError("say where the results go: OUT=results, a folder")
    if os.path.join(os.path.realpath(out), "").startswith(os.path.join(os.path.realpath(submissions), "")):
        raise ToolError(f"OUT: {out} lies among the submissions; choose another place")
    integrity.check_restored(toolchain)
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise cannot_write(out, error) from error
    most = sum(test.points for feature in features for test in read_points(feature))
    table = Table(os.path.join(out, "class.csv"), [feature.stem for feature in features])
    ungraded = 0
    for number, (name, path) in enumerate(found.items(), 1):
        said = f"{number:>{len(str(len(found)))}} of {len(found)}  {results.name_of(name):<24}"
        try:
            if os.path.isfile(path) and not path.endswith(".c"):
                raise ToolError("neither a folder nor a C file")
            suites = grade_submission(build_folder, [feature.stem for feature in features], path, places=(submissions, out))
            results.write_whole(os.path.join(out, name + _ENDINGS[format_name]),
                                results.FORMATS[format_name](suites, name))
            table.add(name, [suite.points() for suite in suites], results.first_failed(suites), _remarks(suites))
            print(f"{said}{results.total(suites):>12} points", flush=True)
        except integrity.KitChanged:
            table.add(name, [], remarks="changed the kit, a submission or the results; the class stopped here")
            raise
        except Exception as error:  # whatever one submission brings about, the others are graded
            ungraded += 1
            table.add(name, [], remarks=f"not graded: {error}".replace("\n", " "))
            print(f"{said}   not graded: {error}", flush=True)
    print(f"grade-class: {len(found) - ungraded} of {len(found)} graded, of {most} points each; wrote {table.path}")
    return ungraded


def main():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog="Exit status: 0 all were graded; 1 some could not be; 2 it could not begin, or had to stop.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--submissions", required=True, metavar="DIR", help="a folder or C file for each student")
    parser.add_argument("--out", required=True, metavar="DIR", help="where the results go")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    parser.add_argument("--format", metavar="FORMAT", default="gradescope",
                        help=f"of the reports: {', '.join(sorted(_ENDINGS))}")
    arguments = parser.parse_args()
    stop_on_signals()
    try:
        choose_format(arguments.format, _ENDINGS)
        ungraded = grade_class(arguments.build, arguments.stems, arguments.submissions, arguments.out, arguments.format)
    except ToolError as error:
        print(f"grade-class: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"grade-class: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("grade-class: stopped; finished reports are in the results", file=sys.stderr)
        return 130
    return 1 if ungraded else 0


if __name__ == "__main__":
    sys.exit(main())
