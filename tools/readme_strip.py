#!/usr/bin/env python3
"""Makes two pictures of README, a claim that fails and what its mistake draws: `make readme-strip`.

The unit has a known mistake of tests/mutants. The claim's message is the grader's; the picture is drawn with
the options that docs/commands.md has for the right one.
"""

import html
import os
import re
import sys
import tempfile
import textwrap

from grade import grade_impl
from grading.assignments import Parser, ToolError, choose, read_features
from grading.build import Toolchain
from grading.mutants import MutantError, mutate, read_mutants
from wrong import draw, link_wrong, mutants_of

STEM, MUTANT = "normals", "not_moved"
SIZE = ["--width", "320", "--height", "320"]
BREADTH = 34  # letters in a line of the claim's picture
RED, WHITE, GREY = "#ff7b72", "#e6edf3", "#9da7b3"


def claim_svg(suite):
    """Returns the first claim that fails, with its message, as a terminal shows it."""
    first = next(test for test in suite.tests if not suite.verdicts[test.name].passed)
    verdict = suite.verdicts[first.name]
    lines = [(RED, f"FAIL {STEM}"), (WHITE, ""), (WHITE, f"{first.name}:")]
    lines += [(RED, line) for line in textwrap.wrap(" ".join(verdict.reason.split()), BREADTH)]
    lines += [(WHITE, ""), (GREY, verdict.place)]
    texts = "\n".join(f'<text x="12" y="{34 + 24 * row}" fill="{colour}">{html.escape(line)}</text>'
                      for row, (colour, line) in enumerate(lines) if line)
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="320" height="320" viewBox="0 0 320 320" '
            'font-family="ui-monospace, Menlo, Consolas, monospace" font-size="14">\n'
            f'<rect width="320" height="320" fill="#0d1117"/>\n{texts}\n</svg>\n')


def options_of(source, feature):
    """Returns the options of the picture that README shows of a feature."""
    with open(os.path.join(source, "docs", "commands.md"), encoding="utf-8") as file:
        text = file.read()
    command = re.search(rf"The pictures in .*?\n    assignments/{feature.folder}/{feature.stem} ([^\n]*)",
                        text, re.DOTALL)
    if not command:
        raise ToolError(f"docs/commands.md has no command for README's picture of {feature.stem}; add it")
    return command[1]


def make_strip(build, folder):
    """Returns the contents of the two files by their names."""
    toolchain = Toolchain(build)
    feature = choose(read_features(toolchain.source), [STEM])[0]
    path = mutants_of(feature)
    mutant = next(one for one in read_mutants(path, path) if one.name == MUTANT)
    driver = link_wrong(toolchain, feature, mutant, folder)
    unit = os.path.join(folder, "unit", STEM + ".c")
    os.mkdir(os.path.dirname(unit))
    with open(feature.reference, encoding="utf-8") as file, open(unit, "w", encoding="utf-8") as wrong:
        wrong.write(mutate(mutant, file.read(), path))
    suite = grade_impl(build, [STEM], unit, own=True)[1][0]
    options = " ".join([options_of(toolchain.source, feature), *SIZE])
    return {"red_claim.svg": claim_svg(suite).encode(), "wrong_picture.png": draw(path, driver, options)}


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--out", required=True, metavar="DIR", help="write the two pictures there")
    arguments = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = make_strip(arguments.build, folder)
        for name, content in made.items():
            with open(os.path.join(arguments.out, name), "wb") as file:
                file.write(content)
    except (ToolError, MutantError) as error:
        print(f"readme-strip: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("readme-strip: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
