"""Which files changed while there was no sandbox? There, a unit runs with the grader's rights and can
write every file that the grader can. A change says nothing about who made it."""

import os

from grading.assignments import walk

_FOLDERS = ("tools", "tests", "assignments", "src")
_FILES = ("Makefile", "config.status", "impl/toolchain", "librktest.a", "librkbase.a")
_ENDINGS = (".c", ".h", ".o", ".py", ".tsv", ".sh")  # an editor's own files have others


def _mark(path):
    try:
        status = os.lstat(path)
    except OSError:
        return None
    return [status.st_mode, status.st_size, status.st_ino, status.st_mtime_ns, status.st_ctime_ns]


class Watch:
    """Compares files of the kit, and all in these folders, with how they were at first. A file's change
    time is set by the system, so a unit cannot set it back."""

    def __init__(self, toolchain, *folders):
        self._tops, self._folders = {toolchain.source, toolchain.build}, folders
        self._before = self._state()

    def _state(self):
        paths = [os.path.join(top, name) for top in self._tops for name in _FILES]
        watched = [os.path.join(top, name) for top in self._tops for name in _FOLDERS]
        for folder in [*watched, *self._folders]:
            for where, folders, names in walk(folder):
                paths += [os.path.join(where, name) for name in [*names, *folders]
                          if not name.startswith(".")
                          and (folder in self._folders or name.endswith(_ENDINGS))]
        return {path: _mark(path) for path in paths if os.path.isfile(path) or os.path.islink(path)}

    def accept(self, folder, names):
        """Notes files that the grader itself wrote or removed."""
        for name in names:
            path = os.path.join(folder, name)
            self._before[path] = _mark(path)

    def changed(self):
        """Names what is not as it was, or returns ""."""
        after = self._state()
        paths = sorted(path for path in self._before.keys() | after.keys()
                       if self._before.get(path) != after.get(path))
        more = f" and {len(paths) - 3} more" if len(paths) > 3 else ""
        return ", ".join(paths[:3]) + more
