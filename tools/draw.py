#!/usr/bin/env python3
"""Draws what a step of an assignment should look like, with the student's unit, and compares it with the
wanted picture; or, with --wanted, draws these pictures by the kit's own units.

assignments/FOLDER/look.tsv has a row for each step that can be seen: the step, the driver's options, and a
caption; look/STEP.png beside it is that picture, small.
"""

import contextlib
import math
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import zlib

from drivers import made_driver
from grading import build, last_check
from grading.assignments import Parser, ToolError, choose, find_unit, read_features, read_looks, run_command
from grading.processor_time import limited
from grading.results import command_of
from grading.starters import unsolved_steps
from png import SIGNATURE, chunk, chunks_of

SIDE = 128  # of a square picture; others are as large
SECONDS = 120  # of processor time, four times what the slowest picture takes on an old laptop
SILENT = 5  # seconds by the clock
_PRAISE = "as good as it can be here, if all your claims hold: "  # of src/driver/driver_save.c
_MOST_BYTES = 15 << 10  # a pack holds some forty of them


def small(options, side=SIDE):
    """Returns the options for a small picture of the same shape, as large as a square of this side."""
    words, size = shlex.split(options), {"--width": 800, "--height": 800}
    for name in size:
        if name in words:
            at = words.index(name)
            size[name] = int(words[at + 1])
            del words[at : at + 2]
    scale = side / math.sqrt(size["--width"] * size["--height"])
    for name in size:
        words += [name, str(round(scale * size[name]))]
    return words


def _run(command, name=None, **options):
    """Runs a driver, with options for its process; it has said why if it fails. Returns what it said, if
    that goes to a pipe."""
    name = name or os.path.relpath(command[0])
    with subprocess.Popen(limited(command, SECONDS), **options) as process:
        try:
            said, _ = process.communicate(timeout=SILENT)
        except subprocess.TimeoutExpired:
            print(f"still drawing; it may take {SECONDS} s of processor time, to which waiting does not add",
                  flush=True)
            said, _ = process.communicate()
    status = process.returncode
    if status == -signal.SIGXCPU:
        raise ToolError(f"{name} has drawn for {SECONDS} s of processor time and was stopped; does a loop in "
                        "your unit never end? make check-... says which test hangs")
    if status < 0:
        raise ToolError(f"{name} crashed: {signal.strsignal(-status)}; make check-... says in which line, "
                        "make debug-... stops there")
    if status:
        raise ToolError(f"{name} could not draw it; its reason is above")
    return said


# --- The student's picture ------------------------------------------------------------------------


def _nothing_to_see(feature, step):
    """Returns which steps have a picture, if this one has none; or ""."""
    steps = [str(look.step) for look in read_looks(feature)]
    if not step or step in steps:
        return ""
    others = f"step {steps[0]} has"
    if len(steps) > 1:
        others = f"steps {', '.join(steps[:-1])} and {steps[-1]} have"
    return f"STEP={step}: {feature.stem} has no picture of this step; {others}"


def choose_look(feature, step):
    """Returns the row of a step, the last one for none."""
    missing = _nothing_to_see(feature, step)
    if missing:
        raise ToolError(missing)
    return next(look for look in reversed(read_looks(feature)) if step in ("", str(look.step)))


def _unsolved(feature, impl):
    unit = find_unit(feature, impl) if impl else None
    return unsolved_steps(unit) if unit and unit.path else []


def _draw_both(driver, path, look, unsolved):
    """Returns what the driver said of the comparison."""
    try:
        _run([driver, *shlex.split(look.options)], path)
    except ToolError as error:
        first = next((number for number in unsolved if number <= look.step), None)
        raise ToolError(f"{error}; step {first} is still the starter") if first else error
    wanted = os.path.relpath(look.picture)
    if not os.path.exists(wanted):
        raise ToolError(f"{wanted} is missing, the picture to compare with")
    return _run([driver, *small(look.options), "--quiet", "--out", os.path.join("out", "compared"),
                 "--compare", wanted], path, stdout=subprocess.PIPE, text=True, errors="replace")


def _broken(toolchain, feature, impl, look):
    """Names a claim of the steps up to this one that failed when this text of the unit was checked, "" for
    none."""
    claim, step = (last_check.read(toolchain.build, feature, impl) if impl else None) or ("", "")
    if not claim or not step.isdigit() or int(step) > look.step:
        return ""
    whose = f" of step {step}" if int(step) else ""
    return f"a claim{whose} fails: {claim} ({command_of('check', feature, impl)})"


def draw(toolchain, impl, stem, step):
    """Draws a step's picture twice: large, to look at, and small, to compare."""
    features = read_features(toolchain.source)
    feature = choose(features, [stem])[0]
    look = choose_look(feature, step)
    with contextlib.ExitStack() as stack:
        driver, path = made_driver(toolchain, impl, feature, stack)
        print(f"step {look.step}: {look.caption}\n{path} {look.options}", flush=True)
        unsolved = _unsolved(feature, impl)
        compared = _draw_both(driver, path, look, unsolved).rstrip("\n")
    is_same = ": the picture is the same" in compared and look.step not in unsolved
    broken = _broken(toolchain, feature, impl, look)
    if broken and is_same:
        compared += f"; it does not show that {broken}"
    elif broken and _PRAISE in compared:
        compared = f"{broken}\n{compared.replace(_PRAISE, '')}"
    print(compared)
    if look.step in unsolved:
        print(f"step {look.step} is still the starter, however the picture looks; "
              f"its claims decide: {command_of('check', feature, impl)}")


# --- The wanted pictures --------------------------------------------------------------------------


def packed(png):
    """Returns a PNG file compressed as far as zlib can, and without texts, such as the time that drawing
    took: drawn again, it is the same."""
    kept, pixels = SIGNATURE, b""
    for kind, content in chunks_of(png):
        if kind == b"IDAT":
            pixels += content
            continue
        if kind == b"IEND":
            kept += chunk(b"IDAT", zlib.compress(zlib.decompress(pixels), 9))
        if kind not in (b"tEXt", b"iTXt", b"zTXt"):
            kept += chunk(kind, content)
    return kept


def draw_wanted(toolchain, stems):
    """Draws the wanted pictures of these features, of all for none, where they have changed."""
    for feature in choose(read_features(toolchain.source), stems):
        driver = toolchain.built(os.path.join("assignments", feature.folder, feature.stem))
        for look in read_looks(feature):
            with tempfile.TemporaryDirectory() as folder:
                _run([driver, *small(look.options), "--quiet", "--out", folder])
                figures = os.path.join(folder, "figures")
                with open(os.path.join(figures, *os.listdir(figures)), "rb") as file:
                    picture = packed(file.read())
            if len(picture) > _MOST_BYTES:
                raise ToolError(f"{feature.stem}, step {look.step}: the picture has {len(picture)} bytes, "
                                f"more than {_MOST_BYTES}; choose one with less noise")
            os.makedirs(os.path.dirname(look.picture), exist_ok=True)
            with open(look.picture, "wb") as file:
                file.write(picture)
            print(f"{os.path.relpath(look.picture)}: {look.caption}", flush=True)


# --- The command ----------------------------------------------------------------------------------


def _work(arguments):
    if arguments.source:
        feature = choose(read_features(arguments.source), arguments.stems)[0]
        is_one = arguments.step in [str(step) for step in range(1, read_looks(feature)[-1].step)]
        if arguments.say and is_one:
            print(_nothing_to_see(feature, arguments.step))
        else:
            choose_look(feature, arguments.step)
    elif arguments.wanted:
        draw_wanted(build.Toolchain(arguments.build), arguments.stems)
    else:
        draw(build.Toolchain(arguments.build), arguments.impl, arguments.stems[0], arguments.step)


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--impl", default="", metavar="FILE_OR_DIR", help="none: the kit's own units")
    parser.add_argument("--step", default="", metavar="N", help="of the handout; the last one for none")
    parser.add_argument("--source", default="", metavar="DIR",
                        help="raykit's source folder: say whether the step has "
                        "something to see, and draw nothing")
    parser.add_argument("--say", action="store_true",
                        help="with --source: print it, and a step that has nothing to see is no error")
    parser.add_argument("--wanted", action="store_true", help="draw the wanted pictures")
    arguments = parser.parse_args()
    return run_command("draw", lambda: _work(arguments))


if __name__ == "__main__":
    sys.exit(main())
