#!/usr/bin/env python3
"""Draws the wrong pictures of a feature, each by its driver with a known mistake in the unit, and beside them
the right ones. The book asks for them while it is woven (tools/weave/wrong.lua).

assignments/FOLDER/wrong.tsv has a row for each: the mutant of tests/mutants/STEM.mutants that makes the
mistake, what one sees (one of SEES), the driver's options, and a caption. A wrong picture that equals the
right one is an error, and so is a driver that crashes or takes longer than it should.

Prints a line for each row, its fields separated by tabs: mutant, what one sees, caption, mistake, the first
test that fails, the wrong picture, the right one, and its options.
"""

import collections
import concurrent.futures
import os
import shlex
import signal
import subprocess
import sys
import tempfile

from draw import packed
from grading import build
from grading.assignments import Parser, ToolError, choose, read_features, read_table
from grading.mutants import MutantError, mutate, read_mutants
from grading.processor_time import limited

# A section of docs/92_wrong_pictures.md each.
SEES = ("holes", "specks", "seams", "stripes", "too dark", "too bright", "wrong colour", "wrong shadow",
        "wrong place", "wrong shape", "wrong blur", "wrong points", "slow")
SIDE = ["--width", "160", "--height", "160"]  # unless the options say otherwise
SECONDS = 30  # of processor time, ten times as long as the slowest takes; by the clock ten times as many

Wrong = collections.namedtuple("Wrong", "place mutant sees options caption")


def wrong_table(feature):
    """Returns the path of the feature's table."""
    return os.path.join(os.path.dirname(feature.points_table), "wrong.tsv")


def mutants_of(feature):
    """Returns the path of the feature's mistakes."""
    source = os.path.join(os.path.dirname(feature.reference), "..", "..")
    return os.path.join(os.path.normpath(source), "tests", "mutants", f"{feature.stem}.mutants")


def read_wrong(source, feature):
    """Returns the rows of a feature's table; none where it has no table."""
    path = wrong_table(feature)
    if not os.path.exists(path):
        return []
    name = os.path.relpath(mutants_of(feature), source)
    mutants = {mutant.name: mutant for mutant in read_mutants(mutants_of(feature), name)}
    rows = []
    for number, (mutant, sees, options, caption) in enumerate(
            read_table(path, ["mutant", "sees", "options", "caption"]), 2):
        place = f"{os.path.relpath(path, source)}:{number}"
        if mutant not in mutants:
            raise ToolError(f"{place}: {name} has no mutant {mutant}; correct its name")
        if any(mutants[mutant] is row.mutant for row in rows):
            raise ToolError(f"{place}: {mutant} has a picture already; remove one")
        if sees not in SEES:
            raise ToolError(f"{place}: nobody sees \"{sees}\"; choose one of: {', '.join(SEES)}")
        if not caption.endswith("."):
            raise ToolError(f"{place}: the caption is a sentence that says what one sees; "
                            "end it with a full stop")
        rows.append(Wrong(place, mutants[mutant], sees, options, caption))
    return rows


# --- Drivers with a mistake -----------------------------------------------------------------------


def _run(command, what, folder):
    # Paths from the folder on: ccache, where it is the compiler, knows the mistake again in another folder.
    done = subprocess.run(command, cwd=folder, env=dict(os.environ, CCACHE_BASEDIR="/"),
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          errors="replace", check=False)
    if done.returncode:
        raise ToolError(f"{what} does not compile or link:\n{done.stdout.rstrip()}")


def link_wrong(toolchain, feature, mutant, folder):
    """Returns the feature's driver with the mistake in its unit."""
    base, name = os.path.join(folder, mutant.name), mutant.name
    with open(feature.reference, encoding="utf-8") as file:
        text = mutate(mutant, file.read(), os.path.relpath(feature.reference, toolchain.source))
    with open(base + ".c", "w", encoding="utf-8") as file:
        file.write(text)
    what = f"{mutant.file}:{mutant.line}: {mutant.name}"
    flags = [*toolchain.flags, *toolchain.base_sanitize]
    _run([*toolchain.compiler, *flags, "-g0", "-w", "-c", name + ".c", "-o", name + ".o"], what, folder)
    own = [toolchain.built(path) for path in toolchain.drivers
           if path.startswith(f"assignments/{feature.folder}/")]
    archives = [toolchain.built("librkrender.a"), toolchain.built("librkbase.a")]
    _run([*toolchain.compiler, *toolchain.base_sanitize, *toolchain.link_flags, "-Wl,-S", *own, base + ".o",
          *archives, *toolchain.libraries, "-o", base], what, folder)
    return base


def draw(place, driver, options):
    """Returns the picture that a driver draws, as the bytes of a PNG file."""
    words = shlex.split(options)
    size = [] if "--width" in words or "--height" in words else SIDE
    with tempfile.TemporaryDirectory() as folder:
        command = [driver, *words, *size, "--quiet", "--out", folder]
        try:
            done = subprocess.run(limited(command, SECONDS), stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace",
                                  timeout=10 * SECONDS, check=False)
        except subprocess.TimeoutExpired:
            done = None
        if not done or done.returncode == -signal.SIGXCPU:
            raise ToolError(f"{place}: the driver was stopped after {SECONDS} s; choose a mistake or options "
                            "with which it ends")
        figures = os.path.join(folder, "figures")
        if done.returncode or not os.path.isdir(figures):
            raise ToolError(f"{place}: the driver ended with {done.returncode} and drew nothing; "
                            f"choose a mistake or options with which it draws:\n{done.stdout.rstrip()}")
        with open(os.path.join(figures, *os.listdir(figures)), "rb") as file:
            return packed(file.read())


# --- The pictures ---------------------------------------------------------------------------------


def draw_all(toolchain, feature, out):
    """Draws the feature's pictures into out/figures; returns the lines that tell of them."""
    rows, pictures = read_wrong(toolchain.source, feature), {}
    figures = os.path.join(out, "figures")
    os.makedirs(figures, exist_ok=True)
    right = {options: os.path.join(figures, f"wrong_{feature.stem}_right_{number}.png")
             for number, options in enumerate(dict.fromkeys(row.options for row in rows), 1)}
    driver = toolchain.built(os.path.join("assignments", feature.folder, feature.stem))
    with tempfile.TemporaryDirectory() as folder, \
            concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {path: pool.submit(draw, wrong_table(feature), driver, options)
                for options, path in right.items()}
        wrong = [os.path.join(figures, f"wrong_{feature.stem}_{row.mutant.name}.png") for row in rows]
        for row, path in zip(rows, wrong):
            jobs[path] = pool.submit(lambda row: draw(row.place,
                                                      link_wrong(toolchain, feature, row.mutant, folder),
                                                      row.options), row)
        for path, job in jobs.items():
            pictures[path] = job.result()
    for row, path in zip(rows, wrong):
        if pictures[path] == pictures[right[row.options]]:
            raise ToolError(f"{row.place}: {row.mutant.name} draws the right picture, pixel for pixel; "
                            "choose options with which one sees the mistake")
    for path, picture in pictures.items():
        with open(path, "wb") as file:
            file.write(picture)
    return ["\t".join([row.mutant.name, row.sees, row.caption, row.mutant.mistake, row.mutant.fails[0], path,
                       right[row.options], row.options]) for row, path in zip(rows, wrong)]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stem", metavar="STEM", help="the feature")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--out", required=True, metavar="DIR",
                        help="where figures/wrong_STEM_MUTANT.png are written")
    arguments = parser.parse_args()
    try:
        toolchain = build.Toolchain(arguments.build)
        feature = choose(read_features(toolchain.source), [arguments.stem])[0]
        print("\n".join(draw_all(toolchain, feature, arguments.out)))
    except (ToolError, MutantError) as error:
        print(f"wrong: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("wrong: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
