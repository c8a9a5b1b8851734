#!/usr/bin/env python3
"""The page of what a class has learned: each number on it is counted a second time, from made-up verdicts of
60 students, some with hostile names. Speaks TAP, for make check-class-page."""

import base64
import collections
import contextlib
import html.parser
import io
import json
import os
import random
import re
import sys
import tempfile
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import class_page  # noqa: E402
from grading.assignments import ToolError, read_features, read_points  # noqa: E402
from grading.results import name_of  # noqa: E402
from tap import check, finish, read, start, write  # noqa: E402

FEATURES = read_features(SOURCE)
STEMS = ["bloom", "shading"]
HOSTILE = ["<script>alert(1)</script>", '" onload="x', "a&amp;b", "=HYPERLINK(1)", "</table><h1>", "\x1b[31m",
           "\u202egnp.exe", "zero\u200bwidth", "'", "<!--"]
NAMES = [f"s{number:02}" for number in range(50)] + list(map(name_of, HOSTILE))
PNG = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8A"
                       "AQUBAScY42YAAAAASUVORK5CYII=")


class Page(html.parser.HTMLParser):
    """The tables by caption, as lists of rows of cells; the items and paragraphs; what stands open at the
    end."""

    VOID = {"meta", "link", "img", "rect", "line", "wbr"}

    def __init__(self, text):
        super().__init__()
        self.tables, self.said, self.open, self.tags, self.images = {}, [], [], [], []
        self._text = ""
        self.is_well_formed = True
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in self.VOID and not self.get_starttag_text().endswith("/>"):
            self.open.append(tag)
        if tag in ("caption", "th", "td", "li", "p"):
            self._text = ""
        if tag == "tr":
            self._row = []

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        self.is_well_formed &= bool(self.open) and self.open.pop() == tag
        if tag == "caption":
            self._rows = self.tables.setdefault(self._text, [])
        elif tag in ("th", "td"):
            self._row.append(self._text)
        elif tag == "tr":
            self._rows.append(self._row)
        elif tag in ("li", "p"):
            self.said.append(self._text)

    def handle_data(self, data):
        self._text += data


def verdict_of(rng, stem, name, when, level=None):
    """A made-up verdict: all claims hold up to a place that is drawn, some later ones by chance."""
    tests = read_points(FEATURES[stem])
    problem = "it does not compile: <b>x.c:1</b>" if rng.random() < 0.1 else ""
    is_starter = not problem and rng.random() < 0.15
    level = rng.choice([0, 3, 3, 3, 5, 8, 12, len(tests)]) if level is None else level
    claims = []
    for number, test in enumerate(tests):
        passed = not test.step if is_starter else not problem and (number < level or rng.random() < 0.2)
        claims.append({"name": test.name, "step": test.step, "points": test.points, "passed": passed,
                       "score": test.points if passed else 0, "place": "x.c:1",
                       "reason": "" if passed else f"got <{rng.randrange(3)}>, want 5\nmore"})
    return {"submission": name, "assignment": stem, "key": f"{rng.random()}", "graded": when, "seconds": 1.0,
            "points": sum(claim["score"] for claim in claims), "maximum": 100, "problem": problem,
            "not_graded": "", "is_starter": is_starter, "claims": claims}


def put(folder, verdicts):
    for number, verdict in enumerate(verdicts):
        write(json.dumps(verdict), folder, "verdicts", verdict["assignment"], f"{number}.json")


def page_of(folder, build="/nowhere"):
    with contextlib.redirect_stdout(io.StringIO()):
        class_page.write_page(SOURCE, build, [], folder)
    return Page(read(folder, "class.html"))


# --- The second count: from the verdicts, in other ways ------------------------------------------


def begun_of(verdicts):
    return [v for v in verdicts if not v["problem"] and not v["is_starter"]
            and [c for c in v["claims"] if c["step"] > 0 and c["passed"]]]


def first_failed(verdict):
    names = [c["name"] for c in verdict["claims"] if not c["passed"]]
    return names[0] if names else None


def quartiles_of(points):
    """Linear between ranks."""
    points, found = sorted(points), []
    for part in (0.25, 0.5, 0.75):
        rank = part * (len(points) - 1)
        low = int(rank)
        high = min(low + 1, len(points) - 1)
        found.append(points[low] + (rank - low) * (points[high] - points[low]))
    return "{:g}, {:g} and {:g}".format(*found)


def numbers_are_right(page, verdicts):
    for stem in STEMS:
        of_stem = [v for v in verdicts if v["assignment"] == stem]
        begun = begun_of(of_stem)
        stuck = collections.Counter(filter(None, map(first_failed, begun)))
        said = f"{len(begun)} of {len(of_stem)} have begun; {len(begun) - sum(stuck.values())} of these"
        check(any(text.startswith(said) for text in page.said), f"{stem}: how many have begun", page.said)
        rows = page.tables[f"Where those who have begun {stem} are stuck"][1:]
        check({row[0]: int(row[1]) for row in rows} == stuck, f"{stem}: where they are stuck", str(rows))
        check([int(row[1]) for row in rows] == sorted(stuck.values(), reverse=True), f"{stem}: most first")
        for name, _, reason, section, _ in rows:
            test = next(test for test in read_points(FEATURES[stem]) if test.name == name)
            got = [c["reason"].split("\n")[0] for v in begun if first_failed(v) == name
                   for c in v["claims"] if c["name"] == name]
            text, times = re.fullmatch(r"(.*) \((\d+) of \d+\)", reason).groups()
            if not (got.count(text) == int(times) == max(map(got.count, got)) and test.section in section):
                check(False, f"{stem}: {name}: reason and section", f"{reason} {section}")
        check(True, f"{stem}: reasons are the most frequent, sections the claims'")
        early = {test.name for test in read_points(FEATURES[stem]) if test.green_since}
        wanted = []
        for step in sorted({c["step"] for c in of_stem[0]["claims"]} - {0}):
            of_step = [[c for c in v["claims"] if c["step"] == step] for v in begun]
            wanted.append([f"step {step}",
                           str(len([1 for cs in of_step if [c for c in cs if c["passed"]
                                                            and c["name"] not in early]])),
                           str(len([1 for cs in of_step if not [c for c in cs if not c["passed"]]])),
                           str(len([1 for v in begun for c in v["claims"]
                                    if c["name"] == first_failed(v) and c["step"] == step]))])
        check(page.tables[f"Steps of {stem}"][1:] == wanted, f"{stem}: steps", str(page.tables))
        points = [v["points"] for v in of_stem]
        check(any(f"Quartiles of the points: {quartiles_of(points)};" in text for text in page.said),
              f"{stem}: median and quartiles", quartiles_of(points))
        chart = next(attrs["aria-label"] for tag, attrs in page.tags if tag == "svg" and
                     attrs["aria-label"].startswith(stem))
        bars = [len([p for p in points if low <= p <= low + 9]) for low in range(0, 100, 10)]
        check(list(map(int, re.findall(r"%: (\d+)", chart))) == [*bars, points.count(100)],
              f"{stem}: the chart's bars", chart)
    counts = [(n, v["assignment"], c) for v in verdicts for c in [first_failed(v)] if v in begun_of([v]) and c
              for n in [sum(w["assignment"] == v["assignment"] and first_failed(w) == c
                            for w in begun_of(verdicts))]]
    most = sorted(set(counts), key=lambda row: -row[0])[:3]
    items = [text for text in page.said if "stuck at" in text]
    check([int(text.split()[0]) for text in items] == [row[0] for row in most] and len(items) == 3,
          "what to teach on Monday: the three claims at which most are stuck", items)
    wanted = [(stem, claim.replace("_", " "), f"of the {len(begun)} who") for _, stem, claim in set(counts)
              for begun in [begun_of([v for v in verdicts if v["assignment"] == stem])]]
    check(all(any(all(part in text for part in parts) for parts in wanted) for text in items),
          "each with its assignment, its claim, and of how many", items)


def words_of(verdicts, not_graded, stuck_before):
    """Whom to talk to, counted again."""
    rows = [(name, "bloom", "was not graded") for name in not_graded]
    for v in verdicts:
        has_begun = bool(begun_of([v]))
        why = ("nothing ran" if v["problem"] else "has not begun" if not has_begun else
               "stuck at the same claim for two runs" if first_failed(v) and first_failed(v) ==
               stuck_before.get((v["assignment"], v["submission"])) else None)
        rows += [(v["submission"], v["assignment"], why)] if why else []
    return sorted(rows)


def a_class_of_60(folder):
    rng, results = random.Random(7), os.path.join(folder, "results")
    first = [verdict_of(rng, stem, name, "2026-11-21 20:00:00 +0000") for stem in STEMS for name in NAMES]
    put(results, first)
    not_graded = {"<i>zip</i>"}
    unpacked = {**verdict_of(random.Random(1), "bloom", "<i>zip</i>", "2026-11-21 20:00:00 +0000"),
                "not_graded": "unpack <it>"}
    write(json.dumps(unpacked), results, "verdicts", "bloom", "zip.json")
    page = page_of(results)
    check(page.is_well_formed and page.open == [], "the page's tags are balanced", str(page.open))
    numbers_are_right(page, first)
    table = page.tables["Whom to talk to"][1:]
    check(sorted(tuple(row[:3]) for row in table) == words_of(first, not_graded, {}),
          "whom to talk to", table)
    check(sum("no earlier run" in text for text in page.said) == len(STEMS),
          "the first run has no earlier one")
    tags = {tag for tag, _ in page.tags}
    handlers = [name for _, attrs in page.tags for name in attrs if name.startswith("on")]
    check(not tags & {"script", "b", "i", "iframe"} and not handlers, "what students wrote is only text",
          sorted(tags))
    check(not re.search(r"[\x00-\x08\x1b\u202e\u200b]", read(results, "class.html")),
          "characters that turn or hide text are not on the page")
    check(not re.search(r"""(src|href)=["']?(https?:|//)""", read(results, "class.html")),
          "the page needs no network")
    scopes = [attrs.get("scope") for tag, attrs in page.tags if tag == "th"]
    check(scopes and set(scopes) == {"row", "col"}, "headings of tables have a scope")

    again = page_of(results)
    check(again.said == page.said and again.tables == page.tables, "the same results give the same page")
    stuck = {(v["assignment"], v["submission"]): first_failed(v) for v in begun_of(first)}
    second = [verdict_of(rng, v["assignment"], v["submission"], "2026-11-28 20:00:00 +0000") for v in first]
    put(results, second)
    page = page_of(results)
    numbers_are_right(page, second)
    table = page.tables["Whom to talk to"][1:]
    check(sorted(tuple(row[:3]) for row in table) == words_of(second, not_graded, stuck) and
          any("two runs" in row[2] for row in table), "who is stuck at the same claim for two runs", table)
    third = verdict_of(rng, "bloom", NAMES[0], "2026-11-29 20:00:00 +0000", 0)
    put(results, [third])
    mine = ["s00", "bloom"]
    rows = [[row for row in rows if row[:2] != mine]
            for rows in (table, page_of(results).tables["Whom to talk to"][1:])]
    check(rows[0] == rows[1], "one that is graded again changes nothing for the others", str(rows))
    before = page_of(results)
    put(results, [{**third, "graded": "2026-11-30 20:00:00 +0000"}])
    after = page_of(results)
    check(after.tables == before.tables and after.said != before.said
          and [text for text in after.said if not text.startswith("Graded")] ==
          [text for text in before.said if not text.startswith("Graded")],
          "the same work, graded again, is no other run", [*before.said, *after.said])
    for stem in STEMS:
        pairs = [(a["points"], b["points"]) for a, b in zip(first, second) if a["assignment"] == stem]
        said = (f"{len([1 for a, b in pairs if b > a])} gained points, {len([1 for a, b in pairs if b < a])} "
                f"lost points, {len([1 for a, b in pairs if a == b])} have as many; 0 have no previous run")
        check(any(said in text for text in page.said), f"{stem}: what changed since the last run", said)


def pictures_are_embedded(folder):
    rng, results, build = random.Random(1), os.path.join(folder, "one"), os.path.join(folder, "build")
    tests = [test.name for test in read_points(FEATURES["bloom"])]
    drawn = {row.mutant.fails[0]: row.mutant.name for row in class_page.read_wrong(SOURCE, FEATURES["bloom"])}
    claim = next(name for name in tests if name in drawn and tests.index(name) > 0)
    with mock.patch.object(rng, "random", lambda: 0.9):
        put(results, [verdict_of(rng, "bloom", "ann", "2026", tests.index(claim))])
    row = page_of(results, build).tables["Where those who have begun bloom are stuck"][1]
    check(row[0] == claim and "make book" in row[4], "without the book's pictures a sentence stands there",
          row)
    figures = os.path.join(build, "docs", "out", "figures")
    os.makedirs(figures)
    for name in drawn.values():
        with open(os.path.join(figures, f"wrong_bloom_{name}.png"), "wb") as file:
            file.write(PNG)
    page = page_of(results, build)
    embedded = "data:image/png;base64," + base64.b64encode(PNG).decode()
    check([image["src"] for image in page.images] == [embedded] and page.images[0]["alt"],
          "the picture of the claim's mistake is in the page", page.images)
    for name in drawn.values():
        write("<script>", figures, f"wrong_bloom_{name}.png")
    check(not page_of(results, build).images, "what is no picture is not")


def damage_is_told(folder):
    results = os.path.join(folder, "damaged")
    for where in ("", results):
        try:
            page_of(where)
            check(False, "without verdicts there is no page")
        except ToolError as error:
            check("RESULTS" in str(error), "without verdicts there is no page", error)
    good = verdict_of(random.Random(3), "bloom", "ann", "2026", 3)
    put(results, [good])
    for name, text in (("half", '{"submission": "be'), ("list", "[]"), ("deep", "[" * 100000),
                       ("other", json.dumps({**good, "claims": [{"name": 3}]})), ("bytes", "\ud800")):
        with open(os.path.join(results, "verdicts", "bloom", f"{name}<.json"), "wb") as file:
            file.write(text.encode("utf-8", "surrogatepass"))
    write('{"bloom": {"ann": 3}, "a": []}', results, "class_page.json")
    page = page_of(results)
    check(any(all(f"{name}<.json" in text for name in ("half", "list", "deep", "other", "bytes"))
              for text in page.said), "files that are no verdicts are named", page.said)
    check(any("of 1 have begun" in text for text in page.said), "the others are counted", page.said)


def main():
    with tempfile.TemporaryDirectory() as folder:
        a_class_of_60(folder)
        pictures_are_embedded(folder)
        damage_is_told(folder)
    return finish()


if __name__ == "__main__":
    start(main)
