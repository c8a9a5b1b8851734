#!/usr/bin/env python3
"""The suites in a page: compiled and run as WebAssembly, by a clang that is WebAssembly itself, they pass
with the kit's units, and say of starters and of known mistakes what the native suites say under sanitizers.
Speaks TAP, for make check-site; runs in a build folder that has site/. RAYKIT_MUTANTS is how many mistakes
of each suite are made, "all" or a number (2 unless told, none with RAYKIT_QUICK); FEATURES names the
suites. Those that test_site_page.js types into a page are left in tests/site_mistakes.json, with what the
native suite says."""

import gzip
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(os.environ.get("srcdir", ".")).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "tools"))

import check_suites  # noqa: E402
import site_tasks  # noqa: E402
from grading.assignments import ToolError, read_features, read_points  # noqa: E402
from grading.mutants import mutate  # noqa: E402
from grading.processor_time import limited  # noqa: E402
from grading.starters import starter_of  # noqa: E402
from grading.verdict_store import Store  # noqa: E402
from page_links import dead_links, is_there  # noqa: E402
from tap import check, finish, start  # noqa: E402

IS_QUICK = bool(os.environ.get("RAYKIT_QUICK"))
NUMBER = "0" if IS_QUICK else "2"
TYPED = {stem: 3 if IS_QUICK else 10 for stem in ("normals", "bvh_median")}  # mistakes of a suite
_SECRET = b"0" * 64  # asks for no decoy


def checked(units, first=False, seconds=60):
    """Returns what tools/site/claims.mjs says of units, (stem, file), in their order."""
    command = [os.environ["RAYKIT_NODE"], SOURCE / "tools/site/claims.mjs", "--site", "site", "--json",
               "--seconds", str(seconds), *(["--first"] if first else []),
               *(f"{stem}={file}" for stem, file in units)]
    answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    results = [json.loads(line) for line in answer.stdout.splitlines()]
    if len(results) != len(units):
        sys.exit(f"tools/site/claims.mjs ended after {len(results)} of {len(units)} units; it says above why")
    return results


def attested(program, test):
    """Returns a native claim's verdict and message; of a crash, and of what sanitizers report, "fault"."""
    ours, theirs = socket.socketpair()
    ours.send(_SECRET)
    environment = dict(os.environ, **check_suites.SANITIZER_ENVIRONMENT, RAYKIT_ATTEST=str(theirs.fileno()))
    environment["ASAN_OPTIONS"] += ":detect_leaks=0"
    with ours, theirs:
        done = subprocess.run(limited([program, "--only", test], check_suites.SECONDS), env=environment,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              pass_fds=[theirs.fileno()], text=True, errors="replace", check=False)
        theirs.close()
        said = b"".join(iter(lambda: ours.recv(4096), b"")).decode(errors="replace")
    if done.returncode == 0:
        return "passed", ""
    place, _, message = said.partition("\n")
    is_told = done.returncode == 1 and place and message != "failed"
    return ("failed", message) if is_told else ("fault", done.stdout)


# What C does not define, as the first function of `normals`, with what is told of it.
_FAULTS = {
    "float *volatile p = malloc(12); p[0] = n.x; float y = p[3]; free(p); return rk_vec(y, 0, 0);":
        "reads 4 bytes beyond the end of a block of 12 bytes that malloc gave",
    "float *volatile p = malloc(12); p[-1] = n.x; free(p); return n;":
        "writes 4 bytes, 4 bytes before a block of 12 bytes that malloc gave",
    "float *volatile p = malloc(12); p[0] = n.x; free(p); return rk_vec(p[0], 0, 0);":
        "reads 4 bytes of a block of 12 bytes that is freed already",
    "float *volatile p = malloc(12); p[0] = n.x; free(p); free(p); return n;":
        "free is called for memory that is freed already, or that malloc did not return",
    "const float *volatile p = NULL; return rk_vec(*p, n.x, 0);":
        "reads 4 bytes by a pointer that is NULL, or almost",
    "float p[5] = {n.x}; float *volatile q = p; q[5] = 1; return rk_vec(p[2], 0, 0);":
        "writes 4 bytes just outside of a variable",
    "float p[3] = {n.x, n.y, n.z}; volatile int i = 3; return rk_vec(p[i], 0, 0);":
        "an index is outside of its array",
    "unsigned *volatile q = malloc(4); float p[3] = {n.x, n.y, n.z}; return rk_vec(p[q[0]], 0, 0);":
        "an index is outside of its array",
    "volatile int big = 0x7fffffff; return rk_vec((float)(big + 1), 0, 0);":
        "the sum of two integers is beyond their type's range",
    "volatile int none = 0; return rk_vec((float)(1 / none), 0, 0);":
        "an integer is divided by 0, or the quotient is beyond its type's range",
    "volatile float p[64]; p[0] = n.x; rk_vec3 m = rk_normals_colour(n); return rk_vec(p[0], m.y, 0);":
        "the stack is used up",
    "volatile float none = n.x; while (none < 9) ; return n;": "no verdict after 2 s",
    "exit(0); return n;": "ends the program, by exit or a function like it",
    "if (n.x < 9) exit(1); return n;": "ends the program, by exit or a function like it",
    "if (n.x < 9) abort(); return n;": "stops itself, by abort",
    "float *none = 0; *none = n.x; return n;": "such as a use of NULL",
    "assert(n.x > 9); return n;": "the assertion n.x > 9 does not hold",
    # What clang sees while it compiles.
    "float *p = malloc(12); if (!p) return n; p[0] = n.x; float y = p[5]; free(p); return rk_vec(y, 0, 0);":
        "reads 4 bytes, 8 bytes beyond the end of a block of 12 bytes that malloc gave",
    "rk_vec3 *p = malloc(8); if (!p) return n; volatile float y = p->z; free(p); return rk_vec(y, 0, 0);":
        "reads 4 bytes beyond the end of a block of 8 bytes that malloc gave",
    "int i = 0; float s = 0; while (i < 3) s += n.x; return rk_vec(s, 0, 0);":
        "no verdict after 2 s: a loop that never ends, or code that is very slow",
}


def check_mains(folder):
    """A main of the unit's own would run in place of the suite's."""
    reference = (SOURCE / "src/features/normals.c").read_text(encoding="utf-8")
    mains = ["int main(void)\n{\n    return 0;\n}\n",
             "int main(int argc, char **argv)\n{\n    return argc < 0 || !argv;\n}\n"]
    files = []
    for number, main in enumerate(mains):
        files.append(os.path.join(folder, f"main-{number}.c"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write(reference + main)
    line = reference.count("\n") + 1
    for main, result in zip(mains, checked([("normals", file) for file in files])):
        error = f"normals.c:{line}:1: error: your file defines main"
        check(error in result["said"] and not result["verdicts"],
              f"a page builds no unit with {main.splitlines()[0]}", result)


def check_faults(folder):
    reference = (SOURCE / "src/features/normals.c").read_text(encoding="utf-8")
    rest = reference[reference.index("rk_vec3 rk_normals_of_triangle"):]
    files = []
    for number, body in enumerate(_FAULTS):
        files.append(os.path.join(folder, f"fault-{number}.c"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write('#include "features/normals.h"\n#include <assert.h>\n#include <stdlib.h>\n'
                       f"rk_vec3 rk_normals_colour(rk_vec3 n)\n{{\n    {body}\n}}\n{rest}")
    results = checked([("normals", file) for file in files], first=True, seconds=2)
    for (body, said), result in zip(_FAULTS.items(), results):
        first = next(iter(result["verdicts"]), {})
        place = "" if "while" in body else "normals.c:6"
        check(said in first.get("message", "") and place == first.get("place"), f"a page tells: {said}",
              [body, result["said"], first])


def check_unset(folder):
    """What is given no value does not happen to have the right one."""
    units = {"bvh_median": ("rk_box box = rk_box_empty();", "rk_box box;"),
             "normals": ("return rk_vec(", "volatile float none; return rk_vec(none + ")}
    files = []
    for stem, change in units.items():
        text = (SOURCE / f"src/features/{stem}.c").read_text(encoding="utf-8")
        files.append((stem, os.path.join(folder, f"unset-{stem}.c")))
        pathlib.Path(files[-1][1]).write_text(text.replace(*change, 1), encoding="utf-8")
    told = [first_of(result) for result in checked(files, first=True)]
    wanted = ["up_to_four_triangles_are_one_leaf", "each_axis_has_a_colour_of_its_own"]
    check([claim for claim, *_ in told] == wanted, "a variable without a value has no right one in a page",
          told)


class Suite(check_suites.Feature):
    """A suite, native with sanitizers."""

    def prepare(self):
        self.common = self.compile_common("", check_suites.SANITIZE) + [self.counting]

    def first(self, unit, name, claims):
        """Returns the first claim that a unit does not pass, with its verdict and its message."""
        program = self.program(unit, name, name, ["-w", *check_suites.SANITIZE], check_suites.SANITIZE)
        for claim in claims:
            verdict, message = attested(program, claim)
            if verdict != "passed":
                return claim, verdict, message
        return "", "passed", ""


def first_of(result):
    """The same in the page."""
    for verdict in result["verdicts"]:
        if verdict["verdict"] != "passed":
            return verdict["claim"], verdict["verdict"], verdict["message"]
    return "", "passed" if result["verdicts"] else result["said"], ""


# Mistakes whose message has other numbers in a page, and why.
_OTHER_NUMBERS = {
    ("bloom", "weights_by_logarithms"): "log and exp are another C library's, and round otherwise",
    ("cubemap", "coordinates_in_float"): "so is atan, whose last bits count where areas are subtracted",
    ("cubemap", "columns_in_8_bits"): "C does not define what 8 bits get of 259.01: 3 by x86, 255 in a page",
    ("cubemap", "quads_in_8_bits"): "the same",
}
# Those that a page finds by another claim, or finds alone; arrays of suites have no margins in it.
_OTHER_CLAIM = {
    ("bvh_median", "sorts_by_insertion"): "in a page a claim before it has no verdict in its time, either",
    ("bvh_median", "first_key_as_the_pivot"): "so has the claim that measures the time",
    ("sampling", "sampler_marked_and_restored"): "constants can be written in a page",
    ("ambient_occlusion", "fourth_component_written"): "it writes beyond an array of the suite",
    ("glossy_reflection", "direction_written_as_four"): "so does this",
    ("watertight", "lanes_without_a_triangle_count"): "this reads beyond one",
    ("sah_binning", "triangles_read_again_for_two_bins_too"): "sanitizers blur the times that tell it",
}
# Those that a page does not find.
_RIGHT_IN_A_PAGE = {
    ("depth_of_field", "infinite_circles_are_converted"):
        "C does not define what an int gets of infinity: the least one by x86, in a page the greatest",
}


def measured_alike(message):
    """The bytes of stack that code took are the compiler's, times the machine's, and NaN has no sign."""
    return re.sub(r"took \d+", "took", re.sub(r"[\d.e-]+ (m?s)\b", r"\1", message)).replace("-nan", "nan")


def same(native, page, of):
    """Faults have other words: a page has no addresses. `of` is the suite and the mistake."""
    if of in _RIGHT_IN_A_PAGE:
        return page[1] == "passed"
    if of in _OTHER_CLAIM:
        return page[1] in ("failed", "fault")
    has_other_words = native[1] == "fault" or of in _OTHER_NUMBERS
    is_alike = has_other_words or measured_alike(native[2]) == measured_alike(page[2])
    return native[:2] == page[:2] and is_alike


def mistakes_of(suite, wanted):
    """Returns the mutants that are made, spread over all of them."""
    mutants = suite.read_mutants()
    count = len(mutants) if wanted == "all" else min(max(int(wanted), TYPED.get(suite.stem, 0)), len(mutants))
    return check_suites.spread(mutants, count) if count else []


def check_suite(suite, claims, wanted):
    """Returns what the native suite says of the mistakes."""
    units = {"starter": starter_of(suite.source)}
    for mutant in mistakes_of(suite, wanted):
        units[mutant.name] = mutate(mutant, suite.source.read_text(encoding="utf-8"), suite.source.name)
    files = {name: suite.builder.folder / f"{suite.stem}-{name}.c" for name in units}
    for name, text in units.items():
        files[name].write_text(text, encoding="utf-8")
    suite.prepare()
    differ, told, names = [], [], ("name", "text", "claim", "verdict", "message")
    for name, result in zip(files, checked([(suite.stem, file) for file in files.values()], first=True)):
        native, page = suite.first(files[name], name, claims), first_of(result)
        if name != "starter":
            told.append(dict(zip(names, (name, units[name], *native))))
        if not same(native, page, (suite.stem, name)):
            differ += [f"{name}: natively {native}", f"    in the page {page}"]
    check(not differ, f"{suite.stem}: the starter and {len(units) - 1} known mistakes fail the same claim "
          "first, with the same message", differ)
    return told


def _page_of_headings(names):
    """Returns a page with a heading of each name, and a paragraph below it."""
    return "".join(f'<h2 class="a"\nid="{name}">A <em>title</em></h2>\n<p>{name}</p>\n'
                   for name in names) + "</main>\n"


def chapters_lead_to_the_workbench(folder):
    """Of two pages with a chapter's headings, and then without the last of them."""
    book, wrong = os.path.join(folder, "book"), []
    os.mkdir(book)
    for feature in read_features(SOURCE).values():
        tests = [test for test in read_points(feature) if test.step]
        chapter = pathlib.Path(SOURCE, feature.chapter).read_text(encoding="utf-8")
        names = re.findall(r"^#+ .*\{#([\w-]+)", chapter, re.MULTILINE)
        parts = {feature.page_name(): names[:2], "more.html": names[2:]}
        places = {name: page for page, part in parts.items() for name in part}
        for page, part in parts.items():
            pathlib.Path(book, page).write_text(_page_of_headings(part), encoding="utf-8")
        site_tasks.lead_to_workbench(book, feature, places)
        texts = {page: pathlib.Path(book, page).read_text(encoding="utf-8") for page in parts}
        below = {name: texts[page].split(f'id="{name}"')[1].split(f"<p>{name}</p>")[0]
                 for name, page in places.items()}
        linked = {(f"#{name}", int(step)) for name, part in below.items()
                  for step in re.findall(rf'href="\.\./workbench\.html\?{feature.stem}#step-(\d+)"', part)}
        if (linked != {(test.section, test.step) for test in tests}
                or not all("folded.js" in text for text in texts.values())
                or f'?{feature.stem}">Try it' not in below[names[0]]):
            wrong.append(f"{feature.stem}: {linked}")
        last = tests[-1].section[1:]
        for gone in ({name: page for name, page in places.items() if name != last}, places):
            for page, part in parts.items():
                part = [name for name in part if name != last]
                pathlib.Path(book, page).write_text(_page_of_headings(part), encoding="utf-8")
            try:
                site_tasks.lead_to_workbench(book, feature, gone)
                wrong.append(f"{feature.stem}: a heading that is not there")
            except ToolError as error:
                if last not in str(error):
                    wrong.append(str(error))
    check(not wrong, "each chapter leads to its workbench, and each section to its steps", "\n".join(wrong))


def book_and_report_lead_to_each_other(folder):
    """By links as weave.lua makes them, in pages planted into a site."""
    site = os.path.join(folder, "site")
    up = "../../../"
    pages = {"book/a.html": f'<a href="{up}reports/out/report.html#speed" class="x">its <em>speed</em></a>',
             "report/report/speed.html": '<header>\n</header><h2 id="speed">Speed</h2>'
             f'<a href="{up}docs/out/book.html#b-part">b</a>, <a href="../source/c.html">c</a>, '
             f'<a href="{up}src/base/vec3.h">vec3</a>, <a href="{up}docs/out/book.html#gone">gone</a>',
             "book/b.html": '<h2 id="b-part">B</h2>', "report/source/c.html": "",
             "index.html": ""}
    for name, text in pages.items():
        os.makedirs(os.path.dirname(os.path.join(site, name)), exist_ok=True)
        pathlib.Path(site, name).write_text(text, encoding="utf-8")
    before = dead_links(site)
    places = {"book": {"b-part": "b.html"}, "report/report": {"speed": "speed.html"}}
    for room in places:
        site_tasks.lead_into_site(site, room, places)
    for name in pages:
        pages[name] = pathlib.Path(site, name).read_text(encoding="utf-8")
    told = ['<a href="../report/report/speed.html#speed" class="x">its <em>speed</em></a>',
            '<a href="../../book/b.html#b-part">b</a>, <a href="../source/c.html">c</a>, vec3, gone']
    check(len(before) == 4 and not dead_links(site) and pages["book/a.html"] == told[0]
          and all(part in pages["report/report/speed.html"] for part in (told[1], "../../index.html")),
          "in a site the book leads to the report, and the report to the book and to all assignments",
          [before, pages])


def tasks_lead_into_the_book():
    """Of the tasks that the workbench shows, each with the sections to read."""
    dead, count = [], 0
    for path in sorted(pathlib.Path("site/tasks").glob("*.json.gz")):
        task = json.loads(gzip.decompress(path.read_bytes()))
        steps = task["steps"] if isinstance(task, dict) and task.get("book") else []
        for section in [section for step in steps for section in step["sections"]]:
            count += 1
            if not is_there("site", task["book"] + section["href"]):
                dead.append(f"{path.name}: {section['href']}")
    check(not dead, f"the {count} sections that tasks name are where they lead", "\n".join(dead))


def main():
    if not os.environ.get("RAYKIT_SITE"):
        print("1..0 # SKIP @yowasp/clang or node is missing: ./bootstrap --site")
        return 0
    with open(os.environ["RAYKIT_SITE"], encoding="utf-8") as file:
        suites = json.load(file)
    rows = check_suites.read_table(SOURCE / "assignments" / "features.tsv")
    wanted = os.environ.get("FEATURES", "").split() or list(suites)
    for stem in wanted:
        result, = checked([(stem, SOURCE / "src/features" / f"{stem}.c")])
        broken = [verdict for verdict in result["verdicts"] if verdict["verdict"] != "passed"]
        count = len(suites[stem])
        check(len(result["verdicts"]) == count and not broken and not result["said"],
              f"{stem}: the kit's unit compiles without a warning and passes all {count} claims in a page",
              [result["said"], *broken])
    dead = dead_links("site")
    check(not dead, "all that the site's pages, its book and its report show or lead to is in it",
          "\n".join(dead))
    tasks_lead_into_the_book()
    with tempfile.TemporaryDirectory(prefix="raykit-site-") as folder:
        chapters_lead_to_the_workbench(folder)
        book_and_report_lead_to_each_other(folder)
        check_faults(folder)
        check_mains(folder)
        check_unset(folder)
        builder = check_suites.Builder(pathlib.Path(folder), Store("", False))
        counting = builder.compile(SOURCE / "tests/count_allocations.c", "counting", check_suites.SANITIZE,
                                   "what counts allocations")
        told = {}
        for row in rows:
            if row["stem"] in wanted:
                suite = Suite(row, SOURCE, builder, None)
                suite.counting = counting
                told[row["stem"]] = check_suite(suite, [claim["name"] for claim in suites[row["stem"]]],
                                                os.environ.get("RAYKIT_MUTANTS") or NUMBER)
    with open("tests/site_mistakes.json", "w", encoding="utf-8") as file:
        json.dump({stem: mistakes for stem, mistakes in told.items() if stem in TYPED}, file)
    return finish()


start(main)
