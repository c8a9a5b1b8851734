"""What is kept: CSV files with a row for each measurement, written as they are made, so that an interruption
costs one of them. Pictures have theirs in measurements.csv, drivers' times in timings.csv
(benchmark/timings.py)."""

import csv
import math
import os

from grading.assignments import ToolError, cannot_write

KEY = ("program", "case", "method", "size", "samples", "seed", "options")
NUMBERS = ("seconds", "mse", "bias", "worst", "camera_rays", "shadow_rays", "reflected_rays")
COLUMNS = KEY + NUMBERS
_REMEDY = "remove the line, or, if this build made the file, measure all anew by make bench RESET=1"
KINDS = {**dict.fromkeys(NUMBERS, float), "samples": int, "seed": int}


def _row_of(path, number, cells, columns, kinds):
    if len(cells) != len(columns):
        raise ToolError(f"{path}:{number}: there are {len(cells)} cells in place of {len(columns)}; "
                        f"{_REMEDY}")
    row = dict(zip(columns, cells))
    try:
        row.update({name: kind(row[name]) for name, kind in kinds.items()})
    except ValueError as error:
        raise ToolError(f"{path}:{number}: {error}; {_REMEDY}") from None
    for name in kinds:
        value = row[name]
        if value != "" and not (math.isfinite(value) and (value >= 0 or name == "bias")):
            raise ToolError(f"{path}:{number}: {name} is {value:g}; {_REMEDY}")
    return row


def read_rows(path, columns, kinds):
    """The rows of a file; `kinds` converts the cells of some columns. A last line that was not finished is
    left out."""
    try:
        with open(path, encoding="utf-8", errors="replace", newline="") as file:
            text = file.read()
    except OSError as error:
        raise ToolError(f"{path}: cannot be read: {error.strerror}") from None
    lines = text[:text.rfind("\n") + 1].split("\n")[:-1]
    header = lines[0].split(",") if lines else []
    if header != list(columns):
        missing = [name for name in columns if name not in header]
        raise ToolError(f"{path}:1: this is no table of make bench"
                        f"{': the column ' + missing[0] + ' is missing' if missing else ''}; "
                        "name its measurements.csv, or remove the file")
    return [_row_of(path, number, cells, columns, kinds)
            for number, cells in enumerate(csv.reader(lines[1:]), 2)]


def read(path):
    """The pictures of a measurements.csv."""
    return read_rows(path, COLUMNS, KINDS)


def write_table(path, columns, rows):
    """Replaces the file whole."""
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path + ".part", "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([columns, *rows])
        os.replace(path + ".part", path)
    except OSError as error:
        raise cannot_write(path, error) from None


class Kept:
    """Rows by the values of their first columns, in a file."""

    def __init__(self, path, columns, key_columns, kinds, reset=False):
        self.path, self.rows = path, {}
        self._columns, self._key_columns = columns, key_columns
        if os.path.exists(path) and not reset:
            self.take_over(read_rows(path, columns, kinds))
        self.rewrite()  # also without an unfinished line

    def take_over(self, rows):
        """Which rows of an older file count?"""
        self.rows = {tuple(row[name] for name in self._key_columns): row for row in rows}

    def rewrite(self):
        write_table(self.path, self._columns,
                    [[row[name] for name in self._columns] for row in self.rows.values()])

    def add(self, row):
        try:
            with open(self.path, "a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow([row[name] for name in self._columns])
        except OSError as error:
            raise cannot_write(self.path, error) from None
        self.rows[tuple(row[name] for name in self._key_columns)] = row


class Measurements(Kept):
    """Pictures by one program in a folder. Rows of other programs move to previous.csv, to compare with."""

    def __init__(self, folder, program, reset=False):
        self._program, self._previous = program, os.path.join(folder, "previous.csv")
        super().__init__(os.path.join(folder, "measurements.csv"), COLUMNS, KEY, KINDS, reset)

    def take_over(self, rows):
        own = [row for row in rows if row["program"] == self._program]
        if rows and not own:
            try:
                os.replace(self.path, self._previous)
            except OSError as error:
                raise cannot_write(self.path, error) from None
        super().take_over(own)

    def key(self, method, size, samples, seed):
        case = method.case
        return (self._program, case.name, method.name, str(size), samples, seed,
                f"{case.options} {method.options(samples, seed)} against {case.reference}")

    def add_picture(self, key, numbers):
        self.add(dict(zip(COLUMNS, key + tuple(numbers))))
