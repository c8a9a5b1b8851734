"""The text of an assignment: its handout.md with the sections that all share, as it is true for whom.

A line of a handout that begins with a link to a section of assignments/handout_common.md stands for
that section, with {stem}, {folder}, {number} and {shown}, the first step that can be seen, filled in. In the
table of steps {tests} stands for the tests that points.tsv gives to a row's step, and {look} for what
look.tsv shows after it. What is true in one place only stands between `<!-- kit -->` and `<!-- pack`, and its
counterpart from there to `end -->`.
"""

import os
import re

from grading.assignments import ToolError, read_looks, read_points
from grading.starters import is_handed_out

_LINK = re.compile(r"^\[[^]]*\]\(\.\./(handout_common\.md)#([\w-]+)\).*$", re.MULTILINE)
_STEP = re.compile(r"^\| (\d+) \|.*\|$", re.MULTILINE)
_ROW = re.compile(r"^\| (.*) \|$", re.MULTILINE)
_KIT_OR_PACK = re.compile(r"^<!-- kit -->\n(.*?)^<!-- pack\n(.*?)^end -->\n", re.MULTILINE | re.DOTALL)
_RUN = re.compile(r"( *)assignments/(\d+_(\w+))/\3 --")
_OF_THE_KIT = re.compile(r"\b(IMPL|DIR)=mine\b|(?<![\w/])mine/|`mine`|<!-- (kit|pack)\b")


def _read(*path):
    try:
        with open(os.path.join(*path), encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        raise ToolError(f"{os.path.join(*path)} cannot be read: {error.strerror}") from error


def _sections(text):
    """Returns a dictionary from a heading's anchor to its section."""
    parts = re.split(r"^(?=## )", text, flags=re.MULTILINE)[1:]
    return {re.sub(r"\W+", "-", part.splitlines()[0][3:].lower()): part.rstrip() for part in parts}


def _named(test):
    kept = f" (green since step {test.green_since}: keep it so)" if test.green_since else ""
    return f"`{test.name}`{kept}"


def _shown(feature, look):
    picture = f"![{look.caption}](look/{look.step}.png)<br>" if os.path.exists(look.picture) else ""
    return f"{picture}{look.caption}<br>`make draw-{feature.stem} IMPL=mine STEP={look.step}`"


def handout_of(source, feature):
    """Returns a feature's handout with the shared sections, and the tests and looks of its steps, in their
    places."""
    own = _read(source, "assignments", feature.folder, "handout.md")
    tests, looks = read_points(feature), read_looks(feature)

    def step(row):
        named = "<br>".join(_named(test) for test in tests if test.step == int(row[1]))
        shown = "".join(_shown(feature, look) for look in looks if look.step == int(row[1]))
        return row[0].replace("{tests}", named).replace("{look}", shown)

    own = _STEP.sub(step, own)
    filled = {"stem": feature.stem, "folder": feature.folder,
              "number": str(int(feature.folder.split("_")[0])),
              "shown": str(looks[0].step)}

    def section(link):
        name, anchor = link.groups()
        shared = _sections(_read(source, "assignments", name))
        if anchor not in shared:
            raise ToolError(f"assignments/{feature.folder}/handout.md: {name} has no section \"{anchor}\"; "
                            f"it has: {', '.join(shared)}")
        return re.sub(r"\{(stem|folder|number|shown)\}", lambda word: filled[word[1]], shared[anchor])

    return _LINK.sub(section, own)


def _counts_for(cell, step):
    """Whether "2", "1, 2" or "4 to 6" has this step."""
    first, _, last = cell.partition(" to ")
    return int(first) <= step <= int(last) if last else str(step) in cell.split(", ")


def task_of(text, step):
    """Returns what a handout's tables say of a step: what to write, and what is given for it, as pairs of a
    name and the file that declares it."""
    rows = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", row[1]).split(" | ") for row in _ROW.finditer(text)]
    write = next((row[1] for row in rows if len(row) == 5 and row[0] == str(step)), "")
    given = [row[:2] for row in rows if len(row) == 3 and row[2][0].isdigit() and _counts_for(row[2], step)]
    return write, given


def sheet_of(feature, impl):
    """Returns the path of the student's own task sheet: the workbook's, or the pack's; "" if neither is
    there."""
    kit = os.path.relpath(feature.source)
    sheets = [os.path.join(impl, feature.stem + ".md")] if os.path.isdir(impl) else []
    if is_handed_out(feature.reference):
        sheets.append(os.path.join("" if kit == "." else kit, "assignments", feature.folder, "handout.md"))
    return next(filter(os.path.isfile, sheets), "")


def with_built_drivers(text):
    """Puts the command that makes a driver of a pack before the lines that run it."""
    made = None

    def command(line):
        nonlocal made
        found = _RUN.match(line)
        if not found:
            made = made if line.strip() else None
            return line
        make = "" if made == found[3] else f"{found[1]}make driver-{found[3]}\n"
        made = found[3]
        return f"{make}{found[1]}impl/{line[len(found[1]):]}"

    return "\n".join(command(line) for line in text.split("\n"))


def as_packed(text, name, stems):
    """Returns a text of the kit as it is true in a pack, where the workbook is meant without a word."""
    text = _KIT_OR_PACK.sub(r"\2", text)
    text = re.sub(r" IMPL=mine\b(?!/)", "", text)
    for stem in stems:
        text = text.replace(f"mine/{stem}.c", f"workbook/{stem}.c")
        text = re.sub(rf"src/features/({stem}\.[co])\b", r"workbook/\1", text)
    left = _OF_THE_KIT.search(text)
    if left:
        line = text.count("\n", 0, left.start()) + 1
        raise ToolError(f"{name}:{line} of the pack says {left.group()}, which is true in the whole kit "
                        "only; put it between <!-- kit --> and <!-- pack")
    return text


def as_in_workbook(text, source, feature, folder):
    """Returns a handout as it is true in the student's folder, which need not be called mine."""
    kit = os.path.relpath(source, folder)
    text = _KIT_OR_PACK.sub(r"\1", text)
    text = re.sub(r"(?<==)mine\b|(?<![\w/])mine(?=/)|(?<=`)mine(?=`)", lambda _: folder.rstrip("/") or "/",
                  text)
    text = re.sub(r"\]\((points\.tsv|look/)", rf"](../../assignments/{feature.folder}/\1", text)
    return text.replace("](../../", f"]({kit}/")
