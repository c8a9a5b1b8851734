"""Whose is a delivered file? The forms of names that Moodle, Canvas, Blackboard and others give to downloads,
and who on the roster fits one. It never guesses: who fits only in part does not fit.

Sources of the forms: Canvas's lib/content_zipper.rb (get_filename, sanitize_user_name); Moodle's mod/assign
(prefix of a participant's files); for Blackboard, kwurst/bb-file-cleanup's README."""

import datetime
import fnmatch
import re
import unicodedata

_MOODLE = re.compile(r"(?P<name>.+?)_(?P<number>\d+)_assignsubmission_[a-z]+(?:_(?P<rest>.*))?")
_CANVAS = re.compile(r"(?P<name>.+?)(?P<late>_LATE)?_(?P<id>\d+)_"
                     r"(?:(?P<serial>\d+)_(?P<rest>.+)|(?:text|link)\.html)")
_BLACKBOARD = re.compile(r"(?P<login>.+)_attempt_(?P<time>\d{4}(?:-\d\d){5})(?:_(?P<rest>.+)|\.txt)?")
_ENDING = re.compile(r"\.(zip|tar|tgz|7z|rar|tar\.\w+|c|c\.txt|h)$", re.IGNORECASE)
AGAIN = r"(?:-\d+|[ _]?\(\d+\))*"  # what Canvas and browsers put behind a name that is there already
_APART = {"ä": "ae", "ö": "oe", "ü": "ue", "ø": "oe", "å": "aa", "æ": "ae", "đ": "d", "ł": "l"}


def plain(text):
    """Returns a text in one of the ways in which Unicode writes it, in small letters, without marks of
    direction and other characters that nobody sees."""
    text = unicodedata.normalize("NFC", text)
    return "".join(char for char in text if unicodedata.category(char) not in ("Cf", "Cc")).casefold().strip()


def letters(text):
    """Returns a text as names are compared: its letters and digits alone."""
    return "".join(char for char in plain(text) if char.isalnum() or unicodedata.category(char)[0] == "M")


def _without_accents(text):
    text = unicodedata.normalize("NFKD", text)
    return "".join(char for char in text if unicodedata.category(char)[0] != "M")


def _forms_of(name):
    """A name's words in a row, from each of them on: masonann and annmason for Ann Mason, or Mason, Ann."""
    words = [word for word in map(letters, re.split(r"[\s,]+", name)) if word]
    return {"".join(words[first:] + words[:first]) for first in range(len(words))}


class UnitNames:
    """The names of the files that are collected: STEM.c, as hands, browsers and platforms change it."""

    def __init__(self, stems):
        self.stems = sorted(stems, key=len, reverse=True)  # the longest that fits counts
        names = "|".join(map(re.escape, self.stems))
        self._file = re.compile(rf"(?P<before>.*?)(?P<stem>{names})(?P<again>{AGAIN})\.c(?:\.txt)?",
                                re.IGNORECASE | re.DOTALL)
        self._behind = re.compile(rf"(?P<who>.+?)[ _-]+(?:{names})", re.IGNORECASE | re.DOTALL)

    def unit_in(self, name, alone):
        """Returns the stem that a file's name says, and the number behind it; None for no unit. `alone`:
        nothing may stand before it."""
        found = self._file.fullmatch(plain(name))
        before = found and found["before"]
        if not found or before and (alone or before[-1] not in " _-"):
            return None
        return found["stem"], max(map(int, re.findall(r"\d+", found["again"])), default=0)

    def before(self, text):
        """Returns what stands before a stem at the end of a text, or None."""
        found = self._behind.fullmatch(text)
        return found and found["who"]


class Reading:
    """What the name of a delivered item says: candidates for a student's id, address, login and name, each
    with the longest first; when it came; whether it was late; its number in the platform's order; and the
    file's own name, if the item is a file that the platform has renamed. `group` is that of the student."""

    def __init__(self, form, ids=(), logins=(), names=(), time=None, late=None, serial=0, rest="", group=""):
        self.form, self.ids, self.logins, self.names = form, ids, logins, names
        self.time, self.late, self.serial, self.rest = time, late, serial, rest
        self.group, self.doubts = group, 0  # submitters who fit several students


def _suffixes(text, mark):
    parts = text.split(mark)
    return [mark.join(parts[first:]) for first in range(len(parts))]


def read_name(name, units, groups=(), is_clone=False):
    """Returns the Reading of an item's name."""
    name = unicodedata.normalize("NFC", name).translate({ord(char): None for char in name
                                                         if unicodedata.category(char) == "Cf"})
    found = _MOODLE.fullmatch(name)
    if found:
        # In a course with groups, the group stands before the name.
        group = next((group for group in groups if found["name"].startswith(group + "-")), None)
        who = found["name"][len(group) + 1:] if group else found["name"]
        return Reading("Moodle", names=[who], rest=found["rest"] or "", group=group or "")
    found = _BLACKBOARD.fullmatch(name)
    if found:
        try:
            time = datetime.datetime(*map(int, found["time"].split("-")))
        except ValueError:
            time = None
        logins = _suffixes(found["login"], "_")
        return Reading("Blackboard", ids=logins, logins=logins, time=time, rest=found["rest"] or "")
    found = _CANVAS.fullmatch(name)
    if found:
        return Reading("Canvas", ids=[found["id"]], names=[found["name"]], late=bool(found["late"]),
                       serial=int(found["serial"] or 0), rest=found["rest"] or "")
    base = _ENDING.sub("", name)
    base = re.sub(rf"{AGAIN}$", "", base) if base != name else name
    whole = list(filter(None, [base, units.before(base)]))
    parts = [part for text in whole for part in re.split(" - |_", text)]
    if is_clone:
        whole += _suffixes(base, "-")[1:]
    return Reading("", ids=whole + [part for part in parts if len(part) > 3], logins=whole,
                   names=whole + [part for part in parts if " " in part.strip()])


class Matcher:
    """Finds the students whom a name fits."""

    def __init__(self, students):
        self._keys = {"id": {}, "email": {}, "login": {}, "name": {}, "accents": {}}
        self._patterns = [(student, re.compile(fnmatch.translate(plain(student.pattern))))
                          for student in students if student.pattern]
        for student in students:
            if student.pattern:
                continue  # by it alone
            self._add("id", student.id, student)
            self._add("email", student.email, student)
            self._add("login", student.login(), student)
            for form in _forms_of(student.name):
                self._add("name", form, student)
                self._add("accents", _without_accents(form), student)
                self._add("accents", "".join(_APART.get(char, char) for char in form), student)

    def _add(self, kind, key, student):
        if key:
            self._keys[kind].setdefault(plain(key), set()).add(student)

    def _first(self, kind, candidates, change=plain):
        keys = self._keys[kind]
        return next((keys[key] for key in map(change, candidates) if key in keys), set())

    def by_pattern(self, name):
        """Returns the students whose pattern fits."""
        text = plain(name)
        return {student for student, pattern in self._patterns if pattern.match(text)}

    def fits(self, name, reading):
        """Returns the set of students whom a name fits: by a pattern; else those whom all that is known of
        them fits, or, where it contradicts itself, all whom a part fits."""
        by_pattern = self.by_pattern(name)
        if by_pattern:
            return by_pattern
        return self.who(reading.ids, [*reading.ids, *reading.logins], reading.logins, reading.names)

    def who(self, ids, emails, logins, names):
        """The same for candidates of each kind."""
        by_name = self._first("name", names, letters)
        hits = [self._first("id", ids), self._first("email", emails), self._first("login", logins),
                by_name or self._first("accents", names, lambda text: _without_accents(letters(text)))]
        hits = [found for found in hits if found]
        return (set.intersection(*hits) or set.union(*hits)) if hits else set()
