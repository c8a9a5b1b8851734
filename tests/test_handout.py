#!/usr/bin/env python3
"""A course from end to end: a pack for students is made, built, failed and solved, and a class of
submissions is graded. Speaks TAP, for make check-handout; runs in a build folder."""

import html
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import handout  # noqa: E402
import live_loop  # noqa: E402
from grading import course_words  # noqa: E402
from grading import leak_check  # noqa: E402
from grading.assignments import ToolError, read_features, read_looks, read_places, read_points  # noqa: E402
from grading.build import Toolchain  # noqa: E402
from grading.mutants import mutate, read_mutants  # noqa: E402
from grading.starters import is_handed_out, is_left_open, solution_lines, starter_of  # noqa: E402
from png import filtered_rows  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

STEM, NEXT = "bvh_median", "sah_binning"  # the second builds its trees by the first
FEATURES = read_features(SOURCE)
FEATURE = FEATURES[STEM]
STARTER = starter_of(FEATURE.reference)
TESTS = read_points(FEATURE)
TOTAL = sum(test.points for test in TESTS)
SECRET = max(sorted(solution_lines(FEATURE.reference)), key=len)
COMMON = "for (uint32_t i = 0; i < count; i++)"


# --- The instructor packs -------------------------------------------------------------------------


def what_comes_later():
    def later(stems, word):
        chosen = [FEATURES[stem] for stem in stems]
        return [feature.stem for feature in handout._later(FEATURES, chosen, word)]

    stems = list(FEATURES)
    after = stems[stems.index(STEM) + 1:]
    check(later([STEM], "") == after, "what comes later in the course has starters", later([STEM], ""))
    check(later([NEXT], "") == after[1:], "what came before has its solutions", later([NEXT], ""))
    check(later([NEXT], "all") == [stem for stem in stems if stem not in (STEM, NEXT)],
          "what is needed has its solution, though all are left open", later([NEXT], "all"))
    used = FEATURES["wide_bvh"].uses
    check(used and not set(used) & set(later(["wide_bvh"], "all")),
          "so has what a suite uses, which fails with its starter", later(["wide_bvh"], "all"))
    check(later([STEM], "no") == [] and later([STEM], "bloom shading") == ["shading", "bloom"],
          "LATER names others, or none")
    for stem, word in ((NEXT, STEM), (STEM, STEM), (STEM, "blom")):
        try:
            later([stem], word)
            check(False, f"LATER={word} is refused for {stem}")
        except ToolError as error:
            check(word in str(error) and "\n" not in str(error), f"LATER={word} is refused for {stem}", error)


def the_goal_is_one_of_the_course():
    order = handout._order(SOURCE, ["watertight", "sampling"])
    check("shading" not in order and "--scene" not in order and "table of steps" in order,
          "a course that the picture at the top does not use has another goal", order)
    order = handout._order(SOURCE, [STEM, "shading", "sampling"])
    check("`make start-shading` begins with another" in order and f"uses `{STEM}` and `shading`:" in order
          and "--scene cover" in order,
          "a course that it uses is told by which assignments, and how to take another order", order)
    check("table's order" not in handout._order(SOURCE, [STEM]), "a single assignment has no order")
    order = handout._order(SOURCE, ["bloom"], ["cubemap", "sampling"])
    check("pictures/bloom.png" in order
          and "make driver-bloom\n    impl/assignments/06_bloom/bloom --scene lanterns" in order
          and "--bloom-radius 100 --width 320 --height 320" in order
          and "cover" not in order and "more noise" in order,
          "where the picture at the top needs what is left open, the goal is the assignment's own", order)
    order = handout._order(SOURCE, [STEM], ["shading"])
    check("goal" not in order and "![" not in order, "there is none that needs what is left open", order)


def mistakes_are_refused(folder):
    taken = os.path.join(folder, "taken.tar.gz")
    write("mine", taken)
    cases = {
        "no assignment is refused, and all are listed": ([], {}, STEM),
        "an unknown assignment is refused": (["bvh_medina"], {}, "bvh_medina"),
        "a place that is taken is refused": ([STEM], {"out": taken}, "exists"),
        "an archive of another kind is refused": (
            [STEM], {"out": os.path.join(folder, "pack.zip")}, ".tar.gz"),
        "a place in a folder that is not there is refused": (
            [STEM], {"folder": os.path.join(folder, "no", "pack")}, "no folder"),
    }
    for name, (stems, place, part) in cases.items():
        try:
            handout.make_handout(SOURCE, stems, book=False, **place)
            check(False, name)
        except ToolError as error:
            check(part in str(error) and "\n" not in str(error), name, error)
    with mock.patch.dict(os.environ, PANDOC=""):
        try:
            handout.make_handout(SOURCE, [STEM], folder=os.path.join(folder, "bookless"))
            check(False, "a pack without the book is made on request only")
        except ToolError as error:
            check("pandoc" in str(error) and "BOOK=no" in str(error),
                  "a pack without the book is made on request only", error)
    check(os.listdir(folder) == ["taken.tar.gz"] and read(taken) == "mine",
          "what is refused leaves nothing behind", os.listdir(folder))


NOTE = """Hand in by Monday, 5 October 2026, 23:59. A day late costs {10 %}.

## Dates

| what | when |
|---|---|
| [your file](workbook/bvh_median.c) | see [the course](https://uni.example/cg), or <ann@uni.example> |

```
git push  # <b>
```
"""


def a_course_has_its_own_words(folder):
    path = os.path.join(folder, "note.md")
    marked = b"\xef\xbb\xbf" + NOTE.replace("\n", "\r\n").encode()
    for text, told in ((NOTE.encode(), "a file"), (marked, "one with a byte order mark and CRLF")):
        with open(path, "wb") as file:
            file.write(text)
        words = course_words.read_words(" Graphics, week 3 ", path)
        check((words.title, words.note) == ("Graphics, week 3", NOTE.strip()), f"a NOTE is {told}",
              words.note)
    words = course_words.read_words("", "No late days. Ask Ann & Bo.")
    check(words.note == "No late days. Ask Ann & Bo.", "or a text", words.note)
    page = "# What is handed out here\n\nThis is raykit.\n"
    check(course_words.read_words("", "").put_into(page) == page, "without words the page stays as it is")
    check(course_words.read_words("T", "N").put_into(page)
          == "# T\n\nN\n\n## What is handed out here\n\nThis is raykit.\n"
          and course_words.read_words("", "N").put_into(page)
          == "# What is handed out here\n\nN\n\nThis is raykit.\n",
          "they stand above all else on the page")
    with open(os.path.join(folder, "latin.md"), "wb") as file:
        file.write("Grüße".encode("latin-1"))
    write("x" * 40000, folder, "long.md")
    many = {"a title of two lines": ("a\nb", "", "TITLE"), "a title with marks": ("a <!-- b", "", "TITLE"),
            "a long title": ("a" * 200, "", "TITLE"),
            "a file that is not there": ("", os.path.join(folder, "no.md"), "no.md"),
            "a folder": ("", folder, "is a folder"), "what is not UTF-8": (
                "", os.path.join(folder, "latin.md"), "latin.md:1: this is not UTF-8; save it as UTF-8"),
            "a book": ("", os.path.join(folder, "long.md"), "shorten it"),
            "a fence without its pair": ("", "so:\n```\nmake\n", "NOTE:2: "),
            "a comment": ("", "so\n<!-- pack", "NOTE:2: "), "HTML": ("", "a <div> b", "NOTE:1: <div>"),
            "a second title": ("", "a\n\n# Course\n", "NOTE:3: begin headings with ##"),
            "one that is underlined": ("", "Course\n======\n", "NOTE:2: begin headings with ##"),
            "control characters": ("", "a\x1b[31m", "NOTE:1: "),
            "what turns text around": ("", "a\u202eb", "NOTE:1: "),
            "a command of the kit alone": ("", "make check-normals IMPL=mine", "NOTE:1: ")}
    for told, (title, note, part) in many.items():
        try:
            course_words.read_words(title, note)
            check(False, f"{told} is refused")
        except ToolError as error:
            check(part in str(error) and "\n" not in str(error), f"{told} is refused", error)
    for note, part in ((f"Hint: {SECRET}", "NOTE:1: this is a line of the solution of bvh_median"),
                       ("see [it](syllabus.pdf)", "NOTE:1: syllabus.pdf is not in the pack")):
        place = os.path.join(folder, "packs")
        os.makedirs(place, exist_ok=True)
        try:
            handout.make_handout(SOURCE, [STEM], folder=os.path.join(place, "pack"), book=False, note=note)
            check(False, f"before anything is packed: {part}")
        except ToolError as error:
            check(part in str(error) and not os.listdir(place), f"before anything is packed: {part}", error)


def the_course_speaks_first(pack, said):
    page = read(pack, "HANDOUT.md")
    check(page.startswith("# Graphics {1}\n\n" + NOTE + "\n## What is handed out here\n\nThis is raykit"),
          "a pack's first page begins with the course's title and note", page[:1000])
    check(any("HANDOUT.md begins with the course's title and note" in line for line in said),
          "and where they are is said", said)
    make, out = os.environ.get("MAKE", "make"), os.path.join(os.path.dirname(pack), "never.tar.gz")
    for words, part in ((["TITLE=a <!-- b"], "TITLE"), (["NOTE=$(no) `such`.md"], "$(no) `such`.md"),
                        (["NOTES=x"], "it takes no NOTES, but DIR LATER BOOK TITLE NOTE")):
        status, text = run(".", make, "-s", "handout", f"ASSIGNMENTS={STEM}", f"OUT={out}", "BOOK=no", *words)
        check(status != 0 and part in text and not os.path.exists(out), f"make handout refuses {words[0]}",
              text)


def what_is_stopped_leaves_nothing_behind(folder):
    pid = os.path.join(folder, "pandoc.pid")
    write(f"#!/bin/sh\necho $$ >'{pid}'\nexec sleep 600\n", folder, "pandoc")
    os.chmod(os.path.join(folder, "pandoc"), 0o755)
    place = os.path.join(folder, "packs")
    os.mkdir(place)
    process = subprocess.Popen([sys.executable, "-B", os.path.join(SOURCE, "tools", "handout.py"),
                                "--source", SOURCE, STEM, "--dir", os.path.join(place, "pack")],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                               env=dict(os.environ, PANDOC=os.path.join(folder, "pandoc"), QUICK="1"))
    until = time.monotonic() + 300
    while time.monotonic() < until and process.poll() is None and not (os.path.exists(pid) and read(pid)):
        time.sleep(0.1)
    process.terminate()
    said, _ = process.communicate(timeout=60)
    check(process.returncode == 130 and "nothing was written" in said,
          "packing can be stopped, and says so", said)
    check(os.path.exists(pid) and not os.path.exists(f"/proc/{read(pid).strip()}"),
          "what it has started is stopped, too", said)
    check(os.listdir(place) == [], "and nothing is left beside the pack's place", os.listdir(place))


def the_pack_holds_no_solution(pack):
    check(read(pack, "workbook", STEM + ".c") == STARTER, "the workbook holds the starter")
    everything = b"".join(open(os.path.join(where, name), "rb").read()
                          for where, _, names in os.walk(pack) for name in names)
    check(SECRET.encode() not in everything, "no file holds a line of the solution")
    instructors = os.environ["RAYKIT_INSTRUCTORS"].split()
    left = [name for name in instructors if os.path.exists(os.path.join(pack, name))]
    check(len(instructors) > 10 and not left, "what only instructors use is left out", left)
    marked = [name for name in leak_check._files(pack)
              if name.endswith((".c", ".h")) and "/* solution */" in read(pack, name)]
    held = {f"src/features/{stem}.c" for stem in FEATURES if stem != STEM}
    check(set(marked) == held, "the word solution stands only in units whose solution is there", marked)
    unit = os.path.join(pack, "src", "features", STEM + ".c")
    check(starter_of(unit) == STARTER and is_handed_out(unit),
          "src/features has the starter, to compare with")
    check(f"## Hand in\n\n- `workbook/{STEM}.c`\n" in read(pack, "HANDOUT.md"),
          "HANDOUT.md names the file to hand in")


def commands_exist(pack):
    """Each command of README.md and docs/commands.md runs a file of the pack, or makes a target of it."""
    text = read(pack, "README.md") + read(pack, "docs", "commands.md")
    rules = "".join(read(pack, name) for name in os.listdir(pack)
                                                   if name.endswith(".am"))
    rules += "".join(read(pack, name) for name in leak_check._files(pack) if name.endswith(".am"))
    commands = [command for line in re.findall(r"^    (.*)|`([^`\n]*)`", text, re.MULTILINE)
                for command in re.split(r" && |; ", line[0] or line[1])]
    files = [command.split()[0] for command in commands if re.match(r"[\w.]+/\S+( |$)", command)
             and not command.startswith("../")]  # after cd
    lost = [name for name in files if not os.path.exists(os.path.join(pack, name)) and name != "./configure"]
    check(files and not lost, "the files that their commands run are in the pack", lost)
    made = {word for command in commands if command.startswith("make ")
            for word in command.split()[1:] if re.fullmatch(r"[a-z][\w-]*", word)}
    lost = [target for target in made - {"install", "distclean"}
            if not re.search(rf"\b{re.sub('-NAME$', '-', target)}[^=\n]*:", rules)]
    check(made and not lost, "and make has the targets of the others", lost)


def texts_speak_of_the_pack(pack):
    commands_exist(pack)
    task, chapter = read(pack, "assignments", FEATURE.folder, "handout.md"), read(pack, FEATURE.chapter)
    first_page = read(pack, "HANDOUT.md")
    for name, text in (("handout", task), ("chapter", chapter),
                       ("book's first page", read(pack, "docs", "book.md")), ("HANDOUT.md", first_page)):
        check("=mine" not in text and "mine/" not in text and "<!--" not in text,
              f"the {name} speaks of the workbook, not of a folder to be made", text[:2000])
    for name, text in (("HANDOUT.md", first_page), (f"assignments/{FEATURE.folder}/handout.md", task)):
        pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", text)
        missing = [picture for picture in pictures
                   if not os.path.exists(os.path.join(pack, os.path.dirname(name), picture))]
        check(pictures and not missing, f"the pictures that {name} shows are in the pack", missing)
    command = "    make driver-motion_blur\n    impl/assignments/10_motion_blur/motion_blur --scene cover"
    check(command in first_page, "HANDOUT.md has the commands that draw its picture")
    names = [*(feature.chapter for feature in FEATURES.values()),
             "HANDOUT.md", f"assignments/{FEATURE.folder}/handout.md"]
    unmade = [name for name in names if re.search(r"^ *assignments/\S+ --", read(pack, name), re.MULTILINE)]
    check(not unmade and f"make driver-{STEM}\nimpl/assignments/{FEATURE.folder}/{STEM} --" in chapter,
          "a command that runs a driver stands below the one that makes it", unmade)
    check(f"make debug-{STEM} TEST=" in chapter, "the chapter's commands are those of the pack")
    check(f"workbook/{STEM}.c" in task and f"(file:workbook/{STEM}.c)" in chapter,
          "texts name the file to edit")
    check("The book is missing" in first_page, "HANDOUT.md says that the book is missing")
    broken = [f"{name}: {target}" for name in leak_check._files(pack) if name.endswith(".md")
              for target in re.findall(r"\]\(([\w./-]+)(?=[)#])", read(pack, name))
              if not os.path.exists(os.path.join(pack, os.path.dirname(name), target))]
    check(not broken, "links in texts lead to files of the pack", broken)
    try:
        handout.as_packed("one\nmake check IMPL=mine_too DIR=mine\n", "docs/some.md", [STEM])
        check(False, "a text that is true in the kit only is refused")
    except ToolError as error:
        check("docs/some.md:2" in str(error) and "DIR=mine" in str(error),
              "a text that is true in the kit only is refused, with file and line", error)


def handouts_share_sections(folder):
    texts = [handout.handout_of(SOURCE, feature) for feature in FEATURES.values()]
    check(all("## How to start" in text and "## Points and handing in" in text
              and "handout_common" not in text and "{" not in re.sub("`.*?`", "", text) for text in texts),
          "each handout has the sections that all share, filled in")
    write("# All\n\n## More\n", folder, "assignments", "handout_common.md")
    write("[Start](../handout_common.md#start)\n", folder, "assignments", FEATURE.folder, "handout.md")
    try:
        handout.handout_of(folder, FEATURE)
        check(False, "a section that is not there is refused")
    except ToolError as error:
        check(FEATURE.folder in str(error) and "\"start\"" in str(error) and "more" in str(error),
              "a section that is not there is refused, with those that are", error)


def numbers_of(path, line):
    """Where a file has this line."""
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        return [number for number, text in enumerate(file.read().split("\n"), 1) if text == line]


def smuggled_lines_are_found(pack):
    secrets, common = leak_check.secret_lines(SOURCE, [FEATURE])
    check(SECRET in secrets and SECRET not in common, "a line that only the solution has is looked for")
    check(COMMON in common, "a line that the kit's other code has, too, says nothing")
    solved = [" ".join(line.split()) for line in read(FEATURE.reference).split("\n")]
    check(leak_check._passages(solved, secrets), "a passage of the solution in the kit's own code is found")
    check(not leak_check._passages(solved[::40], secrets), "its lines one by one, by chance, are none")
    cases = {
        "in a text": ("README.md", "> and then " + SECRET + " it is done"),
        "in a mutant": ("tests/mutants/other.mutants", "- " + SECRET),
        "with other spaces": ("src/scene/bvh.c", "  " + SECRET.replace(" ", "\t ")),
        "coloured in a page": ("docs/handout/more.html", "<b>" + "</b><b>".join(map(html.escape, SECRET))),
        "among bytes that are no text": ("docs/pictures/leaf.dat", "\udcff\udc80 " + SECRET),
        "in the workbook": (f"workbook/{STEM}.c", SECRET),
        "in the workbook, though common elsewhere": (f"workbook/{STEM}.c", COMMON),
    }
    before = {}
    for path, line in cases.values():
        place = os.path.join(pack, path)
        before.setdefault(place, read(place) if os.path.exists(place) else None)
        os.makedirs(os.path.dirname(place), exist_ok=True)
        with open(place, "a", encoding="utf-8", errors="surrogateescape") as file:
            file.write("\n" + line + "\n")
    found = leak_check.find_secrets(SOURCE, pack, [FEATURE], secrets, common)
    for name, (path, line) in cases.items():
        number = max(numbers_of(os.path.join(pack, path), line))
        check(sum(told.startswith(f"{path}:{number}:") for told in found) == 1,
              f"a solution line is found {name}", found)
    check(len(found) == len(cases), "and nothing else is", found)
    for place, text in before.items():
        os.unlink(place) if text is None else write(text, place)
    try:
        write(SECRET, pack, "leak.txt")
        leak_check.prove(SOURCE, pack, FEATURES, [FEATURE])
        check(False, "a pack with a leak is refused")
    except ToolError as error:
        check("leak.txt:1" in str(error), "a pack with a leak is refused, with file and line", error)
    os.unlink(os.path.join(pack, "leak.txt"))
    check(not leak_check.find_secrets(SOURCE, pack, [FEATURE], secrets, common),
          "without the leaks the pack is clean again")


def what_the_kit_has_in_common_is_told(pack):
    place, line = os.path.join(pack, "examples", "shared.c"), "    " + SECRET
    write("/* a line by itself */\n" + line + "\n", place)
    found = leak_check.lines_elsewhere(pack, [FEATURE], {SECRET, COMMON})
    os.unlink(place)
    check(found[0] == ("examples/shared.c", 2, SECRET, 1) and found[1][2] == COMMON and found[1][3] > 1,
          "a solution line in the kit's other code is told, with file and line, the rare ones first", found)
    for stem, _, name, beginning in leak_check.SAME_STEPS:
        steps = leak_check.steps_elsewhere(SOURCE, [FEATURES[stem]])
        lines = read(SOURCE, name).split("\n")
        check(any(step[0] == name and lines[step[1] - 1].startswith(beginning) for step in steps),
              f"a step of {stem} in other words is found in {name}", steps)
    lens, glossy = FEATURES["depth_of_field"], FEATURES["glossy_reflection"]
    said = "\n".join(leak_check.prove(SOURCE, pack, FEATURES, [FEATURE]))
    check("src/accel/query/tree.c:" in said and "in other words" in said, "the packing says so", said)
    alike = ("depth_of_field", "a step", "src/features/glossy_reflection.c", "static rk_vec2 concentric(")
    with mock.patch.object(leak_check, "SAME_STEPS", [alike]):
        check(leak_check.steps_elsewhere(SOURCE, [lens]), "what another feature's solution tells is found")
        check(not leak_check.steps_elsewhere(SOURCE, [lens, glossy]),
              "two that are handed out together do not tell of each other")


# --- The student works ----------------------------------------------------------------------------


def what_is_left_open_is_no_solution(pack):
    for stem in list(FEATURES)[list(FEATURES).index(NEXT) + 1:]:
        path, reference = os.path.join(pack, "src", "features", stem + ".c"), FEATURES[stem].reference
        check(is_left_open(path) and starter_of(path) == starter_of(reference)
              and not solution_lines(reference) & {line.strip() for line in read(path).split("\n")},
              f"{stem}, which a later assignment asks for, is a starter")
    page, workbook = read(pack, "HANDOUT.md"), os.listdir(os.path.join(pack, "workbook"))
    files = [STEM + ".c", NEXT + ".c", "Makefile", "compile_flags.txt", ".gitignore"]
    check(sorted(workbook) == sorted(files) and "shading" not in page.split("Not asked for yet")[0],
          "and nobody is asked for it yet")
    told = " ".join(re.search(r"^Not asked for yet are [^;]*", page, re.MULTILINE)[0].split())
    check(re.findall(r"`(\w+)`", told) == list(FEATURES)[list(FEATURES).index(NEXT) + 1:],
          "HANDOUT.md lists it", told)


def text_of(pages):
    """All pages of a folder."""
    return "\n".join(read(pages, name) for name in sorted(os.listdir(pages)) if name.endswith(".html"))


def chapter_of(pages):
    """The pages of the feature's chapter, in its order."""
    places = read_places(pages)
    headings = re.findall(r"^#+ .*\{#([\w-]+)", read(SOURCE, "docs", f"{FEATURE.folder}.md"), re.MULTILINE)
    return "\n".join(read(pages, name) for name in dict.fromkeys(places[heading] for heading in headings))


def code_of(text, name):
    """The listings of pages that define this name, as text."""
    listings = re.findall(r'<div[^>]* class="listing.*?</pre>', text, re.DOTALL)
    texts = [html.unescape(re.sub("<[^>]*>", "", listing)) for listing in listings]
    return "\n".join(text for text in texts if re.search(rf"\b{name}\(.*\n\{{", text))


def the_book_is_handed_out(pack):
    handed = os.path.join(pack, "docs", "handout")
    pages, record = os.path.join(handed, "book"), os.path.join(handed, "record")
    text = text_of(pages)
    check("First step:" in code_of(text, "box_of") and "workbook/bvh_median.c" in code_of(text, "box_of"),
          "the book is there, with starters", code_of(text, "box_of"))
    linked = set(re.findall(r'(?:src|href)="(\.\./[^"#?]+)', text))
    missing = [link for link in linked if not os.path.exists(os.path.join(pages, link))]
    check(linked and not missing, "its pages find their pictures, and the files that they link to", missing)
    check("Not made:" not in text and "src/features/bvh_median.c" not in text,
          "all its figures are made, its texts are the pack's")
    entries = [os.path.join(record, name) for name in os.listdir(record) if name != "machine"]
    figure = os.path.join("made", "figures", "bvh_median_statue-87130.png")
    check(any(os.path.exists(os.path.join(entry, figure)) for entry in entries), "its figures are there")
    answers = "\n".join(read(entry, name) for entry in entries for name in ("key", "printed", "files"))
    path = re.search(rf"{re.escape(SOURCE)}|\.handout-", text + answers)
    check(not path, "no path of this machine is in it",
          path and (text + answers)[max(0, path.start() - 80):path.end() + 80])
    its_live_figures_stand_still(pages, "impl/assignments")


def its_live_figures_stand_still(pages, drivers):
    """The module that would draw them anew holds the solutions. A book that was woven in the pack names
    drivers that it has built, the handed-out one those that make driver-STEM builds."""
    text = chapter_of(pages)
    tags = re.findall(r'<div class="live"[^>]*>\s*<img[^>]*>', text)
    figures = [{name: html.unescape(value) for name, value in re.findall(r'([\w-]+)="([^"]*)"', tag)}
               for tag in tags]
    wanted = re.findall(r'\{\.live driver=\w+ args="([^"]*)" options="([^"]*)"',
                        read(SOURCE, "docs", f"{FEATURE.folder}.md"))
    found = [(figure["data-args"].removesuffix(" --width 480 --height 480"), figure["data-options"])
             for figure in figures]
    check(wanted and found == wanted, "each live figure has its options", [wanted, found])
    programs = {figure["data-program"] for figure in figures}
    check(programs == {f"{drivers}/{FEATURE.folder}/{STEM}"}, "it names the reader's own program",
          programs)
    pictures = [os.path.join(pages, figure["src"]) for figure in figures]
    check(pictures and all(map(os.path.isfile, pictures)), "its picture is there", pictures)
    scripts = [name for name in os.listdir(pages) if name.endswith(".js")]
    check("live.js" not in scripts and all("WebAssembly" not in read(pages, name) for name in scripts),
          "and no module, which would hold the solutions", scripts)


def answer(url):
    with urllib.request.urlopen(url, timeout=120) as reply:
        return reply.read()


def state_of(url):
    """What the page of the live loop is told, once a save is drawn and checked; {} if it is not."""
    with urllib.request.urlopen(url + "events", timeout=120) as events:
        for line in events:
            known = json.loads(line[len("data: "):]) if line.startswith(b"data: ") else {}
            if any(map(known.get, ("drawn", "undrawn", "failed"))) and not known["busy"]:
                return known
    return {}


def the_live_loop_serves_the_pack(pack):
    looks = [line.split("\t") for line in
             read(pack, "assignments", FEATURE.folder, "look.tsv").splitlines()[1:]]
    own = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    with subprocess.Popen(["make", "-s", f"live-{STEM}"], cwd=pack, env=own, start_new_session=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            said = ""
            while "http" not in said and (line := process.stdout.readline()):
                said += line
            url = re.search(r"http:\S+/", said)
            check(url, "make live serves a page in a pack", said)
            if not url:
                return
            page, known = answer(url[0]), state_of(url[0])
            check(b'src="native.mjs"' in page and b"<select" not in page and b"workbench.mjs" not in page,
                  "it is the workbench, without compiler and editor", page)
            parts = [("live", "native.mjs"), *(("workbench", name) for name in os.listdir(
                os.path.join(pack, "tools", "workbench")) if not name.endswith(".html"))]
            wrong = [name for room, name in parts
                     if answer(url[0] + name) != read(pack, "tools", room, name).encode()]
            check(len(parts) > 5 and not wrong, "its parts are the pack's", wrong)
            check(all(name.endswith(".am") for name in os.listdir(os.path.join(pack, "tools", "site"))),
                  "a pack has no part of the site's")
            task = json.loads(answer(url[0] + "task"))
            claims = [name for step in task["steps"] for name in step["claims"]] + task["kept"]
            check(sorted(claims) == sorted(test.name for test in TESTS) and task["steps"][0]["hints"],
                  "its task has the claims and the hints", task)
            check(task["file"] == f"workbook/{STEM}.c", "it names the file to edit", task["file"])
            places = {section["href"] for step in task["steps"] for section in step["sections"]}
            pages = {place: answer(url[0] + task["book"].lstrip("/") + place.split("#")[0]).decode()
                     for place in places}
            dead = [place for place, text in pages.items() if f'id="{place.split("#")[1]}"' not in text]
            check(len(pages) > 1 and not dead, "its steps lead to their sections of the pack's book", dead)
            header = task["steps"][0]["given"][0]["headers"][0]
            check(answer(f"{url[0]}src/{header}") == read(pack, "src", header).encode(),
                  "it shows the header of what is given", header)
            check([caption for _, caption in known.get("looks", [])] == [look[2] for look in looks],
                  "it offers the pictures of all steps", known)
            steps = {int(step): options for step, options, _ in looks}
            options = steps.get(int(known.get("step", 0)), "none")
            check(known.get("command", "").endswith(f"/{STEM} {options}"),
                  "its command has the options of the picture that it shows", known)
            check(known.get("drawn"), "the student's picture is drawn", known)
            if not known.get("drawn"):
                return
            pictures = [answer(f"{url[0]}picture/{name}") for name in ("own", "wanted")]
            check(all(picture.startswith(b"\x89PNG") for picture in pictures),
                  "the student's picture and the wanted one are there", known)
        finally:
            os.killpg(process.pid, signal.SIGTERM)


def the_live_loop_turns_at_once():
    """Between the verdict and the next picture a page must not hear that all is done."""
    loop, heard = live_loop.Loop.__new__(live_loop.Loop), []
    loop._feature, loop._is_step_chosen, loop._doing = FEATURE, False, {"checking the claims"}
    loop.changed = threading.Condition()
    last = read_looks(FEATURE)[-1].step
    loop.known = {"version": 0, "step": 1, "claims": "", "broken": [{"step": last, "reason": "wrong"}]}
    with mock.patch.object(loop, "tell", lambda **news: (live_loop.Loop.tell(loop, **news),
                                                         heard.append(loop.known["busy"]))):
        loop._take_claims("not ok", 1)
    check(heard and all(heard), "the live loop says with the verdict that another picture follows", heard)


def the_starters_are_failed(pack):
    make = os.environ.get("MAKE", "make")
    compiler = " ".join(Toolchain(".").compiler)
    status, said = run(pack, "./bootstrap", "--no-install", f"CC={compiler}")
    check(status == 0, "the pack configures without git", said)
    status, said = run(pack, make, "-s", "-j2", f"check-{STEM}")
    check(status != 0 and f"first: {TESTS[0].name}" in said,
          "the starter fails, and the check says where to begin", said)
    _, said = run(pack, make, "-s", "grade", f"ASSIGNMENTS={STEM}", "FORMAT=tap")
    scored = sum(test.points > 0 for test in TESTS)
    check(said.count("not ok ") == scored,
          "the starter fails every test that carries points, and no other", said)
    status, said = run(pack, make, "-s", "progress")
    check(status == 0 and f"0 of {TOTAL}" in said, "progress counts no points yet", said)
    status, said = run(pack, make, "-s", f"diff-{STEM}")
    check(status == 0 and "unchanged" in said, "the difference to the starter is none yet", said)
    for target in ("handout", "check-suites", "check-grade", "grade-class", "collect", "grade-book",
                   "feedback", "new-feature"):
        status, said = run(pack, make, "-s", target)
        check(status != 0 and "this is a handout" in said, f"make {target} says that this is a handout", said)
    status, said = run(pack, make, "-s", "check-shading")
    check(status != 0 and "a later assignment asks for it" in said,
          "a suite of what is left open says so", said)


def the_second_is_solved_first(pack):
    make = os.environ.get("MAKE", "make")
    shutil.copyfile(FEATURES[NEXT].reference, os.path.join(pack, "workbook", NEXT + ".c"))
    status, said = run(pack, make, "-s", "-j2", f"check-{NEXT}")
    check(status != 0 and f"it needs {STEM}, which is still the starter: solve that first" in said,
          "the check says what is to be solved before", said)
    for form in ("tap", "gradescope", "table"):
        _, said = run(pack, make, "-s", "grade", f"IMPL=workbook/{NEXT}.c", f"ASSIGNMENTS={NEXT}",
                      f"FORMAT={form}")
        check(f"needs {STEM}, which is still the starter" in said, f"so does a report as {form}", said)
    write(read(FEATURE.reference) + "\n/* Mine. */\n", pack, "workbook", STEM + ".c")
    points = []
    for impl in ("workbook", f"workbook/{NEXT}.c"):
        status, said = run(pack, make, "-s", "grade", f"IMPL={impl}", f"ASSIGNMENTS={NEXT}")
        points += re.findall(r"\d+ of \d+ points", said)
    check(points == ["100 of 100 points"] * 2, "one file gets the points that it gets in the folder", points)
    status, said = run(pack, make, "-s", "-j2", f"check-{STEM}")
    check(status == 0 and f"{TOTAL} of {TOTAL}" in said, "the solution passes with all points", said)


def pictures_are_the_students(pack):
    make = os.environ.get("MAKE", "make")
    status, said = run(pack, make, "-s", "-j2", "all")
    check(status == 0 and "warning" not in said,
          "the drivers are built from the workbook, without a warning", said)
    status, said = run(pack, f"assignments/{FEATURE.folder}/{STEM}",
                       *"--width 64 --height 64 --scene teapot".split())
    check("shading is still the starter" in said, "they name what is left open", said)
    status, said = run(pack, make, "-s", f"driver-{STEM}")
    check(status == 0 and f"impl/assignments/{FEATURE.folder}/{STEM}" in said,
          "the driver of one assignment is made", said)
    names = []
    for impl in ("workbook", f"workbook/{NEXT}.c"):
        status, said = run(pack, make, "-s", f"driver-{NEXT}", f"IMPL={impl}")
        driver = os.path.join("impl", "assignments", FEATURES[NEXT].folder, NEXT)
        status, said = run(pack, driver,
                           *"--width 64 --height 64 --scene teapot --debug level --level 3".split())
        names.append(re.search(r"units: .*?(?=, raykit)", said).group() if status == 0 else said)
        check(f"{NEXT}: shading is still the starter" in said,
              "a driver names a starter that is left open", said)
        names.append(filtered_rows(os.path.join(pack, re.search(r"^(\S+\.png):", said, re.MULTILINE)[1])))
    check(names[1] == names[3] and f"workbook ({STEM}" in names[2],
          "one file draws the pictures that it draws in the folder", [names[0], names[2]])
    _, said = run(pack, make, "-s", f"draw-{STEM}")
    check(": as good as it can be here, if all your claims hold: the picture differs" in said
          and "shading is still the starter here" in said,
          "a picture that lacks only what is not asked for yet is said to be as good as it can be", said)


def the_students_code_is_in_the_book(pack):
    make = os.environ.get("MAKE", "make")
    # Of the texts that the pack's own book has shown whole, a solved feature's and one's that is left open.
    driver = os.path.join(pack, "assignments", FEATURE.folder, STEM)
    os.unlink(driver)
    status, said = run(pack, make, "-s", "book", f"FEATURES={STEM} shading", "CHROMIUM=")
    page = os.path.join(pack, "docs", "out.some", "book.html")
    check(status == 0 and os.path.exists(driver), "make book builds what it needs, and weaves the book again",
          said)
    code = code_of(read(page), "box_of")
    check("rk_box_merge" in code and "Your code." in read(page), "the student's functions are in it", code)
    check("Yours to write" not in code and "Left open here" in read(page) and "Not made:" not in read(page),
          "what is not asked for yet is left open, and all figures are there")
    its_live_figures_stand_still(os.path.join(pack, "docs", "out.some", "book"), "assignments")
    run(pack, "sed", "-i", "s/box_of/my_box_of/g; $ a int broken = ;", f"workbook/{STEM}.c")
    status, said = run(pack, make, "-s", "book", f"ONLY={STEM}", "CHROMIUM=")
    check(status == 0 and "does not define it" in read(page),
          "a function of another name shows the starter, also where the file does not compile", said)
    write(read(FEATURE.reference), pack, "workbook", STEM + ".c")


def suites_of(pack):
    """The names of the suites' programs that have been built."""
    folder = os.path.join(pack, "tests")
    return sorted(name for name in os.listdir(folder)
                  if re.fullmatch(r"test_\w+", name) and os.access(os.path.join(folder, name), os.X_OK))


def fault_of_suite(pack, name):
    """What a suite says if a test fails, which its status does not tell, or it ends early; else nothing."""
    _, said = run(pack, "env", "CMOCKA_MESSAGE_OUTPUT=TAP", f"RAYKIT_HELPERS={pack}", f"tests/{name}")
    plan, passed = re.search(r"^1\.\.(\d+)$", said, re.MULTILINE), re.findall(r"^ok ", said, re.MULTILINE)
    return "" if plan and len(passed) == int(plan[1]) else f"{name}: {said}"


def the_rest_holds(pack):
    """All suites that do not wait for later assignments pass. Scripts that look at files of the pack run by
    make check, with a suite that is left out; programs by themselves, without make's second for each."""
    make = os.environ.get("MAKE", "make")
    scripts = "tests/test_features.sh tests/test_includes.sh tests/test_remedies.sh $(compare_suite)"
    status, said = run(pack, make, "-s", "-j2", "check",
                       "check_PROGRAMS=$(filter-out $(left_out),$(suites) $(stress_suites))",
                       f"TESTS={scripts} tests/test_vec3 tests/test_render")
    told = next((line for line in said.splitlines()
                 if line.startswith(f"red until {STEM} {NEXT} is solved:")), "")
    check(f"test_{STEM}" in told and "test_vec3" not in told and f"make check-{STEM}" in told,
          "make check names the suites that wait for the student", said)
    check(status == 0 and "vec3" in said and "includes" in said and "ok    render" not in said
          and "test_render" in said and "test_surface" in said,
          "all others pass, and those that run what is left open are left out", said)
    left_out = next((line for line in said.splitlines() if line.startswith("left out; ")), "").split()
    programs = [name for name in suites_of(pack) if name not in left_out]
    failed = list(filter(None, (fault_of_suite(pack, name) for name in programs)))
    check(len(programs) > 25 and f"test_{STEM}" in programs and "test_render" not in programs and not failed,
          "each of them, run by itself", failed or programs)
    weaver = [f"tools/weave/{name}" for name in os.listdir(os.path.join(SOURCE, "tools", "weave"))]
    tested = ["bootstrap", "GNUmakefile", "tests/tap_driver", *weaver]
    changed = [name for name in tested if read(pack, name) != read(SOURCE, name)]
    check(not changed, "what the other scripts test is the kit's own, to the byte", changed)
    write("int broken = ;\n", pack, "workbook", STEM + ".c")
    status, said = run(pack, make, "-s", f"check-{STEM}")
    check(status != 0 and "does not compile" in said, "a file that does not compile is told as such", said)


# --- The instructor grades ------------------------------------------------------------------------


def mutant(name):
    """The reference with one of the known mistakes."""
    file = f"tests/mutants/{STEM}.mutants"
    known = {mutant.name: mutant for mutant in read_mutants(os.path.join(SOURCE, file), file)}
    return mutate(known[name], read(FEATURE.reference), FEATURE.reference)


def a_class_is_graded(folder):
    start = "uint32_t count = mesh->triangle_count;\n"
    heads = "#include <stdio.h>\n#include <unistd.h>\n"
    oks = "\\n".join(f"ok {number} - {test.name}" for number, test in enumerate(TESTS, 1))
    any_hit = "bool rk_bvh_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)\n{\n"
    reference = read(FEATURE.reference)
    submissions = {  # text, fewest and most points, part of what is said about some test
        "right": (reference, TOTAL, TOTAL, ""),
        "wrong": (mutant("floor_of_the_half"), 1, TOTAL - 1, "got"),
        "crashing": ("static volatile int *volatile nowhere;\n"
                     + reference.replace(start, start + "    *nowhere = 1;\n"), 0, 0, "NULL"),
        "hanging, by O'Brien": (
            reference.replace(any_hit, any_hit + "    for (volatile int k = 0; k < 2; k = 0) { }\n"),
            1, TOTAL - 1, "endless loop"),
        "cheating by what it prints": (heads + STARTER.replace(
            start,
            start + f'    printf("1..{len(TESTS)}\\n{oks}\\n");\n    fflush(stdout);\n    _Exit(0);\n'),
            0, 0, "_Exit"),
        "cheating before main": (
            "#include <stdlib.h>\n"
            "__attribute__((constructor)) static void early(void)\n{\n    exit(0);\n}\n" + STARTER,
            0, 0, "constructor"),
        "cheating by the suite's own names": (
            STARTER + "\nint rk_suite_main(void);\nint rk_suite_main(void)\n{\n    return 0;\n}\n"
            "bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)\n{\n"
            "    (void)bvh, (void)mesh, (void)error;\n    return true;\n}\n", 0, 0, ""),
    }
    for name, (text, fewest, most, part) in submissions.items():
        place = os.path.join(folder, "submissions", name)
        write(text, place, STEM + ".c")
        out = place + ".json"
        os.environ["RAYKIT_TEST_SECONDS"] = "2" if "hanging" in name else "60"
        status, said = run(".", sys.executable, "-B", os.path.join(SOURCE, "tools", "grade.py"), STEM,
                           "--impl", place, "--format", "gradescope", "--out", out)
        report = json.loads(read(out)) if os.path.exists(out) else {"score": -1, "tests": []}
        outputs = [test["output"] for test in report["tests"]]
        check(fewest <= report["score"] <= most and status == 0
              and any(part in output for output in outputs), f"a submission that is {name} gets its verdict",
              f"{report['score']} points, status {status}\n{said}\n" + "\n".join(outputs))


def it_builds_what_the_book_needs():
    make = os.environ.get("MAKE", "make")
    for name in ("tests/bench/bench", "tools/pair/pair"):
        _, said = run(".", make, "-n", "-W", os.path.relpath(os.path.join(SOURCE, name + ".c")), "handout")
        check(f"{name}.o" in said, f"a pack's book has {name} made first", said[-2000:])


def main():
    folder = tempfile.mkdtemp(prefix="raykit-test-handout-")
    try:
        places = {name: os.path.join(folder, name)
                  for name in ("refused", "words", "stopped", "shared", "packed", "class")}
        for place in places.values():
            os.mkdir(place)
        mistakes_are_refused(places["refused"])
        a_course_has_its_own_words(places["words"])
        it_builds_what_the_book_needs()
        handouts_share_sections(places["shared"])
        what_is_stopped_leaves_nothing_behind(places["stopped"])
        what_comes_later()
        the_goal_is_one_of_the_course()
        pack = os.path.join(places["packed"], "pack")
        said = handout.make_handout(SOURCE, [STEM], folder=pack, book=False, later="no", title="Graphics {1}",
                                    note=NOTE)
        the_course_speaks_first(pack, said)
        check(os.listdir(places["packed"]) == ["pack"]
              and any("no solution is left" in line for line in said),
              "the pack is there with its proof, and nothing beside it", said)
        check(any(line.startswith("the solutions of normals, sah_binning, shading, ")
                  and "are in this pack" in line for line in said)
              and any("THE BOOK IS MISSING" in line for line in said),
              "what is in it, and what is not, is said", said)
        the_pack_holds_no_solution(pack)
        texts_speak_of_the_pack(pack)
        smuggled_lines_are_found(pack)
        what_the_kit_has_in_common_is_told(pack)
        pack = os.path.join(places["packed"], "later")
        with mock.patch.dict(os.environ, QUICK="1"):
            said = handout.make_handout(SOURCE, [STEM, NEXT], folder=pack)
            check(os.listdir("drawn"), "the book's figures are kept for the next pack")
        check(any(line.startswith("the solution of normals is in this pack") for line in said),
              "what came before is solved, and that is said", said)
        what_is_left_open_is_no_solution(pack)
        the_book_is_handed_out(pack)
        the_starters_are_failed(pack)
        the_second_is_solved_first(pack)
        pictures_are_the_students(pack)
        the_live_loop_serves_the_pack(pack)
        the_live_loop_turns_at_once()
        the_students_code_is_in_the_book(pack)
        the_rest_holds(pack)
        a_class_is_graded(places["class"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
