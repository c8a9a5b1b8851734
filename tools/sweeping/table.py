"""The table of a sweep, OUT/sweep.csv: for each frame its options, how long it took, how it ended, and what
the driver reports. It also says which frames are there already."""

import csv
import hashlib
import io
import os
import re
import time

from grading.assignments import ToolError
from grading.results import csv_cell, write_whole

NAME = "sweep.csv"
# Columns, and the picture's texts that they hold. Options have no underscores in their names.
REPORTED = {"render_seconds": "seconds", "triangle_count": "triangles", "ray_count": "rays",
            "estimated_error": "error"}
_BEGIN, _END = ("frame", "files"), ("seconds", "status", *REPORTED, "reason", "key", "checksum")
_PAUSE = 1  # second between two writings: a table of thousands of frames takes some time
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


def checksum(out, names):
    """Returns the checksum of a frame's files, "" if one is missing."""
    state = hashlib.sha256()
    try:
        for name in names:
            with open(os.path.join(out, name), "rb") as file:
                content = file.read()
            state.update(b"%d\0" % len(content) + content)
    except OSError:
        return ""
    return state.hexdigest()[:16]


def _cell(text):
    return text if _NUMBER.fullmatch(text) else csv_cell(text)


class Table:
    """The rows of a sweep by frame. `names` are the varied options, `frames` their values."""

    def __init__(self, out, names, frames, keys):
        self.path, self._out, self._names, self._frames = os.path.join(out, NAME), out, names, frames
        self._columns = [*_BEGIN, *names, *_END]
        self._keys, self._rows, self._written = keys, {}, 0.0

    def read(self):
        """Takes over the rows of frames that are there as their keys and checksums say."""
        try:
            with open(self.path, encoding="utf-8", newline="") as file:
                rows = list(csv.DictReader(file))
        except FileNotFoundError:
            return
        except (OSError, ValueError, csv.Error) as error:
            raise ToolError(f"{self.path} cannot be read; remove it, or choose another OUT") from error
        if rows and not {*_BEGIN, *_END} <= set(rows[0]):
            raise ToolError(f"{self.path} is another program's table; choose another OUT")
        for row in rows:
            number = int(row["frame"]) if (row["frame"] or "").isdigit() else 0
            files = (row["files"] or "").split()
            is_same = 1 <= number <= len(self._frames) and row["key"] == self._keys[number - 1]
            if is_same and files and row["status"] == "0" and row["checksum"] == checksum(self._out, files):
                self._rows[number] = row

    def has(self, number):
        return number in self._rows

    def put(self, number, said):
        """Adds a frame's row; `said` is what tools/sweep_frame.py says of it."""
        values = dict(zip(self._names, map(_cell, self._frames[number - 1])))
        files = said.get("files", [])
        self._rows[number] = {
            **values, "frame": str(number), "files": " ".join(files),
            "seconds": f"{said.get('seconds', 0):.3f}", "status": str(said.get("status", "")),
            **{column: said.get("texts", {}).get(text, "") for column, text in REPORTED.items()},
            "reason": csv_cell(said.get("reason", "")), "key": self._keys[number - 1],
            "checksum": checksum(self._out, files) if files else ""}

    def write_soon(self):
        """Writes the table, unless it was written just now."""
        if time.monotonic() > self._written + _PAUSE:
            self.write()

    def write(self):
        text = io.StringIO()
        writer = csv.DictWriter(text, self._columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(self._rows[number] for number in sorted(self._rows))
        write_whole(self.path, text.getvalue())
        self._written = time.monotonic()
