"""A feature's file as students get it, with starters in place of solutions.

Anywhere between the lines of a feature's file there may be:

    /* solution */
    the reference's lines
    /* starter
    the lines that a student finds instead
    end */

so the reference is ordinary C, and the only source of both. Markers that are absent, nested or left
open are errors with file and line. In a pack for students the file has only its starters, each between
`/* yours to write */` and `/* end of yours */`.
"""

import itertools
import os
import re

from grading.assignments import ToolError
from grading.originals import has_originals


class RegionError(ToolError):
    """A marker out of place; the text names file and line."""

    def __init__(self, path, said):
        pack = os.path.join(os.path.dirname(os.path.abspath(path)), "..", "..")
        remedy = "; make pristine puts the original back" if has_originals(pack) else ""
        super().__init__(path + said + remedy)


MARKER = re.compile(r"^\s*(/\* solution \*/|/\* starter|end \*/"
                    r"|/\* yours to write \*/|/\* end of yours \*/)\s*$")
_BECOMES = {
    ("common", "/* solution */"): "solution", ("solution", "/* starter"): "starter",
    ("starter", "end */"): "common",
    ("common", "/* yours to write */"): "yours", ("yours", "/* end of yours */"): "common",
}
ORDINALS = ["First", "Second", "Third", "Fourth", "Fifth", "Sixth", "Seventh", "Eighth", "Ninth"]
_HANDED_OUT, _LEFT_OPEN = "/* Handed out: ", "/* Left open: "


def read_regions(path):
    """Returns a list of (kind, line) for the file's lines; kind is "common", "solution", "starter"
    or "marker". The file has at least one region, and each is whole."""
    kinds, state, opened = [], "common", 0
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            match = MARKER.match(line)
            if not match:
                is_note = line.startswith((_HANDED_OUT, _LEFT_OPEN))
                kinds.append(("marker" if is_note else "starter" if state == "yours" else state, line))
                continue
            marker = match.group(1)
            if (state, marker) not in _BECOMES:
                expected = next(follows for begun, follows in _BECOMES if begun == state)
                raise RegionError(
                    path, f":{number}: \"{marker}\" stands where \"{expected}\" should come"
                    + (f" (the region began in line {opened})" if opened else "")
                )
            opened = number if state == "common" else opened
            state = _BECOMES[state, marker]
            opened = opened if state != "common" else 0
            kinds.append(("marker", line))
    if state != "common":
        expected = next(follows for begun, follows in _BECOMES if begun == state)
        raise RegionError(path, f":{opened}: this region has no \"{expected}\"")
    if not any(kind == "starter" for kind, _ in kinds):
        raise RegionError(path, ":1: no region is marked for students to solve")
    return kinds


def starter_of(path):
    """Returns the starter file's text."""
    return "".join(line for kind, line in read_regions(path) if kind in ("common", "starter"))


def _packed(path, note):
    """Returns the starter below a note, with marks where students write."""
    text, starter = [note + "\n"], []
    for kind, line in read_regions(path):
        if kind == "starter":
            starter.append(line)
        elif kind == "common":
            text.append(line)
        elif line.strip() == "end */":
            indent = line[:-len(line.lstrip())]
            text += [f"{indent}/* yours to write */\n", *starter, f"{indent}/* end of yours */\n"]
            starter = []
    return "".join(text)


def handed_out_of(path, yours):
    """Returns the file's replacement in a pack for students, whose file to solve is `yours`: the
    starter, to compare with."""
    return _packed(path, f"{_HANDED_OUT}the starter, to compare with; the file to edit is {yours}. */")


def left_open_of(path):
    """Returns the file's replacement in a pack that does not ask for it yet: the starter."""
    return _packed(path, f"{_LEFT_OPEN}a starter, which a later assignment asks for. */")


def is_handed_out(path):
    """Whether the file is what handed_out_of returned."""
    return _begins_with(path, _HANDED_OUT)


def is_left_open(path):
    """Whether the file is what left_open_of returned."""
    return _begins_with(path, _LEFT_OPEN)


def _steps_named(starter):
    """Returns the numbers of the steps that a starter names: "// Second step: ..."."""
    return [ORDINALS.index(word) + 1 for word in re.findall(r"(\w+) step\b", starter) if word in ORDINALS]


def solved_until(path, step, decides=min):
    """Returns the file's text after this step: the solutions of the regions whose step is reached, the
    starters of the others. Of the steps that a region names, `decides` chooses the one: min, so that it has
    more than was asked for, or max, less."""
    text, solution, starter = [], [], []
    for kind, line in read_regions(path):
        if kind == "solution":
            solution.append(line)
        elif kind == "starter":
            starter.append(line)
        elif kind == "common":
            text.append(line)
        elif line.strip() == "end */":
            named = _steps_named("".join(starter))
            if not named:
                raise RegionError(path, ": a starter names no step; "
                                  "begin its comment with \"First step: ...\"")
            text += solution if decides(named) <= step else starter
            solution, starter = [], []
    return "".join(text)


def is_starter(unit):
    """Whether a unit's code is still the starter's, apart from blanks."""
    with open(unit.path, encoding="utf-8", errors="replace") as file:
        return not unit.is_reference and file.read().split() == starter_of(unit.feature.reference).split()


def unsolved_steps(unit):
    """Returns the numbers of the steps all of whose starters, which name them, stand in the unit as they
    were."""
    with open(unit.path, encoding="utf-8", errors="replace") as file:
        written = " ".join(re.sub(r"/\* starter\n.*?end \*/", "", file.read(),
                                  flags=re.DOTALL).split())  # the reference has both
    regions = itertools.groupby(read_regions(unit.feature.reference), key=lambda line: line[0])
    kept = {}
    for starter in (" ".join("".join(line for _, line in lines).split()) for kind, lines in regions
                    if kind == "starter"):
        for step in _steps_named(starter):
            kept.setdefault(step, []).append(starter in written)
    return sorted(step for step, is_kept in kept.items() if all(is_kept))


def _begins_with(path, note):
    with open(path, encoding="utf-8") as file:
        return file.readline().startswith(note)


def solution_lines(path):
    """Returns the set of the solution's lines, stripped, that occur only there: they must not be
    found in a pack for students."""
    regions = read_regions(path)
    common = {line.strip() for kind, line in regions if kind in ("common", "starter")}
    lines = {line.strip() for kind, line in regions if kind == "solution"}
    return {line for line in lines - common if len(line) >= 20}
