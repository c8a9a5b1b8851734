#!/usr/bin/env python3
"""Collects what students handed in: a folder for each, as make grade-class takes it, from a download of
Moodle, Canvas, Blackboard or Gradescope, clones of GitHub, or saved e-mail.

DOWNLOAD is a zip, a tar or a folder; archives in it are unpacked, two levels deep. ROSTER is a CSV file with
the columns id, name, email, and perhaps group, pattern, due and days_late. A delivery is a student's if its
name fits the student's pattern, a glob. For a student without one, it is if its name says the id, the e-mail
address, the login before the @, or the name, in the forms that platforms use. What fits nobody, or two, is
listed and left out. For id, name and email a registry's names of columns do, too: student ID or ID number,
first name and last name, or both in one column, email address; so do Moodle's export of grades and Canvas's
gradebook. Cells are separated by commas, semicolons or tabs, in UTF-8, or UTF-16 with a byte order mark.

The last file counts that came before the deadline and its grace, else the last that is taken. A day late
begins with each 24 hours after the grace. The roster's column due gives students a deadline of their own,
days_late a number in place of what is found out. OUT/ID/STEM.c is a student's, with the headers beside it
that it includes; a group has one folder, that of its first member on the roster. OUT/collected.csv has a row
for each student, missing ones, too, and says by what each time is known; who delivered what could not be
collected has "not collected" and the reason in remarks. The column delivered keeps the name under which each
student's work came, by which make feedback sends reports back. An OUT that this command wrote is replaced,
whole or not at all; what was corrected by hand in it stays, and is told.
"""

import argparse
import os
import sys
import tempfile

from grading.assignments import Parser, ToolError, choose, read_features, run_command
from grading.collect_archives import Download
from grading.collect_items import Items, wanted
from grading.collect_names import UnitNames
from grading.collect_record import Corrections
from grading.collect_roster import read_roster
from grading.collect_submissions import faults_of_time, some, submissions_of
from grading.collect_times import Deadline, Times
from grading.collect_write import HEADING, LIST, NOT_COLLECTED, TABLE, check_out, write_out
from grading.results import printable

_SHOWN = 40  # faults on the screen


def _row(student, submission, unread, stems):
    """Returns a student's row of collected.csv. "missing" is who delivered nothing; what somebody delivered
    that did not come to be collected is said as "not collected"."""
    lacking = [*unread, *(submission.lacking if submission else [])]
    remarks = [*(NOT_COLLECTED + reason for reason in lacking),
               *(submission.remarks if submission else [])]
    row = dict.fromkeys(HEADING, "") | {
        "id": student.id, "name": student.name, "email": student.email, "group": student.group,
        "remarks": "; ".join(remarks or ["missing"]), "assignments": " ".join(stems),
        "delivered": submission.delivered.get(student, "") if submission else ""}
    if not submission or not submission.files:
        return row
    time, deadline = submission.time, submission.deadline
    days = "?" if submission.days is None else str(submission.days)
    return row | {"submission": submission.team[0].id,
                  "submitted": time.strftime("%Y-%m-%d %H:%M:%S %z") if time else "",
                  "days_late": days if deadline.due or deadline.given is not None else ""}


def _all_of_them(items):
    """Returns all that is too much for the screen, a line each, or nothing."""
    if len(items.faults) <= _SHOWN and some(items.ignored) == ", ".join(items.ignored):
        return []
    return [*items.faults, *(f"no work, so ignored: {name}" for name in items.ignored)]


def _tell(items, rows, told, out, deadline):
    """Says what was collected, and what was not."""
    missing = [f"{row['name'] or 'without a name'} ({row['id']})" for row in rows if not row["submission"]]
    days = [row["days_late"] for row in rows]
    late, unknown = sum(count not in ("", "0", "?") for count in days), days.count("?")
    lines = [deadline.zone_taken()] if deadline.zone_taken() else []
    lines += [f"no work collected from {some(missing)}"] if missing else []
    lines += [f"no work, so ignored: {some(items.ignored)}"] if items.ignored else []
    lines += [*told, *items.faults[:_SHOWN]]
    lines += [f"and {len(items.faults) - _SHOWN} more"] if len(items.faults) > _SHOWN else []
    lines += [f"all of these are in {os.path.join(out, LIST)}"] if _all_of_them(items) else []
    due = f" (due {deadline}; {late} late{f'; lateness unknown: {unknown}' if unknown else ''})"
    lines.append(f"work of {len(rows) - len(missing)} of {len(rows)} students was collected"
                 f"{due if deadline.due else ''}; wrote {os.path.join(out, TABLE)}")
    for line in lines:
        print(f"collect: {printable(line)}")


def collect(source, stems, download, out, roster, deadline, again=False):
    """Collects; returns how many things the instructor has to look at."""
    stems = sorted({feature.stem for feature in choose(read_features(source), stems)})
    units = UnitNames(stems)
    if not download:
        raise ToolError("say what was downloaded: DOWNLOAD=path, a zip, a tar or a folder")
    if not os.path.exists(download):
        raise ToolError(f"DOWNLOAD: there is no file or folder {download}")
    old = check_out(out, download)
    corrections = Corrections(out, None if again else old)
    corrections.check(stems)
    students, unused = read_roster(roster)
    if unused:
        print(printable(f"collect: columns of the roster that are not used: {some(unused)}"))
    with tempfile.TemporaryDirectory(prefix="raykit-collect-") as work:
        found = Download(download, wanted(units), work)
        if not found.files and not found.faults:
            raise ToolError(f"DOWNLOAD: {download} holds no file")
        items = Items(found, students, units, download)
        submissions = submissions_of(items, Times(download, deadline, items.items), deadline)
        rows = [_row(student, submissions.get(student), items.unread.get(student, []), stems)
                for student in students]
        files = {one.team[0].id: one.files for one in submissions.values() if one.files}
        record = corrections.put_into(rows, files, stems,
                                      {student.id for student in students if student.days_late})
        items.faults += corrections.faults
        items.faults += faults_of_time(rows, {student.id: one for student, one in submissions.items()})
        named = {row["submission"] for row in rows}
        write_out(out, rows, {name: files[name] for name in files if name in named}, record,
                  _all_of_them(items))
    _tell(items, rows, corrections.told, out, deadline)
    return len(items.faults)


def main():
    parser = Parser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 all that was delivered was collected, whoever is missing; 1 the instructor\n"
        "has to look at what the lines before the last one say, and all else was collected;\n2 nothing was "
        "written.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="assignments to collect; default: all")
    parser.add_argument("--source", default=".", metavar="DIR", help="the kit's folder")
    parser.add_argument("--download", required=True, metavar="PATH", help="a zip, a tar or a folder")
    parser.add_argument("--out", required=True, metavar="DIR", help="where the submissions go")
    parser.add_argument("--roster", required=True, metavar="FILE", help="who is in the course")
    parser.add_argument("--due", default="", metavar="TIME",
                        help='the deadline, such as "2026-10-05 23:59 +0200"')
    parser.add_argument("--grace", default="", metavar="HOURS", help="after the deadline that are not late")
    parser.add_argument("--until", default="", metavar="DAYS",
                        help="late that are taken; default: any number")
    parser.add_argument("--again", action="store_true", help="discard what was corrected by hand in OUT")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    return run_command("collect", lambda: 0 < collect(
        arguments.source, arguments.stems, arguments.download, arguments.out, arguments.roster,
        Deadline(arguments.due, arguments.grace, arguments.until), arguments.again),
        2, "; nothing was written")


if __name__ == "__main__":
    sys.exit(main())
