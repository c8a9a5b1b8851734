"""Grading works on copies: of what it needs from the kit, so that nobody changes it meanwhile, and of
the unit, under a plain name, so that no character in a student's folder name matters."""

import contextlib
import copy
import glob
import os
import re
import shutil
import stat
import tempfile
import time

from grading import judged
from grading.assignments import Unit, UnitError, UnreadableError
from grading.temporary_folder import temporary_folder

_UNIT_BYTES_MAX = 1 << 20
_HEADER_BYTES_MAX = 1 << 20
_STALE = 3600  # seconds


def make_folder():
    """Makes a temporary folder for this process, and removes this user's of processes that were killed."""
    for path in glob.glob(os.path.join(glob.escape(tempfile.gettempdir()), "raykit-grade-*")):
        if _is_stale(path):
            shutil.rmtree(path, ignore_errors=True)
    return tempfile.mkdtemp(prefix=f"raykit-grade-{os.getpid()}-")


@contextlib.contextmanager
def own_folder():
    """Gives a folder of make_folder, and removes it in the end."""
    made = make_folder()
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _is_stale(path):
    owner = re.match(r"raykit-grade-(\d+)-", os.path.basename(path))
    try:
        status = os.lstat(path)
        # Young ones may belong to a process that another container has.
        if not owner or status.st_uid != os.geteuid() or time.time() - status.st_mtime < _STALE:
            return False
        os.kill(int(owner[1]), 0)
    except ProcessLookupError:
        return True
    except OSError:  # removed meanwhile, or somebody else's process
        pass
    return False


def sources_of_suites(stems):
    """Returns the names of files in tests that suites of these features need."""
    return [name for stem in stems for name in (f"test_{stem}.c", f"{stem}.calls")]


def objects_of_suites(toolchain, stems):
    """Returns the files in the build folder that suites of these features need, and no other."""
    judges = [name for stem in stems if toolchain.judges and judged.is_possible(toolchain, stem)
              for name in judged.files(stem)]
    return [*(f"tests/test_{stem}.o" for stem in stems), *judges]


def files_of_kit(toolchain, features, stems):
    """Yields what the suites of these features need, and where it stands in a copy. The references' objects
    lie apart from the headers, which are all that a compiler sees of the kit."""
    of_suites = set(sources_of_suites(stems))
    for room in ("src", "tests"):
        for where, _, names in os.walk(os.path.join(toolchain.source, room)):
            for name in names:
                if name.endswith(".h") or name in of_suites:
                    path = os.path.join(where, name)
                    yield path, os.path.join("kit", os.path.relpath(path, toolchain.source))
    needed = ["librktest.a", "librkbase.a", "impl/count_allocations.o",
              *[f"src/features/{stem}.o" for stem in features], *objects_of_suites(toolchain, stems)]
    for path in dict.fromkeys(needed):
        yield toolchain.built(path), os.path.join("objects", path)


def kit_in(folder, toolchain):
    """Returns the toolchain of the kit's copy in this folder."""
    kit = os.path.join(folder, "kit")
    copied = copy.copy(toolchain)
    copied.source, copied.build = kit, os.path.join(folder, "objects")
    copied.flags = [word.replace(toolchain.source, kit) for word in toolchain.flags]
    return copied


def copy_kit(toolchain, features, stems, folder):
    """Copies what the suites of these features need, and returns the toolchain of the copy."""
    for path, place in files_of_kit(toolchain, features, stems):
        place = os.path.join(folder, place)
        os.makedirs(os.path.dirname(place), exist_ok=True)
        shutil.copy(path, place)
    return kit_in(folder, toolchain)


def update_kit(toolchain, features, stems, folder):
    """As copy_kit, but copies only where something has changed since the last call with this folder."""
    state = repr([(path, os.stat(path).st_mtime_ns) for path, _ in files_of_kit(toolchain, features, stems)])
    record = os.path.join(folder, "state")
    if not os.path.exists(record) or open(record, encoding="utf-8").read() != state:
        for name in ("kit", "objects"):
            shutil.rmtree(os.path.join(folder, name), ignore_errors=True)
        copied = copy_kit(toolchain, features, stems, folder)
        with open(record, "w", encoding="utf-8") as file:
            file.write(state)
        return copied
    return kit_in(folder, toolchain)


@contextlib.contextmanager
def borrowed(folder, toolchain, features, stems, place=None):
    """Gives a folder with a copy of the kit for these suites, all for []: this one, or, for None, one that is
    made, in `place` if that is not None, and removed in the end."""
    if folder:
        yield folder
        return
    with temporary_folder(".kit-", place) if place else own_folder() as made:
        copy_kit(toolchain, features, stems or list(features), made)
        yield made


def copy_unit(unit, folder):
    """Returns the unit as a copy in this folder, with the headers beside it that it includes."""
    if unit.is_reference:
        return unit
    own = os.path.join(folder, "own", unit.feature.stem)
    os.makedirs(own, exist_ok=True)
    path = os.path.join(own, unit.feature.stem + ".c")
    with open(unit.path, "rb") as file:
        text = file.read(_UNIT_BYTES_MAX + 1)
    if len(text) > _UNIT_BYTES_MAX:
        raise UnitError(f"{unit.shown} is larger than {_UNIT_BYTES_MAX >> 20} MB")
    with open(path, "wb") as file:
        file.write(text)
    _copy_headers(os.path.realpath(os.path.dirname(unit.path)), text, own)
    return Unit(unit.feature, path, unit.shown, False)


def _headers_beside(source, text, place="", seen=None):
    """Yields the names and bytes of headers below `source` that a text in the subfolder `place` includes, and
    of those that they include."""
    seen = set() if seen is None else seen
    for name in re.findall(rb'^[ \t]*#[ \t]*include[ \t]*"([^"\n]+\.h)"', text, re.MULTILINE):
        relative = os.path.normpath(os.path.join(place, os.fsdecode(name)))
        path = os.path.join(source, relative)
        if relative in seen or not _is_below(path, source) or not _is_file(path, relative):
            continue
        seen.add(relative)
        with open(path, "rb") as file:
            header = file.read(_HEADER_BYTES_MAX)
        yield relative, header
        yield from _headers_beside(source, header, os.path.dirname(relative), seen)


def _is_file(path, shown):
    """Raises UnreadableError for one that may not be read."""
    try:
        is_file = stat.S_ISREG(os.stat(path).st_mode)
    except PermissionError as error:
        raise UnreadableError(shown) from error
    except OSError:
        return False
    if is_file and not os.access(path, os.R_OK):
        raise UnreadableError(shown)
    return is_file


def own_headers(unit):
    """Returns the names of headers beside a student's unit without which it does not compile. Raises
    UnreadableError for one that may not be read."""
    with open(unit.path, "rb") as file:
        text = file.read(_UNIT_BYTES_MAX)
    return [name for name, _ in _headers_beside(os.path.realpath(os.path.dirname(unit.path)), text)]


def _copy_headers(source, text, own):
    for relative, header in _headers_beside(source, text):
        copied = os.path.join(own, relative)
        if b"\0" in header or os.path.lexists(copied) or not _is_below(copied, own):
            continue
        os.makedirs(os.path.dirname(copied), exist_ok=True)
        with open(copied, "wb") as file:
            file.write(header)


def _is_below(path, folder):
    return os.path.realpath(path).startswith(os.path.realpath(folder) + os.sep)
