"""A feature's file as students get it, with starters in place of solutions.

Anywhere between the lines of a feature's file there may be:

    /* solution */
    the reference's lines
    /* starter
    the lines that a student finds instead
    end */

so the reference is ordinary C, and the only source of both. Markers that are absent, nested or left
open are errors with file and line.
"""

import re
import sys


class RegionError(Exception):
    """A marker out of place; the text names file and line."""


MARKER = re.compile(r"^\s*(/\* solution \*/|/\* starter|end \*/)\s*$")


def read_regions(path):
    """Returns a list of (kind, line) for the file's lines; kind is "common", "solution", "starter"
    or "marker". The file has at least one region, and each is whole."""
    kinds, state, opened = [], "common", 0
    follows = {"common": "/* solution */", "solution": "/* starter", "starter": "end */"}
    becomes = {"/* solution */": "solution", "/* starter": "starter", "end */": "common"}
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            match = MARKER.match(line)
            if not match:
                kinds.append((state, line))
                continue
            marker = match.group(1)
            if marker != follows[state]:
                raise RegionError(
                    f"{path}:{number}: \"{marker}\" stands where \"{follows[state]}\" should come"
                    + (f" (the region began in line {opened})" if opened else "")
                )
            state, opened = becomes[marker], number if marker == "/* solution */" else opened
            opened = opened if state != "common" else 0
            kinds.append(("marker", line))
    if state != "common":
        raise RegionError(f"{path}:{opened}: this region has no \"{follows[state]}\"")
    if not any(kind == "solution" for kind, _ in kinds):
        raise RegionError(f"{path}:1: no region is marked for students to solve")
    return kinds


def starter_of(path):
    """Returns the starter file's text."""
    return "".join(line for kind, line in read_regions(path) if kind in ("common", "starter"))


_HANDED_OUT = "/* Handed out: "


def handed_out_of(path, yours):
    """Returns the file's replacement in a pack for students: its starter in both halves of each
    region, so that compilers and tools find the usual layout. `yours` is the file to solve."""
    note = f"{_HANDED_OUT}this starter is for comparison, the file to edit is {yours}. */\n\n"
    text, starter = ["/* solution */\n", note, "/* starter\n", "end */\n"], []
    for kind, line in read_regions(path):
        if kind == "marker" and line.strip() == "end */":
            text[-1:] = [*starter, text[-1], *starter]
            starter = []
        if kind == "starter":
            starter.append(line)
        elif kind != "solution":
            text.append(line)
    return "".join(text)


def is_handed_out(path):
    """Whether the file is what handed_out_of returned."""
    with open(path, encoding="utf-8") as file:
        return any(line.startswith(_HANDED_OUT) for line in file)


def solution_lines(path):
    """Returns the set of the solution's lines, stripped, that occur only there: they must not be
    found in a pack for students."""
    regions = read_regions(path)
    common = {line.strip() for kind, line in regions if kind in ("common", "starter")}
    lines = {line.strip() for kind, line in regions if kind == "solution"}
    return {line for line in lines - common if len(line) >= 20}


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print("usage: starters.py FEATURE.c     prints the starter", file=sys.stderr)
        return 2
    try:
        sys.stdout.write(starter_of(sys.argv[1]))
    except (RegionError, OSError) as error:
        print(f"regions: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
