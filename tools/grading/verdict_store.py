"""Keeps verdicts by the digest of all that they depend on, so that work is repeated only where something
has changed; as build systems do (Mokhov, Mitchell, Peyton Jones, "Build systems à la carte", 2018).

A store is a folder with an empty file for each thing that was found right. What is wrong is tried each time.
"""

import hashlib
import os
import pathlib
import platform
import re
import shutil
import subprocess


def _bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


class Digest:
    """Of named parts, each with its length, so that none runs into the next."""

    def __init__(self, start=None):
        self._hash = start.copy() if start else hashlib.sha256()

    def add(self, name, content):
        content = content.encode() if isinstance(content, str) else content
        self._hash.update(f"{name}\0{len(content)}\0".encode() + content)

    def add_file(self, name, path):
        self.add(name, _bytes_of(path))

    def copy(self):
        return Digest(self._hash)

    def text(self):
        return self._hash.hexdigest()


class Store:
    """In this folder, or none for "". `is_fresh`: nothing that is there counts, what is found is kept."""

    def __init__(self, folder, is_fresh=False):
        self.folder, self.is_fresh, self.found = folder and pathlib.Path(folder), is_fresh, 0

    def has(self, digest):
        known = bool(self.folder) and not self.is_fresh and self._path(digest).exists()
        self.found += known
        return known

    def keep(self, digest):
        if self.folder:
            self._path(digest).parent.mkdir(parents=True, exist_ok=True)
            self._path(digest).touch()

    def _path(self, digest):
        return self.folder / digest.text()[:2] / digest.text()[2:]


def _said(command):
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=True).stdout


def add_machine(digest):
    """The processor, and what the environment says to programs."""
    cpu = pathlib.Path("/proc/cpuinfo")
    flags = re.search(r"^flags.*$", cpu.read_text(encoding="ascii"), re.MULTILINE) if cpu.exists() else None
    digest.add("processor", platform.machine() + (flags[0] if flags else ""))
    for name in sorted(os.environ):
        if name.startswith(("RAYKIT_ISA", "RAYKIT_STRESS", "LD_", "CMOCKA_", "GCC_", "CPATH", "LIBRARY_PATH",
                            "C_INCLUDE")):
            digest.add(name, os.environ[name])


def add_compiler(digest, command):
    """The compiler with the programs that it starts."""
    digest.add("compiler", _said([command, "--version"]))
    for name in ("cc1", "as", "ld"):
        path = _said([command, f"-print-prog-name={name}"]).decode().strip()
        path = path if os.path.isabs(path) else shutil.which(path)
        if path and os.path.exists(path):
            digest.add_file(name, path)


def add_includes(digest, compile_command, source, root):
    """All files that a source includes, the system's too."""
    rule = _said([*compile_command, "-M", "-MT", "it", str(source)]).decode()
    for path in sorted(set(rule.replace("\\\n", " ").split()[1:])):
        is_own = pathlib.Path(path).resolve().is_relative_to(root)
        digest.add_file(os.path.relpath(path, root) if is_own else path, path)


def add_archive(digest, path):
    """An archive of objects without what debuggers read, and without the name of its build folder."""
    stripped = _said(["strip", "-g", "-o", "/dev/stdout", path])
    digest.add(path, stripped.replace(os.fsencode(os.getcwd()), b"."))


def add_shared_libraries(digest, program):
    for path in sorted(re.findall(r"(/\S+) \(0x", _said(["ldd", program]).decode())):
        digest.add_file(path, path)
