#!/usr/bin/env python3
"""Grades a class: each folder or C file in SUBMISSIONS, one after the other. Writes a report for each
and class.csv, which is rewritten after each, so that an interruption loses no results.

A submission that cannot be graded gets 0 points and the reason. Rows of class.csv and reports of
submissions that are not graded this time stay as they are; each row says when it was made.
"""

import collections
import csv
import errno
import io
import os
import re
import sys
import time

from grading import bubblewrap
from grading import build
from grading import integrity
from grading import results
from grading import sandbox
from grading.assignments import (
    Parser, ToolError, Unit, cannot_write, choose, choose_format, is_archive, is_misnamed_c, read_features,
    read_points,
)
from grading.c_source import tokens_of
from grading.starters import is_handed_out
from grade import Suite, check_seed, grade_submission, stop_on_signals

_ENDINGS = {"text": ".txt", "table": ".txt", "tap": ".tap", "junit": ".xml", "gradescope": ".json"}
_SHOWN = 3  # claims that the class failed most often
# What systems, editors and version control leave behind.
_LEFT_BEHIND = re.compile(r"\.(_.*|DS_Store|localized|Spotlight-V100|Trash.*|fseventsd|directory|nfs.*"
                          r"|git(ignore|attributes|modules|keep|hub)?|svn|hg(ignore|tags)?"
                          r"|vscode|vs|idea|project|editorconfig|clang-format|clangd|cache"
                          r"|~lock\..*|.*\.sw[a-p]|part-.*)")


def submissions_in(folder):
    """Returns a dictionary from name to path, and the names of strays: a table of grades is nobody's work,
    nor is what is hidden."""
    if not folder or not os.path.isdir(folder):
        raise ToolError(f"SUBMISSIONS: there is no folder {folder}" if folder else
                        "say where the submissions are: make grade-class SUBMISSIONS=folder OUT=results")
    found, strays = {}, []
    for entry in sorted(os.listdir(folder)):
        path, stem = os.path.join(folder, entry), entry.removesuffix(".c")
        if entry.startswith("."):
            strays += [] if _LEFT_BEHIND.fullmatch(entry) else [entry]
            continue
        is_unpacked = is_archive(entry) and os.path.isdir(os.path.join(folder, _student(entry)))
        if is_unpacked or not (os.path.isdir(path) or os.path.islink(path) or entry.endswith(".c")
                               or is_archive(entry) or is_misnamed_c(entry)):
            strays.append(entry)
            continue
        found[entry if stem != entry and os.path.lexists(os.path.join(folder, stem)) else stem] = path
    if not found:
        raise ToolError(f"SUBMISSIONS: the folder {folder} holds neither folders nor C files")
    return found, strays


def _student(entry):
    """Returns the name of a file without the endings that submissions have."""
    return re.sub(r"(\.c|\.c\.txt|\.tar\.\w+|\.\w+)$", "", entry, flags=re.IGNORECASE)


def _namesakes(found):
    """Returns a dictionary from the names of submissions that may be one student's to the others' names."""
    students = {}
    for name, path in found.items():
        entry = os.path.basename(path)
        students.setdefault(entry if os.path.isdir(path) else _student(entry), []).append(name)
    return {name: [other for other in names if other != name] for names in students.values()
            for name in names}


def _check_is_a_class(folder, found, features):
    """One student's folder would be graded as students called bloom and so on."""
    work = {name: path for name, path in found.items() if path.endswith(".c") or os.path.isdir(path)}
    if work and all(name in features and os.path.isfile(path) for name, path in work.items()):
        raise ToolError(f"SUBMISSIONS: the folder {folder} holds one student's units ({', '.join(work)}); "
                        f"give the folder that it is in, or grade it by make grade IMPL={folder}")


def _is_reference_text(suite):
    """Whether the unit's code is the reference's, whatever its comments and layout."""
    reference, path = suite.feature.reference, suite.unit.path
    if not path or not os.path.exists(reference) or is_handed_out(reference):
        return False
    texts = []
    for name in (path, reference):
        with open(name, encoding="utf-8", errors="replace") as file:
            texts.append([token.text for token in tokens_of(file.read(1 << 20))])
    return texts[0] == texts[1]


def _remarks(suites):
    """Remarks for the instructor beside the points."""
    told = next((suite for suite in suites if not suite.passed()), None)  # stands in a column of its own
    remarks = []
    for suite in suites:
        is_told = suite is told or (told and suite.problem == told.problem)
        remarks += [f"{suite.feature.stem}: {suite.problem}"] if suite.problem and not is_told else []
        remarks += suite.remarks
        hung = sum(verdict.timed_out for verdict in suite.verdicts.values())
        remarks += [f"{suite.feature.stem}: {hung} claims timed out"] if hung else []
        if suite.unit.is_reference:
            remarks.append(f"{suite.feature.stem}: this is the reference")
        elif _is_reference_text(suite):
            remarks.append(f"{suite.feature.stem}: the same text as the reference")
    return "; ".join(dict.fromkeys(remark.replace("\n", " ") for remark in remarks))


class Table:
    """class.csv, a row for each submission. Begins with the rows of earlier runs."""

    def __init__(self, path, stems):
        self.path, self._rows = path, {}
        self._heading = ["name", *stems, "total", "maximum", "first failing claim", "reason", "remarks",
                         "graded"]
        try:
            with open(path, encoding="utf-8", newline="") as file:
                rows = list(csv.reader(file))
        except FileNotFoundError:
            return
        except (OSError, ValueError, csv.Error) as error:
            raise ToolError(f"{path} cannot be read ({error}); choose another folder for OUT") from error
        if rows and rows[0] != self._heading:
            raise ToolError(f"{path} has other columns ({', '.join(rows[0])}); choose another folder for OUT")
        self._rows = {results.text_of_cell(row[0]): row for row in rows[1:] if row}

    def put(self, name, points, most, first, remarks):
        """Adds or replaces a row, and rewrites the file."""
        name = results.name_of(name)
        first, reason, remarks = map(results.csv_cell, (*first, remarks))
        self._rows[name] = [results.csv_cell(name), *points, sum(points), most, first, reason, remarks,
                            time.strftime("%Y-%m-%d %H:%M:%S %z")]
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([self._heading, *self._rows.values()])
        results.write_whole(self.path, text.getvalue())


def _check_submission(path, submissions):
    """Raises ToolError unless the path itself holds a student's work."""
    if os.path.realpath(path) != os.path.join(os.path.realpath(submissions), os.path.basename(path)):
        raise ToolError("it is a link; a submission is a folder or C file of its own")
    name = os.path.basename(path)
    if is_archive(name) and not os.path.isdir(path):
        raise ToolError(f"unpack {name} into a folder {_student(name)}")
    if is_misnamed_c(name) and not os.path.isdir(path):
        raise ToolError(f"rename {name} to {_student(name)}.c")


def _suites_of(toolchain, features, path, submissions):
    """Returns the graded suites of one submission, and whether they could be graded."""
    try:
        _check_submission(path, submissions)
        return grade_submission(toolchain, [feature.stem for feature in features], path), True
    except Exception as error:  # whatever one submission brings about, the others are graded
        if not os.path.lexists(path):
            error = f"{os.path.basename(path)} vanished while the class was graded"
        suites = [Suite(feature, Unit(feature, None, feature.stem + ".c", False), read_points(feature))
                  for feature in features]
        for suite in suites:
            suite.give_up(f"not graded: {error}")
        return suites, False


def _write_report(suites, name, out, format_name):
    """Writes a submission's report in place of those that earlier runs made, in any format."""
    for ending in set(_ENDINGS.values()):
        old = os.path.join(out, name + ending)
        if os.path.lexists(old):
            os.unlink(old)
    path = os.path.join(out, name + _ENDINGS[format_name])
    try:
        results.write_whole(path, results.FORMATS[format_name](suites, name))
    except ToolError as error:
        if getattr(error.__cause__, "errno", 0) != errno.ENAMETOOLONG:
            raise
        raise ToolError("rename the submission: the report's name would be too long") from error


def grade_class(build_folder, stems, submissions, out, format_name):
    """Grades all; returns how many could not be graded."""
    check_seed()
    toolchain = build.Toolchain(build_folder)
    features = choose(read_features(toolchain.source), stems)
    found, strays = submissions_in(submissions)
    _check_is_a_class(submissions, found, read_features(toolchain.source))
    if not out:
        raise ToolError("say where the results go: OUT=results, a folder")
    if os.path.join(os.path.realpath(out), "").startswith(os.path.join(os.path.realpath(submissions), "")):
        raise ToolError(f"OUT: {out} lies among the submissions; choose another place")
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise cannot_write(out, error) from error
    table = Table(os.path.join(out, "class.csv"), [feature.stem for feature in features])
    sandbox.prepare()
    toolchain.sandbox, toolchain.remark = bubblewrap.find(toolchain)
    if toolchain.remark:
        print(f"grade-class: {toolchain.remark}", flush=True)
    watch = None if toolchain.sandbox else integrity.Watch(toolchain, submissions, out)
    if strays:
        print("grade-class: no submissions, so ignored: " + ", ".join(map(results.name_of, strays)))
    ungraded, namesakes = 0, _namesakes(found)
    most = sum(test.points for feature in features for test in read_points(feature))
    failed, judged = collections.Counter(), collections.Counter()
    for number, (name, path) in enumerate(found.items(), 1):
        # Said before: who ends this process is then the last one named.
        print(f"{number:>{len(str(len(found)))}} of {len(found)}  {results.name_of(name):<24}", end="",
              flush=True)
        suites, was_graded = _suites_of(toolchain, features, path, submissions)
        doubts, twins = [], [results.name_of(path) for path in namesakes.get(name, [])]
        remarks = [f"another submission has the same name: {', '.join(twins)}"] if twins else []
        changed = watch and watch.changed()
        if changed:
            doubts.append(f"{changed} changed since grading began, so these points may be wrong")
        try:
            _write_report(suites, name, out, format_name)
        except (OSError, ToolError) as error:
            doubts.append(f"no report: {error}")
        table.put(name, [suite.points() for suite in suites], most, results.first_failed(suites),
                  "; ".join(filter(None, [*doubts, *remarks, _remarks(suites)])))
        if watch:
            watch.accept(out, [name + ending for ending in _ENDINGS.values()] + ["class.csv"])
        # What does not build says nothing of single claims.
        verdicts = {f"{suite.feature.stem}: {test.name}": suite.verdicts[test.name].passed
                    for suite in suites if not suite.problem for test in suite.tests}
        judged.update(verdicts.keys())
        failed.update(claim for claim, passed in verdicts.items() if not passed)
        ungraded += not was_graded or bool(doubts)
        said = f"{results.total(suites):>12} points" if was_graded else "   " + suites[0].problem
        print(results.printable("; ".join([said, *doubts])), flush=True)
    if failed:
        print("grade-class: failed most often: " + ", ".join(f"{claim} ({count} of {judged[claim]})"
                                                             for claim, count in failed.most_common(_SHOWN)))
    print(f"grade-class: {len(found) - ungraded} of {len(found)} graded, of {most} points each; "
          f"wrote {table.path}")
    return ungraded


def main():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog="Exit status: 0 all were graded, whatever their points; "
        "1 some could not be, or their points may be wrong; 2 it could not begin.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--submissions", required=True, metavar="DIR",
                        help="a folder or C file for each student")
    parser.add_argument("--out", required=True, metavar="DIR", help="where the results go")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    parser.add_argument("--format", metavar="FORMAT", default="gradescope",
                        help=f"of the reports: {', '.join(sorted(_ENDINGS))}")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    stop_on_signals()
    try:
        choose_format(arguments.format, _ENDINGS)
        ungraded = grade_class(arguments.build, arguments.stems, arguments.submissions, arguments.out,
                               arguments.format)
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
