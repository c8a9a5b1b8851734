"""The files that grade books import: Canvas's, Moodle's and Blackboard's, from what the same grade book
exports, and a plain one.

Sources: Canvas, lib/gradebook_importer.rb in instructure/canvas-lms (columns up to Section, "Points Possible"
and "(read only)" in the second row, `Name (id)`; an empty cell takes a grade away, so what is not graded
keeps the export's cell). Moodle, mod/assign/feedback/offline/importgradeslib.php (Identifier, Grade and Last
modified (grade) have to be there; an empty or too large grade is skipped). Blackboard, "Uploading External
Grade Center Items" on library.blackboard.com (Username and the column's number identify; tab or comma,
quotation marks around each cell; a column without a number becomes a new one of text).
"""

import csv
import io
import os
import re
from functools import partial

from grading.assignments import ToolError
from grading.book_points import Grade
from grading.collect_names import Matcher, plain
from grading.collect_roster import read_table
from grading.results import csv_cell


class Book:
    """What is to be written: `wanted` pairs of a name (a stem, or total) and a function from a Grade to its
    points; `maxima` by name; `template` and `column` as the instructor gave them, or empty; `keeps` whether
    points that a template has stay; `has_penalty` whether being late costs points. `changed` are sentences on
    points that became others, or would have."""

    def __init__(self, grades, wanted, maxima, known, template, column, keeps, has_penalty):
        self.grades, self.wanted, self.maxima, self.known = grades, wanted, maxima, known
        self.template, self.column, self.keeps, self.has_penalty = template, column, keeps, has_penalty
        self.faults, self.remarks, self.changed = [], [], []

    def check_maximum(self, text, name, where):
        """Raises ToolError if the grade book counts other points than the results."""
        number = text.strip().replace(",", ".")
        if re.fullmatch(r"\d+(\.\d*)?", number) and float(number) != self.maxima[name]:
            raise ToolError(f"TEMPLATE: {self.template}: {where} has {text.strip()} points, but {name} "
                            f"{self.maxima[name]}; set {self.maxima[name]} there, and export again")

    def join(self, rows, keys, is_nobody=lambda row: False):
        """Yields each row with its Grade, or None. `keys` returns candidates for a row's id, address, login
        and name."""
        grades = {grade.student: grade for grade in self.grades}
        matcher = Matcher(list(grades))
        fits = [(row, matcher.who(*keys(row))) for row in rows]
        claimed = [next(iter(who)) for _, who in fits if len(who) == 1]
        by_name = []
        for row, who in fits:
            student = next(iter(who)) if len(who) == 1 else None
            shown = ", ".join(filter(None, row[:3]))
            if student is not None and claimed.count(student) > 1:
                self.faults.append(f"the row {shown} and another fit {student}; neither was filled in")
                student = None
            elif len(who) > 1:
                self.faults.append(f"the row {shown} fits {' and '.join(sorted(map(str, who)))}; fill it in "
                                   "by hand")
            elif not who and not is_nobody(row):
                self.faults.append(f"no student on the roster matches the row {shown}; it stays as it is")
            elif student is not None and not matcher.who(*keys(row)[:3], []):
                by_name.append(str(student))
            yield row, grades.get(student)
        if by_name:
            self.remarks.append(f"by the name alone: {', '.join(by_name)}")
        found = set(claimed)
        self.faults += [f"{grade.student} has no row in {self.template}" for grade in self.grades
                        if grade.student not in found]

    def columns(self, names, heading):
        """Returns pairs of a column's index and what to put there; `names` are the names of those that may
        take points, by index, or None."""
        def stem_of(name):
            letters = re.sub(r"[^a-z0-9]", "", plain(name))
            fits = [stem for stem in self.known if stem.replace("_", "") in letters]
            return max(fits, key=len, default=None)

        possible = [index for index, name in enumerate(names) if name is not None]
        shown = ", ".join(f'"{heading[index]}"' for index in possible[:8]) or "none"
        if self.column:
            found = [index for index in possible if self.column in (heading[index], names[index])]
            if len(found) != 1:
                raise ToolError(f"COLUMN: {self.template} has {len(found) or 'no'} columns {self.column}; "
                                "choose one "
                                f"of: {shown}")
            return [(found[0], *self.wanted[-1])]
        chosen = []
        parts = [pair for pair in self.wanted if pair[0] != "total"]
        for name, points in parts:
            found = [index for index in possible if stem_of(names[index]) == name]
            found = possible if len(parts) == len(possible) == 1 else found
            if len(found) != 1:
                raise ToolError(f"TEMPLATE: {len(found) or 'no'} columns of {self.template} are called "
                                f"{name}; name "
                                f"the one for the points by COLUMN=, one of: {shown}")
            chosen.append((found[0], name, points))
        return chosen

    def fill(self, cell, grade, points):
        """Returns what is to stand in a cell: what was not graded stays as it was, and so does what was
        entered for who is missing."""
        number = None if grade is None else points(grade)
        is_entered = cell.strip() not in ("", "-")
        if number is None or grade.note == "missing" and is_entered:
            return cell
        old = cell.strip().replace(",", ".")
        if is_entered and not (re.fullmatch(r"\d+(\.\d*)?", old) and float(old) == number):
            self.changed.append(f"{grade.student}: {cell.strip()}, graded {number}")
            return cell if self.keeps else str(number)
        return str(number)


def _text(rows, delimiter, quoting=csv.QUOTE_MINIMAL):
    stream = io.StringIO()
    csv.writer(stream, delimiter=delimiter, quoting=quoting, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def _cell(row, heading, *names):
    """Returns the cells of a row below these headings."""
    return [row[heading.index(name)].strip() for name in names
            if name in heading and heading.index(name) < len(row)]


def _read_template(book, how, encodings=("utf-8-sig",)):
    if not book.template:
        raise ToolError(f"TEMPLATE: give {how}; it has the numbers by which the grade book knows its "
                        "columns and "
                        "students")
    rows, delimiter, encoding = read_table(book.template, "TEMPLATE", encodings)
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    if not rows:
        raise ToolError(f"TEMPLATE: {book.template} is empty; give {how}")
    heading = [name.strip() for name in rows[0]]
    return heading, [row + [""] * (len(heading) - len(row)) for row in rows], delimiter, encoding


def canvas(book):
    """Columns that say who, and those of the assignments: no other grade is touched by the import."""
    how = "the file that Canvas exports (Gradebook, Export)"
    heading, rows, delimiter, _ = _read_template(book, how)
    if "Student" not in heading[:1] or "ID" not in heading or "Section" not in heading:
        raise ToolError(f"TEMPLATE: {book.template}:1: there is no Student, ID and Section; give {how}")
    last, possible = heading.index("Section"), next((row for row in rows if "Points Possible" in row[0]),
                                                    [""] * len(heading))
    found = [re.fullmatch(r"(.*) \((\d+)\)", name) for name in heading]
    columns = book.columns([match and index > last and "read only" not in possible[index] and match[1] or None
                            for index, match in enumerate(found)], heading)
    for index, name, _ in columns:
        book.check_maximum(possible[index], name, heading[index])

    def keys(row):
        login = _cell(row, heading, "SIS Login ID")
        return _cell(row, heading, "SIS User ID", "ID"), login, login, row[:1]

    body = [row for row in rows[1:] if row is not possible and row[heading.index("ID")].strip()]
    grades = {id(row): grade for row, grade in book.join(
        body, keys, lambda row: plain(row[0]) in ("student, test", "test student"))}
    return _text([row[:last + 1] + [book.fill(row[index], grades.get(id(row)), points) for index, _,
                                    points in columns]
                  for row in rows], delimiter), "utf-8"


def _read_worksheet(book):
    """Returns the heading of Moodle's offline grading worksheet, its other rows, its delimiter, and keys for
    Book.join."""
    heading, rows, delimiter, _ = _read_template(book, "Moodle's offline grading worksheet")
    for name in ("Identifier", "Grade", "Last modified (grade)"):
        if name not in heading:
            raise ToolError(f"TEMPLATE: {book.template}:1: there is no column \"{name}\"; set Moodle's "
                            "language to "
                            "English, and download the grading worksheet of the assignment again")

    def keys(row):
        email, login = _cell(row, heading, "Email address"), _cell(row, heading, "Username")
        return _cell(row, heading, "ID number"), email, login, _cell(row, heading, "Full name")

    return heading, rows[1:], delimiter, keys


def participants(path, grades):
    """Returns a dictionary from students to their numbers in a worksheet."""
    book = Book(grades, [], {}, {}, path, "", False, False)
    heading, rows, _, keys = _read_worksheet(book)
    numbers = {}
    for row, grade in book.join(rows, keys):
        found = re.fullmatch(r"Participant (\d+)", row[heading.index("Identifier")])
        if grade and found:
            numbers[grade.student] = found[1]
    return numbers


def moodle(book):
    """The offline grading worksheet of one assignment, with its columns in their order; without one, what
    Grades, Import, CSV file takes."""
    if not book.template:
        heading = ["ID number", "Email address", *(name for name, _ in book.wanted)]
        rows = [[grade.student.id, grade.student.email,
                 *(book.fill("", grade, points) for _, points in book.wanted)] for grade in book.grades]
        return _text([heading, *rows], ","), "utf-8"
    heading, rows, delimiter, keys = _read_worksheet(book)
    column, (name, points) = heading.index("Grade"), book.wanted[-1]
    filled = [heading]
    for row, grade in book.join(rows, keys):
        status = " ".join(_cell(row, heading, "Status"))
        if grade and grade.note == "missing" and "Submitted" in status:
            book.faults.append(f"{grade.student} submitted something, says {book.template}, but nothing was "
                               "collected; that grade stays as it is")
            grade = None
        for maximum in _cell(row, heading, "Maximum Grade", "Maximum grade"):
            book.check_maximum(maximum, name, "the assignment")
        filled.append([*row[:column], book.fill(row[column], grade, points), *row[column + 1:]])
    return _text(filled, delimiter), "utf-8"


def blackboard(book):
    """Columns that say who, and those of the assignments, in the encoding of the download, UTF-16 or UTF-8,
    with its tabs or commas."""
    how = "the file of Blackboard's Grade Center (Work Offline, Download)"
    with_mark = ()
    try:
        with open(book.template or os.devnull, "rb") as file:
            with_mark = ("utf-16",) if file.read(2) in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig",)
    except OSError:
        pass  # said below
    heading, rows, delimiter, encoding = _read_template(book, how, with_mark or ("utf-8-sig",))
    if "Username" not in heading:
        raise ToolError(f"TEMPLATE: {book.template}:1: there is no Username; give {how}")
    found = [re.fullmatch(r"(.*) \[Total Pts: ([\d.,]+) \w+\] \|(\d+)", name) for name in heading]
    columns = book.columns([match and match[1] for match in found], heading)
    for index, name, _ in columns:
        book.check_maximum(found[index][2], name, heading[index])
    who = [index for index, name in enumerate(heading) if name in ("Last Name", "First Name", "Username",
                                                                   "Student ID")]

    def keys(row):
        user = _cell(row, heading, "Username")
        return (_cell(row, heading, "Student ID") + user, user, user,
                [" ".join(_cell(row, heading, "First Name", "Last Name"))])

    filled = [[heading[index] for index in who] + [heading[index] for index, _, _ in columns]]
    for row, grade in book.join(rows[1:], keys):
        filled.append([row[index] for index in who] + [book.fill(row[index], grade, points)
                                                       for index, _, points in columns])
    return _text(filled, delimiter, csv.QUOTE_ALL), encoding


def table(book):
    """A plain table for people and spreadsheets: no cell of it is a formula."""
    if book.template:
        raise ToolError("TEMPLATE: FORMAT=csv takes none; choose FORMAT=moodle, canvas or blackboard")
    columns = []
    for name, points in book.wanted:
        if book.has_penalty:
            columns += [(f"{name} graded", partial(Grade.graded, name=name)),
                        (f"{name} penalty", partial(Grade.penalty, name=name))]
        columns.append((name, points))
    rows = [["id", "name", "email", "group", "submission", *(name for name, _ in columns), "maximum",
             "days_late", "note"]]
    for grade in book.grades:
        row = grade.row
        who = [row["id"], row["name"], row["email"], row.get("group", ""), row["submission"]]
        rows.append([*map(csv_cell, who), *(book.fill("", grade, points) for _, points in columns),
                     book.maxima[book.wanted[-1][0]], csv_cell(row["days_late"]), grade.note])
    return _text(rows, ","), "utf-8"


FORMS = {"canvas": canvas, "moodle": moodle, "blackboard": blackboard, "csv": table}
