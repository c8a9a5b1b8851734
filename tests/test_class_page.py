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

    VOID = {"meta", "link", "img", "rect", "line", "wbr", "br"}

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
        if tag == "br":
            self._text += "\n"
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


def page_of(folder, build="/nowhere", roster="", out=""):
    with contextlib.redirect_stdout(io.StringIO()):
        class_page.write_page(SOURCE, build, [], folder, roster, out)
    return Page(read(out or folder, "class.html"))


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
            told = [re.fullmatch(r"(.*) \((\d+) of \d+\)", line).groups() for line in reason.split("\n")]
            wanted = sorted(map(got.count, set(got)), reverse=True)
            if not ([got.count(text) for text, _ in told] == [int(times) for _, times in told] == wanted
                    and test.section in section):
                check(False, f"{stem}: {name}: reasons and section", f"{reason} {section}")
        check(True, f"{stem}: reasons with how many have each, most first, sections the claims'")
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


def stuck_at(claim, reason, name, level=5):
    """A verdict on a unit that fails this claim first, for this reason."""
    verdict = verdict_of(random.Random(1), "bloom", name, "2026-11-21 20:00:00 +0000", 0)
    names = [test["name"] for test in verdict["claims"]]
    for number, test in enumerate(verdict["claims"]):
        test["passed"] = number < names.index(claim)
        test["reason"] = "" if test["passed"] else reason
    return {**verdict, "problem": "", "is_starter": False}


def reasons_are_not_merged(folder):
    """Who is stuck at one claim need not have made the same mistake."""
    results = os.path.join(folder, "reasons")
    rows = class_page.read_wrong(SOURCE, FEATURES["bloom"])
    tests = [test.name for test in read_points(FEATURES["bloom"])]
    claim = next(row.mutant.fails[0] for row in rows if tests.index(row.mutant.fails[0]) > 0)
    mistake = "; you get this, for example, if the row is divided by "
    reasons = [f"got 1, want 2{mistake}2^r", f"got 3, want 2{mistake}8^r", f"got 4, want 9: of another row"
               f"{mistake}8^r", f"got 3, want 2{mistake}8^r\nyour code printed: hello"]
    put(results, [stuck_at(claim, reason, f"s{number}") for number, reason in enumerate(reasons)])
    row = page_of(results).tables["Where those who have begun bloom are stuck"][1]
    told = row[2].split("\n")
    check(row[1] == "4" and len(told) == 2 and "8^r (3 of 4)" in told[0] and "2^r (1 of 4)" in told[1],
          "who is stuck at one claim by another mistake is told apart, whatever the numbers", row)
    check("Perhaps" not in row[4] and "each reason says it" in row[4],
          "where the reasons say the mistake, no other is supposed", row)
    put(results, [stuck_at(claim, reason, f"s{number}")
                  for number, reason in enumerate([*reasons[:2], "got 7, want 2", "got 8, want 2"])])
    row = page_of(results).tables["Where those who have begun bloom are stuck"][1]
    check(row[2].count("(1 of 4)") == 4 and "Perhaps" in row[4] and "2 of 4" in row[4],
          "where some do not, a known one is supposed of these", row)
    loops = [stuck_at(claim, f"did not end within {number} s in one call: an endless loop?", f"s{number}")
             for number in range(2, 6)]
    put(results, loops + [stuck_at(claim, f"got {number}", f"t{number}") for number in range(9)])
    row = page_of(results).tables["Where those who have begun bloom are stuck"][1]
    told = row[2].split("\n")
    check("(4 of 13)" in told[0] and told[-1] == "4 other reasons (4 of 13)" and len(told) == 7,
          "loops are one reason, whatever their limit, and of many reasons the first are shown", row)


COLLECTED = """submission,id,name,email,group,submitted,days_late,remarks,assignments
s1,s1,Ann <Mason>,a@b,,,,,bloom
s2,s2,Kim Lou,k@b,A,,,,bloom
s2,s3,Tom Jarvis,t@b,A,,,,bloom
,s4,Zoë Berg,z@b,,,,missing,bloom
,s5,Eve Fox,e@b,,,,not collected: w.7z: 7z archives are not unpacked here,bloom
s6,s6,Not Judged,n@b,,,,,bloom
"""


def a_roster_names_who_is_missing(folder):
    results, roster = os.path.join(folder, "roster"), os.path.join(folder, "collected.csv")
    write(COLLECTED, roster)
    tests = [test.name for test in read_points(FEATURES["bloom"])]
    put(results, [stuck_at(tests[9], "got 1", name) for name in ("s1", "s2", "stranger")])
    plain = page_of(results)
    check("roster" not in str(plain.said) and "s4" not in str(plain.tables),
          "without a roster nobody is missing", plain.said)
    page = page_of(results, roster=roster)
    check(any(text.startswith("Of 6 students on the roster, 1 handed in nothing, and the work of 1 was not "
                              "collected.") for text in page.said),
          "with one it is counted who is missing, and whose work was not collected", page.said)
    check(any(text == "Not on the roster: stranger." for text in page.said), "strangers are named", page.said)
    rows = page.tables["Whom to talk to"]
    check(rows[0][0] == "student" and rows[1:] == [
        ["Eve Fox (s5)", "bloom", "handed in what was not collected",
         "w.7z: 7z archives are not unpacked here"],
        ["Not Judged (s6)", "bloom", "was not graded", "there is no verdict in the results"],
        ["Zoë Berg (s4)", "bloom", "handed in nothing", ""]], "and all of these are among those to talk to",
        [str(row) for row in rows])
    again = [stuck_at(tests[9], "got 2", "s1"), {**stuck_at(tests[9], "got 2", "s2"), "problem": "x"}]
    put(results, [{**verdict, "key": "new"} for verdict in again])
    words = page_of(results, roster=roster).tables["Whom to talk to"]
    check([row[0] for row in words[1:]] == [
        "Eve Fox (s5)", "Not Judged (s6)", "Kim Lou (s2), Tom Jarvis (s3)", "Ann <Mason> (s1)",
        "Zoë Berg (s4)"],
          "the others have their names there, a group all of its members'", [str(row) for row in words])
    for text, said in ((COLLECTED.replace("bloom", "shading"), "is of shading"),
                       ("id,name\n1,A\n", "make collect")):
        write(text, roster)
        try:
            page_of(results, roster=roster)
            check(False, f"a roster is refused: {said}")
        except ToolError as error:
            check(said in str(error) and "ROSTER" in str(error), f"a roster is refused: {said}", error)


def several_results_are_one_page(folder):
    week, other, out = (os.path.join(folder, name) for name in ("of bloom", "shading", "both"))
    put(week, [verdict_of(random.Random(seed), "bloom", f"s{seed}", "2026-11-21 20:00:00 +0000")
               for seed in range(9)])
    put(other, [verdict_of(random.Random(seed), "shading", f"s{seed}", "2026-11-22 20:00:00 +0000")
                for seed in range(7)])
    os.mkdir(out)
    page = page_of(week)
    check("Steps of bloom" in page.tables, "a folder's name may have spaces")
    os.rename(week, os.path.join(folder, "bloom"))
    page = page_of(f"{folder}/bloom {other}", out=out)
    check({"Steps of bloom", "Steps of shading"} <= set(page.tables) and len(page.tables) > 4
          and os.path.exists(os.path.join(out, "class_page.json")),
          "several folders of results are one page, in OUT", list(page.tables))
    for name, stem in (("b.csv", "bloom"), ("s.csv", "shading")):
        write(COLLECTED.replace(",bloom\n", f",{stem}\n").replace("s4,Zoë", f"{stem[0]}4,Zoë"), folder, name)
    page = page_of(f"{folder}/bloom {other}", out=out, roster=f"{folder}/b.csv {folder}/s.csv")
    missing = [row[:2] for row in page.tables["Whom to talk to"] if row[2] == "handed in nothing"]
    check(missing == [["Zoë Berg (b4)", "bloom"], ["Zoë Berg (s4)", "shading"]],
          "each with its own roster", missing)
    page = page_of(f"{folder}/bloom {other}", out=out, roster=f"{folder}/b.csv")
    check(any("no roster of shading was given" in text for text in page.said),
          "or told that it has none", page.said)
    newer = verdict_of(random.Random(1), "bloom", "s1", "2026-11-23 01:00:00 +0500", 0)
    put(other, [{**newer, "problem": "new"}])
    page = page_of(f"{folder}/bloom {other}", out=out)
    check(["s1", "bloom", "nothing ran", "new"] in page.tables["Whom to talk to"]
          and any("of 9 have begun" in text for text in page.said),
          "of two verdicts on one submission the newer one counts", page.said)
    for folders, roster, said in ((f"{folder}/bloom {folder}/nowhere", "", "nowhere/verdicts"),
                                  (f"{folder}/bloom {other}", f"{folder}/b.csv {folder}/b.csv",
                                   "are both of bloom")):
        try:
            page_of(folders, out=out, roster=roster)
            check(False, f"it is told: {said}")
        except ToolError as error:
            check(said in str(error), f"it is told: {said}", error)


def a_class_that_was_not_graded_has_a_page(folder):
    results = os.path.join(folder, "ungraded")
    put(results, [{**verdict_of(random.Random(1), "bloom", "s1", "2026-11-21 20:00:00 +0000"),
                   "not_graded": "unpack w.zip"}])
    page = page_of(results)
    check(["s1", "bloom", "was not graded", "unpack w.zip"] in page.tables["Whom to talk to"]
          and "Nobody's work was graded." in page.said,
          "a class without a graded work has a page, too", page.said)


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
        reasons_are_not_merged(folder)
        a_roster_names_who_is_missing(folder)
        several_results_are_one_page(folder)
        a_class_that_was_not_graded_has_a_page(folder)
        damage_is_told(folder)
    return finish()


if __name__ == "__main__":
    start(main)
