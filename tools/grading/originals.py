"""The files of a pack as they were packed, in tools/originals.zip, so that edits outside of the workbook are
noticed and can be undone. Texts and settings of editors and git hosts are a student's to change."""

import os
import zipfile
import zlib

_ARCHIVE = os.path.join("tools", "originals.zip")
_NOT_KEPT = (".md", ".png", ".svg", ".html", ".zip", ".yml")
_CODE_FOLDERS = ("src", "tests", "tools", "assignments")
_MADE = ("src/features/list.h", "src/features/all.h")  # by tools/features.sh


def keep_originals(pack):
    """Writes the archive of a pack that is complete."""
    with zipfile.ZipFile(os.path.join(pack, _ARCHIVE), "w", zipfile.ZIP_DEFLATED) as archive:
        for where, folders, files in os.walk(pack):
            folders[:] = sorted(name for name in folders
                                if name not in (".vscode", "__pycache__")
                                and os.path.join(where, name) != os.path.join(pack, "workbook"))
            for name in sorted(files):
                path = os.path.join(where, name)
                if not name.endswith(_NOT_KEPT) and not os.path.islink(path):
                    archive.write(path, os.path.relpath(path, pack))


def has_originals(source):
    """Whether this is a pack, and not the whole kit."""
    return os.path.exists(os.path.join(source, _ARCHIVE))


def edited_files(source):
    """Returns the names of the pack's files that were changed or removed; none in the whole kit."""
    if not has_originals(source):
        return []
    names = []
    with zipfile.ZipFile(os.path.join(source, _ARCHIVE)) as archive:
        for entry in archive.infolist():
            try:
                with open(os.path.join(source, entry.filename), "rb") as file:
                    same = zlib.crc32(file.read()) == entry.CRC
            except OSError:
                same = False
            if not same:
                names.append(entry.filename)
    return names


def added_files(source):
    """Returns the names of files beside the pack's code that are not the pack's, but of such a kind that the
    build may take them for its own; none in the whole kit."""
    if not has_originals(source):
        return []
    with zipfile.ZipFile(os.path.join(source, _ARCHIVE)) as archive:
        known = {*archive.namelist(), *_MADE}
    kinds = {os.path.splitext(name)[1] for name in known
             if name.startswith(tuple(f"{top}/" for top in _CODE_FOLDERS))} - {"", ".txt"}
    names = []
    for top in _CODE_FOLDERS:
        for where, folders, files in os.walk(os.path.join(source, top)):
            folders[:] = sorted(name for name in folders if not name.startswith((".", "__pycache__")))
            names += [os.path.relpath(os.path.join(where, name), source) for name in sorted(files)
                      if not name.startswith(".") and os.path.splitext(name)[1] in kinds]
    return [name for name in names if name not in known]


def put_back(source, names):
    """Restores these files, and returns those whose edited text is now in NAME.edited."""
    saved = []
    with zipfile.ZipFile(os.path.join(source, _ARCHIVE)) as archive:
        for name in names:
            path = os.path.join(source, name)
            if os.path.lexists(path):
                os.replace(path, path + ".edited")
                saved.append(name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "wb") as file:
                file.write(archive.read(name))
            os.chmod(path, archive.getinfo(name).external_attr >> 16 & 0o777)
    return saved
