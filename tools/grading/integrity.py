"""Has a submission changed the files with which others are graded? They are compared before and
after it, because a unit runs with the grader's rights and can write every file that the grader can."""

import json
import os
import tempfile

from grading.assignments import ToolError
from grading.results import write_whole

_FOLDERS = ("tools", "tests", "assignments", "src")
_FILES = ("Makefile", "Makefile.am", "librktest.a", "librkbase.a", "impl/toolchain")
_OF_OTHERS = (".log", ".trs")  # written by make check, which may run at the same time


class KitChanged(ToolError):
    """No verdict since the last check is reliable, and none on others until somebody restores the
    changed files."""


class KitRestored(ToolError):
    """No verdict since the last check is reliable; the kit is as it was before."""


def _mark(path):
    try:
        status = os.lstat(path)
    except OSError:
        return None
    return [status.st_mode, status.st_size, status.st_ino, status.st_mtime_ns, status.st_ctime_ns]


def state(toolchain, *places):
    """Returns a dictionary from path to a mark that changes with the file, for the kit and these
    folders. Its change time is set by the system, so a unit cannot set it back."""
    found = {}

    def look(path):
        mark = _mark(path)
        if mark:
            found[path] = mark

    for top in {toolchain.source, toolchain.build}:
        for name in _FILES:
            look(os.path.join(top, name))
    tops = [os.path.join(top, name) for top in {toolchain.source, toolchain.build} for name in _FOLDERS]
    for folder in [*tops, *places]:
        for where, folders, names in os.walk(folder):
            links = [name for name in folders if os.path.islink(os.path.join(where, name))]
            for name in names + links:
                if not name.endswith(_OF_OTHERS):
                    look(os.path.join(where, name))
    return found


def check_unchanged(toolchain, before, submission, *places):
    """Raises KitRestored if the kit has more files than in the state before, which are then removed;
    KitChanged if any other file has changed, also in these folders."""
    after = state(toolchain, *places)
    changed = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
    if not changed:
        return
    tops = tuple(os.path.join(top, "") for top in (toolchain.source, toolchain.build))
    others = tuple(os.path.join(os.path.abspath(place), "") for place in places)
    if all(path not in before and path.startswith(tops) and not path.startswith(others) for path in changed):
        folder = _take_out(toolchain, changed)
        if folder and state(toolchain, *places) == before:
            raise KitRestored(f"{submission} added {_named(changed)} to the kit, so no verdict on it is believed; "
                              f"what it added is now in {folder}, and the kit is as before")
    write_whole(_note(toolchain), json.dumps({"by": submission, "files": {path: _mark(path) for path in changed}}))
    raise KitChanged(f"while {submission} was graded, {_named(changed)} changed: no verdict on it is believed. "
                     f"Read what it does; {_remedy(toolchain, [path for path in changed if path not in before])}")


def check_restored(toolchain):
    """Raises ToolError if a file is still as an earlier submission left it."""
    try:
        with open(_note(toolchain), encoding="utf-8") as file:
            note = json.load(file)
    except OSError:
        return
    left = [path for path, mark in note["files"].items() if _mark(path) == mark]
    if left:
        raise ToolError(f"{_named(left)} {'is' if len(left) == 1 else 'are'} still as {note['by']} left it; "
                        f"{_remedy(toolchain, [])}")
    os.unlink(_note(toolchain))


def _note(toolchain):
    return os.path.join(toolchain.build, "grading-stopped.json")  # make clean, part of the remedy, leaves it


def _named(paths):
    return " and ".join([", ".join(paths[:3]), *([f"{len(paths) - 3} more"] if len(paths) > 3 else [])])


def _remedy(toolchain, added):
    remove = f"remove {_named(added)} and " if added else "remove what is new, and "
    return (f"{remove}bring back what was there before (git checkout, or unpack the kit anew; make clean and make "
            f"for what is built). Until then nothing is graded; where all is well, remove {_note(toolchain)}")


def _take_out(toolchain, paths):
    """Moves files out of the kit. Returns the folder that now has them, or None on failure."""
    try:
        folder = tempfile.mkdtemp(prefix="added-", dir=os.path.join(toolchain.build, "impl"))
        for number, path in enumerate(paths, 1):
            os.rename(path, os.path.join(folder, f"{number}-{os.path.basename(path)}"))
    except OSError:
        return None
    return folder
