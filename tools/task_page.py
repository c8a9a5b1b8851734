"""What the workbench shows of an assignment, from its handout and its table of points.

That is the goal, the hours, for each step what to write, what is given with its prototypes, its claims, its
hints and its sections in the chapter, and the suite with the lines of each claim."""

import os
import re

from grading.assignments import ToolError, read_points
from handout_text import handout_of, task_of
from hint import hints_of


def _without_kit_links(text):
    """Leaves the words of links to files, which a page does not have."""
    return re.sub(r"\[([^]]*)\]\((?!https?:)[^)]*\)", r"\1", text)


def _paragraph(text, beginning):
    found = re.search(rf"^\*\*{beginning}\.?:?\*\*:? *(.*?)\n\n", text, re.MULTILINE | re.DOTALL)
    return " ".join(found[1].split()) if found else ""


def _read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def _prototypes(headers, names):
    """Returns the declarations of those of these names that are functions of these headers."""
    found = (re.search(rf"^(?:static )?(?:inline )?(\w[\w ]*[ *]+{name}\([^;{{]*\))", header, re.MULTILINE)
             for name in names for header in headers)
    return [" ".join(declaration[1].split()) + ";" for declaration in found if declaration]


def _given(source, text, name, file):
    """Returns a row of what is given: its text, the headers that a page can show, and the prototypes."""
    headers = re.findall(r"`src/([^`]*\.h)`", file)
    declared = [_read(os.path.join(source, "src", header)) for header in headers]
    names = dict.fromkeys(re.findall(r"\brk_\w+", " ".join(re.findall(r"`([^`]*)`", name))))
    return {"text": text(name), "headers": headers, "prototypes": _prototypes(declared, names)}


def _titles(source, feature):
    """Returns a chapter's headings by their places, such as "#normals-colours"."""
    text = _read(os.path.join(source, feature.chapter))
    return {f"#{place}": title for title, place in re.findall(r"^#+ (.*?) \{#([\w-]+)", text, re.MULTILINE)}


def _lines_of_claims(feature, suite, names):
    """Returns the first and the last line of each claim's function in the suite, with the comment before
    it."""
    code = {}
    for name in names:
        found = re.search(rf"^static void {name}\(void \*\*state\)\n\{{\n.*?^\}}$", suite,
                          re.MULTILINE | re.DOTALL)
        if not found:
            raise ToolError(f"{feature.suite} has no function {name}")
        comment = re.search(r"(?:\A|\n\n)(/\*(?:(?!\*/).)*\*/\n)\Z", suite[:found.start()], re.DOTALL)
        begin = found.start() - (len(comment[1]) if comment else 0)
        code[name] = [suite.count("\n", 0, begin) + 1, suite.count("\n", 0, found.end()) + 1]
    return code


def task_page(source, feature, text, book="", page_of=lambda section: "", goal=""):
    """Returns an assignment's data for a page. text(words) is what the page gets in the place of words in
    Markdown; `book` the address of the book there, page_of(section) its page with a section, and `goal` takes
    the place of the handout's."""
    handout = _without_kit_links(handout_of(source, feature))
    hints, tests, titles = hints_of(handout), read_points(feature), _titles(source, feature)
    steps, suite = [], _read(feature.suite)
    for number in sorted({test.step for test in tests if test.step}):
        write, given = task_of(handout, number)
        of_step = [test for test in tests if test.step == number]
        steps.append({
            "number": number, "write": text(write), "given": [_given(source, text, *row) for row in given],
            "hints": [{"title": text(title), "text": text(body)}
                      for title, body in hints.get(str(number), [])],
            "claims": [test.name for test in of_step], "points": sum(test.points for test in of_step),
            "sections": [{"href": page_of(section) + section, "title": text(titles[section])}
                         for section in dict.fromkeys(test.section for test in of_step)]})
    return {"stem": feature.stem, "title": re.match(r"# (?:Assignment \d+: )?(.*)", handout)[1],
            "goal": text(goal or _paragraph(handout, "Goal")), "hours": _paragraph(handout, "Time"),
            "book": book, "steps": steps, "suite": suite,
            "code": _lines_of_claims(feature, suite, [test.name for test in tests]),
            "kept": [test.name for test in tests if not test.step]}
