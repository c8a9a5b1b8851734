"""What counts of each student's or group's deliveries, and what the instructor is told of it."""

import filecmp
import re

from grading.collect_choice import Candidate, around_unit, choose, headers_of, in_one_item
from grading.collect_names import plain
from grading.collect_roster import team_of


class Submission:
    """Files that count, as a dictionary from their names to where they are read; when the last of them came,
    and how many days late, None if nobody knows."""

    def __init__(self, team):
        self.team, self.files, self.remarks = team, {}, []
        self.time, self.days = None, 0

    def add(self, one, headers):
        """Takes a unit with its headers; returns the names of those that another unit has with other text."""
        twice = [name for name, path in headers.items()
                 if name in self.files and not filecmp.cmp(path, self.files[name], shallow=False)]
        self.files.update(headers, **{one.stem + ".c": one.found.path})
        self.time = max(filter(None, (self.time, one.time)), default=None)
        self.days = None if None in (one.days, self.days) else max(one.days, self.days)
        return twice


def _headers_around(one, items):
    """Returns the headers that a unit may include: those around it or, where the platform renames each file,
    the student's others."""
    if not one.item.reading.rest:
        return around_unit(one, one.item.files)
    beside = {}
    for item in sorted(items, key=lambda item: item.reading.serial):
        name = re.sub(r"(-\d+|[ _]?\(\d+\))+\.h$", ".h", plain(item.reading.rest))
        same = (item.reading.form, item.reading.time) == (one.item.reading.form, one.item.reading.time)
        if name.endswith(".h") and same and item.files[0].path:
            beside[name] = item.files[0].path
    return beside


def _submission_of(team, items, sorted_items, times, deadline):
    """Returns what counts of a team's items, and the faults that the instructor has to look at."""
    submission, candidates, faults = Submission(team), {}, []
    for item in items:
        units = {}
        for found, name, stem, again in sorted_items.units_of(item):
            one = Candidate(item, found, stem, name, again, *times.of(item, found))
            units.setdefault(stem, []).append(one)
        for stem, some in units.items():
            one, fault = in_one_item(some, stem)
            candidates.setdefault(stem, []).extend([one] if one else [])
            faults += [fault] if fault else []
        submission.remarks += item.trouble
    sources = []
    for stem, some in sorted(candidates.items()):
        one, fault, remarks = choose(some, stem, deadline) if some else (None, "", [])
        submission.remarks += remarks
        faults += [fault] if fault else []
        if one is None:
            continue
        faults += [f"there are two {name} of different text; the one beside {stem}.c was taken"
                   for name in submission.add(one, headers_of(one, _headers_around(one, items)))]
        sources.append(one.source)
        if len(team) > 1:
            sources += [f"handed in by {student.name or student.id}" for student in one.item.students]
        if one.days is None:
            faults.append(f"{one.found}: how many days late it is, nobody knows ({one.source}); write it for "
                          "the ? in collected.csv")
    if not candidates:
        names = list(dict.fromkeys(found.parts[-1] for item in items for found in item.files))
        wanted = " or ".join(stem + ".c" for stem in sorted_items.units.stems[:3])
        faults.append(f"handed in, but no {wanted}; found: {', '.join(names[:4])}")
    submission.remarks += [*faults, *dict.fromkeys(sources)]
    return submission, faults


def submissions_of(sorted_items, times, deadline):
    """Returns a dictionary from students to what counts of their work. Adds to the faults of the items."""
    teams = {}
    for item in sorted_items.items:
        for student in sorted(item.students, key=sorted_items.students.index):
            items = teams.setdefault(tuple(team_of(student, sorted_items.students)), [])
            items += [item] if item not in items else []
    found = {}
    for team, items in teams.items():
        submission, faults = _submission_of(team, items, sorted_items, times, deadline)
        sorted_items.faults += [f"{team[0]}: {fault}" for fault in faults]
        found.update(dict.fromkeys(team, submission))
    return found
