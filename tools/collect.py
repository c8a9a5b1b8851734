#!/usr/bin/env python3
"""Collects what students handed in: a folder for each, as make grade-class takes it, from a download of
Moodle, Canvas, Blackboard or Gradescope, clones of GitHub, or saved e-mail.

DOWNLOAD is a zip, a tar or a folder; archives in it are unpacked, two levels deep. ROSTER is a CSV file with
the columns id, name, email, and perhaps group and pattern. A delivery is a student's if its name fits the
student's pattern, a glob. For a student without one, it is if its name says the id, the e-mail address, the
login before the @, or the name, in the forms that platforms use. What fits nobody, or two, is listed and left
out.

The last file counts that came before the deadline and its grace, else the last that is taken. A day late
begins with each 24 hours after the grace. OUT/ID/STEM.c is a student's, with the headers beside it that it
includes; a group has one folder, that of its first member on the roster. OUT/collected.csv has a row for each
student, missing ones, too, and says by what each time is known. An OUT that this command wrote is replaced,
whole or not at all.
"""

import argparse
import os
import sys
import tempfile

from grading.assignments import Parser, ToolError, choose, read_features, run_command
from grading.collect_archives import Download
from grading.collect_items import Items, wanted
from grading.collect_names import UnitNames
from grading.collect_roster import read_roster
from grading.collect_submissions import submissions_of
from grading.collect_times import Deadline, Times
from grading.collect_write import TABLE, check_out, write_out
from grading.results import printable

_SHOWN = 40  # faults on the screen


def _row(student, submission, unread, deadline):
    """Returns a student's row of collected.csv."""
    who = [student.id, student.name, student.email, student.group]
    remarks = [*unread, *(submission.remarks if submission else [])]
    if not submission or not submission.files:
        return ["", *who, "", "", "; ".join(remarks or ["missing"])]
    time = submission.time.strftime("%Y-%m-%d %H:%M:%S %z") if submission.time else ""
    days = "?" if submission.days is None else submission.days
    return [submission.team[0].id, *who, time, str(days) if deadline.due else "", "; ".join(remarks)]


def _some(names):
    return ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")


def _tell(items, rows, out, deadline):
    """Says what was collected, and what was not."""
    missing = [f"{row[2] or 'without a name'} ({row[1]})" for row in rows if not row[0]]
    late = sum(row[6] not in ("", "0") for row in rows)
    lines = [f"nothing of {_some(missing)}"] if missing else []
    lines += [f"no work, so ignored: {_some(items.ignored)}"] if items.ignored else []
    lines += items.faults[:_SHOWN]
    lines += [f"and {len(items.faults) - _SHOWN} more of these"] if len(items.faults) > _SHOWN else []
    due = f" (due {deadline}; {late} late)" if deadline.due else ""
    lines.append(f"{len(rows) - len(missing)} of {len(rows)} students handed in{due}; "
                 f"wrote {os.path.join(out, TABLE)}")
    for line in lines:
        print(f"collect: {printable(line)}")


def collect(source, stems, download, out, roster, deadline):
    """Collects; returns how many things the instructor has to look at."""
    units = UnitNames([feature.stem for feature in choose(read_features(source), stems)])
    if not download:
        raise ToolError("say what was downloaded: DOWNLOAD=path, a zip, a tar or a folder")
    if not os.path.exists(download):
        raise ToolError(f"DOWNLOAD: there is no file or folder {download}")
    check_out(out, download)
    students, unused = read_roster(roster)
    if unused:
        print(printable(f"collect: columns of the roster that are not used: {', '.join(unused)}"))
    with tempfile.TemporaryDirectory(prefix="raykit-collect-") as work:
        found = Download(download, wanted(units), work)
        if not found.files and not found.faults:
            raise ToolError(f"DOWNLOAD: {download} holds no file")
        items = Items(found, students, units, download)
        submissions = submissions_of(items, Times(download, deadline, items.items), deadline)
        rows = [_row(student, submissions.get(student), items.unread.get(student, []), deadline)
                for student in students]
        write_out(out, rows, {submission.team[0].id: submission.files for submission in submissions.values()
                              if submission.files})
    _tell(items, rows, out, deadline)
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
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    return run_command("collect", lambda: 0 < collect(
        arguments.source, arguments.stems, arguments.download, arguments.out, arguments.roster,
        Deadline(arguments.due, arguments.grace, arguments.until)), 2, "; nothing was written")


if __name__ == "__main__":
    sys.exit(main())
