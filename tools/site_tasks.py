#!/usr/bin/env python3
"""Writes the texts of a site: the landing page, the list of assignments, what the workbench shows of each.

That is tasks/STEM.json.gz, the data of task_page.py. Texts are HTML, made by pandoc."""

import gzip
import html
import json
import os
import re
import shutil
import subprocess
import sys

from grading.assignments import Parser, ToolError, choose, read_features, read_places, read_points
from grading.course_words import read_words
from task_page import task_page

# Of assignments whose own goal speaks of the terminal.
_GOALS = {"normals": "Try everything once before it gets difficult: the editor, the claims that are "
                     "checked at each pause in typing, the picture beside the wanted one, and the rays of a "
                     "pixel. You write two functions of one line each, and see what they do."}
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
        self._texts.append(text)

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


def html_page(source, feature, places):
    """Returns an assignment's data for a page, with texts as HTML; `places` are read_places's."""
    texts, goal = Html(), _GOALS.get(feature.stem, "")
    task_page(source, feature, texts.add, goal=goal)
    made = iter(texts.made())

    def page_of(section):
        return f"{_place(places, section)}?work" if places else ""
    return task_page(source, feature, lambda _: next(made), "book/" if places else "", page_of, goal)


_ASSIGNMENT = ('<li><a href="workbench.html?{stem}"><img src="pictures/{stem}.png" alt="" loading="lazy">'
               '<strong>{number}. {title}</strong> {about}</a></li>')
_STRIP = ("red_claim.svg", "wrong_picture.png", "normals.png")  # below the landing page's first picture


def _sentence(words):
    return html.escape(words[0].upper() + words[1:])


def landing_page(source, course, words, parts):
    """Returns the landing page with the course's Words, a picture and a link for each assignment, and a
    link for each of these parts of the site: "book", "report"; "kit": with what is said to instructors."""
    with open(os.path.join(source, "tools", "site", "index.html"), encoding="utf-8") as file:
        page = file.read()
    features = read_features(source)
    items = [_ASSIGNMENT.format(stem=task["stem"], number=task["number"], title=_sentence(task["title"]),
                                about=_sentence(features[task["stem"]].about)) for task in course]
    note = Html()
    note.add(words.note)
    filled = {"title": html.escape(words.title or "raykit"), "note": note.made()[0],
              "first": course[0]["stem"], "course": "\n    ".join(items)}
    parts = [*parts, *(["note"] if words.note else [])]
    page = re.sub(r"( *)<!-- (\w+) -->(.*?)<!-- end -->\n",
                  lambda part: f"{part[1]}{part[3]}\n" if part[2] in parts else "", page, flags=re.DOTALL)
    return re.sub(r"\{(title|note|first|course)\}", lambda name: filled[name[1]], page)


# --- The book's copy ------------------------------------------------------------------------------


def _behind_heading(page, name, link, where):
    """Returns a page with a paragraph of a link behind the heading of this name."""
    heading = re.compile(rf'<(h[1-6])\b[^>]*\sid="{re.escape(name)}".*?</\1>', re.DOTALL)
    made, count = heading.subn(lambda found: f'{found[0]}\n<p class="workbench">{link}</p>', page, count=1)
    if not count:
        raise ToolError(f"{where} has no heading {name}; make book again, or correct points.tsv")
    return made


def _steps_of(tests):
    """Returns a dictionary from a section to the numbers of its steps."""
    steps = {}
    for test in tests:
        if test.step and test.section and test.step not in steps.setdefault(test.section, []):
            steps[test.section].append(test.step)
    return steps


def _place(places, section):
    """Returns the page with a section, such as "#bloom-box"."""
    if section[1:] not in places:
        raise ToolError(f"the book has no section {section}; make book again, or correct points.tsv")
    return places[section[1:]]


def _read_pages(book, feature, places):
    """Returns a dictionary from the names of a chapter's pages to their texts: each has a heading."""
    with open(os.path.join(feature.source, feature.chapter), encoding="utf-8") as file:
        headings = re.findall(r"^#+ .*\{#([\w-]+)", file.read(), re.MULTILINE)
    pages = dict.fromkeys(_place(places, f"#{name}") for name in headings)
    for name in pages:
        with open(os.path.join(book, name), encoding="utf-8") as file:
            pages[name] = file.read()
    return pages


def lead_to_workbench(book, feature, places):
    """Puts links to the workbench into a chapter's pages, below its title and below the sections that belong
    to steps; and the script that folds solutions for those who come from there."""
    first, bench = feature.page_name(), f"../workbench.html?{feature.stem}"
    lines = {first.removesuffix(".html"): [f'<a href="{bench}">Try it: the workbench</a>']}
    for section, steps in _steps_of(read_points(feature)).items():
        lines[section[1:]] = [f'<a href="{bench}#step-{step}">Step {step} in the workbench</a>'
                              for step in sorted(steps)]
    pages = _read_pages(book, feature, places)
    for section, links in lines.items():
        name = _place(places, f"#{section}")
        pages[name] = _behind_heading(pages[name], section, ", ".join(links), os.path.join(book, name))
    for name, page in pages.items():
        before, end, behind = page.partition("</main>\n")
        if not end:
            raise ToolError(f"{os.path.join(book, name)} does not end its text; make book again")
        _write(book, name, f'{before}{end}<script src="../folded.js"></script>\n{behind}')


def lead_to_start(book, places):
    """Says where the book tells how to write units that they can be written here."""
    if "write-it" in places:
        name = places["write-it"]
        with open(os.path.join(book, name), encoding="utf-8") as file:
            page = file.read()
        link = '<a href="../index.html">Here, in your browser: choose an assignment</a>'
        _write(book, name, _behind_heading(page, "write-it", link, os.path.join(book, name)))


# --- Links that lead out of the book and the report ---------------------------------------------

_OF_THE_KIT = re.compile(r"<a\s([^>]*?)href=\"(?:\.\./){2,}([^\"]*)\"([^>]*)>(.*?)</a>", re.DOTALL)
_HOME = '<p class="home"><a href="{up}index.html">All assignments</a></p>'
_ROOMS = {"docs/out/book.html": "book", "reports/out/report.html": "report/report"}


def _place_in_site(target, places):
    """Returns where the site has what is at target in the kit's folder, None if nowhere."""
    page, _, name = target.partition("#")
    room = next((room for file, room in _ROOMS.items() if page.endswith(file)), None)
    return f"{room}/{places[room][name]}#{name}" if name in places.get(room, {}) else None


def lead_into_site(site, room, places):
    """Turns links from the pages in a room, such as "book", to the book and the report into those of the
    site, and leaves the words of links to other files of the kit, which a site does not have; puts a link to
    the site's first page above each. `places` has of each room that the site has the page of each name."""
    folder, up = os.path.join(site, room), "../" * (room.count("/") + 1)

    def turned(link):
        before, target, behind, words = link.groups()
        place = _place_in_site(target, places)
        return f'<a {before}href="{up}{place}"{behind}>{words}</a>' if place else words
    for name in os.listdir(folder):
        if name.endswith(".html"):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                page = file.read()
            page = _OF_THE_KIT.sub(turned, page)
            _write(folder, name, page.replace("<header>\n", f'<header>\n{_HOME.format(up=up)}\n', 1))


# --- The site -------------------------------------------------------------------------------------


def _write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text)


def _write_json(folder, name, value):
    with open(os.path.join(folder, "tasks", f"{name}.json.gz"), "wb") as file:
        file.write(gzip.compress(json.dumps(value).encode(), mtime=0))


def workbook_in(folder, name):
    """Returns a workbook's data for a page: its name for students, and the texts of its files."""
    texts = {}
    for file in sorted(os.listdir(folder)):
        with open(os.path.join(folder, file), encoding="utf-8") as opened:
            texts[file] = opened.read()
    return {"folder": name, "files": texts}


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--out", required=True, metavar="DIR", help="write the files there")
    parser.add_argument("--workbook", required=True, metavar="DIR",
                        help="what workbook.py has made --named mine")
    parser.add_argument("--book", action="store_true", help="the site has the book, as book/")
    parser.add_argument("--report", action="store_true", help="the site has the report, as report/")
    parser.add_argument("--title", default="", metavar="TEXT", help="the course's title for the first page")
    parser.add_argument("--note", default="", metavar="FILE|TEXT",
                        help="what the course says there, such as dates; Markdown")
    parser.add_argument("--course", action="store_true", help="the site is a course's, not the kit's")
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    arguments = parser.parse_args()
    try:
        for folder in ("pictures", "starters", "tasks"):
            os.makedirs(os.path.join(arguments.out, folder), exist_ok=True)
        parts = [part for part in ("book", "report") if getattr(arguments, part)]
        words = read_words(arguments.title, arguments.note)
        book = os.path.join(arguments.out, "book")
        places = read_places(book) if arguments.book else {}
        course = []
        for feature in choose(read_features(arguments.source), arguments.stems):
            task = html_page(arguments.source, feature, places)
            course.append({"stem": feature.stem, "number": int(feature.folder.split("_")[0]),
                           "title": task["title"]})
            _write_json(arguments.out, feature.stem, task)
            shutil.copy(os.path.join(arguments.workbook, feature.stem + ".c"),
                        os.path.join(arguments.out, "starters"))
            if arguments.book:
                lead_to_workbench(book, feature, places)
        if arguments.book:
            lead_to_start(book, places)
        rooms = {room: read_places(os.path.join(arguments.out, room)) for room in _ROOMS.values()}
        for room in filter(rooms.get, rooms):
            lead_into_site(arguments.out, room, rooms)
        _write_json(arguments.out, "course", course)
        _write_json(arguments.out, "workbook", workbook_in(arguments.workbook, "mine"))
        for picture in ("cover.png", *_STRIP, *(task["stem"] + ".png" for task in course)):
            shutil.copy(os.path.join(arguments.source, "docs", "pictures", picture),
                        os.path.join(arguments.out, "pictures"))
        _write(arguments.out, "index.html", landing_page(
            arguments.source, course, words, [*parts, *([] if arguments.course else ["kit"])]))
    except (ToolError, OSError) as error:
        print(f"site_tasks: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
