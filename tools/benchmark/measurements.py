"""The measurements that are kept: a CSV file with a row for each picture, written as they are made, so that an
interruption costs one picture."""

import csv
import os

from grading.assignments import ToolError, cannot_write

KEY = ("program", "case", "method", "size", "samples", "seed", "options")
NUMBERS = ("seconds", "mse", "bias", "worst", "camera_rays", "shadow_rays", "reflected_rays")
COLUMNS = KEY + NUMBERS


class Row(dict):
    """A picture's measurement; numbers are floats."""

    def key(self):
        return tuple(self[name] for name in KEY)


def _row_of(path, number, cells):
    if len(cells) != len(COLUMNS):
        raise ToolError(f"{path}:{number}: there are {len(cells)} cells in place of {len(COLUMNS)}; "
                        "remove the line, or measure all anew by make bench RESET=1")
    row = Row(zip(COLUMNS, cells))
    try:
        row.update({name: float(row[name]) for name in NUMBERS}, samples=int(row["samples"]), seed=int(row["seed"]))
    except ValueError as error:
        raise ToolError(f"{path}:{number}: {error}; remove the line, or measure all anew by make bench RESET=1") from None
    return row


def read(path):
    """The rows of a file. A last line that was not finished is left out."""
    try:
        with open(path, encoding="utf-8", errors="replace", newline="") as file:
            text = file.read()
    except OSError as error:
        raise ToolError(f"{path}: cannot be read: {error.strerror}") from None
    lines = text[:text.rfind("\n") + 1].split("\n")[:-1]
    header = lines[0].split(",") if lines else []
    if header != list(COLUMNS):
        missing = [name for name in COLUMNS if name not in header]
        raise ToolError(f"{path}:1: this is no table of make bench"
                        f"{': the column ' + missing[0] + ' is missing' if missing else ''}; name its measurements.csv")
    return [_row_of(path, number, cells) for number, cells in enumerate(csv.reader(lines[1:]), 2)]


class Measurements:
    """Those of one program in a folder. Rows of other programs move to previous.csv, to compare with."""

    def __init__(self, folder, program, reset=False):
        self.path, self._program = os.path.join(folder, "measurements.csv"), program
        self._previous = os.path.join(folder, "previous.csv")
        self.rows = {}
        try:
            os.makedirs(folder, exist_ok=True)
            if os.path.exists(self.path) and not reset:
                self._take_over(read(self.path))
            else:
                self._rewrite()
        except OSError as error:
            raise cannot_write(self.path, error) from None

    def _take_over(self, rows):
        self.rows = {row.key(): row for row in rows if row["program"] == self._program}
        if len(self.rows) < len(rows) and not self.rows:
            os.replace(self.path, self._previous)
        self._rewrite()  # also without an unfinished line

    def _rewrite(self):
        part = self.path + ".part"
        with open(part, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            writer.writerows([row[name] for name in COLUMNS] for row in self.rows.values())
        os.replace(part, self.path)

    def key(self, method, size, samples, seed):
        case = method.case
        return (self._program, case.name, method.name, str(size), samples, seed,
                f"{case.options} {method.options(samples, seed)} against {case.reference}")

    def add(self, key, numbers):
        row = Row(zip(COLUMNS, key + tuple(numbers)))
        try:
            with open(self.path, "a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow([row[name] for name in COLUMNS])
        except OSError as error:
            raise cannot_write(self.path, error) from None
        self.rows[key] = row
