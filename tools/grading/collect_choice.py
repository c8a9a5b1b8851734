"""Which of the files that a student, or a group, has delivered counts: the last one in time, else the last
one that is taken; never one of two that cannot be told apart."""

import hashlib
import os
import posixpath
import re

from grading.collect_names import AGAIN, plain

_INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]*"([^"\n]+\.h)"', re.MULTILINE)


class Candidate:
    """A unit in a delivered item. `name` is what the student called it, `time` when it came, or None,
    `source` by what that is known; `serial` is the platform's number, `again` that behind the name."""

    def __init__(self, item, found, stem, name, again, time, source):
        self.item, self.found, self.stem, self.name = item, found, stem, name
        self.time, self.source = time, source
        self.serial, self.again = item.reading.serial, again
        self.days = None  # late; None: nobody knows

    def digest(self):
        with open(self.found.path, "rb") as file:
            return hashlib.sha256(file.read()).digest()


def _below(one):
    """Returns a unit's name within what was handed in as one."""
    return "/".join(one.found.parts[len(one.item.parts):]) or one.found.parts[-1]


def _series(one):
    """What bloom.c and bloom (1).c of one folder share: browsers and platforms that find a name taken put a
    number behind the later one."""
    return one.found.parts[:-1], re.sub(rf"{AGAIN}\.c(\.txt)?$", "", plain(one.found.parts[-1]))


def _without_kits(candidates):
    """A whole pack holds the kit's files in folders beside the workbook; these are nobody's work."""
    def is_own(one):
        return one.found.parts[-2:-1] == ("workbook",)

    packs = {one.found.parts[:-2] for one in candidates if is_own(one)}
    return [one for one in candidates if is_own(one) or not any(
        one.found.parts[:count] in packs for count in range(len(one.found.parts) - 1))]


def _last(candidates, stem):
    """Returns the one that came last, a fault if nobody knows, and a remark if its name alone says so."""
    if all(one.time is not None for one in candidates):
        last = max(one.time for one in candidates)
        candidates = [one for one in candidates if (last - one.time).total_seconds() < 60]
    candidates = [one for one in candidates if one.serial == max(other.serial for other in candidates)]
    if len({one.digest() for one in candidates}) == 1:
        return min(candidates, key=lambda one: (one.name != stem + ".c", len(one.found.parts))), "", ""
    most = [one for one in candidates if one.again == max(other.again for other in candidates)]
    if len(set(map(_series, candidates))) == 1 and len({one.digest() for one in most}) == 1:
        return most[0], "", f"no times tell which {stem}.c is the last one; the highest number was taken"
    names = ", ".join(str(one.found) for one in candidates[:4])
    return None, (f"{stem}.c: nobody knows which of several {stem}.c is the last one: {names}; keep the "
                  "right one in a copy of the download, and collect that"), ""


def choose(candidates, stem, deadline):
    """Returns the one that counts, a fault if nobody knows, and remarks, which name those that do not."""
    candidates = _without_kits(candidates)
    for one in candidates:
        if one.time is not None or deadline.given is not None:
            one.days = deadline.days_late(one.time)
        elif one.item.reading.late is False or deadline.due is None:
            one.days = 0
    taken = [one for one in candidates if one.days is None or deadline.takes(one.days)]
    if not taken:
        days = min(one.days for one in candidates)
        return None, "", [f"{stem}.c came {days} day{'s' * (days != 1)} late, so it was not taken"]
    one, fault, remark = _last([one for one in taken if one.days == 0] or taken, stem)
    if one is None:
        return None, fault, []
    remarks = [remark] if remark else []
    remarks += [] if one.name == stem + ".c" else [f"{stem}.c was {one.name}"]
    others = [other for other in candidates if other.digest() != one.digest()]
    later = [other for other in others if other.days and (
        one.time is None or other.time is None or other.time > one.time)]
    for kind, some in (("a later", later), ("another", [other for other in others if other not in later])):
        names = ", ".join(map(_below, some))
        remarks += [f"{kind} {stem}.c was not taken: {names}"] if some else []
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
    """Returns a dictionary from the names of headers below a unit's folder, as seen from there, to paths, and
    one to what they were called: own (1).h is a later own.h if its time does not say otherwise."""
    place, depth, series = candidate.found.parts[:-1], len(candidate.item.parts), {}
    for found in files:
        name = plain("/".join(found.parts[len(place):]))
        if found.path and found.parts[:len(place)] == place and name.endswith(".h") \
                and os.path.isfile(found.path):
            number = re.search(r"[ _]?\((\d+)\)\.h$", name)
            time = found.time_below(depth)
            upload = (int(number[1]) if number else 0, time and time.timestamp(), name, found)
            for key in {name, name[:number.start()] + ".h" if number else name}:
                series.setdefault(key, []).append(upload)
    headers, called = {}, {}
    for key, uploads in series.items():
        last = max(time or 0 for _, time, _, _ in uploads)
        if all(time for _, time, _, _ in uploads):
            uploads = [upload for upload in uploads if last - upload[1] < 60]
        _, _, name, found = max(uploads, key=lambda upload: upload[0])
        headers[key], called[key] = found.path, name
    return headers, called
