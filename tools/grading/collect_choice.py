"""Which of the files that a student, or a group, has delivered counts: the last one in time, else the last
one that is taken; never one of two that cannot be told apart."""

import hashlib
import os
import posixpath
import re

from grading.collect_names import plain

_INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]*"([^"\n]+\.h)"', re.MULTILINE)


class Candidate:
    """A unit in a delivered item. `name` is what the student called it, `time` when it came, or None,
    `source` by what that is known; `order` is the platform's number, then that behind the name."""

    def __init__(self, item, found, stem, name, again, time, source):
        self.item, self.found, self.stem, self.name = item, found, stem, name
        self.time, self.source = time, source
        self.order = (item.reading.serial, again)
        self.days = None  # late; None: nobody knows

    def digest(self):
        with open(self.found.path, "rb") as file:
            return hashlib.sha256(file.read()).digest()


def _only(candidates, what):
    """Returns the one of these that is meant, and a fault if nobody knows."""
    if len({one.digest() for one in candidates}) == 1:
        return candidates[0], ""
    names = ", ".join(str(one.found) for one in candidates[:4])
    return None, f"{what}: {names}; keep the right one in a copy of the download, and collect that"


def in_one_item(candidates, stem):
    """Of units in one folder or archive that was handed in as a whole: the one by its plain name, at the top,
    or in the workbook of a whole pack. Returns it and a fault."""
    def depth(one):
        return len(one.found.parts)

    for chosen in ([one for one in candidates if one.found.parts[-2:-1] == ("workbook",)],
                   [one for one in candidates if one.name == stem + ".c"], candidates):
        top = [one for one in chosen if depth(one) == min(map(depth, chosen))]
        if top:
            return _only(top, f"there are several {stem}.c")
    return None, ""


def choose(candidates, stem, deadline):
    """Returns the one that counts, a fault if nobody knows, and remarks."""
    for one in candidates:
        if one.time is not None:
            one.days = deadline.days_late(one.time)
        elif one.item.reading.late is False or deadline.due is None:
            one.days = 0
    taken = [one for one in candidates if one.days is None or deadline.takes(one.days)]
    if not taken:
        days = min(one.days for one in candidates)
        return None, "", [f"{stem}.c came {days} day{'s' * (days != 1)} late, so it was not taken"]
    eligible = [one for one in taken if one.days == 0] or taken
    if all(one.time is not None for one in eligible):
        last = max(one.time for one in eligible)
        # Of files of the same minute the platform's number decides.
        eligible = [one for one in eligible if (last - one.time).total_seconds() < 60]
    eligible = [one for one in eligible if one.order == max(other.order for other in eligible)]
    one, fault = _only(eligible, f"nobody knows which {stem}.c is the last one")
    if one is None:
        return None, fault, []
    remarks = [] if one.name == stem + ".c" else [f"{stem}.c was {one.name}"]
    later = [other for other in candidates if other is not one and other.days
             and (one.time is None or other.time is None or other.time > one.time)]
    remarks += [f"a later {stem}.c was not taken"] if later and not one.days else []
    others = len(candidates) - 1 - len(later)
    remarks += [f"the last {stem}.c of {others + 1}"] if others > 0 else []
    return one, "", remarks


def headers_of(candidate, around):
    """Returns a dictionary from relative names to paths of the headers beside a unit that it includes,
    directly or by others; `around` are those that can be had."""
    found, waiting = {}, [("", candidate.found.path)]
    while waiting:
        place, path = waiting.pop()
        with open(path, "rb") as file:
            text = file.read()
        for name in _INCLUDE.findall(text):
            name = posixpath.normpath(posixpath.join(place, name.decode("utf-8", "surrogateescape")))
            key = plain(name)
            if not name.isprintable() or key not in around or key in found:
                continue
            found[key] = (name, around[key])
            waiting.append((posixpath.dirname(name), around[key]))
    return dict(found.values())


def around_unit(candidate, files):
    """Returns a dictionary from the names of headers below a unit's folder, as seen from there, to paths."""
    place = candidate.found.parts[:-1]
    return {plain("/".join(found.parts[len(place):])): found.path for found in files
            if found.path and found.parts[:len(place)] == place and found.parts[-1].lower().endswith(".h")
            and os.path.isfile(found.path)}
