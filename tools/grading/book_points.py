"""A class's points for a grade book: class.csv of make grade-class joined with collected.csv of make
collect."""

import csv
import fractions
import os
import re

from grading.assignments import ToolError
from grading.collect_roster import Student
from grading.collect_write import NOT_COLLECTED, read_collected
from grading.results import text_of_cell


def penalty_of(text):
    """Returns PENALTY, percent of the points for each day late, as an exact number."""
    if not re.fullmatch(r"(\d{1,3}(\.\d{1,3})?)?", text) or fractions.Fraction(text or 0) > 100:
        raise ToolError(f"PENALTY={text}: write percent of the points for each day late, such as PENALTY=10")
    return fractions.Fraction(text or 0)


def with_penalty(points, percent, days):
    """Returns whole points: a half is rounded up, and nobody gets less than 0."""
    left = points * max(0, 100 - percent * days) / 100
    return int(left + fractions.Fraction(1, 2))


def is_late(row):
    """Whether a row of collected.csv has a submission after the deadline."""
    days = row["days_late"]
    return bool(row["submission"] and re.fullmatch(r"\d+(\.0*)?", days) and float(days))


class Results:
    """class.csv: `stems` of its assignments, and for each name a dictionary from these to points, or None for
    what was not graded. Its columns are found by their names."""

    def __init__(self, path, stems, known):
        path = os.path.join(path, "class.csv") if os.path.isdir(path) else path
        self.path, self.rows = path, {}
        try:
            with open(path, encoding="utf-8-sig", newline="") as file:
                rows = list(csv.reader(file))
        except (OSError, ValueError, csv.Error) as error:
            reason = getattr(error, "strerror", None) or error
            raise ToolError(f"RESULTS: {path} cannot be read ({reason}); make grade-class writes "
                            "it") from error
        heading = rows[0] if rows else []
        self.stems = [stem for stem in heading if stem in known and (not stems or stem in stems)]
        lacking = [stem for stem in stems if stem not in heading]
        if "name" not in heading or lacking or not self.stems:
            what = ", ".join(lacking) or ("the name" if "name" not in heading else "any assignment")
            raise ToolError(f"RESULTS: {path}:1: there is no column of {what}")
        for number, row in enumerate(rows[1:], 2):
            cells = dict(zip(heading, row))
            if any(row):
                self.rows[text_of_cell(cells["name"])] = {
                    stem: self._points(cells.get(stem, ""), number, stem) for stem in self.stems}

    def _points(self, cell, number, stem):
        if cell and not cell.isdecimal():
            raise ToolError(f"RESULTS: {self.path}:{number}: {cell} in column {stem} is no number of points")
        return int(cell) if cell else None


def _sum(parts):
    return None if None in parts.values() else sum(parts.values())


class Grade:
    """A student with two dictionaries from stems to points, or None: `graded`, those of the results, and
    `points`, those that count, after the penalty; and the reason for None. `days` late are counted if there
    is a penalty, else None."""

    def __init__(self, row, points, note="", graded=None, days=None):
        self.student = Student(row["id"], row["name"], row["email"], row.get("group", ""))
        self.row, self.points, self.note, self.days = row, points, note, days
        self._graded = points if graded is None else graded

    def total(self):
        """Returns the sum, None if a part of it was not graded."""
        return _sum(self.points)

    def graded(self, name):
        """Returns the points before the penalty of a stem, or of the total; None if nobody knows."""
        return _sum(self._graded) if name == "total" else self._graded[name]

    def counts(self, name):
        """Returns what counts of them."""
        return self.total() if name == "total" else self.points[name]

    def penalty(self, name):
        """Returns what being late costs of them."""
        graded, counts = self.graded(name), self.counts(name)
        return None if None in (graded, counts) else graded - counts


def _grade_of(row, results, percent, missing):
    """Returns a student's Grade, and what the instructor has to look at."""
    nothing = dict.fromkeys(results.stems)
    remarks = row.get("remarks", "")
    if not row["submission"] and NOT_COLLECTED in remarks:
        return Grade(row, nothing, "not collected"), remarks
    if not row["submission"]:
        return Grade(row, dict.fromkeys(results.stems, missing), "missing", nothing), ""
    if row["submission"] not in results.rows:
        fault = f"the submission {row['submission']} has no row in {results.path}"
        return Grade(row, nothing, "not graded"), fault
    left_out = dict.fromkeys(stem for stem in results.stems if f"{NOT_COLLECTED}{stem}.c:" in remarks)
    graded, days = {**results.rows[row["submission"]], **left_out}, row["days_late"]
    if percent and not re.fullmatch(r"\d+(\.0*)?", days):
        fault = f"days_late is {days or 'empty'}; write the number into collected.csv"
        return Grade(row, nothing, "days late unknown", graded), fault
    days = int(float(days)) if percent else None
    points = {stem: most if most is None or not percent else with_penalty(most, percent, days)
              for stem, most in graded.items()}
    if left_out:
        return Grade(row, points, "not collected", graded, days), remarks
    lacking = [stem for stem, count in points.items() if count is None]
    fault = f"{', '.join(lacking)} could not be graded ({results.path} has the reason)" if lacking else ""
    return Grade(row, points, "not graded" if lacking else "", graded, days), fault


def grades_of(results, roster, percent, missing):
    """Returns a Grade for each student, and sentences on what the instructor has to look at."""
    rows, faults, grades = read_collected(roster), [], []
    collected = {stem for row in rows for stem in row.get("assignments", "").split()}
    others = [stem for stem in results.stems if collected and stem not in collected]
    if others:
        raise ToolError(f"ROSTER: {roster} was collected for {', '.join(sorted(collected))}, and the results "
                        f"are of {', '.join(others)}: each has a table of its own")
    if percent and not any(row["days_late"] for row in rows):
        raise ToolError(f"PENALTY: {roster} does not say how late anybody was; give make collect DUE=")
    for row in rows:
        grade, fault = _grade_of(row, results, percent, missing)
        grades.append(grade)
        faults += [f"{grade.student}: {fault}"] if fault else []
    known = {row["submission"] for row in rows}
    faults += [f"no student on the roster matches {name} in {results.path}" for name in results.rows
               if name not in known]
    return grades, faults
