"""What collect wrote, kept in a file beside it: so that what was corrected there since then stays when the
same is collected again."""

import hashlib
import json
import os
import stat

from grading.assignments import ToolError
from grading.results import csv_cell, text_of_cell

RECORD = ".collected.json"
_CELLS = ("submission", "submitted", "days_late", "delivered")
_REMARKS = "remarks"


def _digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def _as_read(cell):
    """Returns a cell as it is when it is read again."""
    return text_of_cell(csv_cell(cell)).strip()


def record_of(rows, submissions, stems):
    """Returns what RECORD has to say of these rows, dictionaries, and of these submissions, from their names
    to dictionaries of files."""
    return {"assignments": stems,
            "rows": {row["id"]: {name: _as_read(row[name]) for name in (*_CELLS, _REMARKS)} for row in rows},
            "files": {f"{name}/{file}": _digest(path) for name, files in submissions.items()
                      for file, path in files.items()}}


def _remark(row, text):
    remarks = row[_REMARKS]
    row[_REMARKS] = "; ".join(filter(None, ("" if remarks == "missing" and row["submission"] else remarks,
                                            text)))


class Corrections:
    """What was corrected in the folder OUT since collect wrote it: `rows`, what its table says, `files`, from
    names such as 1001/bloom.c to paths. `told` are sentences on what is kept, `faults` those on what the
    instructor has to look at. `old` are the table's rows, None if there is no such folder."""

    def __init__(self, out, old):
        self.told, self.faults, self.files, self._out = [], [], {}, out
        self._old = {row["id"]: row for row in old or []}
        self._record = {"assignments": [], "rows": {}, "files": {}} if old is None else self._read()
        for folder in sorted({row["submission"] for row in old or []} & set(os.listdir(out) if old else [])):
            for where, _, names in os.walk(os.path.join(out, folder)):
                for path in (os.path.join(where, name) for name in sorted(names)):
                    self._look_at(path)

    def _read(self):
        try:
            with open(os.path.join(self._out, RECORD), encoding="utf-8") as file:
                record = json.load(file)
            return {"assignments": [*record["assignments"]], "rows": {**record["rows"]},
                    "files": {**record["files"]}}
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ToolError(f"OUT: {self._out} has no {RECORD} that can be read, so nobody knows what was "
                            "corrected there by hand; choose another OUT, or say AGAIN=yes, which discards "
                            "corrections") from error

    def _look_at(self, path):
        name = os.path.relpath(path, self._out)
        if not stat.S_ISREG(os.lstat(path).st_mode):
            raise ToolError(f"OUT: {path} is no plain file; move it away")
        if _digest(path) != self._record["files"].get(name):
            self.files[name] = path

    def _written(self, id):
        return self._record["rows"].get(id, {})

    def _corrected(self, id):
        """Returns the names of the cells that were corrected."""
        row, written = self._old.get(id, {}), self._written(id)
        return [name for name in _CELLS if name in row and row[name].strip() != written.get(name, "")]

    def check(self, stems):
        """Raises ToolError if this is of other assignments."""
        before = self._record["assignments"]
        if before != stems and (self.files or any(map(self._corrected, self._old))):
            raise ToolError(f"OUT: {self._out} was collected for {', '.join(before)}, and corrected by hand "
                            f"since; choose another OUT for {', '.join(stems)}, or say AGAIN=yes, which "
                            "discards corrections")

    def put_into(self, rows, submissions, stems, ruled):
        """Puts them into rows and submissions; returns what RECORD has to say. `ruled` are the ids of those
        whose days_late the roster says."""
        record = record_of(rows, submissions, stems)
        for row in rows:
            for name in self._corrected(row["id"]):
                if name != "days_late" or row["id"] not in ruled:
                    self._keep(row, name)
        for name, path in self.files.items():
            self._keep_file(name, path, rows, submissions, record["files"].get(name))
        known = {row["id"] for row in rows}
        self.faults += [f"{id} is not on the roster, so the row that was corrected by hand was left out"
                        for id in self._old if id not in known and self._corrected(id)]
        for row in rows:
            record["rows"][row["id"]][_REMARKS] = _as_read(row[_REMARKS])
            written = self._written(row["id"]).get(_REMARKS, "").split("; ")
            own = self._old.get(row["id"], {}).get(_REMARKS, "").strip().split("; ")
            row[_REMARKS] = "; ".join(filter(None, [*(part for part in own if part not in written),
                                                    row[_REMARKS]]))
        return record

    def _keep(self, row, name):
        old, computed = self._old[row["id"]][name].strip(), _as_read(row[name])
        if old == computed:
            return
        text = f"{row['name']} ({row['id']}): {name} was corrected by hand, and stays {old or 'empty'}"
        if computed != self._written(row["id"]).get(name, ""):
            self.faults.append(f"{text}; from this download it would be {computed or 'empty'}")
        else:
            self.told.append(text)
        row[name] = old
        _remark(row, f"{name} was corrected by hand")

    def _keep_file(self, name, path, rows, submissions, collected):
        """`collected` is the digest of what was now collected in place of this file."""
        folder, _, below = name.partition("/")
        whose = [row for row in rows if row["submission"] == folder]
        if not whose:
            whose = [row for row in rows if not row["submission"]
                     and self._old.get(row["id"], {}).get("submission") == folder]
            for row in whose:
                row.update({cell: self._old[row["id"]].get(cell, "") for cell in _CELLS})
        if not whose:
            raise ToolError(f"OUT: {path} was changed by hand, and no student on the roster has that folder "
                            "now; move it away")
        submissions.setdefault(folder, {})[below] = path
        text = f"{path} was changed by hand, and stays; AGAIN=yes collects it anew"
        if collected in (None, self._record["files"].get(name)):
            self.told.append(text)
        else:
            self.faults.append(f"{text}, as a text that was handed in since")
        for row in whose:
            _remark(row, f"{below} was changed by hand")
