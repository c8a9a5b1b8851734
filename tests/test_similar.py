#!/usr/bin/env python3
"""Similar units: copies in disguise are found, what was written apart or given to all is not, and nothing
that students hand in ends the comparison. Speaks TAP, for make check-similar."""

import contextlib
import csv
import io
import os
import random
import re
import sys
import tempfile
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import disguise  # noqa: E402
import made_up_class  # noqa: E402
import similar  # noqa: E402
from grading import fingerprints  # noqa: E402
from grading.assignments import read_features  # noqa: E402
from grading.starters import starter_of  # noqa: E402
from tap import check, finish, read, start, write  # noqa: E402

FEATURES = read_features(SOURCE)
# The gradient of `shading`, as three wrote it who knew nothing of each other.
HONEST = ("""
rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x)
{
    int low = -1, high = -1;
    for (int k = 0; k < (int)gradient->count; k++) {
        float at = gradient->stops[k].at;
        if (at <= x && (low < 0 || at >= gradient->stops[low].at))
            low = k;
        if (at > x && (high < 0 || at < gradient->stops[high].at))
            high = k;
    }
    if (low < 0 && high < 0)
        return rk_vec(0, 0, 0);
    if (low < 0)
        return gradient->stops[high].colour;
    if (high < 0)
        return gradient->stops[low].colour;
    double from = gradient->stops[low].at, t = (x - from) / (gradient->stops[high].at - from);
    return rk_mix(gradient->stops[low].colour, gradient->stops[high].colour, (float)t);
}
""", """
static void sort_stops(rk_gradient *g)
{
    for (uint32_t n = g->count; n > 1; n--)
        for (uint32_t j = 1; j < n; j++)
            if (g->stops[j - 1].at > g->stops[j].at) {
                rk_gradient_stop t = g->stops[j];
                g->stops[j] = g->stops[j - 1];
                g->stops[j - 1] = t;
            }
}

rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x)
{
    rk_gradient mine = *gradient;
    sort_stops(&mine);
    if (mine.count == 0)
        return rk_vec(0, 0, 0);
    if (x < mine.stops[0].at)
        return mine.stops[0].colour;
    uint32_t last = 0;
    while (last + 1 < mine.count && mine.stops[last + 1].at <= x)
        last++;
    if (last + 1 == mine.count)
        return mine.stops[last].colour;
    double width = (double)mine.stops[last + 1].at - (double)mine.stops[last].at;
    double part = (double)x - (double)mine.stops[last].at;
    return rk_mix(mine.stops[last].colour, mine.stops[last + 1].colour, (float)(part / width));
}
""", """
rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x)
{
    float below = -INFINITY, above = INFINITY;
    rk_vec3 first = rk_vec(0, 0, 0), second = first;
    const rk_gradient_stop *s = gradient->stops, *end = s + gradient->count;
    do {
        if (s == end)
            break;
        if (s->at > x ? s->at < above : s->at >= below)
            *(s->at > x ? &above : &below) = s->at, *(s->at > x ? &second : &first) = s->colour;
    } while (++s);
    if (isinf(below))
        return second;
    return isinf(above) ? first : rk_mix(first, second, (x - below) / (above - below));
}
""")


def compared(folder, stem, submissions, last_year=None):
    """Returns the rows of similar.csv for these units, {name: text}, and what was said."""
    with tempfile.TemporaryDirectory(dir=folder) as here:
        for name, text in submissions.items():
            write(text, here, "class", name, f"{stem}.c")
        for name, text in (last_year or {}).items():
            write(text, here, "before", name, f"{stem}.c")
        return run_in(here, stem, bool(last_year))


def run_in(here, stem, has_last_year=False, is_asked=True):
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        similar.similar(SOURCE, [stem] if is_asked else [], os.path.join(here, "class"),
                        os.path.join(here, "out"), os.path.join(here, "before") if has_last_year else "")
    return list(csv.DictReader(io.StringIO(read(here, "out", "similar.csv")))), said.getvalue()


def reference_of(stem):
    return read(FEATURES[stem].reference)


def shading_by(gradient):
    """A unit with nothing of its own but the gradient."""
    return starter_of(FEATURES["shading"].reference).split("rk_vec3 rk_gradient_at")[0] + gradient


def copies_are_found(folder):
    for way in (*[(way,) for way in disguise.ALL], tuple(disguise.ALL)):
        name = way[0].__name__ if len(way) == 1 else "all of these together"
        shares = {}
        for seed, stem in enumerate(FEATURES if len(way) > 1 else ["bloom", "bvh_median"]):
            rows, _ = compared(folder, stem, {"ann": disguise.copy_of(reference_of(stem), seed, way)})
            shares[stem] = max([float(row["share of the smaller one's own code"]) for row in rows
                                if row["other"] == "the reference"], default=0)
        shares.pop("normals", None)
        check(min(shares.values()) >= 0.85, f"a copy of the reference is found: {name}", shares)
    mine = shading_by(HONEST[1])
    rows, _ = compared(folder, "shading", {"ann": mine, "ben": disguise.copy_of(mine, 7)})
    check([(row["submission"], row["other"]) for row in rows] == [("ben", "ann")],
          "a copy of another student's is found, and no more", rows)
    rows, _ = compared(folder, "shading", {"ben": disguise.copy_of(mine, 7)}, {"=ann": mine})
    check([row["other"] for row in rows] == ["last year: =ann"], "a copy of last year's is found", rows)


def a_single_function_is_found(folder):
    stem = "bloom"
    begin, end = "rk_bloom_span rk_bloom_bright_span", "/* --- The filter's weights"
    text = reference_of(stem)
    part = text[text.index(begin):text.index(end)]
    rows, _ = compared(folder, stem, {"ann": '#include "features/bloom.h"\n' + part + HONEST[0] + HONEST[1]})
    check([row["other"] for row in rows] == ["the reference"], "a function that was copied is found", rows)
    first, last = map(int, rows[0]["its lines in the other"].removeprefix("lines ").split("-"))
    lines = text.split("\n")[first - 1:last]
    check(first > text[:text.index("rk_bloom_bright_pass(")].count("\n") and "memset(masked, 0, total" in
          "\n".join(lines), "the passage's lines are named", lines)


def honest_work_is_not(folder):
    for stem in FEATURES:
        starter = starter_of(FEATURES[stem].reference)
        rows, _ = compared(folder, stem, {"ann": starter, "ben": disguise.copy_of(starter, 3)})
        check(not rows, f"what all were given counts for nobody: {stem}", rows)
    rows, _ = compared(folder, "shading", {f"s{number}": shading_by(text)
                                           for number, text in enumerate(HONEST)})
    check(not rows, "three who wrote the same function apart are no pairs", rows)
    short = reference_of("normals")
    rows, _ = compared(folder, "normals", {"ann": short, "ben": short})
    check(not rows, "a unit that is too short to tell is none", rows)
    idiom = HONEST[1].split("rk_vec3 rk_gradient_at")[0] * 3
    sums = [" + ".join(f"{number}{k} * a" for k in range(40)) for number in range(12)]
    units = {f"s{number}": shading_by(f"{idiom}\nint f(int a) {{ return {text}; }}")
             for number, text in enumerate(sums)}
    rows, _ = compared(folder, "shading", units)
    check([row["other"] for row in rows] == ["one another"],
          "what more than half of a class has counts for nobody", rows[:3])


def class_with(folder, count):
    """A made-up class, of which so many also handed in the same code, and two of these the same beside it.
    Returns the rows, what was said, and the names of those that have it."""
    with tempfile.TemporaryDirectory(dir=folder) as here:
        works = {member.id: member.work.text for member in made_up_class.make(SOURCE, here, 100)
                 if member.work.text is not None}
        having = random.Random(2).sample(sorted(works), count)
        for name, text in works.items():
            lines = HONEST[1] if name in having else ""
            lines += HONEST[0].replace("rk_gradient_at", "mine") if name in having[:2] else ""
            os.makedirs(os.path.join(here, "class", name))
            with open(os.path.join(here, "class", name, "normals.c"), "wb") as file:
                file.write(text + lines.encode())
        return *run_in(here, "normals"), having


def code_that_many_share_is_told_once(folder):
    alone, _, _ = class_with(folder, 0)
    for count in (6, 40):
        rows, said, having = class_with(folder, count)
        listed = [{row["submission"], row["other"]} for row in rows]
        check(len(rows) < len(alone) + count and all(any(name in pair for pair in listed) for name in having),
              f"{count} that share code are each listed with one other", f"{len(rows)} rows")
        told = "submissions share code, each with at least one other"
        check(said.count(told) == 1 and f"similar: normals: {count}" in said
              or count == 40 and re.search(rf"normals: 4\d {told}", said), "one line says so", said)
        check(set(having[:2]) in listed, "two that share more are a pair all the same", listed)
    rows, said, having = class_with(folder, 60)
    ring = [row for row in rows if row["other"] == "one another"]
    check(len(ring) == 1 and len(rows) <= len(alone) + 4 and ring[0]["submission"].startswith("60 of 93")
          and said.count("60 of 93 submissions, such as") == 1 and "counts for nobody" in said,
          "what more than half of a class shares is told in one line and one row", f"{said}{ring}")
    first, last = map(int, ring[0]["lines of the longest passage"].removeprefix("lines ").split("-"))
    check(last - first > 20, "with its lines", ring)


def nothing_ends_it(folder):
    stem = "bloom"
    odd = {"broken": "void f( { [ for(for(for( ) ] }} struct { \"", "empty": "", "binary": "",
           "loops": "for(" * 20000, "endless": "for(;;)" * 20000, "structs": "struct{" * 20000,
           "right": reference_of(stem)}
    with tempfile.TemporaryDirectory(dir=folder) as here:
        for name, text in odd.items():
            write(text, here, "class", name, f"{stem}.c")
        with open(os.path.join(here, "class", "binary", f"{stem}.c"), "wb") as file:
            file.write(bytes(range(256)) * 300)
        write("int a;\n" * 100000, here, "class", "huge", f"{stem}.c")
        write("", here, "class", "missing", "notes.txt")
        os.mkdir(os.path.join(here, "class", "folder"))
        os.makedirs(os.path.join(here, "class", "place", f"{stem}.c"))
        os.symlink(os.path.join(here, "class", "right"), os.path.join(here, "class", "linked"))
        write("", here, "class", "packed.zip")
        write(odd["right"], here, "class", "secret", f"{stem}.c")
        real = os.access
        with mock.patch.object(os, "access",
                               lambda path, mode: "secret" not in str(path) and real(path, mode)):
            rows, said = run_in(here, stem)
        for name, why in (("huge", "more than 200 kB"), ("missing", "there is no bloom.c"),
                          ("folder", "there is no bloom.c"), ("place", "not a plain file"),
                          ("linked", "it is a link"), ("packed.zip", "archive"),
                          ("secret", "cannot be read")):
            check(any(f"{name} was not compared" in line and why in line for line in said.splitlines()),
                  f"what cannot be compared is told: {name}", said)
        check([row["submission"] for row in rows] == ["right"], "the others are compared", rows)
        rows, said_by_itself = run_in(here, stem, is_asked=False)
        left_out = [other for other in FEATURES if other != stem]
        said = f"no units to compare of {', '.join(left_out)};"
        check("right" in [row["submission"] for row in rows] and said in said_by_itself
              and "shading was not" not in said_by_itself,
              "assignments of which nobody has a unit are told in one line", said_by_itself)
        check("never an accusation" in said_by_itself, "what a share means is said", said_by_itself)


def a_class_is_quick():
    """500 texts of which each has some of the others': an index finds the few that are alike."""
    rng, texts = random.Random(1), {}
    words = "a.b f(c) g(d) x[1] + - * / % < > & | ^ ? : 2 3 4 5".split()
    idioms = [rng.choices(words, k=20) for _ in range(60)]
    for number in range(500):
        code = [word for _ in range(6) for word in rng.choices(words, k=50) + rng.choice(idioms)]
        texts[f"s{number}"] = fingerprints.Text(" ".join(code))
    texts["copy"] = texts["s42"]
    done = similar.Comparison("bloom")
    done.compare(texts, None, set())
    check(done.compared < 5000, "of 125,000 pairs few are laid side by side", str(done.compared))
    check(("copy", "s42") in [(pair.one, pair.other) for pair in done.pairs], "a copy among 500 is found")


def main():
    with tempfile.TemporaryDirectory() as folder:
        copies_are_found(folder)
        a_single_function_is_found(folder)
        honest_work_is_not(folder)
        code_that_many_share_is_told_once(folder)
        nothing_ends_it(folder)
    a_class_is_quick()
    return finish()


if __name__ == "__main__":
    start(main)
