#!/usr/bin/env python3
"""The site of a course: it has no solution, other units are the student's or starters, and it is light.
Speaks TAP, for make check-site; runs in a build folder that has site/."""

import gzip
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import site_course  # noqa: E402
import site_weights  # noqa: E402
from grading.assignments import ToolError, read_features  # noqa: E402
from grading.starters import solution_lines, starter_of  # noqa: E402
from page_links import dead_links  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

FEATURES = read_features(SOURCE)
COURSE, LATER = ["bvh_median", "sah_binning"], ["shading", "watertight"]  # each suite uses watertight's unit
LEFT_OUT = [FEATURES[stem] for stem in COURSE + LATER]
SECRET = max(sorted(solution_lines(FEATURES["bvh_median"].reference)), key=len)
MOST = 30e6  # bytes of a first visit, from a server that compresses nothing
NOTE = """Hand in by **5 October 2026**. [More](https://uni.example/cg) & ask.

## Dates
"""


def make(*arguments):
    return run(".", os.environ.get("MAKE", "make"), "-s", "site", *arguments)


def it_is_light(site, told):
    names = json.loads(re.search(r"NEEDED = (\[.*\]);", read(site, "service_worker.js"))[1])
    missing = [name for name in names if not os.path.isfile(os.path.join(site, name))]
    bytes_all = sum(os.path.getsize(os.path.join(site, name)) for name in names)
    check(not missing and bytes_all <= MOST, f"{told} is at most {MOST / 1e6:.0f} MB at the first visit",
          f"{missing} {bytes_all}")
    print(f"# {told}: {len(names)} files, {bytes_all / 1e6:.1f} MB")
    objects = [name for name in names if name.endswith((".o", ".a", ".wasm", ".tar"))]
    check(not objects, "what a server would send unpacked is packed", objects)
    check(not os.path.exists(os.path.join(site, "objects")), "it holds nothing that only make needs")


def it_is_the_courses(site, said):
    missing = dead_links(site)
    check(not missing, "all that its pages show or lead to is in it", "\n".join(missing))
    page = " ".join(read(site, "index.html").split())
    check("<h1>Graphics &amp; {1}</h1>" in page and "<strong>5 October 2026</strong>" in page
          and '<a href="https://uni.example/cg">More</a>' in page and ">Dates</h2>" in page,
          "the first page has the course's title, dates and links", page)
    stems = re.findall(r"workbench\.html\?(\w+)", page)
    check(stems == ["bvh_median", *COURSE] and "For instructors" not in page,
          "it leads to the course's assignments, and begins with the first", stems)
    for folder in ("starters", "suites", "tasks"):
        own = [name.partition(".")[0] for name in os.listdir(os.path.join(site, folder))]
        check(sorted(set(own) - {"course", "workbook"}) == COURSE, f"{folder} has only these", own)
    own = [stem for stem in COURSE
           if read(site, "starters", f"{stem}.c") == starter_of(FEATURES[stem].reference)]
    check(own == COURSE, "which are the kit's", own)
    check("the solutions of normals, parallelogram_light, " in said and "Searched the site for" in said,
          "make says which solutions it holds, and that no others are in it", said)


def leaks_of(site, pack):
    """Returns the status and the words of the search for the solutions' code."""
    return run(".", os.environ["RAYKIT_NODE"], os.path.join(SOURCE, "tools", "site", "leak_check.mjs"),
               "--tools", SOURCE, "--pack", pack, "--site", site, "--open", " ".join(COURSE + LATER),
               "--store", "impl/site")


def starters_in(folder):
    """Makes what the search needs of a pack."""
    pack = os.path.join(folder, "pack")
    for part in ("src", "tests", os.path.join("tools", "live", "sse2")):
        shutil.copytree(os.path.join(SOURCE, part), os.path.join(pack, part))
    for feature in LEFT_OUT:
        write(starter_of(feature.reference), pack, "src", "features", f"{feature.stem}.c")
    return pack


def it_has_no_solution(site, folder):
    pack = starters_in(folder)
    status, said = leaks_of(site, pack)
    count = int((re.search(r"for (\d+) pieces", said) or [0, 0])[1])
    check(status == 0 and count >= 3 * len(LEFT_OUT), "no code of the solutions is in any file", said)
    leaks = {"suites/sah_binning.o.gz": ["bvh_median"], "kit.a.gz": ["watertight"],
             "drivers/normals.o.gz": COURSE + LATER}
    kept = os.path.join(folder, "kept")
    shutil.copytree(site, kept)
    for name in leaks:
        shutil.copyfile(os.path.join("site", name), os.path.join(site, name))
    write("\0asm\1\0\0\0", site, "more.wasm")
    status, said = leaks_of(site, pack)
    for name, stems in leaks.items():
        held = re.findall(rf"^{re.escape(name)}: .* solution of (\w+)$", said, re.MULTILINE)
        check(status == 1 and sorted(held) == sorted(stems), f"the kit's own {name} would be found", said)
    check("more.wasm: this is a module" in said, "and so would a module of another compiler", said)
    shutil.rmtree(site)
    os.rename(kept, site)
    task = json.dumps({"text": f"so:\n{SECRET}\n"}).encode()
    for name, text in (("tasks/more.json.gz", gzip.compress(task)),
                       ("book/more.html", f"<b>{html.escape(SECRET)}</b>".encode()),
                       ("starters/bvh_median.c", SECRET.encode())):
        place = os.path.join(site, name)
        before = read(place) if os.path.exists(place) else None
        os.makedirs(os.path.dirname(place), exist_ok=True)
        with open(place, "wb") as file:
            file.write(text)
        try:
            site_course._check_texts(SOURCE, site, LEFT_OUT)
            check(False, f"a line of a solution would be found in {name}")
        except ToolError as error:
            check(name in str(error), f"a line of a solution would be found in {name}", error)
        os.unlink(place) if before is None else write(before, place)


def tool(name, site, *arguments):
    """Returns what a tool of tools/site prints, a row for each line."""
    command = [os.environ["RAYKIT_NODE"], os.path.join(SOURCE, "tools", "site", name), "--site", site,
               "--json", *arguments]
    answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    return [json.loads(line) for line in answer.stdout.splitlines()]


def others_are_the_students(site, folder):
    mine = os.path.join(folder, "mine")

    def verdicts(*stems, broken=""):
        """Of sah_binning's suite, with the reference's units of these stems in the student's folder."""
        shutil.rmtree(mine, ignore_errors=True)
        for stem in stems:
            text = broken if stem == "bvh_median" and broken else read(FEATURES[stem].reference)
            write(text, mine, f"{stem}.c")
        result, = tool("claims.mjs", site, "--units", mine, "--only", "sah_binning", "--seconds", "600")
        return [verdict["verdict"] for verdict in result["verdicts"]], result["starters"]

    held, starters = verdicts("sah_binning")
    check(set(held) != {"passed"} and starters == ["bvh_median"],
          "a suite that needs another unit has its starter, and says so", [held, starters])
    held, starters = verdicts("sah_binning", "bvh_median")
    check(set(held) == {"passed"} and not starters, "or the student's own", [held, starters])
    for broken in ("int broken = ;\n", "int nothing;\n"):
        _, starters = verdicts("sah_binning", "bvh_median", broken=broken)
        check(starters == ["bvh_median"], f"but not one that cannot be used: {broken.strip()}", starters)
    shutil.rmtree(mine)
    write(read(FEATURES["bvh_median"].reference), mine, "bvh_median.c")
    rows = tool("pictures.mjs", site, "--units", mine, "--only", "bvh_median", "--size", "40x40")
    said = "\n".join(row["said"] for row in rows)
    check(rows and all(row["status"] == 0 for row in rows) and "shading is still the starter" in said,
          "drivers draw with what is still the starter, and say so", said)


def it_is_refused(folder):
    taken = os.path.join(folder, "taken.zip")
    write("mine", taken)
    for arguments, part in (([f"ASSIGNMENTS={COURSE[0]}", f"OUT={taken}"], "exists"),
                            ([f"ASSIGNMENTS={COURSE[0]}", "LATER=bvh_median"], "is handed out"),
                            (["ASSIGNMENTS=bvh_medina"], "bvh_medina"),
                            ([f"ASSIGNMENTS={COURSE[0]}", f"NOTE={SECRET}"], "a line of the solution"),
                            (["TITEL=x"], "TITEL")):
        where = [] if any(word.startswith("OUT=") for word in arguments) else [f"OUT={folder}/never"]
        status, said = make(*arguments, *where)
        check(status != 0 and part in said, f"make site refuses {arguments[-1][:40]}", said)
    check(read(taken) == "mine" and os.listdir(folder) == ["taken.zip"], "and leaves nothing behind",
          os.listdir(folder))


def it_is_a_zip(site, folder):
    place = os.path.join(folder, "site.zip")
    site_course.copy_site(site, place)
    with zipfile.ZipFile(place) as archive:
        names = archive.namelist()
        whole = all(archive.read(name) == open(os.path.join(site, name), "rb").read() for name in names)
    files = [os.path.relpath(os.path.join(where, name), site) for where, _, all_names in os.walk(site)
             for name in all_names]
    check(whole and sorted(names) == sorted(files) and "index.html" in names,
          "a zip holds the same files, with the first page at its top", names)


def main():
    if not os.environ.get("RAYKIT_SITE"):
        print("1..0 # SKIP @yowasp/clang or node is missing: ./bootstrap --site")
        return 0
    with tempfile.TemporaryDirectory(prefix="raykit-site-course-") as folder:
        places = {name: os.path.join(folder, name) for name in ("refused", "packed", "other")}
        for place in places.values():
            os.mkdir(place)
        it_is_light("site", "the kit's own site")
        weights = site_weights.weights_of("site")
        check(site_weights.is_right(read(SOURCE, "docs", "tools.md"), weights),
              "its weight is that of the table in docs/tools.md: make site-weights",
              site_weights.table(weights))
        it_is_refused(places["refused"])
        site = os.path.join(places["packed"], "course")
        status, said = make(f"ASSIGNMENTS={' '.join(reversed(COURSE))}", f"LATER={' '.join(LATER)}",
                            "TITLE=Graphics & {1}", f"NOTE={NOTE}", "BOOK=no", f"OUT={site}")
        check(status == 0 and os.listdir(places["packed"]) == ["course"], "the site of a course is made",
              said)
        if status == 0:
            it_is_the_courses(site, said)
            it_is_light(site, "that")
            others_are_the_students(site, places["other"])
            it_is_a_zip(site, places["other"])
            it_has_no_solution(site, places["other"])
    return finish()


start(main)
