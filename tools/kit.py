"""Has a submission changed what others are graded with? What grading stands on is looked at before
and after it: a unit runs as the user who grades, and can write whatever that user can."""

import os

from assignments import ToolError

_FOLDERS = ("tools", "tests", "assignments", "src")
_FILES = ("Makefile", "Makefile.am", "librktest.a", "librkbase.a", "impl/toolchain")
_OF_OTHERS = (".log", ".trs")  # written by make check, which may run at the same time


class KitChanged(ToolError):
    """No verdict since the last look can be believed."""


def state(toolchain, *places):
    """Returns a dictionary from path to what changes with the file, for the kit and these folders. The
    change time is the system's, so a unit cannot set it back."""
    found = {}

    def look(path):
        try:
            status = os.lstat(path)
        except OSError:
            return
        found[path] = (status.st_mode, status.st_size, status.st_ino, status.st_mtime_ns, status.st_ctime_ns)

    for top in {toolchain.source, toolchain.build}:
        for name in _FILES:
            look(os.path.join(top, name))
    tops = [os.path.join(top, name) for top in {toolchain.source, toolchain.build} for name in _FOLDERS]
    for folder in [*tops, *places]:
        for where, _, names in os.walk(folder):
            for name in names:
                if not name.endswith(_OF_OTHERS):
                    look(os.path.join(where, name))
    return found


def check_unchanged(before, after, submission):
    """Raises KitChanged, which names a file and the submission, unless both states are the same."""
    changed = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
    if changed:
        others = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise KitChanged(
            f"while {submission} was graded, {changed[0]}{others} changed: no verdict on it is believed. Read what it "
            "does, and restore the kit before you grade on: unpack it anew, or git checkout, make clean and make"
        )
