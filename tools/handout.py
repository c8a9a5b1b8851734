#!/usr/bin/env python3
"""Packs the kit for students: everything but the solutions of the named assignments, proven.

The pack is a release of the kit in which those features' sources are starters in workbook/, and those of
later assignments are starters in src/features; lines there tell the build so (tools/features.sh). It is
made beside its destination and moved there when it is complete and found free of solutions
(leak_check.py).
"""

import errno
import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import textwrap

from grading.assignments import Parser, ToolError, cannot_write, choose, read_features, read_points
from grade import stop_on_signals
from handout_text import as_packed, handout_of, with_built_drivers
from grading.course_words import read_words
from grading.leak_check import prove, solution_in
from grading.originals import keep_originals
from grading.starters import handed_out_of, left_open_of, starter_of
from grading.results import write_whole
from grading.workbook_files import workbook_files
from png import size_of


# What checks the workbook on git hosts, and where these look for it.
_WORKFLOWS = {"check.yml": os.path.join(".github", "workflows", "raykit.yml"),
              "check.gitlab-ci.yml": ".gitlab-ci.yml"}
_SECONDS_TO_CLEAN_UP = 10  # it removes a few folders


# --- The place ------------------------------------------------------------------------------------


def check_place(place, named="OUT=..."):
    """Raises ToolError if something is there, or it is in no folder."""
    if os.path.lexists(place):
        raise ToolError(f"{place} exists; remove it, or choose another name by {named}")
    parent = os.path.dirname(os.path.abspath(place))
    if not os.path.isdir(parent):
        raise ToolError(f"{place}: there is no folder {parent}; make it first")


def place_of(out, folder):
    """Returns where the pack goes and the name of its top folder."""
    if out and folder:
        raise ToolError("give OUT=file.tar.gz or DIR=folder, not both")
    place = os.path.normpath(out or folder or "raykit-handout.tar.gz")
    if not folder and not place.endswith(".tar.gz"):
        raise ToolError(f"OUT: {place} should end in .tar.gz; for a folder give DIR={place}")
    check_place(place, "OUT=... or DIR=...")
    return place, os.path.basename(place).removesuffix("" if folder else ".tar.gz")


def run(command, environment, **pipes):
    """Runs a command in a session of its own, which ends, with all that it started, when this script is
    stopped."""
    process = subprocess.Popen(command, env=environment, start_new_session=True, text=True, errors="replace",
                               **pipes)
    try:
        said, wrong = process.communicate()
    except BaseException:
        os.killpg(process.pid, signal.SIGTERM)
        try:
            process.wait(_SECONDS_TO_CLEAN_UP)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        raise
    return process.returncode, (said or wrong or "").strip()


def tell(phase):
    """Says what takes the next seconds or minutes."""
    print(f"{os.path.basename(sys.argv[0]).removesuffix('.py')}: {phase}", file=sys.stderr, flush=True)


# --- The pack -------------------------------------------------------------------------------------


def _copy(path, copied):
    """Copies a file, or a folder with all in it, for all to read whatever the umask."""
    if os.path.isdir(path):
        for name in os.listdir(path):
            _copy(os.path.join(path, name), os.path.join(copied, name))
        return
    os.makedirs(os.path.dirname(copied), exist_ok=True)
    shutil.copy2(path, copied)
    os.chmod(copied, 0o755 if os.access(path, os.X_OK) else 0o644)


def copy_release(source, folder):
    """The files that make dist would pack. Its own rules would start a process for each."""
    command = [os.environ.get("MAKE", "make"), "-s", "dist-files"]
    environment = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
    status, said = run(command, environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if status:
        raise ToolError(f"the kit's files could not be listed:\n{said}")
    for name in said.split("\n"):
        path = name if os.path.isfile(name) else os.path.join(source, name)
        _copy(path, os.path.join(folder, name))


def _release(source, pack):
    """A release without what ./bootstrap makes and what only instructors use, and with a workflow for git
    hosts."""
    copy_release(source, pack)
    made = ["configure", "Makefile.in", "aclocal.m4", "features.am", "build-aux"]
    for name in [*made, *os.environ["RAYKIT_INSTRUCTORS"].split()]:
        path = os.path.join(pack, name)
        (shutil.rmtree if os.path.isdir(path) else os.unlink)(path)
    for name, place in _WORKFLOWS.items():
        _copy(os.path.join(source, "tools", "workflows", name), os.path.join(pack, place))


def _hand_out(pack, features, later):
    """Replaces solutions by starters, whose notes tell the build which sources to take from workbook/."""
    workbook = os.path.join(pack, "workbook")
    os.mkdir(workbook)
    for name, text in workbook_files(pack, workbook, pack).items():
        write_whole(os.path.join(workbook, name), text)
    for feature in [*features, *later]:
        old, new = f"src/features/{feature.stem}.c", f"workbook/{feature.stem}.c"
        if feature in later:
            write_whole(os.path.join(pack, old), left_open_of(feature.reference))
        else:
            write_whole(os.path.join(pack, new), starter_of(feature.reference))
            write_whole(os.path.join(pack, old), handed_out_of(feature.reference, new))
    names = [f"workbook/{feature.stem}.c" for feature in features]
    sums = subprocess.run(["cksum", *names], cwd=pack, check=True, stdout=subprocess.PIPE, text=True).stdout
    write_whole(os.path.join(pack, "assignments", "starters.txt"), sums)


def _configurable(pack):
    """Makes what ./bootstrap would make on each student's machine."""
    for command in (["sh", "tools/features.sh"], ["autoreconf", "--install"],
                    ["touch", "Makefile.in", "configure"]):
        status, said = run(command, dict(os.environ, PWD=pack), cwd=pack, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)
        if status:
            raise ToolError(f"{command[0]} failed in the pack:\n{said}")
    shutil.rmtree(os.path.join(pack, "autom4te.cache"))


def _adapt_texts(source, pack, features, chosen):
    """Adapts chapters and handouts to the workbook; removes assignments that are not handed out."""
    for name in ("handout_common.md", "handout_page.md"):
        os.unlink(os.path.join(pack, "assignments", name))
    for feature in features:
        if feature not in chosen:
            os.unlink(os.path.join(pack, "assignments", feature.folder, "handout.md"))
    texts = {f"assignments/{feature.folder}/handout.md": handout_of(source, feature) for feature in chosen}
    for name in ("README.md", "docs/architecture.md", "docs/commands.md", "docs/book.md", "docs/one_pixel.md",
                 "docs/92_wrong_pictures.md", *(feature.chapter for feature in features)):
        with open(os.path.join(pack, name), encoding="utf-8") as file:
            texts[name] = file.read()
    texts["docs/book.md"] = texts["docs/book.md"].replace("bvh_median", chosen[0].stem)
    for name, text in texts.items():
        if name not in ("README.md", "docs/commands.md"):  # they build all drivers first
            text = with_built_drivers(text)
        write_whole(os.path.join(pack, name), as_packed(text, name, [feature.stem for feature in chosen]))


# --- The book -------------------------------------------------------------------------------------


def weave_book(pack, sources=""):
    """Makes docs/out, with book, a page per section: the pack's text and code, the figures of this build's
    drivers. What they made stays in the build folder's store, for the next pack. Returns these two folders.
    `sources`: tools/weave/sources.lua."""
    kept = os.path.abspath("drawn")
    environment = dict(os.environ, RAYKIT_SOURCE=pack, RAYKIT_BUILD=pack, RAYKIT_DRIVERS=os.getcwd(),
                       RAYKIT_STORE=kept, MESHES="", CHROMIUM="unused", FEATURES="", SOLUTIONS="yes",
                       ANSWERS="",
                       RAYKIT_LIVE="", RAYKIT_STEPS="", RAYKIT_JUDGES="no", RAYKIT_SOURCES=sources,
                       RAYKIT_RECORD="")
    if os.environ.get("QUICK"):
        tell("QUICK=1 only makes its figures small; BOOK=no is the quick way to try a pack")
    tell("weaving the book; figures that this build has not drawn yet are drawn now")
    status, _ = run(["sh", os.path.join(pack, "docs", "make_book")], environment)
    if status:
        raise ToolError("the book could not be woven (its reason is above); BOOK=no leaves it out")
    return os.path.join(pack, "docs", "out"), kept


def _hand_out_book(pack):
    """Makes docs/handout, with the book, and with what its own make book needs."""
    made, kept = weave_book(pack, "linked")
    handed = os.path.join(pack, "docs", "handout")
    os.mkdir(handed)
    for part in ("book", "figures", "tables"):
        os.rename(os.path.join(made, part), os.path.join(handed, part))
    record = os.path.join(handed, "record")
    with open(os.path.join(made, "used"), encoding="utf-8") as used:
        for name in used.read().split():
            shutil.copytree(os.path.join(kept, name), os.path.join(record, name))
    os.rename(os.path.join(made, "machine"), os.path.join(record, "machine"))
    shutil.rmtree(made)


def _title_and_time(pack, feature):
    """The first line of the task, and the time that it takes."""
    with open(os.path.join(pack, "assignments", feature.folder, "handout.md"), encoding="utf-8") as file:
        text = file.read()
    time = re.search(r"^\*\*Time:\*\* about (.*)\.$", text, re.MULTILINE)
    if not time:
        raise ToolError(f"assignments/{feature.folder}/handout.md says nowhere "
                        "\"**Time:** about ... hours.\"")
    return text.splitlines()[0].lstrip("# "), time[1]


def _at_the_size_of(source, picture, command):
    """Returns the command that draws the picture as large as it is shown: some options count pixels."""
    if "--width" in command:
        return command
    width, height = size_of(os.path.join(source, "docs", "pictures", f"{picture}.png"))
    return f"{command} --width {width} --height {height}"


def _goal(source, stems, left_open):
    """A picture that students can draw when these features are solved, with its command: the one at the top
    of README.md if it uses any of them and none that is left open, or else the last feature's own, if what it
    may use is there."""
    with open(os.path.join(source, "README.md"), encoding="utf-8") as file:
        text = file.read()
    with open(os.path.join(source, "docs", "commands.md"), encoding="utf-8") as file:
        examples = file.read()
    course = list(read_features(source))
    first, last = re.search(r"picture at the top uses those from `(\w+)` to `(\w+)`", text).groups()
    needed = course[course.index(first):course.index(last) + 1]
    used = [stem for stem in needed if stem in stems]
    picture, driven, takes = "cover", r"assignments/\S+ --scene cover --env", ["It takes a minute or two."]
    if not used or set(needed) & set(left_open):
        picture, used, takes = stems[-1], stems[-1:], []
        driven = rf"assignments/\d+_{picture}/{picture} --"
        needed = [*course[:course.index(picture)], "shading"]  # which lights also what comes before it
    place = rf"docs/pictures/{picture}\.png"
    shown = re.search(rf"!\[(?P<said>[^]]*)\]\({place}\)|src=\"{place}\" alt=\"(?P<read>[^\"]*)\"", text)
    examples = examples[examples.index("The pictures in [README.md]"):]
    command = re.search(rf"^    {driven}(.*\\\n)*.*", examples, re.MULTILINE)
    if not shown or not command or set(needed) & set(left_open):
        return []
    if "sampling" in left_open:
        takes.append("`sampling` is not asked for yet: pictures with random samples have more noise.")
    said = shown["said"] or shown["read"]
    return [f"The goal is this picture, which uses {_and([f'`{stem}`' for stem in used])}:",
            f"![{said}](docs/pictures/{picture}.png)",
            with_built_drivers(_at_the_size_of(source, picture, command[0])),
            *([" ".join(takes)] if takes else [])]


def _order(source, stems, left_open=()):
    """In which order these assignments are written, and what for."""
    first = next((stem for stem in ("shading", "parallelogram_light") if stem in stems), stems[-1])
    table = ("`make start` follows the table's order, which is a good one. "
             f"`make start-{first}` begins with another task.\n" if len(stems) > 1 else "")
    looks = "In each task the table of steps has pictures of what you should see after most steps."
    return "\n\n".join([table + looks, *_goal(source, stems, left_open)])


def _open(left_open):
    """Which starters nobody is asked to write yet."""
    if not left_open:
        return ""
    names = _and([f"`{stem}`" for stem in left_open])
    text = (f"Not asked for yet are {names}; their files in `src/features` are starters, too, "
            "and pictures lack what they add." if len(left_open) > 1 else
            f"Not asked for yet is {names}; its file in `src/features` is a starter, too, "
            "and pictures lack what it adds.")
    return textwrap.fill(text, 110) + "\n\n"


def _write_handout(source, pack, features, left_open, has_book, words):
    """Writes HANDOUT.md, the student's first page, by assignments/handout_page.md, with the course's own
    words above all else."""
    rows = ["| task | your file | points | time | chapter |", "|---|---|---|---|---|"]
    for feature in features:
        task, file = f"assignments/{feature.folder}/handout.md", f"workbook/{feature.stem}.c"
        points = sum(test.points for test in read_points(feature))
        title, time = _title_and_time(pack, feature)
        chapter = f"docs/handout/book/{feature.page_name()}" if has_book else feature.chapter
        rows.append(f"| [{title}]({task}) | [{file}]({file}) | {points} | {time} | [{chapter}]({chapter}) |")
    first = features[0].stem
    reading = ("Open `docs/handout/book/index.html` in a browser: "
               "the chapters, with figures as they should become.\n"
               "`make book` makes `docs/out/book.html`, with your own functions in it."
               if has_book else
               "**The book is missing from this pack**, which was made for a trial; "
               "ask for one with the book. Until then, `make start` names chapters as\n"
               "text, in `docs`, and `make book` makes `docs/out/book.html`, with figures by your code, "
               "which are wrong until it is solved.")
    with open(os.path.join(source, "assignments", "commands.txt"), encoding="utf-8") as file:
        commands = [re.split("  +", line.replace("STEM", first)) for line in file.read().splitlines()]
    width = max(len(command) for command, _ in commands)
    files = "\n".join(f"- `workbook/{feature.stem}.c`" for feature in features)
    with open(os.path.join(source, "assignments", "handout_page.md"), encoding="utf-8") as file:
        page = file.read()
    page = page.format(
        order=_order(source, [feature.stem for feature in features], left_open),
        left_open=_open(left_open), assignments="\n".join(rows), first=first, reading=reading, files=files,
        commands="\n".join(f"    {command:<{width}}  {does}" for command, does in commands))
    write_whole(os.path.join(pack, "HANDOUT.md"), words.put_into(page))


# --- The command ----------------------------------------------------------------------------------


def _later(features, chosen, later):
    """Returns the features whose starters only fill their places: as LATER says, or those that come
    later in the course than the chosen. What the chosen need has its solution in the pack."""
    stems, needed = list(features), {feature.stem for feature in chosen}
    while more := {need for stem in needed for need in features[stem].needs + features[stem].uses} - needed:
        needed |= more
    named = {"no": [], "all": stems, "": stems[stems.index(chosen[-1].stem) + 1:]}.get(later, later.split())
    for feature in choose(features, named) if named else []:
        if feature.stem in needed and later not in ("", "all"):
            who = "is handed out" if feature in chosen else "is needed by what is handed out"
            raise ToolError(f"LATER: {feature.stem} {who}; leave it out there")
    return [features[stem] for stem in stems if stem in named and stem not in needed]


def _and(stems):
    return " and ".join(filter(None, [", ".join(stems[:-1]), *stems[-1:]]))


def check_words(words, source, features):
    """Raises ToolError if the course's words hold a line of a solution."""
    found = solution_in(words.note, source, features) if words.note else None
    if found:
        number, stem = found
        words.refuse(number, f"this is a line of the solution of {stem}; take it out")
    if words.title and solution_in(words.title, source, features):
        raise ToolError("TITLE: this is a line of a solution; choose another")


def choose_course(features, stems, later):
    """Returns the features that are handed out, in the course's order, and those not asked for yet."""
    if not stems:
        raise ToolError("name the assignments: make handout ASSIGNMENTS=\"...\", all, or of: "
                        + " ".join(features))
    named = choose(features, stems)
    chosen = [feature for feature in features.values() if feature in named]
    return chosen, _later(features, chosen, later)


def fill_pack(source, pack, features, chosen, left_open):
    """Makes the pack's folder with all but the book and HANDOUT.md."""
    tell("copying the kit")
    _release(source, pack)
    _hand_out(pack, chosen, left_open)
    _adapt_texts(source, pack, features.values(), chosen)


def told_of_solutions(features, chosen, left_open, later, what="pack"):
    """Returns lines that say which solutions are left out."""
    solved = [stem for stem, feature in features.items() if feature not in [*chosen, *left_open]]
    lines = [f"handed out: {_and([feature.stem for feature in chosen])}"]
    if left_open:
        lines.append(f"starters that are not asked for yet: {_and([feature.stem for feature in left_open])}")
    if solved:
        remedy = "" if later == "all" else "; LATER=all leaves out all that are not needed"
        return [*lines, f"the solution{'s' if len(solved) > 1 else ''} of {_and(solved)} "
                f"{'are' if len(solved) > 1 else 'is'} in this {what}{remedy}"]
    return [*lines, f"no solution is in this {what}"]


def make_handout(source, stems, out="", folder="", book=True, later="", title="", note=""):
    """Makes the pack; returns lines that describe it. `title` and `note` are the course's own words."""
    features, words = read_features(source), read_words(title, note)
    chosen, left_open = choose_course(features, stems, later)
    place, name = place_of(out, folder)
    check_words(words, source, [*chosen, *left_open])
    if book and not os.environ.get("PANDOC"):
        raise ToolError("the book needs pandoc: run ./bootstrap, or give BOOK=no for a pack without the book")
    try:
        work = tempfile.mkdtemp(prefix=".handout-", dir=os.path.dirname(os.path.abspath(place)))
    except OSError as error:
        raise cannot_write(place, error) from error
    try:
        pack = os.path.join(work, name)
        fill_pack(source, pack, features, chosen, left_open)
        words.check_links(pack, book)
        if book:
            _hand_out_book(pack)
        _write_handout(source, pack, chosen, [feature.stem for feature in left_open], book, words)
        tell("looking for lines of the solutions")
        proof = prove(source, pack, features, [*chosen, *left_open])
        keep_originals(pack)
        tell("making configure, so that students need no autotools")
        _configurable(pack)
        if not folder:
            tell("packing")
            with tarfile.open(pack + ".tar.gz", "w:gz") as archive:
                archive.add(pack, name, filter=_anonymous)
        os.rename(pack + ("" if folder else ".tar.gz"), place)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    lines = told_of_solutions(features, chosen, left_open, later)
    if not book:
        lines.append("THE BOOK IS MISSING: this pack is for trying. Without BOOK=no, the book is in it")
    if words.named():
        lines.append(f"HANDOUT.md begins with the course's {words.named()}")
    return [*lines, *proof, f"wrote {place}; students begin with its HANDOUT.md"]


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
    parser.add_argument("--later", default="", metavar="all|no|STEMS",
                        help="features that are not asked for yet; "
                        "default: those that come later in the course")
    parser.add_argument("--title", default="", metavar="TEXT", help="the course's title for the first page")
    parser.add_argument("--note", default="", metavar="FILE|TEXT",
                        help="what the course says there, such as dates and rules for late work; Markdown")
    parser.add_argument("--book", default="", metavar="yes|no", help="no leaves the woven book out")
    arguments = parser.parse_args()
    stop_on_signals()
    try:
        if arguments.book not in ("", "yes", "no"):
            raise ToolError(f"BOOK={arguments.book}: choose yes or no")
        print("\n".join(make_handout(arguments.source, arguments.stems, arguments.out, arguments.dir,
                                     arguments.book != "no", arguments.later, arguments.title,
                                     arguments.note)))
    except ToolError as error:
        print(f"handout: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        why = cannot_write(arguments.out or arguments.dir, error) if full else (
            f"{error.filename or 'the system'}: {error.strerror}")
        print(f"handout: {why}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("handout: stopped; nothing was written", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
