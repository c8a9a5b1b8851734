#!/usr/bin/env python3
"""Writes the texts of a site: the landing page, the list of assignments, what the workbench shows of each.

That is tasks/STEM.json: the goal, the hours, and for each step what to write, what is given, its claims, its
hints and its sections in the chapter. Texts are HTML, made by pandoc."""

import html
import json
import os
import re
import shutil
import subprocess
import sys

from grading.assignments import Parser, ToolError, choose, read_features, read_looks, read_points
from handout_text import handout_of, task_of
from hint import hints_of

_BETWEEN = "<hr class=\"between\">"  # pandoc leaves it as it is


def _unwrapped(text):
    """Returns HTML without its paragraph if it is no more than one."""
    only = re.fullmatch(r"<p>(.*)</p>", text, re.DOTALL)
    return only[1] if only and "<p>" not in only[1] else text


class Html:
    """Texts in Markdown that one call of pandoc makes HTML."""

    def __init__(self):
        self._texts = []

    def add(self, text):
        """Returns a place for the HTML of this text."""
        self._texts.append(text)
        return len(self._texts) - 1

    def made(self):
        """Returns the HTML of all texts, in their order."""
        command = ["pandoc", "--from", "markdown-smart", "--to", "html5", "--mathml"]
        answer = subprocess.run(command, input=f"\n\n{_BETWEEN}\n\n".join(self._texts), capture_output=True,
                                encoding="utf-8", check=False)
        if answer.returncode:
            raise ToolError(f"pandoc failed: {answer.stderr.strip()}")
        made = [_unwrapped(part.strip()) for part in answer.stdout.split(_BETWEEN)]
        if len(made) != len(self._texts):
            raise ToolError("pandoc changed what stands between the texts of an assignment")
        return made


def _without_kit_links(text):
    """Leaves the words of links to files, which a page does not have."""
    return re.sub(r"\[([^]]*)\]\((?!https?:)[^)]*\)", r"\1", text)


def _paragraph(text, beginning):
    found = re.search(rf"^\*\*{beginning}\.?:?\*\*:? *(.*?)\n\n", text, re.MULTILINE | re.DOTALL)
    return " ".join(found[1].split()) if found else ""


def _in_place(value, made):
    """Puts HTML where numbers stand for it, in lists and dictionaries."""
    if isinstance(value, int):
        return made[value]
    if isinstance(value, list):
        return [_in_place(item, made) for item in value]
    return {key: item if key in ("number", "points", "claims", "sections") else _in_place(item, made)
            for key, item in value.items()}


def task_page(source, feature):
    """Returns an assignment's data for a page: title, goal, hours, chapter, starter's name, steps."""
    text = _without_kit_links(handout_of(source, feature))
    hints, tests, texts = hints_of(text), read_points(feature), Html()
    title = re.match(r"# (?:Assignment \d+: )?(.*)", text)[1]
    steps = []
    for number in sorted({test.step for test in tests if test.step}):
        write, given = task_of(text, number)
        of_step = [test for test in tests if test.step == number]
        steps.append({
            "number": number, "write": texts.add(write),
            "given": [texts.add(name) for name, _ in given],
            "hints": [{"title": texts.add(title), "text": texts.add(body)}
                      for title, body in hints.get(str(number), [])],
            "look": [texts.add(look.caption) for look in read_looks(feature) if look.step == number],
            "claims": [test.name for test in of_step], "points": sum(test.points for test in of_step),
            "sections": list(dict.fromkeys(test.section for test in of_step))})
    goal = texts.add(_paragraph(text, "Goal"))
    made = texts.made()
    return {"stem": feature.stem, "title": title, "goal": made[goal], "hours": _paragraph(text, "Time"),
            "chapter": feature.page_name(), "folder": feature.folder, "steps": _in_place(steps, made),
            "kept": [test.name for test in tests if not test.step]}


_ASSIGNMENT = ('<li><a href="workbench.html?{stem}"><img src="pictures/{stem}.png" alt="" loading="lazy">'
               '{number}. {title}</a></li>')


def landing_page(source, course, parts):
    """Returns the landing page with a picture and a link for each assignment of the course, and a link for
    each of these parts of the site: "book", "report"."""
    with open(os.path.join(source, "tools", "site", "index.html"), encoding="utf-8") as file:
        page = file.read()
    items = [_ASSIGNMENT.format(stem=task["stem"], number=task["number"], title=html.escape(task["title"]))
             for task in course]
    page = re.sub(r" *<!-- (\w+) -->(.*?)<!-- end -->\n",
                  lambda part: f"    {part[2]}\n" if part[1] in parts else "", page)
    return page.replace("<!-- course -->", "\n    ".join(items))


def _write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text)


def _write_json(folder, name, value):
    _write(folder, f"tasks/{name}.json", json.dumps(value, indent=1))


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--out", required=True, metavar="DIR", help="write the files there")
    parser.add_argument("--book", action="store_true", help="the site has the book, as book/")
    parser.add_argument("--report", action="store_true", help="the site has the report, as report/")
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    arguments = parser.parse_args()
    try:
        os.makedirs(os.path.join(arguments.out, "pictures"), exist_ok=True)
        os.makedirs(os.path.join(arguments.out, "tasks"), exist_ok=True)
        parts = [part for part in ("book", "report") if getattr(arguments, part)]
        course = []
        for feature in choose(read_features(arguments.source), arguments.stems):
            task = dict(task_page(arguments.source, feature), has_book=arguments.book)
            course.append({"stem": feature.stem, "number": int(feature.folder.split("_")[0]),
                           "title": task["title"]})
            _write_json(arguments.out, feature.stem, task)
        _write_json(arguments.out, "course", course)
        for picture in ("cover", *(task["stem"] for task in course)):
            shutil.copy(os.path.join(arguments.source, "docs", "pictures", picture + ".png"),
                        os.path.join(arguments.out, "pictures"))
        _write(arguments.out, "index.html", landing_page(arguments.source, course, parts))
    except (ToolError, OSError) as error:
        print(f"site_tasks: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
