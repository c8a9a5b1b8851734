#!/usr/bin/env python3
"""Makes the files of a new feature, with a pattern that builds and whose suite says what to do next.

tools/new_feature/ holds them for a feature called fog; its name is replaced by the new one, in texts
and paths. Either all is written, or nothing.
"""

import os
import re
import subprocess
import sys

from grading.assignments import Parser, ToolError, read_features, run_command
from grading.results import write_whole

# C's, and what standard headers make of C17's.
KEYWORDS = set("""auto bool break case char complex const continue default do double else enum extern false
    float for goto if imaginary inline int long main noreturn register restrict return short signed sizeof
    static struct switch true typedef union unsigned void volatile while""".split())


def _read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def _files(folder):
    return sorted(os.path.relpath(os.path.join(where, name), folder)
                  for where, _, names in os.walk(folder) for name in names)


# --- The name -------------------------------------------------------------------------------------


def check_name(source, stem):
    """Raises ToolError unless a new feature can be called so."""
    if not stem:
        raise ToolError("say what it is called: make new-feature NAME=fog")
    if not re.fullmatch("[a-z][a-z0-9_]*", stem):
        raise ToolError(f"NAME={stem}: a feature's name is a C identifier of small letters, digits and _, "
                        "and begins with a letter")
    if stem in KEYWORDS:
        raise ToolError(f"NAME={stem}: this word means something in C; choose another")
    if stem in read_features(source):
        raise ToolError(f"NAME={stem}: there is such a feature; choose another name")
    if any(re.search(rf"\b(check|driver)-{stem}\b", _read(os.path.join(source, name)))
           for name in ("Makefile.am", "tests/tests.am", "tools/grading/grading.am")):
        raise ToolError(f"NAME={stem}: make check-{stem} does something else; choose another name")
    for folder in ("src", "tests"):
        for name in _files(os.path.join(source, folder)):
            if name.endswith((".c", ".h")) and f"rk_{stem}_" in _read(os.path.join(source, folder, name)):
                raise ToolError(f"NAME={stem}: {folder}/{name} has names that begin with rk_{stem}_; "
                                "choose another")


# --- The files ------------------------------------------------------------------------------------


def _filler(stem, folder):
    """Returns the function that makes a text or a path about fog one about the feature."""
    words = {"NN_fog": folder, "NUMBER": str(int(folder.split("_")[0])), "FOG": stem.upper(),
             "Fog": stem.replace("_", " ").capitalize(), "fog-": stem.replace("_", "-") + "-", "fog": stem}
    return lambda text: re.sub("|".join(words), lambda match: words[match.group()], text)


def new_files(source, stem, folder):
    """Returns a dictionary from path to text."""
    filled, patterns = _filler(stem, folder), os.path.join(source, "tools", "new_feature")
    files = {filled(name): filled(_read(os.path.join(patterns, name))) for name in _files(patterns)}
    for name in files:
        if os.path.lexists(os.path.join(source, name)):
            raise ToolError(f"NAME={stem}: there is a file {name}; choose another name, or move it away")
    return files


def edited_files(source, stem, folder):
    """Returns the same for files that gain a line."""
    table = "assignments/features.tsv"
    row = "\t".join([stem, folder, "", "", "say in a few words what it is", ""])
    options = "src/render/plan.h"
    text, end = _read(os.path.join(source, options)), "} rk_render_options;\n"
    includes = re.search(r'(#include "features/.*\n)+', text).group().splitlines(keepends=True)
    more = sorted([*includes, f'#include "features/{stem}.h"\n'])
    text = text.replace("".join(includes), "".join(more))
    return {table: _read(os.path.join(source, table)) + row + "\n",
            options: text.replace(end, f"    rk_{stem}_options {stem};\n" + end)}


def _make_folders(folder):
    """Returns the folders that were missing, the outer ones first."""
    if os.path.isdir(folder):
        return []
    made = _make_folders(os.path.dirname(folder))
    os.mkdir(folder)
    return [*made, folder]


class _Undo:
    """Writes files and remembers what was there before."""

    def __init__(self, source):
        self.source, self.before, self.folders = source, {}, []

    def write(self, name, text):
        path = os.path.join(self.source, name)
        self.folders += _make_folders(os.path.dirname(path))
        self.before[path] = _read(path) if os.path.lexists(path) else None
        write_whole(path, text)

    def undo(self):
        for path, text in self.before.items():
            if text is not None:
                write_whole(path, text)
            elif os.path.lexists(path):
                os.unlink(path)
        for folder in reversed(self.folders):
            os.rmdir(folder)


def _readme(source):
    """Returns README.md with the table as it should be."""
    command = ["sh", os.path.join(source, "tools", "features.sh"), "--readme"]
    answer = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if answer.returncode:
        raise ToolError(answer.stderr.strip())
    return answer.stdout


# --- The command ----------------------------------------------------------------------------------


def make_feature(source, stem):
    """Writes the files; returns lines that say which, and what to do next."""
    check_name(source, stem)
    last = max(int(feature.folder.split("_")[0]) for feature in read_features(source).values())
    folder = f"{last + 1:02}_{stem}"
    new, edited = new_files(source, stem, folder), edited_files(source, stem, folder)
    files = _Undo(source)
    try:
        for name, text in (new | edited).items():
            files.write(name, text)
        files.write("README.md", _readme(source))
    except BaseException:
        files.undo()
        raise
    return [
        *(f"made    {name}" for name in new), *(f"edited  {name}" for name in [*edited, "README.md"]),
        f"next: make check-{stem}, which fails and says where to begin; make format, where lines became long",
        f"      assignments/{folder}/{stem} draws, when make has built it; "
        "README's words stand in features.tsv",
        "      docs/architecture.md, \"Adding a feature\", has the steps"]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("stem", metavar="NAME", help="the feature's name")
    arguments = parser.parse_args()
    return run_command("new-feature", lambda: print("\n".join(
        make_feature(arguments.source, arguments.stem))), kept="; nothing was written")


if __name__ == "__main__":
    sys.exit(main())
