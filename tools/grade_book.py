#!/usr/bin/env python3
"""Writes the points of a class for a grade book: Canvas's, Moodle's or Blackboard's, or a plain table.

RESULTS is the folder of make grade-class, ROSTER the collected.csv of make collect. TEMPLATE is what the
grade book exports; only the cells of the assignments are filled in there. FORMAT=canvas and blackboard write
the columns that say who, and those of the assignments, found by their names; COLUMN names one for the sum of
all. FORMAT=moodle fills the Grade column of the offline grading worksheet with the sum, or, without a
TEMPLATE, writes what Grades, Import, CSV file takes.

Points that nobody knows are left as the TEMPLATE has them, empty without one: they are not 0. So are those of
students who handed in nothing, unless MISSING=0. Points that the TEMPLATE has already become those of the
results, and are listed if these are others; KEEP=yes leaves them as they are. PENALTY=10 takes 10 percent of
an assignment's points for each day late; the rest is rounded to whole points, a half up. FORMAT=csv then has
three columns for each assignment: what was graded, the penalty, and what counts; the other forms have what
counts, and students read all three in their reports (make feedback). In FORMAT=csv, an apostrophe stands
before what a spreadsheet would take for a formula; the other forms have names as the TEMPLATE has them.
"""

import argparse
import os
import sys

from grading.assignments import (Parser, ToolError, choose, choose_format, read_features, read_points,
                                 run_command)
from grading.book_forms import FORMS, Book
from grading.book_points import Results, grades_of, is_late, penalty_of
from grading.results import check_place, printable, write_whole

_SHOWN = 40  # faults on the screen


def _part(stem):
    return lambda grade: grade.counts(stem)


def _check_out(out, *sources):
    if not out:
        raise ToolError("say where the grades go: OUT=file.csv")
    check_place(out)
    for source in sources:
        if source and os.path.exists(out) and os.path.exists(source) and os.path.samefile(out, source):
            raise ToolError(f"OUT: {out} is what the grades are made from; choose another name")


def grade_book(options):
    """Writes the file; returns how many things the instructor has to look at."""
    if not options.results:
        raise ToolError("say where the results are: RESULTS=results, the folder of make grade-class")
    if not options.roster:
        raise ToolError("say who is in the course: ROSTER=submissions/collected.csv, which make collect "
                        "wrote")
    choose_format(options.format, FORMS)
    percent, features = penalty_of(options.penalty), read_features(options.source)
    if options.column and options.format not in ("canvas", "blackboard"):
        raise ToolError(f"COLUMN: FORMAT={options.format} has no columns to choose from")
    if options.missing not in ("", "0"):
        raise ToolError(f"MISSING={options.missing}: only MISSING=0 says something, that who is missing "
                        "gets 0")
    choose(features, options.stems)
    results = Results(options.results, options.stems, features)
    _check_out(options.out, options.template, options.roster, results.path)
    grades, faults = grades_of(results, options.roster, percent, 0 if options.missing else None)
    wanted = [(stem, _part(stem)) for stem in results.stems]
    wanted += [("total", _part("total"))] if len(wanted) > 1 else []
    maxima = {stem: sum(test.points for test in read_points(features[stem])) for stem in results.stems}
    maxima["total"] = sum(maxima.values())
    book = Book(grades, wanted, maxima, features, options.template, options.column,
                options.keep, bool(percent))
    text, encoding = FORMS[options.format](book)
    write_whole(options.out, text, encoding)
    faults += book.faults
    missing = [grade for grade in grades if grade.note == "missing"]
    what = "have 0" if options.missing else "have no grade; MISSING=0 would give them 0"
    lines = [f"{len(missing)} of {len(grades)} students handed in nothing, and {what}"] if missing else []
    late = sum(is_late(grade.row) for grade in grades)
    lines += [f"{options.penalty} percent for each day were taken from {late} students"] if percent else []
    lines += book.remarks
    if book.changed:
        lines.append("KEEP=yes kept other points than the graded ones:" if options.keep else
                     "other points stood in the template, and were replaced; KEEP=yes would keep them:")
    for listed in (book.changed, faults):
        lines += listed[:_SHOWN]
        lines += [f"and {len(listed) - _SHOWN} more of these"] if len(listed) > _SHOWN else []
    graded = sum(any(points is not None for points in grade.points.values()) for grade in grades)
    lines.append(f"{graded} of {len(grades)} students have a grade; wrote {options.out}")
    for line in lines:
        print(f"grade-book: {printable(line)}")
    return len(faults)


def main():
    parser = Parser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 every student is in the file, and every row is a student's; 1 the instructor "
               "has to\n"
        "look at what the lines before the last one say, and all else was written; 2 nothing was written.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="assignments; default: all in the results")
    parser.add_argument("--source", default=".", metavar="DIR", help="the kit's folder")
    parser.add_argument("--results", required=True, metavar="DIR", help="what make grade-class wrote")
    parser.add_argument("--roster", required=True, metavar="FILE",
                        help="collected.csv, which make collect wrote")
    parser.add_argument("--format", default="csv", metavar="FORMAT", help=f"{', '.join(sorted(FORMS))}")
    parser.add_argument("--out", required=True, metavar="FILE", help="where the grades go")
    parser.add_argument("--template", default="", metavar="FILE", help="what the grade book exported")
    parser.add_argument("--column", default="", metavar="NAME", help="the column for the sum")
    parser.add_argument("--penalty", default="", metavar="PERCENT", help="of the points, for each day late")
    parser.add_argument("--keep", action="store_true", help="points that the template has")
    parser.add_argument("--missing", default="", metavar="0", help="who handed in nothing gets 0")
    options = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")
    return run_command("grade-book", lambda: 0 < grade_book(options), 2, "; nothing was written")


if __name__ == "__main__":
    sys.exit(main())
