#!/usr/bin/env python3
"""Writes the tables of files in docs/tools.md: `make tools-page`. Each file stands there with the first
sentence of its docstring or opening comment, so that nobody has to write it twice.

A folder's table is what stands between `<!-- files of FOLDER -->` and `<!-- end -->`. Suites, test_*, are
left out. With --check nothing is written: a table that is not up to date is an error. So is, in any case, a
file that does not say what it is for."""

import argparse
import ast
import os
import re
import sys

TABLE = re.compile(r"(<!-- files of (\S+) -->\n).*?(<!-- end -->\n)", re.DOTALL)


def _comment(text):
    """The opening comment, without its marks."""
    text = re.sub(r"\A(#!.*\n|# shellcheck .*\n)*", "", text)
    if text.startswith("/*"):
        return text[2:text.index("*/")].replace("\n *", "\n")
    mark = re.match(r"(//|--|#) |", text)[1]
    return re.match(rf"(?:{mark}.*\n)*", text)[0].replace(f"\n{mark}", "\n")[len(mark):] if mark else ""


def first_sentence(path):
    """Ends with a full stop or a question mark before a blank, or with its paragraph."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    text = (ast.get_docstring(ast.parse(text)) or "") if path.endswith(".py") else _comment(text)
    paragraph = " ".join(re.split(r"\n *\n", text.strip())[0].split())
    return re.split(r"(?<=[.?])\s", paragraph)[0].rstrip(".")


def _is_source(path):
    """A file in one of our languages, or a script without an ending; not what a compiler has left."""
    ending = os.path.splitext(path)[1]
    if ending or not os.path.isfile(path):
        return ending in (".py", ".sh", ".awk", ".lua", ".js", ".mjs", ".c", ".h")
    with open(path, "rb") as file:
        return file.read(2) == b"#!"


def table(source, folder):
    """The rows of a folder. Of NAME.c and NAME.h, the header speaks if the other one says nothing."""
    said = {}
    for name in sorted(os.listdir(os.path.join(source, folder))):
        path = os.path.join(source, folder, name)
        if _is_source(path) and not name.startswith("test_"):
            both = re.sub(r"\.[ch]$", "", name)
            before, sentence = said.get(both, (name, ""))
            said[both] = before, sentence or first_sentence(path)
    for name, sentence in said.values():
        if not sentence:
            sys.exit(f"{folder}/{name}:1: begin with a sentence that says what it is for")
    rows = [f"| `{name}` | " + sentence.replace("|", r"\|") + " |\n" for name, sentence in said.values()]
    return f"| file in `{folder}` | what it does |\n|---|---|\n" + "".join(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", default=".", help="the kit's folder")
    parser.add_argument("--check", action="store_true", help="write nothing; are the tables up to date?")
    options = parser.parse_args()
    page = os.path.join(options.source, "docs/tools.md")
    with open(page, encoding="utf-8") as file:
        old = file.read()
    new = TABLE.sub(lambda found: found[1] + table(options.source, found[2]) + found[3], old)
    if options.check:
        sys.exit(None if new == old else "docs/tools.md: a table is out of date; run make tools-page")
    with open(page + ".part", "w", encoding="utf-8") as file:
        file.write(new)
    os.replace(page + ".part", page)


if __name__ == "__main__":
    main()
