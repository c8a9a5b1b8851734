"""Gradescope's submission_metadata.yml: who handed in each folder of an export, and when. Only the lines that
are needed are read, by their indentation, so that no library for YAML is needed."""

import datetime
import re

NAME = "submission_metadata.yml"
_TIME = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:\.\d+)? *(Z|UTC|[+-]\d\d:?\d\d)?$")


class Entry:
    """A submission: when, and a dictionary of name, sid and email for each of its students."""

    def __init__(self):
        self.time, self.submitters = None, []


def _text(value):
    """Returns what stands behind a colon, without quotation marks."""
    value = value.strip()
    if len(value) > 1 and value[0] == value[-1] == "'":
        return value[1:-1].replace("''", "'")
    if len(value) > 1 and value[0] == value[-1] == '"':
        return re.sub(r"\\(?:u([0-9A-Fa-f]{4})|x([0-9A-Fa-f]{2})|(.))",
                      lambda found: chr(int(found[1] or found[2], 16)) if found[1] or found[2] else found[3],
                      value[1:-1])
    return "" if value in ("null", "~") else value


def time_of(text):
    """Returns the time that a YAML timestamp says, in UTC unless it says another zone; None for no time."""
    found = _TIME.match(text.strip())
    if not found:
        return None
    zone = "+0000" if found[3] in (None, "Z", "UTC") else found[3].replace(":", "")
    try:
        return datetime.datetime.strptime(f"{found[1]} {found[2]} {zone}", "%Y-%m-%d %H:%M:%S %z")
    except ValueError:
        return None


def read_metadata(text):
    """Returns a dictionary from the name of each folder to its Entry."""
    entries, entry, inside = {}, None, ""
    for line in text.splitlines():
        found = re.match(r"( *)(- )?:?([^:\s]+|'[^']*'|\"[^\"]*\"):(.*)$", line)
        if not found:
            continue
        depth, key, value = len(found[1]), _text(found[3]).lstrip(":"), _text(found[4])
        if depth == 0 and not found[2]:
            entry = entries[key] = Entry()
            inside = ""
        elif entry is None:
            continue
        elif depth == 2 and not found[2]:
            inside = key
            if key == "created_at":
                entry.time = time_of(value)
        elif inside == "submitters":
            if found[2]:
                entry.submitters.append({})
            if entry.submitters:
                entry.submitters[-1][key] = value
    return entries
