#!/usr/bin/env python3
"""What students see: pictures of the starters, of each step, and of mistakes. Speaks TAP, for make
check-pictures; runs in a build folder."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import draw  # noqa: E402
import readme_strip  # noqa: E402
import wrong  # noqa: E402
from drivers import driver_of, link_drivers  # noqa: E402
from grading.assignments import ToolError, read_features, read_looks  # noqa: E402
from grading.build import Toolchain  # noqa: E402
from grading.starters import solved_until  # noqa: E402
from png import filtered_rows, size_of  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402
from workbook import make_workbook  # noqa: E402

BUILD = os.getcwd()
FEATURES = read_features(SOURCE)
TOOLCHAIN = Toolchain(BUILD)
FEWEST_GREYS = 20  # a silhouette has two
SIZE = ["--width", "96", "--height", "96"]


def greys(path):
    """Returns the brightness, 0 to 255, of each pixel of a PNG file as the drivers write it: 8 bits, RGB."""
    (width, height), lines = size_of(path), filtered_rows(path)
    before, found = bytes(3 * width), []
    for y in range(height):
        line = _unfiltered(lines[y * (3 * width + 1) :][: 3 * width + 1], before)
        found += [sum(line[x : x + 3]) // 3 for x in range(0, len(line), 3)]
        before = line
    return found


def _paeth(a, b, c):
    p = a + b - c
    return min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]


def _unfiltered(line, above):
    kind, out = line[0], bytearray(line[1:])
    for i, value in enumerate(out):
        a, b, c = (out[i - 3] if i > 2 else 0), above[i], (above[i - 3] if i > 2 else 0)
        out[i] = (value + (0, a, b, (a + b) // 2, _paeth(a, b, c))[kind]) & 255
    return out


def _draw(driver, folder, *options):
    """Runs a driver; returns its output, and the picture that it wrote, or None."""
    shutil.rmtree(folder, ignore_errors=True)
    status, said = run(BUILD, driver, *options, "--out", folder)
    figures = os.path.join(folder, "figures")
    pictures = [os.path.join(figures, name) for name in sorted(os.listdir(figures))] if status == 0 else []
    return said, pictures[0] if pictures else None


# --- Starters ---------------------------------------------------------------------------------------


def starters_draw(folder):
    """With every unit a starter, as on the first day of a course."""
    mine = os.path.join(folder, "mine")
    make_workbook(SOURCE, mine)
    toolchain = Toolchain(BUILD)
    toolchain.handed_out = list(FEATURES)
    link_drivers(toolchain, mine)
    for stem, feature in FEATURES.items():
        said, picture = _draw(driver_of(feature), os.path.join(folder, "out"), *SIZE)
        found = greys(picture) if picture else [0]
        lit, kinds = sum(grey > 0 for grey in found) / len(found), len(set(found))
        check(lit > 0.02 and kinds >= FEWEST_GREYS, f"{stem}: with nothing solved its picture shows form",
              f"{lit:.0%} of the pixels are not black, in {kinds} greys\n{said}")
        check(re.search(rf"\b{stem}\b.* (still the starter|find no triangles yet|finds no triangles yet)",
                        said),
              f"{stem}: the driver says that it is still the starter", said)
    starters_of_glass_let_light_pass(folder)
    said, _ = _draw(driver_of(FEATURES["bvh_median"]), os.path.join(folder, "out"), *SIZE)
    check("the renderer's own tree" in said, "the driver says that rays go through the renderer's own tree",
          said)
    named = re.findall(r"^bvh_median: (.*); the picture shows it", said, re.MULTILINE)
    check(named and "bvh_median" not in named[0],
          "it does not say that a tree is seen in the picture, which another draws, too", said)
    said, _ = _draw(driver_of(FEATURES["bvh_median"]), os.path.join(folder, "out"), *SIZE, "--debug", "level",
                    "--level", "0")
    check(re.search(r"\bbvh_median\b[^:]* still the starter", said), "a view of the tree shows it", said)
    _, picture = _draw(driver_of(FEATURES["bloom"]), os.path.join(folder, "out"), *SIZE, "--debug",
                       "threshold")
    check(picture and len(set(greys(picture))) >= FEWEST_GREYS,
          "bright pixels are looked for in a picture with form")
    look = read_looks(FEATURES["bvh_median"])[-1]
    said, _ = _draw(driver_of(FEATURES["bvh_median"]), os.path.join(folder, "out"), *draw.small(look.options),
                    "--compare", look.picture)
    check(re.search(r"shows where; shading [^;]*still the starter here, and solved in the wanted picture",
                    said),
          "where a picture differs that uses starters, they are named", said)
    shutil.copyfile(FEATURES["bvh_median"].reference, os.path.join(mine, "bvh_median.c"))
    link_drivers(toolchain, mine, "sah_binning")
    said, _ = _draw(driver_of(FEATURES["sah_binning"]), os.path.join(folder, "out"), *SIZE, "--scene",
                    "teapot")
    check("the tree of sah_binning finds no triangles yet" in said and "the renderer's own tree" in said,
          "where bvh_median is solved, and sah_binning is not, only that is named", said)
    link_drivers(toolchain, mine, "normals")
    said, _ = _draw(driver_of(FEATURES["normals"]), os.path.join(folder, "out"), *SIZE)
    check("finds no triangles yet" not in said,
          "where no tree is shown, the renderer's own is traced, and not a word said",
          said)


def starters_of_glass_let_light_pass(folder):
    out = os.path.join(folder, "out")
    cases = [("transparency", f"--scene cornell-glass --transparency --shadows --glass {model}")
             for model in ("multiplicative", "ordered", "beer-lambert")]
    # The goal in HANDOUT.md, with fewer samples.
    cases.append(("motion_blur",
                  "--scene cover --environment sky --shadows --shading blinn-phong --reflections "
                  "--transparency --glass beer-lambert --time-samples 1"))
    for stem, options in cases:
        said, picture = _draw(driver_of(FEATURES[stem]), out, *SIZE, *options.split())
        found = greys(picture) if picture else [0]
        lit, kinds = sum(grey > 0 for grey in found) / len(found), len(set(found))
        check(lit > 0.3 and kinds >= FEWEST_GREYS, f"{stem} {options}: lit with nothing solved",
              f"{lit:.0%} of the pixels are not black, in {kinds} greys\n{said}")
    means = []
    for options in ([], ["--transparency"]):
        said, picture = _draw(driver_of(FEATURES["transparency"]), out, *SIZE, "--scene", "cover",
                              "--environment",
                              "sky", *options)
        found = greys(picture) if picture else [0]
        means.append(sum(found) / len(found))
    check(abs(means[1] - means[0]) < 0.05 * means[0], "with nothing solved the sky is seen beside glass",
          f"the mean grey is {means[1]:.1f} with --transparency, and {means[0]:.1f} without\n{said}")


# --- Looks ------------------------------------------------------------------------------------------


def wanted_pictures_are_what_the_kit_draws(folder):
    for stem, feature in FEATURES.items():
        driver, wrong = os.path.join("assignments", feature.folder, stem), []
        for look in read_looks(feature):
            said, _ = _draw(driver, folder, *draw.small(look.options), "--compare", look.picture)
            if f"{look.picture}: the picture is the same" not in said:
                wrong.append(f"step {look.step}: {said}")
        check(not wrong,
              f"{stem}: each step's wanted picture is what the kit draws (make look draws them anew)",
              "\n".join(wrong))


def a_step_shows_its_picture_before_the_next_is_begun(folder):
    """With the starters in place of all later steps."""
    for stem, feature in FEATURES.items():
        looks, mine, wrong = read_looks(feature), os.path.join(folder, stem), []
        for look in looks[:-1]:
            write(solved_until(feature.reference, look.step), mine, stem + ".c")
            link_drivers(TOOLCHAIN, mine, stem)
            said, _ = _draw(driver_of(feature), os.path.join(folder, "out"), *draw.small(look.options),
                            "--compare", look.picture)
            if f"{look.picture}: the picture is the same\n" not in said:
                wrong.append(f"step {look.step}: {said}")
        check(not wrong, f"{stem}: after each step its picture is the wanted one, before the next is begun",
              "\n".join(wrong))


def pictures_of_another_size_are_refused(folder):
    feature = FEATURES["normals"]
    driver, picture = os.path.join("assignments", feature.folder, "normals"), read_looks(feature)[0].picture
    status, said = run(BUILD, driver, *SIZE, "--out", folder, "--compare", picture)
    check(status == 1 and "128 x 128" in said and "--width" in said,
          "a picture of another size is not compared; the message says which size it has", said)
    status, said = run(BUILD, driver, *SIZE, "--out", folder, "--compare", "no.png")
    check(status == 1 and "no.png" in said, "a picture that is not there is named", said)


def sizes_are_small():
    for options, want in (("", ("128", "128")), ("--width 1000 --height 250 --fov 4", ("256", "64"))):
        words = draw.small(options)
        got = tuple(words[words.index(name) + 1] for name in ("--width", "--height"))
        check(got == want and words.count("--width") == 1,
              f"the small picture of \"{options}\" has {want[0]} x {want[1]} pixels",
              shlex.join(words))


def a_students_picture_is_compared(folder):
    """A right unit, and one with z for x."""
    feature = FEATURES["normals"]
    with open(feature.reference, encoding="utf-8") as file:
        right = file.read()
    wrong = right.replace("0.5f * n.x", "0.5f * n.z")
    for name, text in (("right", right + "/* mine */\n"), ("wrong", wrong)):
        os.mkdir(os.path.join(folder, name))
        with open(os.path.join(folder, name, "normals.c"), "w", encoding="utf-8") as file:
            file.write(text)
    make = os.environ["MAKE"]
    status, said = run(BUILD, make, "-s", "draw-normals", "STEP=1", f"IMPL={folder}/right")
    check(status == 0 and "look/1.png: the picture is the same" in said, "a right picture is the wanted one",
          said)
    status, said = run(BUILD, make, "-s", "draw-normals", "STEP=1", f"IMPL={folder}/wrong")
    told = re.search(r"differs in \d+ % of the 128 x 128 pixels, most at \d+,\d+; (\S+) shows where\n", said)
    check(status == 0 and "starter" not in said and told and os.path.exists(os.path.join(BUILD, told[1])),
          "of another one it is said how much differs and where, and a picture shows it", said)
    status, said = run(BUILD, make, "-s", "draw-normals", "STEP=1", f"IMPL={folder}/right")
    check(status == 0 and told and not os.path.exists(os.path.join(BUILD, told[1])),
          "once it is right, no picture of a difference is left", said)
    status, said = run(BUILD, make, "-s", "check-normals", f"IMPL={folder}/right")
    check(status == 0 and f"draw it: make draw-normals IMPL={folder}/right" in said,
          "at 100 points the check prints the command that draws", said)
    make_workbook(SOURCE, os.path.join(folder, "starters"))
    for name, step, part, claim in (
            ("bvh_median", 4, "the picture is the same, but was traced through another tree",
             "a right picture that another tree has traced is told"),
            ("bvh_median", 4,
             "step 4 is still the starter, however the picture looks; "
             "its claims decide: make check-bvh_median",
             "a step that is not begun is told, though its picture looks right"),
            ("cubemap", 2, "differs in 100 % of the",
             "of a picture that is all wrong the per cent are written out"),
            ("sah_binning", 3, "write steps 1 to 3 of sah_binning first",
             "where no candidate is found, the step to write is named"),
            ("sah_binning", 5, "is one leaf, as a starter's is",
             "a tree of one node is told where a level is to be drawn"),
            ("sah_binning", 5, "its reason is above; step 1 is still the starter",
             "and the first step that is not begun")):
        _, said = run(BUILD, make, "-s", f"draw-{name}", f"STEP={step}", f"IMPL={folder}/starters")
        check(part in said, claim, said)
    _, said = run(BUILD, make, "-s", "draw-normals", "STEP=2", f"IMPL={folder}/wrong")
    check("still the starter" not in said, "a step that is begun is not called a starter", said)
    status, said = run(BUILD, make, "-s", "draw-normals", "STEP=7")
    check(status != 0 and "STEP=7" in said and "steps 1 and 2" in said,
          "a step that shows nothing is refused, with those that do", said)


def a_picture_that_does_not_show_a_broken_claim_says_so(folder):
    """A unit whose normal of a triangle without area is wrong: no triangle of the picture is one."""
    mine, claim = os.path.join(folder, "unseen"), "a_triangle_without_area_has_the_normal_0"
    right = read(FEATURES["normals"].reference)
    wrong = right.replace("return rk_normalize(rk_cross(rk_sub(b, a), rk_sub(c, a)));",
                          "rk_vec3 n = rk_normalize(rk_cross(rk_sub(b, a), rk_sub(c, a)));\n"
                          "    return rk_dot(n, n) > 0 ? n : rk_vec(0, 1, 0);")
    write(wrong, mine, "normals.c")
    commands = [os.environ["MAKE"], "-s", f"IMPL={mine}"]
    said = run(BUILD, *commands, "draw-normals")[1]
    check("look/2.png: the picture is the same\n" in said, "before a check, of claims nothing is said", said)
    run(BUILD, *commands, "check-normals")
    status, said = run(BUILD, *commands, "draw-normals")
    check(status == 0 and "look/2.png: the picture is the same; it does not show that a claim of step 2 "
          f"fails: {claim} (make check-normals IMPL={mine})\n" in said,
          "a picture that is the same though a claim of its step fails says so, and names the claim", said)
    said = run(BUILD, *commands, "draw-normals", "STEP=1")[1]
    check("look/1.png: the picture is the same\n" in said, "it does not, of a later step's claim", said)
    write(right + "/* mine */\n", mine, "normals.c")
    said = run(BUILD, *commands, "draw-normals")[1]
    check("look/2.png: the picture is the same\n" in said, "nor of a check of another text", said)


def draws_at_once_do_not_meet(folder):
    """Three draws of a right unit, three of a wrong one, and a driver that is made, all at once."""
    make = os.environ["MAKE"]
    names = ["right", "wrong"] * 3
    draws = [subprocess.Popen([make, "-s", "draw-normals", "STEP=1", f"IMPL={folder}/{name}"], cwd=BUILD,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for name in names]
    status, made = run(BUILD, make, "-s", "driver-normals", f"IMPL={folder}/right")
    said = [process.communicate()[0] for process in draws]
    told = ["right" if "the picture is the same" in text else "wrong" if "differs in" in text else "nothing"
            for text in said]
    check(told == names, "six draws at once give the answers that each gives alone", "\n".join(said))
    check(status == 0 and "run impl/assignments/00_normals/normals" in made,
          "and so does a driver beside them", made)
    left = [name for name in os.listdir(os.path.join(BUILD, "impl")) if name.startswith("drivers-")]
    check(not left, "and nothing is left of them", left)


def a_unit_that_never_ends_is_stopped(folder):
    os.mkdir(os.path.join(folder, "endless"))
    write(read(FEATURES["normals"].reference).replace("return rk_normalize",
                                                      "for (;;)\n        ;\n    return rk_normalize"),
          folder, "endless", "normals.c")
    draw.SECONDS = 1
    try:
        draw.draw(TOOLCHAIN, os.path.join(folder, "endless"), "normals", "")
        check(False, "a unit that never ends is stopped")
    except ToolError as error:
        check("was stopped; does a loop" in str(error), "a unit that never ends is stopped", error)


def a_wrong_table_is_refused(folder):
    feature = FEATURES["normals"]
    feature.points_table = os.path.join(folder, "points.tsv")
    for rows, part in (("step\tcaption\n", ":1:"), ("step\toptions\tcaption\n2\t\ta\n1\t\tb\n", ":3:"),
                       ("step\toptions\tcaption\n", "no step")):
        with open(os.path.join(folder, "look.tsv"), "w", encoding="utf-8") as file:
            file.write(rows)
        try:
            read_looks(feature)
            check(False, f"look.tsv: {rows!r} is refused")
        except ToolError as error:
            check(part in str(error), f"look.tsv: {rows!r} is refused, with its line", error)


# --- Mistakes ---------------------------------------------------------------------------------------


def mistakes_are_drawn(folder):
    """Of one feature; the book is woven with those of all."""
    feature = read_features(SOURCE)["normals"]
    rows = wrong.read_wrong(SOURCE, feature)
    told = [line.split("\t") for line in wrong.draw_all(TOOLCHAIN, feature, folder)]
    check([line[0] for line in told] == [row.mutant.name for row in rows],
          "each wrong picture is told, in order", told)
    check(all(len(set(greys(line[5]))) >= FEWEST_GREYS for line in told), "and shows something")


def mistakes_that_cannot_be_seen_are_refused(folder):
    feature = read_features(SOURCE)["normals"]
    feature.points_table = os.path.join(folder, "points.tsv")
    cases = (("up_without_area", "--scene cube", 30, "draws the right picture",
              "a mistake that does not show is refused"),
             ("not_moved", "--scene nowhere", 30, "drew nothing", "a driver that draws nothing is told"),
             ("not_moved", "--samples 1000", 0.01, "was stopped after 0.01 s",
              "a driver that takes too long is stopped"))
    for mutant, options, seconds, part, name in cases:
        write(f"mutant\tsees\toptions\tcaption\n{mutant}\tholes\t{options}\tHoles.\n", folder, "wrong.tsv")
        wrong.SECONDS = seconds
        try:
            check(False, name, wrong.draw_all(TOOLCHAIN, feature, os.path.join(folder, "out")))
        except ToolError as error:
            check(part in str(error) and "wrong.tsv" in str(error), name, error)
        finally:
            wrong.SECONDS = 30


# --- README -----------------------------------------------------------------------------------------


def readme_shows_what_is_drawn(folder):
    pictures, feature = os.path.join(SOURCE, "docs", "pictures"), FEATURES[readme_strip.STEM]
    os.mkdir(folder)
    made = readme_strip.make_strip(BUILD, folder)
    check(made["red_claim.svg"].decode() == read(pictures, "red_claim.svg"),
          "README shows the message of a claim that fails: make readme-strip makes it", made["red_claim.svg"])
    options = shlex.split(readme_strip.options_of(SOURCE, feature)) + readme_strip.SIZE
    driver = os.path.join("assignments", feature.folder, feature.stem)
    _, right = _draw(driver, os.path.join(folder, "out"), *options)
    wrong_picture = os.path.join(folder, "wrong_picture.png")
    with open(wrong_picture, "wb") as file:
        file.write(made["wrong_picture.png"])
    for path, name in ((wrong_picture, "wrong_picture"), (right, feature.stem)):
        check(filtered_rows(path) == filtered_rows(os.path.join(pictures, name + ".png")),
              f"README's {name} is what its driver draws: make readme-strip, docs/commands.md")


def main():
    with tempfile.TemporaryDirectory() as folder:
        starters_draw(folder)
        wanted_pictures_are_what_the_kit_draws(os.path.join(folder, "out"))
        a_step_shows_its_picture_before_the_next_is_begun(os.path.join(folder, "steps"))
        pictures_of_another_size_are_refused(os.path.join(folder, "out"))
        sizes_are_small()
        a_students_picture_is_compared(folder)
        a_picture_that_does_not_show_a_broken_claim_says_so(folder)
        draws_at_once_do_not_meet(folder)
        a_unit_that_never_ends_is_stopped(folder)
        a_wrong_table_is_refused(folder)
        mistakes_are_drawn(os.path.join(folder, "drawn"))
        mistakes_that_cannot_be_seen_are_refused(os.path.join(folder, "unseen"))
        readme_shows_what_is_drawn(os.path.join(folder, "strip"))
    return finish()


if __name__ == "__main__":
    start(main)
