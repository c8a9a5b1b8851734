"""The folder that collect writes: whole or not at all, and only in place of one that it wrote itself."""

import csv
import json
import os
import shutil
import tempfile

from grading.assignments import ToolError, cannot_write
from grading.collect_record import RECORD
from grading.collect_roster import rows_of_table
from grading.results import csv_cell, printable, text_of_cell

TABLE = "collected.csv"
NOT_COLLECTED = "not collected: "  # begins a remark; the reason follows
LIST = "collected.txt"  # all that is too much for the screen
HEADING = ["submission", "id", "name", "email", "group", "submitted", "days_late", "remarks",
           "assignments", "delivered"]


def read_collected(path):
    """Returns the rows of a collected.csv as dictionaries. Raises ToolError if it is none."""
    rows, _, _ = rows_of_table(path)
    rows = [row for row in rows if any(row)]
    if not rows or not set(HEADING[:4] + ["days_late"]) <= set(rows[0]):
        raise ToolError(f"{path} is not a {TABLE}, which make collect writes: its first line should be "
                        f"{','.join(HEADING)}")
    padding = [""] * len(rows[0])
    return [dict(zip(rows[0], map(text_of_cell, row + padding))) for row in rows[1:]]


def check_out(out, download):
    """Raises ToolError unless OUT can be made, or is a folder that collect made. Returns the rows of its
    table, None if there is none."""
    if not out:
        raise ToolError("say where the submissions go: OUT=submissions, a folder")
    place, source = (os.path.join(os.path.realpath(path), "") for path in (out, download))
    if place.startswith(source) or source.startswith(place):
        raise ToolError(f"OUT: {out} and the download {download} lie in each other; choose another place")
    if not os.path.isdir(os.path.dirname(place.rstrip(os.sep))):
        raise ToolError(f"OUT: there is no folder {os.path.dirname(out.rstrip(os.sep))}; make it first")
    if not os.path.lexists(out):
        return None
    if os.path.islink(out) or not os.path.isdir(out):
        raise ToolError(f"OUT: {out} is no folder; choose another name")
    entries = set(os.listdir(out))
    if not entries:
        return None
    if TABLE not in entries:
        raise ToolError(f"OUT: the folder {out} holds files, and no {TABLE} that make collect wrote; choose "
                        "another name")
    try:
        rows = read_collected(os.path.join(out, TABLE))
    except ToolError as error:
        raise ToolError(f"OUT: {error}; choose another name") from error
    stray = min(entries - {row["submission"] for row in rows} - {TABLE, LIST, RECORD}, default=None)
    if stray:
        raise ToolError(f"OUT: {out} also holds {stray}, which make collect did not write; "
                        "move it away, or choose another name")
    return rows


def _fill(folder, rows, submissions, record, notes):
    for name, files in submissions.items():
        for relative, path in files.items():
            place = os.path.join(folder, name, relative)
            os.makedirs(os.path.dirname(place), exist_ok=True)
            shutil.copyfile(path, place)
    with open(os.path.join(folder, TABLE), "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADING)
        writer.writerows([[csv_cell(row[name]) for name in HEADING] for row in rows])
    with open(os.path.join(folder, RECORD), "w", encoding="utf-8") as file:
        json.dump(record, file, indent=1)
    if notes:
        with open(os.path.join(folder, LIST), "w", encoding="utf-8") as file:
            file.writelines(printable(line) + "\n" for line in notes)


def write_out(out, rows, submissions, record, notes):
    """Writes collected.csv with these rows, and for each submission its files, given as a dictionary from
    their names to where they are read; a record of it; and notes, if there are any."""
    out = out.rstrip(os.sep) or out
    try:
        part = tempfile.mkdtemp(prefix=".part-", dir=os.path.dirname(out) or ".")
    except OSError as error:
        raise cannot_write(out, error) from error
    new, old = os.path.join(part, "new"), os.path.join(part, "old")
    try:
        os.mkdir(new)
        _fill(new, rows, submissions, record, notes)
        if os.path.lexists(out):
            os.rename(out, old)
        try:
            os.rename(new, out)
        except BaseException:
            if os.path.lexists(old):
                os.rename(old, out)
            raise
    except OSError as error:
        raise cannot_write(out, error) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
