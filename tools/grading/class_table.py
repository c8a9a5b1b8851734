"""class.csv: a row for each submission, with its points in each assignment."""

import csv
import io

from grading import results
from grading.assignments import ToolError


def _remarks(found):
    """What is to be known beside the points; what stands in a column of its own is left out."""
    told = next((part for part in found if not part["passed"] and not part["not_graded"]), None)
    remarks = []
    for part in found:
        is_told = part["not_graded"] or part is told or told and part["problem"] == told["problem"]
        remarks += [f"{part['assignment']}: {part['problem']}"] if part["problem"] and not is_told else []
        remarks += part["notes"]
    return "; ".join(dict.fromkeys(remark.replace("\n", " ") for remark in remarks))


def _first(found):
    """Returns the claim to work on first, and why."""
    graded = [part for part in found if not part["not_graded"]]
    part = next((part for part in graded if not part["passed"]), None)
    if not part:
        return "", ""
    if part["first"] or all(other["reason"] == part["reason"] for other in graded):
        return part["first"], part["reason"]
    return "", f"{part['assignment']}: {part['reason']}"


def _not_graded(found):
    """Says why points are missing; each reason once."""
    reasons = {}
    for part in found:
        if part["not_graded"]:
            reasons.setdefault(part["not_graded"], []).append(part["assignment"])
    return "; ".join(reason if len(stems) == len(found) else f"{', '.join(stems)}: {reason}"
                     for reason, stems in reasons.items())


class Table:
    """Begins with the rows of earlier runs. Points that are not known are empty cells, and so are sums of
    them."""

    def __init__(self, path, stems):
        self.path, self._rows = path, {}
        self._heading = ["name", *stems, "total", "maximum", "first failing claim", "reason", "remarks",
                         "graded", "not graded"]
        try:
            with open(path, encoding="utf-8", newline="") as file:
                rows = list(csv.reader(file))
        except FileNotFoundError:
            return
        except (OSError, ValueError, csv.Error) as error:
            raise ToolError(f"{path} cannot be read ({error}); choose another folder for OUT") from error
        if rows and rows[0] != self._heading:
            others = [name for name in rows[0] if name not in self._heading]
            raise ToolError(f"{path} has other columns ({', '.join(others or rows[0])}): results of other "
                            f"assignments need another folder, such as OUT=results/{stems[0]}")
        self._rows = {results.text_of_cell(row[0]): row for row in rows[1:] if row}

    def put(self, name, found, more=""):
        """Adds or replaces a row: what was found of each assignment (verdict_files), and more remarks."""
        self.put_shown(results.name_of(name), found, more)

    def put_shown(self, name, found, more=""):
        """The same for a name as results.name_of makes it."""
        points = ["" if part["not_graded"] else part["points"] for part in found]
        total = "" if "" in points else sum(points)
        words = [*_first(found), "; ".join(filter(None, [more, _remarks(found)])),
                 max(part["graded"] for part in found), _not_graded(found)]
        self._rows[name] = [results.csv_cell(name), *points, total, sum(part["maximum"] for part in found),
                            *map(results.csv_cell, words)]

    def put_unknown(self, name, reason):
        """Adds a row without points for what this machine did not grade."""
        name, columns = results.name_of(name), len(self._heading)
        self._rows[name] = [results.csv_cell(name), *[""] * (columns - 2), results.csv_cell(reason)]

    def has(self, name):
        return results.name_of(name) in self._rows

    def write(self):
        """Rewrites the file, in the order of names."""
        text = io.StringIO()
        rows = [row for _, row in sorted(self._rows.items())]
        csv.writer(text, lineterminator="\n").writerows([self._heading, *rows])
        results.write_whole(self.path, text.getvalue())
