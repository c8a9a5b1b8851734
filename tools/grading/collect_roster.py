"""The roster of a course: a CSV file with the columns id, name, email, and perhaps group, pattern, due and
days_late."""

import csv
import io
import os
import re
import shlex

from grading.assignments import ToolError, is_archive
from grading.collect_times import moment_of
from grading.results import name_of, printable

_NEEDED, _OPTIONAL = ("id", "name", "email"), ("group", "pattern", "due", "days_late")

_ALSO = {"student id": "id", "id number": "id", "e-mail": "email", "email address": "email",
         "e-mail address": "email", "surname": "last name", "family name": "last name",
         "given name": "first name", "full name": "name", "student name": "name",
         "last name, first name": "name", "surname, first name": "name",
         "last, first": "name"}  # as registries and platforms call them
_PARTS = ("first name", "last name")
# Canvas's gradebook has rows that are nobody's, and a login in place of an address.
_OF_CANVAS = {"student": "name", "sis login id": "email"}
_NOBODY = ("student, test", "test student")

_SEPARATORS = {",": "a comma", ";": "a semicolon", "\t": "a tab"}
_UTF_16 = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_SPREADSHEETS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_AS_UTF_8 = "save it as \"CSV UTF-8\""


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


def _decoded(data, path, encodings):
    """Returns a file's text and its encoding."""
    marked, line = _UTF_16.get(data[:2]), 1
    if data.startswith(_SPREADSHEETS):
        raise ToolError(f"{path} is a spreadsheet's own file; {_AS_UTF_8}")
    if b"\0" in data[:100] and not marked:
        raise ToolError(f"{path} is UTF-16 without a byte order mark, or no table; {_AS_UTF_8}")
    for encoding in encodings or ([marked] if marked else ["utf-8-sig"]):
        try:
            return data.decode(encoding), encoding
        except UnicodeDecodeError as error:
            line = data[:error.start].count(b"\n") + 1
    said = data.split(b"\n")[line - 1].decode("cp1252", "replace").strip()
    convert = f"iconv -f WINDOWS-1252 -t UTF-8 {shlex.quote(path)} >new.csv"
    raise ToolError(f"{path}:{line}: this is not UTF-8; {_AS_UTF_8}, or, if this line should read "
                    f"{printable(said)[:100]}, convert it: {convert}")


def _separator_of(text):
    """Returns what separates the cells of a table, which is what its first line has most of outside of
    quotation marks, or says, as spreadsheets write it; and such a line, or ""."""
    first = text.lstrip("\ufeff\r\n").partition("\n")[0]
    said = re.fullmatch(r'"?sep=([,;\t])"?\s*', first)
    outside = re.sub(r'"[^"]*"', "", first)
    return (said[1], first) if said else (max("\t;,", key=outside.count), "")


def rows_of_table(path, encodings=()):
    """Returns the rows of a CSV file as lists, its delimiter and its encoding, which is UTF-8, or UTF-16 with
    a byte order mark, unless others are given. Raises ToolError with what to do."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise ToolError(f"{path} cannot be read: {error.strerror}") from error
    text, encoding = _decoded(data, path, encodings)
    delimiter, said = _separator_of(text)
    text = text.lstrip("\ufeff").replace(said, "", 1)  # an empty line stays, for the numbers of the others
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise ToolError(f"{path} is no CSV file ({error}); does a quotation mark lack its pair?") from error
    return rows, delimiter, encoding


def read_table(path, what, encodings=()):
    """The same of what a variable names."""
    try:
        return rows_of_table(path, encodings)
    except ToolError as error:
        raise ToolError(f"{what}: {error}") from error


def fault_in_id(text):
    """Says why this cannot be the name of a student's folder, or returns ""."""
    if not text:
        return "the id is empty; each student needs one, such as the login"
    if re.fullmatch(r"\d[.,]\d+E[+]\d+", text, re.IGNORECASE):
        return (f"the id {text} has lost digits in a spreadsheet; format the column as text, and export it "
                "again")
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
    """Returns the names of columns as the kit has them, and whether the table is Canvas's gradebook."""
    names = [name.strip().lower() for name in row]
    is_canvas = {"student", "id", "section"} <= set(names)
    also = _ALSO | (_OF_CANVAS if is_canvas else {})
    return [name if also.get(name) in names else also.get(name, name) for name in names], is_canvas


def _check_columns(path, line, heading, parts, row):
    """Returns the names of columns that are used. Raises ToolError unless each that is needed is there once;
    `row` is the heading as it stands there."""
    used = [name for name in _NEEDED if name != "name" or not parts]
    for name in used:
        if name not in heading:
            among = f" among {printable(', '.join(row))[:200]}" if any(heading) else ""
            raise ToolError(f"ROSTER: {path}:{line}: there is no column \"{name}\"{among}; rename the one "
                            "that says it: the first line should be id,name,email, and perhaps group and "
                            "pattern")
    used += [*_OPTIONAL, *parts]
    for name in heading:
        if name in used and heading.count(name) > 1:
            raise ToolError(f"ROSTER: {path}:{line}: the column \"{name}\" is there twice; leave one")
    return used


def _check_widths(path, rows, columns, delimiter):
    """Raises ToolError if all rows have more cells than there are columns."""
    widths = {len(row) for row in rows if any(cell.strip() for cell in row)}
    if len(widths) == 1 and len(rows) > 2 and widths.pop() == columns + 1:
        raise ToolError(f"ROSTER: {path}: each line has {columns + 1} cells for {columns} columns; "
                        f"{_SEPARATORS[delimiter]} within a cell, as in Mason, Ann, needs quotation marks "
                        "around it, or another separator of cells")


def _cells_of(row, heading, parts, is_canvas):
    """Returns a row's cells by column."""
    cells = dict(zip(heading, (cell.strip() for cell in row)))
    cells["name"] = " ".join(filter(None, (cells[part] for part in parts))) or cells.get("name", "")
    if is_canvas and "@" not in cells.get("email", ""):
        cells["email"] = ""
    return cells


def read_roster(path):
    """Returns the students, and the names of columns that are not used. Raises ToolError that names every
    fault with its line."""
    if not path:
        raise ToolError("say who is in the course: ROSTER=roster.csv, with the columns id, name, email, "
                        "and perhaps group, pattern, due and days_late")
    rows, delimiter, _ = read_table(path, "ROSTER")
    top = next((number for number, row in enumerate(rows) if any(row)), 0)
    heading, is_canvas = _names_of_columns(rows[top]) if rows else ([], False)
    if is_canvas and "email" not in heading:
        heading.append("email")
    parts = _PARTS if "name" not in heading and set(_PARTS) <= set(heading) else ()
    used = _check_columns(path, top + 1, heading, parts, rows[top] if rows else [])
    columns = len(rows[top])
    _check_widths(path, rows[top + 1:], columns, delimiter)
    students, faults, lines, line = [], [], {}, 1
    for number, row in enumerate(rows[top + 1:], top + 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != columns:
            faults.append(f"{path}:{number}: {len(row)} cells for {columns} columns; "
                          f"{_SEPARATORS[delimiter]} within a cell needs quotation marks around it")
            continue
        cells = _cells_of(row, heading, parts, is_canvas)
        if is_canvas and (not cells["id"] or cells["name"].lower() in _NOBODY):
            continue
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
