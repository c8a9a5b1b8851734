"""What a download holds: the files of a folder, a zip or a tar, and of archives in it. Nothing is ever
written under a name that comes from an archive, and what would grow without end is left out and told."""

import bz2
import collections
import datetime
import errno
import gzip
import lzma
import os
import re
import stat
import struct
import tarfile
import zipfile
import zlib

from grading.assignments import ToolError, is_archive

# An archive in an archive that is in the download is still unpacked; what is deeper isn't.
_DEEPEST = 2
_FILES = 1000000  # of the download itself
_FILES_IN_ALL = 5000000
_NAMED = 8  # files besides those that are wanted, of an archive inside
_FILES_INSIDE = 20000  # of an archive inside; a whole pack with its build has fewer than 5000
_FILE_BYTES = 4 << 20  # of a C file or a header; a unit may have 1 MB
_ARCHIVE_BYTES = 256 << 20  # of an archive inside, packed
_INSIDE_BYTES = 512 << 20  # of one unpacked
_BYTES = 16 << 30  # of the download unpacked, and of what is copied of it
_RATIO, _FREE = 100, 64 << 20  # packed a hundred times smaller: told, beyond the first megabytes
_CHUNK = 1 << 18

_DAMAGE = (zipfile.BadZipFile, zipfile.LargeZipFile, tarfile.TarError, zlib.error, lzma.LZMAError,
           struct.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError, IndexError,
           OverflowError)

# Of all errors of the system those that no archive brings about.
_OF_THE_MACHINE = (errno.EACCES, errno.EPERM, errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EMFILE,
                   errno.ENFILE)


class Found:
    """A file of the download. `parts` are the names from its top on, those of archives among them. `times`
    has, for each archive around it and itself, the number of parts and a time, or None. `path` is where its
    bytes can be read if they were wanted."""

    __slots__ = "parts", "times", "path"

    def __init__(self, parts, times, path=None):
        self.parts, self.times, self.path = parts, times, path

    def time_below(self, depth):
        """When it was delivered as a part of an item of so many parts: files in a student's own archive have
        times that the student chose."""
        return next((time for count, time in self.times if count >= depth), None)

    def __str__(self):
        return "/".join(self.parts)


class _TooLarge(ValueError):
    pass


class _Bounded:
    """A stream that ends with an error after so many bytes."""

    def __init__(self, stream, most):
        self.stream, self.left = stream, most

    def read(self, count):
        data = self.stream.read(count)
        self.left -= len(data)
        if self.left < 0:
            raise _TooLarge("it unpacks to far more than it takes up")
        return data


def _moment(seconds):
    """Returns a time, or None for one that no file of a course has."""
    if not 0 < seconds < 1 << 32:
        return None
    return datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc)


def _is_hidden(parts):
    return any(part.startswith(".") or part == "__MACOSX" for part in parts)


def _safe_parts(name):
    """Returns the names on the way to a member, or None for one that leads out of the archive."""
    name = name.replace("\\", "/")
    parts = tuple(part for part in name.split("/") if part not in ("", "."))
    return None if name.startswith("/") or re.match(r"[A-Za-z]:", name) or ".." in parts else parts


def _zip_name(info):
    """macOS writes UTF-8 without saying so, and Python then reads it as cp437."""
    if info.flag_bits & 0x800:
        return info.filename
    try:
        return info.filename.encode("cp437").decode("utf-8")
    except UnicodeError:
        return info.filename


def _zip_time(info):
    """Info-ZIP's extra field has the time with its zone; what every zip has is a local time of somebody."""
    extra = info.extra
    while len(extra) >= 4:
        kind, size = struct.unpack("<HH", extra[:4])
        if kind == 0x5455 and size >= 5 and len(extra) >= 9 and extra[4] & 1:
            return _moment(struct.unpack("<i", extra[5:9])[0])
        extra = extra[4 + size:]
    try:
        return datetime.datetime(*info.date_time) if info.date_time[0] > 1980 else None
    except ValueError:
        return None


class Download:
    """Looks through a download: `files` are what it holds, `faults` pairs of parts and a sentence. `choose`
    gets the parts of all files in one folder or archive, and returns those whose bytes are wanted; these are
    put into the folder `work` under numbers."""

    def __init__(self, path, choose, work):
        self.files, self.faults = [], []
        self._choose, self._work, self._count, self._copies, self._copied = choose, work, 0, 0, 0
        self._named = collections.Counter()
        try:
            if os.path.isdir(path):
                self._look_into_folder(path)
            else:
                self._look_into(path, (), [], 0)
        except OSError as error:
            raise ToolError(f"DOWNLOAD: {error.filename or path} cannot be read: {error.strerror}") from error

    def _fault(self, parts, text):
        self.faults.append((parts, text))

    def _give_up(self, path, parts, depth, text):
        """Of an archive that cannot be read."""
        if depth == 0:
            raise ToolError(f"DOWNLOAD: {path}: {text}")
        self._fault(parts, text)

    def _look_into_folder(self, top):
        paths = {}

        def stop(error):
            raise error

        for where, folders, names in os.walk(top, onerror=stop):
            below = os.path.relpath(where, top)
            parts = () if below == "." else tuple(below.split(os.sep))
            for name in [*folders]:
                if os.path.islink(os.path.join(where, name)):
                    self._fault((*parts, name), "it is a link, and was left out")
            folders[:] = sorted(name for name in folders if not _is_hidden([name])
                                and not os.path.islink(os.path.join(where, name)))
            for name in sorted(names):
                path, status = os.path.join(where, name), os.lstat(os.path.join(where, name))
                if _is_hidden([name]):
                    continue
                if not stat.S_ISREG(status.st_mode):
                    kind = "a link" if stat.S_ISLNK(status.st_mode) else "no plain file"
                    self._fault((*parts, name), f"it is {kind}, and was left out")
                    continue
                self._count_file(paths, _FILES)
                paths[(*parts, name)] = (path, status)
        wanted = self._choose(list(paths))
        for parts, (path, status) in paths.items():
            times = [(len(parts), _moment(status.st_mtime))]
            if is_archive(parts[-1]):
                self._look_into(path, parts, times, 1)
            elif parts in wanted and status.st_size > _FILE_BYTES:
                self._fault(parts, f"it is larger than {_FILE_BYTES >> 20} MB, and was left out")
            else:
                self.files.append(Found(parts, times, path if parts in wanted else None))

    def _count_file(self, files, most):
        self._count += 1
        if self._count > _FILES_IN_ALL:
            raise ToolError(f"DOWNLOAD: it holds more than {_FILES_IN_ALL} files; give a part of it")
        if len(files) >= most:
            raise _TooLarge(f"it holds more than {most} files")

    def _look_into(self, path, parts, times, depth):
        """An archive is taken as a folder of its name, or told."""
        if depth > _DEEPEST:
            self._fault(parts, "it is an archive in an archive in an archive; unpack it by hand")
            return
        kept = len(self.files)
        try:
            with open(path, "rb") as file:
                magic = file.read(6)
            if magic[:2] == b"PK":
                self._look_into_zip(path, parts, times, depth)
            elif magic in (b"7z\xbc\xaf\x27\x1c",) or magic[:4] == b"Rar!":
                kind = "7z" if magic[:2] == b"7z" else "rar"
                self._give_up(path, parts, depth,
                              f"{kind} archives are not unpacked here; unpack it by hand, "
                              "into a folder or a zip of the same name")
            else:
                self._look_into_tar(path, magic, parts, times, depth)
        except _TooLarge as error:
            del self.files[kept:]
            self._give_up(path, parts, depth,
                          f"{error}, and was left out; look at it before you unpack it by "
                          "hand")
        except _DAMAGE as error:
            del self.files[kept:]
            if getattr(error, "errno", None) in _OF_THE_MACHINE:
                raise
            reason = str(error).split("\n")[0]
            self._give_up(path, parts, depth,
                          f"it is damaged, or no archive of a known kind ({reason}); ask for "
                          "it anew")

    def _limits(self, path, depth):
        """Returns how many bytes an archive may unpack to, and how many files."""
        grown = max(_FREE, _RATIO * os.path.getsize(path))
        return (min(grown, _INSIDE_BYTES), _FILES_INSIDE) if depth else (min(grown, _BYTES), _FILES)

    def _place(self):
        """Returns the path of a new file."""
        self._copies += 1
        return os.path.join(self._work, str(self._copies))

    def _keep(self, stream, size, packed, parts):
        """Returns the path of a copy of what is wanted, or None for what is too large."""
        most = _ARCHIVE_BYTES if is_archive(parts[-1]) else _FILE_BYTES
        if size > most or packed and size > 1 << 20 and size > _RATIO * packed:
            self._fault(parts, f"it is larger than {most >> 20} MB, and was left out" if size > most else
                        "it unpacks to far more than it takes up, and was left out")
            return None
        self._copied += size
        if self._copied > _BYTES:
            raise ToolError(f"DOWNLOAD: it unpacks to more than {_BYTES >> 30} GB; give a part of it")
        path, stream = self._place(), _Bounded(stream, most)
        with open(path, "wb") as file:
            while data := stream.read(_CHUNK):
                file.write(data)
        return path

    def _take(self, path, parts, times, depth):
        """Notes a file whose copy, if it has one, is at the path, or what is in it if it is an archive."""
        if path and is_archive(parts[-1]):
            self._look_into(path, parts, times, depth + 1)
            os.unlink(path)
            return
        around = parts[:times[-2][0]] if len(times) > 1 else ()
        self._named[around] += not path
        if path or not around or self._named[around] <= _NAMED:
            self.files.append(Found(parts, times, path))

    def _member(self, name, kind, parts):
        """Returns the parts of a member, or None for one that is left out; `kind` says what it is besides a
        plain file."""
        below = _safe_parts(name)
        if below is None:
            self._fault(parts, f"{name[:80]} leads out of the archive, and was left out")
        elif not below or _is_hidden(below):
            return None
        elif kind:
            self._fault((*parts, *below), f"it is {kind}, and was left out")
            return None
        return below and (*parts, *below)

    def _look_into_zip(self, path, parts, times, depth):
        most, count = self._limits(path, depth)
        with zipfile.ZipFile(path) as archive:
            members = []
            for info in archive.infolist():
                mode = info.external_attr >> 16
                kind = ("a link" if stat.S_ISLNK(mode) else
                        "no plain file" if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR) else "")
                member = None if info.is_dir() else self._member(_zip_name(info), kind, parts)
                if member:
                    self._count_file(members, count)
                    members.append((info, member))
            wanted = self._choose([member for _, member in members])
            for info, member in members:
                copy, here = None, [*times, (len(member), _zip_time(info))]
                if member in wanted or is_archive(member[-1]):
                    if info.flag_bits & 1:
                        self._fault(member, "it needs a password; unpack it by hand, or ask for one without")
                        continue
                    try:
                        with archive.open(info) as stream:
                            copy = self._keep(stream, info.file_size, info.compress_size, member)
                    except _DAMAGE as error:
                        if getattr(error, "errno", None) in _OF_THE_MACHINE:
                            raise
                        self._fault(member, f"it is damaged ({error}), and was left out; ask for it anew")
                        continue
                    if copy is None:
                        continue
                    most -= info.file_size
                    if most < 0:
                        raise _TooLarge("it unpacks to far more than it takes up")
                self._take(copy, member, here, depth)

    def _tar_members(self, path, magic, most):
        """Yields the members of a tar from its first byte to its last, for a stream that may not go back."""
        opened = (gzip.open if magic[:2] == b"\x1f\x8b" else bz2.open if magic[:3] == b"BZh" else
                  lzma.open if magic == b"\xfd7zXZ\0" else open)
        with opened(path, "rb") as stream, tarfile.open(fileobj=_Bounded(stream, most), mode="r|") as archive:
            for member in archive:
                yield archive, member

    def _look_into_tar(self, path, magic, parts, times, depth):
        most, count = self._limits(path, depth)
        names = {}
        for index, (_, info) in enumerate(self._tar_members(path, magic, most)):
            kind = "a link" if info.issym() or info.islnk() else "" if info.isreg() else "no plain file"
            member = None if info.isdir() else self._member(info.name, kind, parts)
            if member:
                self._count_file(names, count)
                names[index] = member
        wanted = self._choose(list(names.values()))
        for index, (archive, info) in enumerate(self._tar_members(path, magic, most)):
            member = names.get(index)
            if member is None:
                continue
            copy = None
            if member in wanted or is_archive(member[-1]):
                copy = self._keep(archive.extractfile(info), info.size, 0, member)
                if copy is None:
                    continue
            self._take(copy, member, [*times, (len(member), _moment(info.mtime))], depth)
