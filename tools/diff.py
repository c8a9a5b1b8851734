#!/usr/bin/env python3
"""Shows a student's changes: the unit against its starter."""

import difflib
import sys

from grading.assignments import Parser, ToolError, check_impl, choose, find_unit, missing_unit, read_features
from grading.starters import starter_of


def difference(source, stem, impl):
    """Returns the lines of a unified difference, starter to unit, and a sentence about it."""
    features = read_features(source)
    feature = choose(features, [stem])[0]
    check_impl(features, impl, [stem])
    unit = find_unit(feature, impl)
    if unit.path is None:
        raise missing_unit(feature, impl)
    with open(unit.path, encoding="utf-8", errors="replace") as file:
        own = file.read().splitlines()
    starter = starter_of(feature.reference).splitlines()
    lines = list(difflib.unified_diff(starter, own, f"starter of {stem}", unit.shown, lineterm=""))
    added = sum(line.startswith("+") for line in lines[2:])
    removed = sum(line.startswith("-") for line in lines[2:])
    if not lines:
        return [], f"{unit.shown} is the starter, unchanged"
    return lines, (
        f"{unit.shown} against its starter: + {added} lines that are yours, - {removed} that you replaced"
    )


def _show(lines, sentence):
    colours = {"+": 32, "-": 31, "@": 36} if sys.stdout.isatty() else {}
    for line in lines:
        colour = colours.get(line[:1])
        print(f"\033[{colour}m{line}\033[m" if colour else line)
    print(sentence, flush=True)


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument("impl", metavar="FILE_OR_DIR")
    arguments = parser.parse_args()
    try:
        lines, sentence = difference(arguments.source, arguments.stem, arguments.impl)
    except ToolError as error:
        print(f"diff: {error}", file=sys.stderr)
        return 1
    try:
        _show(lines, sentence)
    except BrokenPipeError:  # a pager that was left
        sys.stderr.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
