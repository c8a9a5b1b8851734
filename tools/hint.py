#!/usr/bin/env python3
"""Prints a handout's hints one at a time, the nudge first: with --step its first hint, with --hint a
later one; without them what there is."""

import re
import sys
import textwrap

from grading import last_check
from grading.assignments import Parser, ToolError, choose, read_features
from handout_text import handout_of

_HINT = re.compile(r"^<details><summary>(.*?)</summary>\n(.*?)^</details>", re.MULTILINE | re.DOTALL)


def hints_of(text):
    """Returns a dictionary from a step's name ("2", or another word) to its hints: (title, text)."""
    hints = {}
    for title, body in _HINT.findall(text):
        step = re.match(r"Steps? (\d+)(?:[^\d,]+\d+)?,? *", title)
        name = title[step.end():] if step else title
        hints.setdefault(step[1] if step else "0", []).append((name or "a hint", body.strip("\n")))
    return hints


def _listed(stem, hints, failed):
    """Returns the list of hints, in which the step of the first claim that fails is marked."""
    lines = [f"hints for {stem}: make hint-{stem} STEP=... prints the first of a step"]
    claim, its_step = failed or ("", "")
    for name, of_step in hints.items():
        mark = f"  <- {claim} fails first" if claim and name == its_step else ""
        lines.append(f"    STEP={name}  " + "; ".join(title for title, _ in of_step) + mark)
    if failed is None:
        lines.append(f"After make check-{stem} this list marks the step of the first claim that fails.")
    elif claim and its_step not in hints:
        lines.append(f"{claim} fails first; no hint is about it.")
    elif not claim:
        lines.append("All claims held at the last check.")
    return "\n".join(lines)


def said(stem, hints, step, number, failed=None):
    """Returns what is printed for these options. `failed` is what last_check.read returns."""
    if not step:
        return _listed(stem, hints, failed)
    if step not in hints:
        raise ToolError(f"STEP={step}: {stem} has hints for the steps {', '.join(hints)}")
    count = len(hints[step])
    if not number.isdigit() or not 1 <= int(number) <= count:
        raise ToolError(f"HINT={number}: step {step} of {stem} has {count} hint{'s' * (count > 1)}")
    title, body = hints[step][int(number) - 1]
    rest, command = count - int(number), f"make hint-{stem} STEP={step} HINT={int(number) + 1}"
    further = [f"({rest} more; the next: {command})"] if rest else []
    return "\n".join([f"step {step}, {title}:", "", textwrap.indent(body, "    "), "", *further]).rstrip()


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--impl", default="", metavar="FILE_OR_DIR")
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument("--step", default="", metavar="N")
    parser.add_argument("--hint", default="", metavar="N")
    arguments = parser.parse_args()
    try:
        feature = choose(read_features(arguments.source), [arguments.stem])[0]
        hints = hints_of(handout_of(arguments.source, feature))
        if not hints:
            raise ToolError(f"the task of {feature.stem} has no hints")
        failed = last_check.read(arguments.build, feature, arguments.impl)
        print(said(feature.stem, hints, arguments.step, arguments.hint or "1", failed))
    except ToolError as error:
        print(f"hint: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
