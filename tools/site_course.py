#!/usr/bin/env python3
"""Makes the site of a course from a pack for students, without the solutions of the named assignments,
proven. It is a folder or a zip; --site makes that of the kit's own site.

The units that are linked with suites and drivers in the page are the pack's (handout.py): starters of the
assignments and of later ones. Lines of the solutions are looked for in all texts of the site, and their code
in its objects (site/leak_check.mjs)."""

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile

from grade import stop_on_signals
from grading.assignments import Parser, ToolError, cannot_write, read_features
from grading.course_words import read_words
from grading.leak_check import find_secrets, prove, secret_lines
from handout import (check_place, check_words, choose_course, fill_pack, run, tell, told_of_solutions,
                     weave_book)

_CLANG = "clang"  # the folder of a site with the compiler, which is not the kit's
_FIRST_DATE = (1980, 1, 1, 0, 0, 0)  # of a zip's files: the same site is the same file


def _zipped(folder, path):
    """Packs a site with its first page at the top, as learning platforms want it."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for where, folders, names in os.walk(folder):
            folders.sort()
            for name in sorted(names):
                place = os.path.join(where, name)
                entry = zipfile.ZipInfo(os.path.relpath(place, folder), _FIRST_DATE)
                entry.external_attr = 0o644 << 16
                entry.compress_type = zipfile.ZIP_STORED if name.endswith(".gz") else zipfile.ZIP_DEFLATED
                with open(place, "rb") as file:
                    archive.writestr(entry, file.read())


def _weight(site):
    sizes = [os.path.getsize(os.path.join(where, name)) for where, _, names in os.walk(site)
             for name in names]
    return f"{len(sizes)} files, {sum(sizes) / 1e6:.1f} MB"


def _publish(site, place):
    """Moves a site to its place, as a folder or a zip; returns a line that says so."""
    weight = _weight(site)
    if place.endswith(".zip"):
        tell("packing")
        _zipped(site, site + ".zip")
        site += ".zip"
    os.rename(site, place)
    return f"wrote {place}: {weight}"


def _make_site(pack, site, left_out, chosen, has_book, title, note):
    """Lets make's rules do it: they know the sources of suites and drivers."""
    environment = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
    environment.update(RAYKIT_PACK=pack, RAYKIT_SITE=site, RAYKIT_SITE_TITLE=title, RAYKIT_SITE_NOTE=note,
                       RAYKIT_OPEN=" ".join(feature.stem for feature in left_out))
    command = [os.environ["MAKE"], "-s", "site-of-pack", f"site_book={'yes' if has_book else ''}",
               "ASSIGNMENTS=" + " ".join(feature.stem for feature in chosen)]
    status, said = run(command, environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if status:
        raise ToolError(f"the site could not be made:\n{said}")
    return said.splitlines()


def _check_texts(source, site, left_out):
    """Raises ToolError if a text of the site has a line of a solution."""
    secrets, common = secret_lines(source, left_out)
    found = find_secrets(source, site, left_out, secrets, common, beside=_CLANG)
    if found:
        raise ToolError("\n".join(["these lines of the site are solutions:", *found[:10]]))


def make_course(source, stems, place, book=True, later="", title="", note=""):
    """Makes the site; returns lines that describe it."""
    features, words = read_features(source), read_words(title, note)
    chosen, left_open = choose_course(features, stems, later)
    left_out = [*chosen, *left_open]
    check_place(place)
    check_words(words, source, left_out)
    if not os.environ.get("PANDOC"):
        raise ToolError("the texts need pandoc: run ./bootstrap")
    try:
        work = tempfile.mkdtemp(prefix=".site-", dir=os.path.dirname(os.path.abspath(place)))
    except OSError as error:
        raise cannot_write(place, error) from error
    try:
        pack, site = os.path.join(work, "pack"), os.path.join(work, "site")
        fill_pack(source, pack, features, chosen, left_open)
        tell("looking for lines of the solutions")
        proof = prove(source, pack, features, left_out)
        os.mkdir(site)
        shutil.copytree(os.path.join("site", _CLANG), os.path.join(site, _CLANG))
        if book:
            made, _ = weave_book(pack)
            for part in ("book", "source", "figures", "tables"):
                shutil.copytree(os.path.join(made, part), os.path.join(site, part))
        tell("compiling for the page, and looking for the solutions' code")
        proof += _make_site(pack, site, left_out, chosen, book, title, note)
        words.check_links(site, False, "site")
        _check_texts(source, site, left_out)
        told = told_of_solutions(features, chosen, left_open, later, "site")
        return [*told, *proof, _publish(site, place)]
    finally:
        shutil.rmtree(work, ignore_errors=True)


def copy_site(site, place):
    """Copies the kit's own site; returns lines that describe the copy."""
    check_place(place)
    work = tempfile.mkdtemp(prefix=".site-", dir=os.path.dirname(os.path.abspath(place)))
    try:
        shutil.copytree(site, os.path.join(work, "site"))
        return [_publish(os.path.join(work, "site"), place)]
    finally:
        shutil.rmtree(work, ignore_errors=True)


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features of the course")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--out", default="", metavar="DIR|FILE.zip", help="the folder, or the zip")
    parser.add_argument("--site", default="", metavar="DIR", help="the kit's own site, to be copied")
    parser.add_argument("--later", default="", metavar="all|no|STEMS",
                        help="features that are not asked for yet; "
                        "default: those that come later in the course")
    parser.add_argument("--title", default="", metavar="TEXT", help="the course's title for the first page")
    parser.add_argument("--note", default="", metavar="FILE|TEXT",
                        help="what the course says there, such as dates and links; Markdown")
    parser.add_argument("--book", default="", metavar="yes|no", help="no leaves the woven book out")
    arguments = parser.parse_args()
    stop_on_signals()
    place = os.path.normpath(arguments.out or "course-site")
    try:
        if arguments.book not in ("", "yes", "no"):
            raise ToolError(f"BOOK={arguments.book}: choose yes or no")
        said = copy_site(arguments.site, place) if arguments.site else make_course(
            arguments.source, arguments.stems, place, arguments.book != "no", arguments.later,
            arguments.title, arguments.note)
        print("\n".join(said))
    except (ToolError, OSError) as error:
        print(f"site_course: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("site_course: stopped; nothing was written", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
