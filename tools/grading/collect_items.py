"""What was handed in as one, a folder, an archive or a file of a download, and by whom."""

import os
import re

from grading import collect_gradescope
from grading.collect_names import Matcher, letters, read_name
from grading.collect_roster import team_of

_DEEPEST = 3  # folders or archives around those of students


class Item:
    """`students` are those whom it fits; `reading` is what its name says, `trouble` what is wrong with parts
    of it."""

    def __init__(self, parts, files, reading, students):
        self.parts, self.files, self.reading, self.students = parts, files, reading, students
        self.trouble = []

    def __str__(self):
        return "/".join(self.parts)


def wanted(units):
    """Returns a function that says what to read of a folder or archive: units, the headers below their
    folders, and Gradescope's list."""
    def choose_parts(all_parts):
        found = {parts for parts in all_parts if units.unit_in(parts[-1], False)}
        places = {parts[:-1] for parts in found}

        def is_near(parts):
            return any(parts[:count] in places for count in range(max(0, len(parts) - 3), len(parts)))

        return found | {parts for parts in all_parts if parts[-1] == collect_gradescope.NAME
                        or parts[-1].lower().endswith(".h") and is_near(parts)}

    return choose_parts


def _as_pattern(name):
    """Returns a glob that fits this name."""
    return re.sub(r"([*?[])", r"[\1]", name)


def _pattern_for(name, reading, units):
    """Returns a glob that fits this name and, where the platform allows, what this student delivers later. A
    number of Moodle's is of one assignment."""
    if reading.form == "Canvas":
        return f"{_as_pattern(reading.names[0])}*_{reading.ids[0]}_*"
    if reading.form == "Blackboard":
        return f"*_{_as_pattern(reading.logins[-1])}_attempt_*"
    who = "" if reading.form else units.before(re.sub(r"\.\w+$", "", name))
    return _as_pattern(name[:len(who) + 1]) + "*" if who else _as_pattern(name)


class Items:
    """Sorts a download: `items` are somebody's, `faults` sentences on what is nobody's or cannot be read,
    `ignored` names of what is no work. `source` is the download's path."""

    def __init__(self, download, students, units, source):
        self.units, self.students, self._source = units, students, source
        self._matcher = Matcher(students)
        self._groups = {student.group for student in students if student.group}
        self.items, self.faults, self.ignored = [], [], []
        self.unread = {}  # by student: what may be theirs, and was not collected
        for item in self._look(download.files, ()):
            self._sort(item)
        for parts, fault in download.faults:
            self._note(parts, fault)

    def _entries(self, files, prefix):
        """Returns what Gradescope says of the folders in this one."""
        for found in files:
            if found.parts == (*prefix, collect_gradescope.NAME) and found.path:
                with open(found.path, encoding="utf-8", errors="replace") as file:
                    return collect_gradescope.read_metadata(file.read())
        return {}

    def _read(self, parts, files, entry=None):
        """Returns the item of this name."""
        clone = os.path.join(self._source, *parts, ".git")
        reading = read_name(parts[-1], self.units, self._groups, os.path.isdir(clone))
        students = self._matcher.fits(parts[-1], reading)
        if entry and not self._matcher.by_pattern(parts[-1]):
            reading.form, reading.time, students = "Gradescope", entry.time, set()
            for who in entry.submitters:
                email = who.get("email", "")
                fits = self._matcher.who([who.get("sid", "")], [email], [email.partition("@")[0]],
                                         [who.get("name", "")])
                students |= fits
                reading.doubts += len(fits) > 1
        return Item(parts, files, reading, students)

    def _look(self, files, prefix):
        """Returns the items of a folder or archive. Of a folder that holds the work of several, or is the
        only one, they are those in it."""
        children, items = {}, []
        for found in files:
            children.setdefault(found.parts[:len(prefix) + 1], []).append(found)
        entries = self._entries(files, prefix)
        children.pop((*prefix, collect_gradescope.NAME), None)
        for parts, below in children.items():
            item = self._read(parts, below, entries.get(parts[-1]))
            if not item.students and len(below[0].parts) > len(parts) and len(parts) < _DEEPEST:
                inner = self._look(below, parts)
                whose = {student for one in inner for student in one.students}
                if len(whose) > 1 or whose and len(children) == 1:
                    items += inner
                    continue
            items.append(item)
        return items

    def _is_clear(self, item):
        """Whether an item's students are one, or of one group, or those whom Gradescope names."""
        if item.reading.form == "Gradescope":
            return bool(item.students) and not item.reading.doubts
        some = next(iter(item.students), None)
        return bool(some) and item.students <= set(team_of(some, self.students))

    def _has_work(self, item):
        return len(item.files[0].parts) > len(item.parts) or any(
            self.units.unit_in(found.parts[-1], False) or found.parts[-1].lower().endswith(".c")
            for found in item.files)

    def _sort(self, item):
        if self._is_clear(item):
            self.items.append(item)
        elif not self._has_work(item):
            self.ignored.append(str(item))
            self._withhold(item.students, f"{item}: it is one of several students', and no work")
        else:
            who = sorted(map(str, item.students))
            reason = (f"it fits {' and '.join(who[:3])}{' and others' * (len(who) > 3)}" if who else
                      "it fits nobody on the roster")
            self._withhold(item.students or self._of_group(item.reading), f"{item}: {reason}")
            pattern = _pattern_for(item.parts[-1], item.reading, self.units)
            only = "; Moodle's number is another in each assignment" if item.reading.form == "Moodle" else ""
            self.faults.append(f"{item}: {reason}; give the right one a pattern in the roster, such as "
                               f"{pattern}, or add the student to the roster{only}")

    def _of_group(self, reading):
        """Returns the students of the group that a name says."""
        said = {letters(name) for name in (reading.group, *reading.names, *reading.ids) if name}
        return {student for student in self.students if student.group
                and said & {before + letters(student.group) for before in ("", "group", "team")}}

    def _withhold(self, students, reason):
        """Notes, for those whom it may be of, what was not collected."""
        for student in {member for one in students for member in team_of(one, self.students)}:
            self.unread.setdefault(student, []).append(reason)

    def _note(self, parts, fault):
        """A fault of what could not be read, or was left out, is also that of its student."""
        self.faults.append(f"{'/'.join(parts) or 'the download'}: {fault}")
        for item in self.items:
            if parts[:len(item.parts)] == item.parts:
                item.trouble.append(f"{parts[-1]}: {fault}")
                return
        for count in range(1, min(len(parts), _DEEPEST) + 1):
            item = self._read(parts[:count], [])
            if self._is_clear(item):
                self._withhold(item.students, f"{parts[-1]}: {fault}")
                return

    def units_of(self, item):
        """Yields the files of an item that may be units: the file, the student's name for it, the stem, and
        the number behind it."""
        for found in item.files:
            is_alone = len(found.parts) == len(item.parts)
            name = item.reading.rest if is_alone and item.reading.rest else found.parts[-1]
            unit = found.path and self.units.unit_in(name, bool(item.reading.rest) or not is_alone)
            if unit:
                yield found, name, *unit
