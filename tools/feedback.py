#!/usr/bin/env python3
"""Writes a zip with a report for each student, which Moodle and Canvas take back: what counts, and what was
found.

RESULTS is the folder of make grade-class, ROSTER the collected.csv of make collect. The report begins with
the student's points in each assignment, what being late costs (PENALTY=10, percent for each day), and what
counts, which are the numbers of make grade-book. Then comes the report of make grade-class. Members of a
group have the same report, each with their own days.

FORMAT=moodle is for "Upload multiple feedback files in a zip", FORMAT=canvas for "Upload Submissions". Each
file is named as the platform named what the student handed in; make collect keeps that in the column
delivered of collected.csv. Students without such a name, members of a group, say, have Moodle's number from
its offline grading worksheet, TEMPLATE. FORMAT=plain has a folder for each student, called by the id. Who
handed in nothing, and whose work was not collected, gets no file.
"""

import argparse
import io
import json
import os
import sys
import zipfile

from grading import results
from grading.assignments import (Parser, ToolError, choose, choose_format, read_features, read_points,
                                 run_command)
from grading.book_forms import participants
from grading.book_points import Results, grades_of, penalty_of
from grading.collect_write import read_collected
from grading.feedback_forms import FORMS
from grading.verdict_files import file_name

_SHOWN = 40  # sentences of a kind on the screen
_OURS = b"raykit feedback"  # the comment of a zip that may be replaced


# --- The report -----------------------------------------------------------------------------------


def _days(count):
    return f"{count} day{'s' * (count != 1)}"


def _line(name, grade, maximum, penalty):
    """Says what became of the points of an assignment."""
    graded, counts, days = grade.graded(name), grade.counts(name), grade.days
    if graded is None:
        return f"{name}: no points yet; the reason is below."
    said = f"{name}: {graded} of {maximum} points"
    if not penalty:
        return said + "."
    if counts is None:
        return f"{said}. How many days late this was is not known yet, so neither is what counts."
    if not days:
        return f"{said}, in time."
    cost = grade.penalty(name)
    if not cost:
        return f"{said}, {_days(days)} late."
    points = f"{cost} point{'s' * (cost != 1)}"
    return (f"{said}. {_days(days)} late, at {penalty} percent for each day, cost{'s' * (days == 1)} "
            f"{points}: {counts} count{'s' * (counts == 1)}.")


def _page(grade, report, maxima, penalty):
    """Returns the text that a student gets."""
    lines = [f"Feedback for {grade.student}", "",
             *(_line(stem, grade, most, penalty) for stem, most in maxima.items())]
    if len(maxima) > 1 and grade.total() is not None:
        counts = " count" if penalty else ""
        lines += ["", f"In all, {grade.total()} of {sum(maxima.values())} points{counts}."]
    return "\n".join([*map(results.printable, lines), "", "What was found:", "", report.rstrip("\n"), ""])


def _report_of(folder, name):
    """Returns the report of a submission as text. Raises ToolError if there is none, or one for programs."""
    base = os.path.join(folder, file_name(name))
    try:
        if os.path.exists(base + ".txt"):
            with open(base + ".txt", encoding="utf-8") as file:
                return file.read()
        with open(base + ".json", encoding="utf-8") as file:
            text = json.load(file)["output"]
        if isinstance(text, str):
            return text
    except FileNotFoundError as error:
        raise ToolError(f"there is no report {base}.json; grade again") from error
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass  # said below
    raise ToolError(f"the report {base}.json cannot be read; grade again")


def _check_reports(folder, names):
    """Raises ToolError if reports are of a kind that nobody reads."""
    for name in names:
        for ending in (".xml", ".tap"):
            path = os.path.join(folder, file_name(name) + ending)
            if os.path.exists(path):
                raise ToolError(f"RESULTS: {path} is a report for programs; give make grade-class the same "
                                "words again, with FORMAT=text: what has not changed is not graded again")


# --- The zip --------------------------------------------------------------------------------------


def _check_out(out):
    if not out:
        raise ToolError("say where the reports go: OUT=feedback.zip")
    if not out.endswith(".zip"):
        raise ToolError(f"OUT: {out} should end in .zip")
    results.check_place(out)
    try:
        with zipfile.ZipFile(out) as archive:
            is_ours = archive.comment == _OURS
    except FileNotFoundError:
        return
    except (OSError, zipfile.BadZipFile):
        is_ours = False
    if not is_ours:
        raise ToolError(f"OUT: {out} is there, and not of make feedback; choose another name")


def _zipped(pages):
    """Returns a zip's bytes; `pages` are texts by path."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = _OURS
        for path, text in pages.items():
            entry = zipfile.ZipInfo(path)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o100644 << 16
            archive.writestr(entry, text)
    return stream.getvalue()


def _placed(form, grades, file):
    """Returns those who can be given a file, as pairs of a path and a grade, those without a name, and
    sentences on names that several have."""
    places, nameless = {}, []
    for grade in grades:
        place = form.place(grade.row.get("delivered", ""), grade.student, file)
        if place is None:
            nameless.append(grade.student)
        else:
            places.setdefault(place[0], []).append((place[1], grade))
    faults = [f"{' and '.join(str(grade.student) for _, grade in some)} have the same number, {key}; none of "
              "them gets a file" for key, some in places.items() if len(some) > 1]
    return [some[0] for some in places.values() if len(some) == 1], nameless, faults


def _shorten(lines):
    more = [f"and {len(lines) - _SHOWN} more"] if len(lines) > _SHOWN else []
    return lines[:_SHOWN] + more


def _check(options, features):
    """Raises ToolError if the command is wrong."""
    if not options.results:
        raise ToolError("say where the results are: RESULTS=results, the folder of make grade-class")
    if not options.roster:
        raise ToolError("say who is in the course: ROSTER=submissions/collected.csv, which make collect "
                        "wrote")
    choose_format(options.format, FORMS)
    choose(features, options.stems)
    if options.template and options.format != "moodle":
        raise ToolError("TEMPLATE: only FORMAT=moodle takes one, its grading worksheet")
    _check_out(options.out)
    rows = read_collected(options.roster)
    if FORMS[options.format].title and rows and "delivered" not in rows[0]:
        raise ToolError(f"ROSTER: {options.roster} has no column delivered, because an older make collect "
                        "wrote it; collect again, which keeps what was corrected there by hand")


def _name_by_worksheet(form, template, grades):
    """Gives those whose delivery does not say who they are the name that it would have had."""
    numbers = participants(template, grades) if template else {}
    for grade in grades:
        student, row = grade.student, grade.row
        if student in numbers and form.place(row["delivered"], student, "") is None:
            row["delivered"] = f"{student.name}_{numbers[student]}_assignsubmission_file_"


def feedback(options):
    """Writes the zip; returns how many things the instructor has to look at."""
    features = read_features(options.source)
    _check(options, features)
    form, found = FORMS[options.format], Results(options.results, options.stems, features)
    grades, faults = grades_of(found, options.roster, penalty_of(options.penalty), None)
    graded = [grade for grade in grades if grade.row["submission"] in found.rows]
    _check_reports(options.results, [grade.row["submission"] for grade in graded])
    _name_by_worksheet(form, options.template, graded)
    file = f"feedback_{found.stems[0]}.txt" if len(found.stems) == 1 else "feedback.txt"
    placed, nameless, twice = _placed(form, graded, file)
    maxima = {stem: sum(test.points for test in read_points(features[stem])) for stem in found.stems}
    pages = {}
    for path, grade in placed:
        try:
            report = _report_of(options.results, grade.row["submission"])
            pages[path] = _page(grade, report, maxima, options.penalty)
        except ToolError as error:
            faults.append(f"{grade.student}: {error}")
    results.write_whole(options.out, _zipped(pages))
    _tell(options, grades, len(pages), faults + twice, nameless)
    return len(faults) + len(twice) + len(nameless)


def _tell(options, grades, count, faults, nameless):
    """Says who gets a file, and who does not."""
    form, missing = FORMS[options.format], sum(grade.note == "missing" for grade in grades)
    lines = [f"{missing} of {len(grades)} students handed in nothing, and get{'s' * (missing == 1)} no file"
             ] if missing else []
    lines += [form.remark] if form.remark and count else []
    lines += _shorten(faults)
    if nameless:
        shown = ", ".join(_shorten(list(map(str, nameless))))
        lines.append(f"no name from {form.title} is known for {shown}; "
                     + form.needs.format(roster=options.roster))
    lines.append(f"{count} of {len(grades)} students get a file; wrote {options.out}")
    for line in lines:
        print(f"feedback: {results.printable(line)}")


def main():
    parser = Parser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 all whose work was graded get their report; 1 the instructor has to look at\n"
        "what the lines before the last one say, and all else was written; 2 nothing was written.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="assignments; default: all in the results")
    parser.add_argument("--source", default=".", metavar="DIR", help="the kit's folder")
    parser.add_argument("--results", required=True, metavar="DIR", help="what make grade-class wrote")
    parser.add_argument("--roster", required=True, metavar="FILE",
                        help="collected.csv, which make collect wrote")
    parser.add_argument("--format", default="moodle", metavar="FORMAT", help=f"{', '.join(sorted(FORMS))}")
    parser.add_argument("--out", required=True, metavar="FILE", help="the zip")
    parser.add_argument("--template", default="", metavar="FILE", help="Moodle's grading worksheet")
    parser.add_argument("--penalty", default="", metavar="PERCENT", help="of the points, for each day late")
    options = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")
    return run_command("feedback", lambda: 0 < feedback(options), 2, "; nothing was written")


if __name__ == "__main__":
    sys.exit(main())
