"""The deadline of an assignment, and how late a submission is."""

import copy
import datetime
import os
import re
import subprocess

from grading.assignments import ToolError

_DAY = datetime.timedelta(days=1)
_SAME = datetime.timedelta(minutes=10)  # what all came within them is a download


def _number(name, text, unit):
    if not text:
        return None
    if not re.fullmatch(r"\d{1,4}(\.\d{1,3})?", text):
        raise ToolError(f"{name}={text}: write a number of {unit}, such as {name}=2")
    return float(text)


def moment_of(text):
    """Returns the time that a deadline says, without its zone, and the zone, None if it says none. Raises
    ValueError if it is no such time."""
    found = re.fullmatch(r"(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d)(:\d\d)? ?(Z|[+-]\d\d:?\d\d)?", text.strip())
    if not found:
        raise ValueError(text)
    zone = "" if not found[4] else "+0000" if found[4] == "Z" else found[4].replace(":", "")
    # A deadline of 23:59 ends with that minute.
    time = datetime.datetime.fromisoformat(f"{found[1]} {found[2]}{found[3] or ':59'}")
    return time, datetime.datetime.strptime(zone, "%z").tzinfo if zone else None


class Deadline:
    """DUE, a time with its zone; GRACE, hours after it that are not late; UNTIL, the last day late, from the
    end of these on, that is taken. Without DUE nothing is late."""

    def __init__(self, due="", grace="", until=""):
        self.due, self.zone, self.given = None, None, None
        self.grace = datetime.timedelta(hours=_number("GRACE", grace, "hours") or 0)
        self.until = _number("UNTIL", until, "days")
        if not due:
            if grace or until:
                raise ToolError(f"{'GRACE' if grace else 'UNTIL'} counts from the deadline; say that, too: "
                                'DUE="2026-10-05 23:59 +0200"')
            return
        try:
            time, self.zone = moment_of(due)
        except ValueError as error:
            raise ToolError(f'DUE={due}: write the date, the time and the zone, such as '
                            'DUE="2026-10-05 23:59 +0200"') from error
        self.due = self.with_zone(time)

    def with_zone(self, time):
        """Returns a time in the deadline's zone, or in this machine's. One that says no zone is taken as of
        that zone."""
        if time is None:
            return None
        if time.tzinfo is None:
            return time.replace(tzinfo=self.zone) if self.zone else time.astimezone()
        return time.astimezone(self.zone)

    def days_late(self, time):
        """Returns the number of days that have begun since the deadline and its grace, or what the roster
        says."""
        if self.due is None or self.given is not None:
            return self.given or 0
        over = self.with_zone(time) - self.due - self.grace
        return max(0, -(-over // _DAY))

    def takes(self, days):
        return self.until is None or self.given is not None or days <= self.until

    def of(self, team):
        """Returns the deadline of these students: the latest of theirs and, of those without one, of all; and
        as days late the fewest that the roster gives one of them."""
        own = copy.copy(self)
        own.given = min((int(student.days_late) for student in team if student.days_late), default=None)
        moments = [moment_of(student.due) for student in team if student.due]
        dues = [time.replace(tzinfo=zone) if zone else self.with_zone(time) for time, zone in moments]
        if dues:
            own.due = max(dues + [self.due] * (self.due is not None and len(dues) < len(team)))
            own.zone = own.due.tzinfo
        return own

    def __str__(self):
        grace = f", with {self.grace.total_seconds() / 3600:g} hours of grace" if self.grace else ""
        until = "" if self.until is None else f", taken up to {self.until:g} days late"
        return f"{self.due:%Y-%m-%d %H:%M %z}{grace}{until}" if self.due else "none"

    def zone_taken(self):
        """Returns a sentence on the zone if DUE says none."""
        return "" if self.zone or not self.due else (
            f"DUE says no time zone, so it was taken in this machine's, {self.due:%z}")


def _commit_time(folder):
    """Returns when the last commit of a clone was made, or None."""
    command = ["git", "--no-pager", "-c", "safe.directory=*", "-c", "core.fsmonitor=false", "-c",
               "log.showSignature=false", "-C", folder, "log", "-1", "--format=%ct"]
    try:
        said = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20,
                              check=False).stdout.strip()
    except (OSError, subprocess.TimeoutExpired):
        return None
    if not re.fullmatch(r"\d{1,10}", said):
        return None
    return datetime.datetime.fromtimestamp(int(said), datetime.timezone.utc)


class Times:
    """When items of a download were handed in, and by what that is known."""

    def __init__(self, source, deadline, items):
        self._source, self._deadline, self._is_download = source, deadline, False
        times = [time for item in items for time, _, is_sure in [self._of(item, item.files[0])]
                 if time and not is_sure]
        # Some platforms give all files the time of the download. Before the deadline that does no harm.
        if deadline.due and len(times) > 1:
            self._is_download = max(times) - min(times) < _SAME and deadline.days_late(min(times)) > 0

    def _of(self, item, found):
        """Returns a time, what it is of, and whether that is more than what an archive or a folder says."""
        reading, place = item.reading, os.path.join(self._source, *item.parts)
        if reading.time:
            says = "Gradescope's time" if reading.form == "Gradescope" else "the time in its name"
            return self._deadline.with_zone(reading.time), says, True
        if reading.form == "Canvas":  # whose archives have the time of the download (canvas-lms, issue 2219)
            return None, "Canvas's mark LATE" if reading.late else "Canvas, which does not call it late", True
        if os.path.isdir(os.path.join(place, ".git")):
            says = "the time of its last commit, which the author can choose"
            return self._deadline.with_zone(_commit_time(place)), says, True
        on_disk = os.path.isdir(self._source) and found.times[0][0] >= len(item.parts)
        time = self._deadline.with_zone(found.time_below(len(item.parts)))
        return time, "the file's time" if on_disk else "the archive's time", False

    def of(self, item, found, deadline):
        """Returns when a file of an item was handed in, None if nobody knows, and by what that is known.
        `deadline` is the student's."""
        time, says, is_sure = self._of(item, found)
        if is_sure or not self._is_download or deadline.due and not deadline.days_late(time):
            return time, f"by {says}" if time or is_sure else "no time is known"
        return None, "all have the time of the download, so none is known"
