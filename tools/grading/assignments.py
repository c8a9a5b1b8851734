"""The tables of assignments, and the units that solve them.

assignments/features.tsv lists the features (stem, folder, needs, uses, and README's words), from which
tools/features.sh makes the build's lists; assignments/FOLDER/points.tsv lists the scored tests of one
(test, points, step, section of the chapter to read), simplest first. Every tool for students and instructors
reads both, so a new feature needs two tables and no code.
"""

import argparse
import csv
import errno
import filecmp
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

from grading import least_python  # noqa: F401


class ToolError(Exception):
    """An error that the user can correct; the text is one sentence that says how."""


class UnitError(ToolError):
    """A submission that cannot be graded, and so earns nothing; the text is the reason."""


class UngradableError(UnitError):
    """One of which nobody knows what it earns until somebody has done what the text says."""


class UnreadableError(UngradableError):
    """One that the system does not let this user read."""

    def __init__(self, what):
        super().__init__(f"{what} cannot be read; check its permissions")


class MachineError(ToolError):
    """A fault of this machine, which says nothing about a submission: it may do later, or elsewhere."""


_MACHINES_FAULTS = {errno.ENOSPC, errno.EDQUOT, errno.ENOMEM, errno.EMFILE, errno.ENFILE, errno.EAGAIN,
                    errno.EIO, errno.EROFS, errno.ESTALE, errno.ENODEV}


def is_machines_fault(error):
    """Whether an exception tells of a full disk, no memory or the like."""
    return isinstance(error, (MachineError, MemoryError)) or (
        isinstance(error, OSError) and error.errno in _MACHINES_FAULTS)


_FULL = "; free some space, or choose another place"
_ADVICE = {errno.ENOSPC: _FULL, errno.EDQUOT: _FULL, errno.ENAMETOOLONG: "; choose a shorter name"}


def cannot_write(path, error):
    """Returns the ToolError for an OSError that prevents writing a file or folder."""
    kind = MachineError if is_machines_fault(error) else ToolError
    return kind(f"{path}: cannot be written: {error.strerror}{_ADVICE.get(error.errno, '')}")


class Parser(argparse.ArgumentParser):
    """Reports errors in one line, without the usage."""

    def error(self, message):
        name = os.path.splitext(self.prog)[0].replace("_", "-")
        self.exit(2, f"{name}: {message}; see --help\n")


def run_command(name, work, status=1, kept="", elsewhere=None):
    """Does a command's work and returns its exit status, `elsewhere`, if that is given, where this machine is
    to blame. An error is said in one line, and so is Ctrl-C, with what is kept of the work."""
    try:
        return int(work() or 0)
    except (ToolError, OSError, subprocess.CalledProcessError) as error:
        said = error
        if isinstance(error, subprocess.CalledProcessError):
            said = f"{shlex.join(map(str, error.cmd[:1]))} failed; its reason is above"
        elif isinstance(error, OSError):
            said = f"{error.filename or 'the system'}: {error.strerror or error}"
        print(f"{name}: {said}", file=sys.stderr)
        return elsewhere if elsewhere is not None and is_machines_fault(error) else status
    except KeyboardInterrupt:
        print(f"{name}: stopped{kept}", file=sys.stderr)
        return 130


def choose_format(name, formats):
    """Raises ToolError unless FORMAT names one of these."""
    if name not in formats:
        raise ToolError(f"FORMAT={name}: choose one of {', '.join(sorted(formats))}")


def read_places(book):
    """Returns a dictionary from the names of a book's sections, figures and listings to their pages; empty
    where there is no book of pages."""
    try:
        text = (pathlib.Path(book) / "places.js").read_text(encoding="utf-8")
    except OSError:
        return {}
    return json.loads(text[text.index("{"):text.rindex("}") + 1])


class Feature:
    """A row of features.tsv. What it needs may be the student's, too; what it uses is always the kit's."""

    def __init__(self, source, stem, folder, needs, uses="", about=""):
        self.about = about  # what the effect is, for lists of all
        self.stem, self.folder, self.needs, self.uses = stem, folder, needs.split(), uses.split()
        self.reference = os.path.join(source, "src", "features", stem + ".c")
        self.header = os.path.join(source, "src", "features", stem + ".h")
        self.workbook = os.path.join(source, "workbook",
                                     stem + ".c")  # the unit of a feature handed out in a pack
        self.source, self.chapter = source, f"docs/{folder}.md"
        self.points_table = os.path.join(source, "assignments", folder, "points.tsv")
        self.suite = os.path.join(source, "tests", f"test_{stem}.c")

    def page_name(self):
        """Returns the name of the chapter's first page in a book of pages, which is its first heading's."""
        with open(os.path.join(self.source, self.chapter), encoding="utf-8") as file:
            return re.search(r"\{#([\w-]+)\}", file.readline())[1] + ".html"

    def page(self, section=""):
        """Returns the page with this section of the chapter, such as "#bloom-box", or its first page, in the
        book that `make book` has woven, or in a pack's; None without a book."""
        for room in ("out", "handout"):
            book = pathlib.Path(self.source, "docs", room, "book").resolve()
            page = book / read_places(book).get(section[1:], self.page_name())
            if page.is_file():
                return page
        return None

    def where_to_read(self, section):
        """Returns the address of a section in the book, for a click; without a book, the chapter's text and
        the section, and how to get pages."""
        page = self.page(section)
        return page.as_uri() + section if page else (
            f"{self.chapter}{section} (source text: there is no book here; make book weaves it)")


class ScoredTest:
    """A row of points.tsv. `step` is the handout's step that turns it green, 0 for a test without
    points; `green_since` an earlier one after which it happens to hold, or 0."""

    def __init__(self, name, points, section, step=0, green_since=0):
        self.name, self.points, self.section = name, points, section
        self.step, self.green_since = step, green_since


# Points that a claim without points costs if it fails: it held with the starter, and must continue to hold.
DEDUCTION = 5
# Claims that the grader judges itself, for every assignment.
KEEPS_NOTHING = ScoredTest("no_data_is_kept_between_calls", 0, "")
FREES_ALL = ScoredTest("all_memory_is_freed", 0, "")


def cause_of(error, build):
    """Returns what an OSError says: that the build folder is gone, if it is."""
    if not os.path.isdir(build):
        return "this folder was moved or removed; run the same command in the new place"
    return f"{error.filename or 'the system'}: {error.strerror}"


def run_loop(name, build, work):
    """As run_command, for work that goes on until Ctrl-C."""
    try:
        work()
    except (ToolError, OSError) as error:
        print(f"{name}: {cause_of(error, build) if isinstance(error, OSError) else error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print()
    return 0


def read_table(path, columns):
    """The rows of a table whose columns are separated by tabs and named in its first line."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    except OSError as error:
        raise ToolError(f"{path} cannot be read: {error.strerror}") from error
    if not rows or rows[0] != columns:
        raise ToolError(f"{path}:1: the header should be {', '.join(columns)}, separated by tabs")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(columns):
            raise ToolError(f"{path}:{number}: {len(columns)} columns are needed, separated by tabs; "
                            f"this line has {len(row)}")
    return rows[1:]


def read_features(source):
    """Returns a dictionary from stem to Feature, in the table's order."""
    path = os.path.join(source, "assignments", "features.tsv")
    rows = read_table(path, ["stem", "folder", "needs", "uses", "about", "picture"])
    features = {row[0]: Feature(source, *row[:5]) for row in rows}
    for feature in features.values():
        for need in feature.needs:
            if need not in features:
                raise ToolError(f"{path}: {feature.stem} needs {need}, which the table does not list")
        for used in feature.uses:
            if used not in features or used in feature.needs or used == feature.stem:
                raise ToolError(f"{path}: {feature.stem} uses {used}, "
                                "which the table does not list, or lists as needed")
    return features


def choose(features, stems):
    """Returns the features with these stems, all of them for none."""
    for stem in stems:
        if stem not in features:
            raise ToolError(f"there is no feature \"{stem}\"; choose one of: {', '.join(features)}")
    return [features[stem] for stem in stems] if stems else list(features.values())


def read_points(feature):
    """Returns the feature's scored tests, in the order in which a student works. Those without
    points hold with the starter, and must continue to hold."""
    tests = []
    for number, row in enumerate(
        read_table(feature.points_table, ["test", "points", "step", "section"]), 2
    ):
        if not row[1].isdigit():
            raise ToolError(f"{feature.points_table}:{number}: points are whole numbers, not {row[1]}")
        if any(test.name == row[0] for test in tests):
            raise ToolError(f"{feature.points_table}:{number}: {row[0]} is listed twice")
        step = re.fullmatch(r"(\d+)(?: \(green since (\d+)\))?", row[2]) if row[2] != "-" else None
        if (step is None) != (row[1] == "0"):
            raise ToolError(f"{feature.points_table}:{number}: the step is \"3\" or \"3 (green since 2)\", "
                            "or - for a test without points")
        tests.append(ScoredTest(row[0], int(row[1]), row[3],
                                *(int(k or 0) for k in step.groups()) if step else ()))
    if not tests:
        raise ToolError(f"{feature.points_table} lists no tests")
    return tests


class Look:
    """A row of look.tsv: what can be seen after a step, by the driver with these options."""

    def __init__(self, feature, step, options, caption):
        self.step, self.options, self.caption = step, options, caption
        self.picture = os.path.join(os.path.dirname(feature.points_table), "look", f"{step}.png")


def read_looks(feature):
    """Returns the steps of an assignment after which there is something to see; the last of them is the last
    step."""
    path = os.path.join(os.path.dirname(feature.points_table), "look.tsv")
    looks = []
    for number, row in enumerate(read_table(path, ["step", "options", "caption"]), 2):
        if not row[0].isdigit() or any(int(row[0]) <= look.step for look in looks):
            raise ToolError(f"{path}:{number}: each step has one row, and they are in order")
        looks.append(Look(feature, int(row[0]), *row[1:]))
    if not looks:
        raise ToolError(f"{path} lists no step; one at least can be seen")
    return looks


class Unit:
    """The C file that solves a feature; `path` is None where there is none."""

    def __init__(self, feature, path, shown, is_reference):
        self.feature, self.path, self.shown = feature, path, shown
        self.is_reference = is_reference


def is_archive(name):
    """Whether a file's name says that it has to be unpacked first."""
    return name.lower().endswith((".zip", ".tar", ".tgz", ".tar.gz", ".tar.xz", ".tar.bz2", ".7z", ".rar"))


_ARCHIVES = {b"\x1f\x8b": "gzip", b"PK\3\4": "zip", b"BZh91AY&SY": "bzip2", b"\xfd7zXZ\0": "xz",
             b"7z\xbc\xaf\x27\x1c": "7z", b"Rar!\x1a\7": "rar", b"\x28\xb5\x2f\xfd": "zstd"}


def archive_in(data):
    """Returns which kind of archive the bytes of a file are, or "". The first 512 are enough."""
    kind = next((name for begin, name in _ARCHIVES.items() if data.startswith(begin)), "")
    return "tar" if data[257:262] == b"ustar" else kind


def is_misnamed_c(name):
    """Whether a file's name is one of those that C files get by mistake."""
    return name.endswith(".C") or name.lower().endswith((".cpp", ".cc", ".cxx", ".c.txt"))


_DEEPEST = 30  # folders in folders; Python would not come out of a thousand


def walk(folder):
    """os.walk without what lies too deep for a person to have put it there. Such a folder is named as a file
    "..." in it."""
    for where, folders, names in os.walk(folder):
        if os.path.relpath(where, folder).count(os.sep) >= _DEEPEST and folders:
            folders[:], names = [], [*names, _TOO_DEEP]
        yield where, folders, names


_TOO_DEEP = " ..."


def _walk_visible(folder):
    """As walk, without hidden files and folders."""
    for where, folders, names in walk(folder):
        # macOS puts a folder of this name into archives.
        folders[:] = [name for name in folders if name[0] != "." and name != "__MACOSX"]
        yield where, folders, [name for name in names if name[0] != "."]


def _check_readable(folder, top=None):
    """Raises UnreadableError for a folder, named as seen from where its `top` lies."""
    if not os.access(folder, os.R_OK | os.X_OK):
        above = os.path.dirname(os.path.abspath(top or folder))
        raise UnreadableError(f"the folder {os.path.relpath(folder, above)}")


def _check_readable_below(top):
    """The same for a folder and all in it."""
    _check_readable(top)
    for where, folders, _ in _walk_visible(top):
        for path in (os.path.join(where, name) for name in folders):
            if not os.path.islink(path):  # these are not followed
                _check_readable(path, top)


def _files_below(folder):
    """Returns the files below a folder as paths from there, without hidden ones, those at the top first."""
    found = []
    for where, _, names in _walk_visible(folder):
        found += [os.path.relpath(os.path.join(where, name), folder) for name in names]
    return sorted(found, key=lambda path: (path.count(os.sep), path))


def reference_unit(feature):
    """Returns the reference as a unit."""
    return Unit(feature, feature.reference, f"src/features/{feature.stem}.c", True)


def _unit_in(feature, path):
    if os.path.exists(feature.reference) and os.path.exists(path) and os.path.samefile(path,
                                                                                       feature.reference):
        return reference_unit(feature)
    if not os.path.isfile(path):
        raise UnitError(f"{os.path.basename(path)} is not a plain file")
    if not os.access(path, os.R_OK):
        raise UnreadableError(os.path.basename(path))
    return Unit(feature, path, path, False)


def find_unit(feature, impl):
    """Returns the unit for a feature in IMPL, a C file or a folder with STEM.c, or one without a
    path where the folder has none."""
    if os.path.isdir(impl):
        path = os.path.join(impl, feature.stem + ".c")
        if os.path.lexists(path):
            return _unit_in(feature, path)
        return Unit(feature, None, path, False)
    return _unit_in(feature, impl)


def _place_below(feature, impl):
    """Returns the path from a folder of the only STEM.c below it, None if there is none. In a whole pack it
    is the one in the workbook."""
    name = feature.stem + ".c"
    files = _files_below(impl)
    places = [path for path in files if os.path.basename(path) == name]
    if not places and any(os.path.basename(path) == _TOO_DEEP for path in files):
        raise UngradableError(f"there is no {name} in the first {_DEEPEST} folders within folders; move it "
                              "to the top of the folder")
    if not places:  # a browser numbers what was downloaded or handed in again
        again = re.compile(rf"{feature.stem}(-[0-9]+| ?\([0-9]+\))\.c")
        places = [path for path in files if again.fullmatch(os.path.basename(path))]
    in_workbooks = [path for path in places if os.path.basename(os.path.dirname(path)) == "workbook"]
    chosen = in_workbooks if len(in_workbooks) == 1 else places
    if len(chosen) > 1:
        raise UngradableError(f"there are several {name}: {', '.join(chosen[:4])}; "
                              f"move the right one to the top of the folder, as {name}")
    return chosen[0] if chosen else None


def submitted_unit(feature, impl, place=None):
    """Returns the submitted unit, or raises UnitError if it is missing or a link to somebody else's
    work. `place` is its path from the folder IMPL, if not STEM.c."""
    path = os.path.join(impl, place or feature.stem + ".c") if os.path.isdir(impl) else impl
    if os.path.islink(path):
        place = os.path.realpath(path)
        if place == os.path.realpath(feature.reference):
            raise UnitError(f"{os.path.basename(path)} is a link to the reference, which earns no points")
        if not os.path.isdir(impl) or not place.startswith(os.path.join(os.path.realpath(impl), "")):
            raise UnitError(f"{os.path.basename(path)} is a link to a file outside of the submission")
    if not os.path.lexists(path):
        likely = _likely(feature, impl)
        if likely:
            raise UngradableError(f"there is no {feature.stem}.c; {likely}")
        raise UnitError(f"there is no {feature.stem}.c; found: {_what_is_in(impl)}")
    return _unit_in(feature, path)


def _unpacked(unit):
    """Returns the unit, or raises UngradableError if it is an archive under the name of a C file."""
    with open(unit.path, "rb") as file:
        kind = archive_in(file.read(512))
    if kind:
        raise UngradableError(f"{os.path.basename(unit.path)} is an archive ({kind}); unpack it")
    return unit


def handed_in(feature, impl):
    """Returns the submitted unit as a grader finds it, also below the top of the folder, and remarks on where
    that was, and on an edited suite in the pack around it, which does not count."""
    if not os.path.isdir(impl) or os.path.lexists(os.path.join(impl, feature.stem + ".c")):
        return _unpacked(submitted_unit(feature, impl)), []
    place = _place_below(feature, impl)
    if not place or not os.path.lexists(os.path.join(impl, place)):
        _check_readable_below(impl)
    unit, remarks = _unpacked(submitted_unit(feature, impl, place)), [f"taken from {place}"]
    suite = os.path.join(os.path.dirname(os.path.dirname(place)), "tests", os.path.basename(feature.suite))
    path = os.path.join(impl, suite)
    if os.path.isfile(path) and os.access(path, os.R_OK) and not filecmp.cmp(path, feature.suite,
                                                                             shallow=False):
        remarks.append(f"{suite} differs from the kit's, which was run")
    return unit, remarks


def ignored_in(features, folder, taken):
    """Returns remarks on what a folder holds beside the files that were taken, other units, headers, texts
    and pictures."""
    units, names = {*taken, *(stem + ".c" for stem in features)}, []
    for path in _files_below(folder):
        if path not in units and not path.lower().endswith((".h", ".md", ".txt", ".pdf", ".png", ".o")):
            top, below, _ = path.partition(os.sep)
            names.append(top + below)
    names = list(dict.fromkeys(names))
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return [f"ignored: {', '.join(names[:4])}{more}"] if names else []


def _what_is_in(folder):
    """Names up to eight files below the folder."""
    names = _files_below(folder)
    return ", ".join([*names[:8], "..."] if len(names) > 8 else names) or "nothing"


def _likely(feature, folder):
    """Says how a folder gets the unit that is missing there from a file in it, or returns ""."""
    name, plain, files = feature.stem + ".c", feature.stem.replace("_", ""), _files_below(folder)
    for path in files:
        other = os.path.basename(path)
        if other != name and (other.endswith(".c") or is_misnamed_c(other)) and (
                plain in re.sub("[-_ ]", "", other.lower())):
            return f"rename {path} to {name}"
    return next((f"unpack {path}" for path in files if is_archive(path)), "")


def remedy(feature, folder, shown):
    """Says how a folder gets the unit that is missing there: from the file that was probably meant, or
    anew."""
    return _likely(feature, folder) or f"make workbook DIR={shlex.quote(shown)} puts the starter there"


def missing_unit(feature, impl):
    """Returns the ToolError for a folder IMPL that has no unit for a feature."""
    return ToolError(f"there is no {os.path.join(impl, feature.stem + '.c')}; {remedy(feature, impl, impl)}")


def unit_beside(feature, impl, handed_out):
    """Returns the unit with which another feature's work is built: the reference, so that each
    assignment is graded separately. If the feature is handed out, too, and so has no reference, it is
    the one in the folder IMPL, or else in the workbook."""
    if feature.stem not in handed_out:
        return reference_unit(feature)
    if os.path.isdir(impl):
        try:
            unit = find_unit(feature, impl)
            if unit.path is not None:
                return unit
        except UnitError:
            pass
    if not os.path.isfile(feature.workbook):
        how = remedy(feature, os.path.dirname(feature.workbook), "workbook")
        raise ToolError(f"workbook/{feature.stem}.c is missing; {how}")
    return Unit(feature, feature.workbook, f"workbook/{feature.stem}.c", False)


def units_of_suite(feature, units):
    """Returns the units with which a feature's suite is built beside its own, of `units`, by stem
    (unit_beside)."""
    return [units[stem] for stem in feature.needs + feature.uses]


def check_impl(features, impl, stems, may_be_empty=False):
    """Raises ToolError unless IMPL can be used for these stems; a grader also accepts a folder
    without matching units."""
    if not impl:
        raise ToolError("name the work: IMPL=mine (a folder) or IMPL=my_file.c")
    if os.path.isdir(impl):
        if not may_be_empty and not any(os.path.lexists(os.path.join(impl, stem + ".c"))
                                        for stem in features):
            _check_readable(impl)
            if len(stems) == 1 and _likely(features[stems[0]], impl):
                raise missing_unit(features[stems[0]], impl)
            names = ", ".join(stem + ".c" for stem in features)
            raise ToolError(
                f"IMPL: the folder {impl} holds no unit ({names}); "
                f"make workbook DIR={impl} puts the starters there"
            )
    elif not os.path.lexists(impl):
        raise ToolError(
            f"IMPL: there is no file or folder {impl}; make workbook DIR=mine makes one"
        )
    elif is_archive(impl):
        raise ToolError(f"IMPL: {impl} is an archive; unpack it into a folder")
    elif not impl.endswith(".c"):
        name = stems[0] + ".c" if len(stems) == 1 else "STEM.c"
        raise ToolError(f"IMPL: {impl} is not a C file; name it {name}, or give a folder that holds {name}")
    elif len(stems) != 1:
        name = os.path.basename(impl)
        names = " or ".join([stem + ".c" for stem in stems[:2]] + ["so on"] * (len(stems) > 2))
        raise ToolError(f"{name} is one file for {len(stems)} assignments: put it into a folder "
                        f"{name.removesuffix('.c')}, as {names}")
