"""The roster of a course: a CSV file with the columns id, name, email, and perhaps group, pattern, due and
days_late."""

import csv
import io
import os
import re

from grading.assignments import ToolError, is_archive
from grading.collect_times import moment_of
from grading.results import name_of

_NEEDED, _OPTIONAL = ("id", "name", "email"), ("group", "pattern", "due", "days_late")

_ALSO = {"student id": "id", "id number": "id", "e-mail": "email", "email address": "email",
         "surname": "last name"}  # as registries and platforms call them
_PARTS = ("first name", "last name")


class Student:
    """A row of the roster. `pattern` is a glob of the names of what the student delivers, `due` a deadline of
    one's own, `days_late` what counts in place of what is found out; each may be empty."""

    def __init__(self, id, name, email, group="", pattern="", due="", days_late=""):
        self.id, self.name, self.email, self.group, self.pattern = id, name, email, group, pattern
        self.due, self.days_late = due, days_late

    def login(self):
        return self.email.partition("@")[0]

    def __str__(self):
        return f"{self.name or 'without a name'} ({self.id})"


def read_table(path, what, encodings=("utf-8-sig",)):
    """Returns the rows of a CSV file as lists, its delimiter and its encoding. It is separated by whichever
    of comma, semicolon and tab its first line has most of."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise ToolError(f"{what}: {path} cannot be read: {error.strerror}") from error
    text = None
    for encoding in encodings:
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError as error:
            line = data[:error.start].count(b"\n") + 1
    if text is None:
        raise ToolError(f"{what}: {path}:{line}: this is not UTF-8; save it as \"CSV UTF-8\"")
    first = text.lstrip("\ufeff\r\n").partition("\n")[0]
    delimiter = max(",;\t", key=first.count)
    try:
        lines = io.StringIO(text.lstrip("\ufeff"), newline="")
        rows = list(csv.reader(lines, delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise ToolError(f"{what}: {path} is no CSV file ({error}); does a quotation mark "
                        "lack its pair?") from error
    return rows, delimiter, encoding


def fault_in_id(text):
    """Says why this cannot be the name of a student's folder, or returns ""."""
    if not text:
        return "the id is empty; each student needs one"
    if text != name_of(text) or text != text.strip() or re.search(r"[/\\:*?\"<>|]", text) or text[0] in ".-~":
        return f"the id {name_of(text)} cannot name a folder; use letters, digits, and _ - + @ . between them"
    if is_archive(text) or text.lower().endswith((".c", ".csv")) or len(os.fsencode(text)) > 100:
        return f"the id {text} reads as a file's name; choose one of up to 100 characters, without an ending"
    return ""


def _fault_in_times(student):
    """Says what is wrong with a student's own deadline or days late, or returns ""."""
    try:
        moment_of(student.due or "2026-10-05 23:59")
    except ValueError:
        return f"due is {student.due}; write the date, the time and the zone, such as 2026-10-05 23:59 +0200"
    if not re.fullmatch(r"\d{0,4}", student.days_late):
        return f"days_late is {student.days_late}; write a whole number, or leave the cell empty"
    return ""


def _names_of_columns(row):
    names = [name.strip().lower() for name in row]
    return [name if _ALSO.get(name) in names else _ALSO.get(name, name) for name in names]


def read_roster(path):
    """Returns the students, and the names of columns that are not used. Raises ToolError that names every
    fault with its line."""
    if not path:
        raise ToolError("say who is in the course: ROSTER=roster.csv, with the columns id, name, email, "
                        "and perhaps group, pattern, due and days_late")
    rows, _, _ = read_table(path, "ROSTER")
    heading = _names_of_columns(rows[0]) if rows else []
    parts = _PARTS if "name" not in heading and set(_PARTS) <= set(heading) else ()
    used = [name for name in _NEEDED if name != "name" or not parts]
    for name in used:
        if name not in heading:
            raise ToolError(f"ROSTER: {path}:1: there is no column \"{name}\"; the first line should be "
                            "id,name,email, and perhaps group and pattern")
    used += [*_OPTIONAL, *parts]
    for name in heading:
        if name in used and heading.count(name) > 1:
            raise ToolError(f"ROSTER: {path}:1: the column \"{name}\" is there twice; leave one")
    students, faults, lines, line = [], [], {}, 1
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(heading):
            faults.append(f"{path}:{number}: {len(row)} cells for {len(heading)} columns; a comma within "
                          "a cell needs quotation marks around it")
            continue
        cells = dict(zip(heading, (cell.strip() for cell in row)))
        cells["name"] = " ".join(filter(None, (cells[part] for part in parts))) or cells.get("name", "")
        student = Student(*(cells.get(name, "") for name in _NEEDED + _OPTIONAL))
        fault = fault_in_id(student.id)
        for kind, text in (("id", student.id), ("email", student.email), ("pattern", student.pattern)):
            line = lines.setdefault((kind, text.casefold()), number)
            if text and line != number and not fault:
                fault = f"the {kind} {text} is that of line {line}, too; each student has one of their own"
        if student.email and "@" not in student.email and not fault:
            fault = f"{student.email} is no e-mail address; leave the cell empty if you do not know it"
        fault = fault or _fault_in_times(student)
        faults += [f"{path}:{number}: {fault}"] if fault else []
        students.append(student)
    if not students and not faults:
        faults.append(f"{path}: there is nobody in it; write a line for each student below the first")
    if faults:
        more = [f"and {len(faults) - 20} more"] if len(faults) > 20 else []
        raise ToolError("ROSTER: " + "\nROSTER: ".join(faults[:20] + more))
    return students, [name for name in heading if name and name not in used]


def team_of(student, students):
    """Returns those whose work counts for a student: their group, or the student alone."""
    return [other for other in students if student.group and other.group == student.group] or [student]
