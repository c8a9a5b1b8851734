#!/usr/bin/env python3
"""Makes a workbook: a student's folder with a starter and its task for every feature.

A file that the student changed is never touched. The folder's .workbook has the hash of each generated file,
so that an unchanged starter is renewed with the kit.
"""

import hashlib
import os
import shlex
import sys

from grading.assignments import Parser, ToolError, cannot_write, choose, read_features, run_command
from handout_text import as_in_workbook, handout_of
from grading.originals import has_originals
from grading.starters import starter_of
from grading.results import write_whole
from grading.workbook_files import workbook_files

MANIFEST = ".workbook"

README = """\
This is your workbook: one C file for each assignment, yours to change, and beside it its task.

{assignments}

In raykit's folder, with this folder as IMPL:

{commands}

Start with {first}.md and its chapter, {chapter}: read, run the check, solve in {first}.c the step
that it names, and run it again.
A file that is not here is replaced by the kit's own where something needs it.
make workbook DIR={folder} brings new assignments later, and leaves alone what you have changed.
"""

COMMANDS = [
    ("make check-{first} IMPL={folder}", "tests one assignment, and says what to work on first"),
    ("make watch-{first} IMPL={folder}", "the same again whenever you save; Ctrl-C ends it"),
    ("make live-{first} IMPL={folder}", "the same in the browser, with your picture and the wanted one"),
    ("make hint-{first}", "a list of hints; STEP=1 prints the first for a step"),
    ("make draw-{first} IMPL={folder}", "its last picture by your code, compared with the wanted one"),
    ("make debug-{first} IMPL={folder}", "the first failing test in gdb, stopped in your code"),
    ("make diff-{first} IMPL={folder}", "what you have changed since the starter"),
    ("make progress IMPL={folder}", "all assignments with their points"),
    ("make driver-{first} IMPL={folder}",
     "its driver, to draw any picture by your code; it says where it is"),
    ("make report IMPL={folder}/{first}.c QUICK=1", "its section of the report, drawn by your code, small"),
]


def _digest(text):
    return hashlib.sha256(text.encode()).hexdigest()


def _read_manifest(path):
    try:
        with open(path, encoding="utf-8") as file:
            return dict(reversed(line.split()) for line in file if len(line.split()) == 2)
    except FileNotFoundError:
        return {}


def _put(path, text, generated, said):
    """Writes the file unless the student changed it; returns a line about it."""
    name = os.path.basename(path)
    if not os.path.lexists(path):
        write_whole(path, text)
        said.append(f"wrote    {name}")
    else:
        try:
            with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
                present = file.read()
        except OSError as error:
            said.append(f"kept     {name}, which cannot be read: {error.strerror}")
            return
        digest = hashlib.sha256(present.encode("utf-8", "surrogateescape")).hexdigest()
        if present == text:
            said.append(f"kept     {name}, as it was generated")
        elif digest == generated.get(name) and not os.path.islink(path):
            write_whole(path, text)
            said.append(f"renewed  {name}, which you have not changed")
        else:
            newer = name in generated and generated[name] != _digest(text)
            more = "; its starter is newer" if newer else ""
            said.append(f"kept     {name}, which you have changed{more}")
            return
    generated[name] = _digest(text)


def _put_starters_back(features):
    """Writes those starters of a pack whose files are missing."""
    missing = [feature for feature in features if not os.path.lexists(feature.workbook)]
    for feature in missing:
        os.makedirs(os.path.dirname(feature.workbook), exist_ok=True)
        write_whole(feature.workbook, starter_of(feature.reference))
    said = [f"wrote    {feature.stem}.c, the starter" for feature in missing]
    return [*(said or ["no starter is missing; nothing was changed"]),
            f"next: make check-{[*missing, *features][0].stem}, which needs no IMPL for this folder"]


def make_workbook(source, folder, stems=(), named=None):
    """Puts starters of these features, or of all, and a README.txt into the folder. With `named`, they say
    what is true in a folder of this name in a kit that is built in its own folder. Returns a line for each
    file."""
    if not folder:
        raise ToolError("name a folder: make workbook DIR=mine")
    real, inside = os.path.realpath(folder), os.path.realpath(os.path.join(source, "src"))
    if os.path.commonpath([real, inside]) == inside:
        raise ToolError(
            f"DIR: {folder} is in the kit's own src/; choose a folder of your own, such as DIR=mine"
        )
    if os.path.lexists(folder) and not os.path.isdir(folder):
        raise ToolError(f"DIR: {folder} is a file; choose another name")
    features = choose(read_features(source), stems)
    if has_originals(source) and real == os.path.realpath(os.path.dirname(features[0].workbook)):
        return _put_starters_back(features)
    kit, place, build = (".", named, ".") if named else (source, folder, os.getcwd())
    files = {feature.stem + ".c": starter_of(feature.reference) for feature in features}
    for feature in features:
        files[feature.stem + ".md"] = as_in_workbook(handout_of(source, feature), kit, feature, place)
    first = features[0]
    shown = shlex.quote(place.rstrip("/") or "/")
    lines = [(command.format(first=first.stem, folder=shown), does) for command, does in COMMANDS]
    width = max(len(command) for command, _ in lines)
    files["README.txt"] = README.format(
        commands="\n".join(f"    {command:<{width}}  {does}" for command, does in lines),
        assignments="\n".join(f"    {f.stem + '.c':<24}chapter {f.chapter}" for f in features),
        first=first.stem, chapter=first.chapter, folder=shown,
    )
    files |= workbook_files(kit, place, build, place)
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
    manifest, said = os.path.join(folder, MANIFEST), []
    generated = _read_manifest(manifest)
    for name, text in files.items():
        _put(os.path.join(folder, name), text, generated, said)
    write_whole(manifest, "".join(f"{digest}  {name}\n" for name, digest in sorted(generated.items())))
    return said + [f"next: make check-{first.stem} IMPL={shlex.quote(folder)}"]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--named", metavar="NAME", help="the folder's name in a kit built in its own folder, "
                        "where the workbook is to be used; default: DIR, here")
    parser.add_argument("folder", metavar="DIR", help="the workbook")
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    arguments = parser.parse_args()
    return run_command("workbook", lambda: print("\n".join(
        make_workbook(arguments.source, arguments.folder, arguments.stems, arguments.named))))


if __name__ == "__main__":
    sys.exit(main())
