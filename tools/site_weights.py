#!/usr/bin/env python3
"""Prints docs/tools.md with its table of a page's weight made anew: `make site-weights`.

It is made from the files of site/ that the service worker lists, as a server sends them that compresses
nothing."""

import argparse
import json
import os
import re
import sys

_TABLE = re.compile(r"(<!-- weights of a site -->\n)(.*?)(<!-- end -->\n)", re.DOTALL)
_PARTS = [("the compiler: clang, lld, wasi-libc", r"clang/"), ("the editor: CodeMirror", r"modules/"),
          ("the kit's library and headers", r"(kit\.a|drivers\.a|headers\.json)\.gz$"),
          ("suites, all", r"suites/"), ("drivers, all", r"drivers/"), ("pictures", r"(pictures|wanted)/"),
          ("pages, tasks, starters", r"")]


def weights_of(site):
    """Returns (part, bytes) for each part of a first visit, and their sum last."""
    with open(os.path.join(site, "service_worker.js"), encoding="utf-8") as file:
        names = json.loads(re.search(r"NEEDED = (\[.*\]);", file.read())[1])
    sums = {part: 0 for part, _ in _PARTS}
    for name in names:
        part = next(part for part, begins in _PARTS if re.match(begins, name))
        sums[part] += os.path.getsize(os.path.join(site, name))
    return [*sums.items(), ("together", sum(sums.values()))]


def table(weights):
    rows = "".join(f"| {part} | {size / 1e6:.1f} |\n" for part, size in weights)
    return f"| what | MB |\n|---|--:|\n{rows}"


def _numbers(text):
    return [float(number) for number in re.findall(r"\| ([\d.]+) \|$", text, re.MULTILINE)]


def is_right(text, weights):
    """Whether the text's table has these weights: another version of zlib packs a little better or worse."""
    told, right = _numbers(_TABLE.search(text)[2]), [size / 1e6 for _, size in weights]
    return len(told) == len(right) and all(abs(one - other) <= 0.15 for one, other in zip(told, right))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--site", required=True, metavar="DIR", help="the kit's own site")
    parser.add_argument("page", metavar="FILE", help="docs/tools.md")
    arguments = parser.parse_args()
    with open(arguments.page, encoding="utf-8") as file:
        text = file.read()
    print(_TABLE.sub(lambda part: part[1] + table(weights_of(arguments.site)) + part[3], text), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
