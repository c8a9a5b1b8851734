#!/usr/bin/env python3
"""Packs the kit for students: everything but the solutions of the named assignments, proven.

The pack is a release of the kit in which those features' sources are starters in workbook/; a line in
src/features tells the build so (tools/features.sh). It is made beside its destination and moved there
when it is complete and found free of solutions (leak_check.py).
"""

import errno
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile

from grading.assignments import Parser, ToolError, cannot_write, choose, read_features, read_points
from handout_text import as_packed, handout_of
from grading.leak_check import prove
from grading.starters import RegionError, handed_out_of, starter_of
from grading.results import write_whole

HANDOUT = """\
# What is handed out here

This is raykit, a teaching kit for ray tracing in C, with a part left open for you to write.

{assignments}

## Begin

    ./bootstrap
    make check-{first}

The first line installs what is missing and configures. The second builds what it needs, tests your
file and says what to work on first; now all that gives points fails. Then read, solve the first step,
and check again. `make` alone builds the rest: the drivers in `assignments/`, which draw pictures by
your code; `--help` lists their options.

{reading}

## Go on

    {one}  one test alone, by its name
    {watch}  the check again whenever you save; Ctrl-C ends it
    {debug}  the first failing test in gdb, stopped in your code
    {diff}  what you have changed since the starter
    {progress}  the points that you have
    {report}  pictures and measurements by your code: reports/out/report.html
    {check}  all suites; those that use your code fail until it is solved

`watch` and `debug` take `TEST=name`, too. A test that takes longer than 10 seconds is stopped and has
failed; `RAYKIT_TEST_SECONDS=60 make check-{first}` gives each a minute.

`IMPL=folder` with any of these means the files of another folder, a copy of an older state, say. What
stands in `src/features` for these assignments is the starter once more, for comparison; nothing uses
it.

## Hand in

{files}

Hand in nothing else, unless your instructor asks for more.
"""


# --- The place ------------------------------------------------------------------------------------


def place_of(out, folder):
    """Returns where the pack goes and the name of its top folder."""
    if out and folder:
        raise ToolError("give OUT=file.tar.gz or DIR=folder, not both")
    place = os.path.normpath(out or folder or "raykit-handout.tar.gz")
    if not folder and not place.endswith(".tar.gz"):
        raise ToolError(f"OUT: {place} should end in .tar.gz; for a folder give DIR={place}")
    if os.path.lexists(place):
        raise ToolError(f"{place} exists; remove it, or choose another name by OUT=... or DIR=...")
    parent = os.path.dirname(os.path.abspath(place))
    if not os.path.isdir(parent):
        raise ToolError(f"{place}: there is no folder {parent}; make it first")
    return place, os.path.basename(place).removesuffix("" if folder else ".tar.gz")


# --- The pack -------------------------------------------------------------------------------------


def _release(pack):
    """The files that make dist would pack, without those that ./bootstrap makes."""
    command = [os.environ.get("MAKE", "make"), "-s", "distdir", f"distdir={pack}"]
    environment = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
    answer = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            errors="replace", check=False)
    if answer.returncode:
        raise ToolError(f"the kit's files could not be gathered:\n{answer.stdout.strip()}")
    for name in ("configure", "Makefile.in", "aclocal.m4", "features.am"):
        os.unlink(os.path.join(pack, name))
    shutil.rmtree(os.path.join(pack, "build-aux"))


def _hand_out(pack, features):
    """Replaces solutions by starters, from which the build knows which sources to take from workbook/."""
    os.mkdir(os.path.join(pack, "workbook"))
    for feature in features:
        old, new = f"src/features/{feature.stem}.c", f"workbook/{feature.stem}.c"
        write_whole(os.path.join(pack, new), starter_of(feature.reference))
        write_whole(os.path.join(pack, old), handed_out_of(feature.reference, new))
        os.unlink(os.path.join(pack, "tests", "mutants", f"{feature.stem}.mutants"))


def _adapt_texts(source, pack, features, chosen):
    """Adapts chapters and handouts to the workbook; removes assignments that are not handed out."""
    os.unlink(os.path.join(pack, "assignments", "handout_common.md"))
    for feature in features:
        if feature not in chosen:
            os.unlink(os.path.join(pack, "assignments", feature.folder, "handout.md"))
    texts = {f"assignments/{feature.folder}/handout.md": handout_of(source, feature) for feature in chosen}
    for name in ("docs/book.md", *(feature.chapter for feature in features)):
        with open(os.path.join(pack, name), encoding="utf-8") as file:
            texts[name] = file.read()
    for name, text in texts.items():
        write_whole(os.path.join(pack, name), as_packed(text, name, [feature.stem for feature in chosen]))


def _weave_book(pack, features):
    """Makes docs/handout/book.html: the pack's text and code, the figures of this build's drivers."""
    drivers = []
    for feature in features:
        path = os.path.join("assignments", feature.folder, feature.stem)
        os.symlink(os.path.abspath(path), os.path.join(pack, path))
        drivers.append(os.path.join(pack, path))
    environment = dict(os.environ, RAYKIT_SOURCE=pack, RAYKIT_BUILD=pack, RAYKIT_DRIVERS=pack,
                       CHROMIUM="", SOLUTIONS="yes")
    answer = subprocess.run(["sh", os.path.join(pack, "docs", "make_book")], env=environment,
                            stderr=subprocess.PIPE, text=True, errors="replace", check=False)
    if answer.returncode:
        raise ToolError(f"the book could not be woven; BOOK=no leaves it out:\n{answer.stderr.strip()}")
    os.mkdir(os.path.join(pack, "docs", "handout"))
    os.rename(os.path.join(pack, "docs", "out", "book.html"), os.path.join(pack, "docs", "handout", "book.html"))
    shutil.rmtree(os.path.join(pack, "docs", "out"))
    for driver in drivers:
        os.unlink(driver)


def _title(pack, feature):
    with open(os.path.join(pack, "assignments", feature.folder, "handout.md"), encoding="utf-8") as file:
        return file.readline().lstrip("# ").rstrip()


def _write_handout(pack, features, has_book):
    """Writes HANDOUT.md, the student's first page."""
    rows = ["| task | your file | points | chapter |", "|---|---|---|---|"]
    for feature in features:
        task, file = f"assignments/{feature.folder}/handout.md", f"workbook/{feature.stem}.c"
        points = sum(test.points for test in read_points(feature))
        rows.append(f"| [{_title(pack, feature)}]({task}) | [{file}]({file}) | {points} "
                    f"| [{feature.chapter}]({feature.chapter}) |")
    first = features[0].stem
    reading = ("Open `docs/handout/book.html` in a browser: the chapters, with figures as they should become.\n"
               "`make book` makes `docs/out/book.html`, with figures by your code."
               if has_book else "`make book` makes `docs/out/book.html`, the chapters, with figures by your code.")
    one = f"make check-{first} TEST=name"
    width = len(one)
    commands = {"one": one} | {word: f"make {word}-{first}".ljust(width) for word in ("watch", "debug", "diff")}
    commands |= {word: f"make {word}".ljust(width) for word in ("progress", "report", "check")}
    files = "\n".join(f"- `workbook/{feature.stem}.c`" for feature in features)
    write_whole(os.path.join(pack, "HANDOUT.md"), HANDOUT.format(
        assignments="\n".join(rows), first=first, reading=reading, files=files, **commands))


# --- The command ----------------------------------------------------------------------------------


def make_handout(source, stems, out="", folder="", book=True):
    """Makes the pack; returns lines that describe it."""
    features = read_features(source)
    if not stems:
        raise ToolError(f"name the assignments: make handout ASSIGNMENTS=\"...\", of: {' '.join(features)}")
    named = choose(features, stems)
    chosen = [feature for feature in features.values() if feature in named]  # in the course's order
    place, name = place_of(out, folder)
    has_book = book and bool(os.environ.get("PANDOC"))
    try:
        work = tempfile.mkdtemp(prefix=".handout-", dir=os.path.dirname(os.path.abspath(place)))
    except OSError as error:
        raise cannot_write(place, error) from error
    try:
        pack = os.path.join(work, name)
        _release(pack)
        _hand_out(pack, chosen)
        _adapt_texts(source, pack, features.values(), chosen)
        if has_book:
            _weave_book(pack, features.values())
        _write_handout(pack, chosen, has_book)
        proof = prove(source, pack, features, chosen)
        if not folder:
            with tarfile.open(pack + ".tar.gz", "w:gz") as archive:
                archive.add(pack, name, filter=_anonymous)
        os.rename(pack + ("" if folder else ".tar.gz"), place)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    without = "" if has_book else ", without the book" + (" (it needs pandoc)" if book else "")
    return [f"handed out: {' '.join(feature.stem for feature in chosen)}{without}", *proof,
            f"wrote {place}; students begin with its HANDOUT.md"]


def _anonymous(entry):
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    return entry


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features to hand out")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--out", default="", metavar="FILE", help="the archive")
    parser.add_argument("--dir", default="", metavar="DIR", help="a folder instead of an archive")
    parser.add_argument("--book", default="", metavar="yes|no", help="no leaves the woven book out")
    arguments = parser.parse_args()
    try:
        if arguments.book not in ("", "yes", "no"):
            raise ToolError(f"BOOK={arguments.book}: choose yes or no")
        print("\n".join(make_handout(arguments.source, arguments.stems, arguments.out, arguments.dir,
                                     arguments.book != "no")))
    except (ToolError, RegionError) as error:
        print(f"handout: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        why = cannot_write(arguments.out or arguments.dir, error) if full else (
            f"{error.filename or 'the system'}: {error.strerror}")
        print(f"handout: {why}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("handout: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
