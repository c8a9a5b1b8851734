"""What counts of each student's or group's deliveries, and what the instructor is told of it."""

import filecmp
import re

from grading.collect_choice import Candidate, around_unit, choose, headers_of
from grading.collect_names import plain
from grading.collect_roster import team_of


def some(names):
    """Returns the first of many names, and how many more there are."""
    return ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")


class Submission:
    """Files that count, as a dictionary from their names to where they are read; when the last of them came,
    and how many days late, None if nobody knows, for the reasons `unknown`. `lacking` says what was not
    collected; `delivered` are the names, by student, of what each has handed in, by which platforms take
    feedback back."""

    def __init__(self, team, deadline):
        self.deadline = deadline.of(team)
        self.team, self.files, self.remarks, self.lacking, self.unknown = team, {}, [], [], []
        self.time, self.days, self.delivered = None, 0, {}

    def add(self, one, headers):
        """Takes a unit with its headers; returns the names of those that another unit has with other text."""
        twice = [name for name, path in headers.items()
                 if name in self.files and not filecmp.cmp(path, self.files[name], shallow=False)]
        self.files.update(headers, **{one.stem + ".c": one.found.path})
        self.time = max(filter(None, (self.time, one.time)), default=None)
        self.days = None if None in (one.days, self.days) else max(one.days, self.days)
        return twice


def _headers_around(one, items):
    """Returns the headers that a unit may include, and what they were called: those around it or, where the
    platform renames each file, the student's others."""
    if not one.item.reading.rest:
        return around_unit(one, one.item.files)
    beside, called = {}, {}
    for item in sorted(items, key=lambda item: item.reading.serial):
        name = re.sub(r"(-\d+|[ _]?\(\d+\))+\.h$", ".h", plain(item.reading.rest))
        same = (item.reading.form, item.reading.time) == (one.item.reading.form, one.item.reading.time)
        if name.endswith(".h") and same and item.files[0].path:
            beside[name], called[name] = item.files[0].path, plain(item.reading.rest)
    return beside, called


def _delivered(items, chosen):
    """Returns a dictionary from students to the name of their own delivery: the platform's last one, which is
    the one that it shows, else the one that counts."""
    names = {}
    for item in sorted(items, key=lambda item: (item.reading.serial, item in chosen)):
        names.update(dict.fromkeys(item.students, item.parts[-1]))
    return names


def _submission_of(team, items, sorted_items, times, deadline):
    """Returns what counts of a team's items. Adds to the faults of all items."""
    submission, candidates, faults = Submission(team, deadline), {}, []
    deadline = submission.deadline
    for item in items:
        for found, name, stem, again in sorted_items.units_of(item):
            one = Candidate(item, found, stem, name, again, *times.of(item, found, deadline))
            candidates.setdefault(stem, []).append(one)
    sources, chosen = [], []
    for stem, some in sorted(candidates.items()):
        one, fault, remarks = choose(some, stem, deadline)
        submission.remarks += remarks
        submission.lacking += [fault] if fault else []
        if one is None:
            continue
        around, called = _headers_around(one, items)
        headers = headers_of(one, around)
        submission.remarks += [f"{name} was {called[plain(name)]}" for name in headers
                               if called[plain(name)] != plain(name)]
        faults += [f"there are two {name} of different text; the one beside {stem}.c was taken"
                   for name in submission.add(one, headers)]
        sources.append(one.source)
        chosen.append(one.item)
        if len(team) > 1:
            sources += [f"handed in by {student.name or student.id}" for student in one.item.students]
        if one.days is None:
            submission.unknown.append(one.source)
    submission.delivered = _delivered(items, chosen)
    if not candidates:
        names = list(dict.fromkeys(found.parts[-1] for item in items for found in item.files))
        stems = sorted_items.units.stems
        wanted = " or ".join(stem + ".c" for stem in stems) if len(stems) < 4 else "C file of an assignment"
        more = f" and {len(names) - 4} more" if len(names) > 4 else ""
        submission.lacking.append(f"handed in, but no {wanted}; found: {', '.join(names[:4])}{more}")
    sorted_items.faults += [f"{team[0]}: {fault}" for fault in [*submission.lacking, *faults]]
    trouble = [fault for item in items for fault in item.trouble]
    if all(stem + ".c" in submission.files for stem in sorted_items.units.stems):
        faults += trouble
    else:
        submission.lacking += trouble
    if any(student.due for student in team):
        sources.append(f"due {deadline.due:%Y-%m-%d %H:%M %z}, as the roster says")
    sources += ["days_late as the roster says"] if deadline.given is not None else []
    submission.remarks += [*faults, *dict.fromkeys(sources)]
    return submission


def submissions_of(sorted_items, times, deadline):
    """Returns a dictionary from students to what counts of their work. Adds to the faults of the items."""
    teams = {}
    for item in sorted_items.items:
        for student in sorted(item.students, key=sorted_items.students.index):
            items = teams.setdefault(tuple(team_of(student, sorted_items.students)), [])
            items += [item] if item not in items else []
    found = {}
    for team, items in teams.items():
        found.update(dict.fromkeys(team, _submission_of(team, items, sorted_items, times, deadline)))
    return found


def faults_of_time(rows, submissions):
    """Returns sentences on whose days late nobody knows, with the reasons. `submissions` are by id."""
    whose = {}
    for row in rows:
        unknown = submissions[row["id"]].unknown if row["id"] in submissions else []
        for source in dict.fromkeys(unknown if row["days_late"] == "?" else []):
            whose.setdefault(source, []).append(f"{row['name']} ({row['id']})")
    return [f"how many days late they are, nobody knows ({source}): {some(who)}; write it for each ? of "
            "days_late in collected.csv, or into the roster" for source, who in whose.items()]
