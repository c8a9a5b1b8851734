#!/usr/bin/env python3
"""Links each driver with the student's unit of its own feature: impl/assignments in the build folder
then corresponds to assignments/ with the reference's units.

All other units are the reference's, so that an unsolved assignment does not spoil the pictures of
the solved ones; in a pack, they are the workbook's where it has them. Pictures and impl/units name the
units' authors. If a unit cannot be built, a script that reports it replaces the driver of its own feature,
and STEM.unmade beside it has the reason."""

import os
import re
import subprocess
import sys

from grading import build
from grading.assignments import (Parser, ToolError, check_impl, find_unit, read_features, reference_unit,
                                 unit_beside)
from grading.results import write_whole
from grading.starters import is_left_open, is_starter


def _object(toolchain, unit, folder):
    """Compiles a unit, if it is a student's, and returns its object."""
    reference = toolchain.built(f"src/features/{unit.feature.stem}.o")
    if unit.is_reference:
        return reference
    path, warnings = build.compile_unit(toolchain, unit, folder, [*toolchain.base_sanitize])
    if warnings:
        print(warnings, file=sys.stderr)
    build.keep_interface(toolchain, unit.feature, path)
    interface = build.global_symbols(toolchain, reference)
    missing = sorted(set(interface) - set(build.global_symbols(toolchain, path)))
    if missing:
        raise build.BuildError(f"{unit.shown} does not define {' and '.join(missing)}")
    return path


def _objects_of_driver(toolchain, feature):
    """Returns the objects of the files in the driver's folder."""
    place = f"assignments/{feature.folder}/"
    return [toolchain.built(path) for path in toolchain.drivers if path.startswith(place)]


def _sentence(units, impl):
    """Names the units' authors, for captions; empty if all are the reference's."""
    work, own, others = os.path.realpath(impl), {}, set()
    for unit in units:
        if unit.is_reference:
            others.add("left open" if is_left_open(unit.path) else "reference")
        else:
            is_named = os.path.realpath(unit.path).startswith(work)
            author = os.path.basename(os.path.normpath(impl)) if is_named else "workbook"
            own.setdefault(author, []).append(unit.feature.stem)
    names = [f"{author} ({', '.join(stems)})" for author, stems in own.items()]
    rest = [f"others: {' or '.join(sorted(others, reverse=True))}"] if others else []
    return "units: " + ", ".join(names + rest) if own else ""


def _authors(sentence):
    """The sentence without the list of units, if one author has written them all."""
    return re.sub(r" \([^)]*\)(?=$|, others)", "", sentence) if sentence.count("(") == 1 else sentence


def _object_that_says(toolchain, sentence, units, folder):
    """Returns the object that brings the sentence into a driver, and the names of the starters."""
    starters = " ".join(["", *(unit.feature.stem for unit in units if is_starter(unit)
                               or is_left_open(unit.path)), ""])
    literal = sentence.replace("\\", "\\\\").replace('"', '\\"')
    source = os.path.join(folder, "units.c")
    folder_of_pictures = "impl/out" if sentence else "out"
    write_whole(source, '#include "driver/implementation_note.h"\n\n'
                f'const char rk_implementation_note[] = "{literal}";\n'
                f'const char rk_pictures_folder[] = "{folder_of_pictures}";\n'
                f'const char rk_unsolved_features[] = "{starters}";\n')
    output = os.path.join(folder, "units.o")
    subprocess.run([*toolchain.compiler, *toolchain.flags, "-c", source, "-o", output], check=True)
    return output


def _told(error, in_full=True):
    """Shows why a driver cannot be made, and returns it for the page."""
    details = error.details if in_full else ""
    print(f"{details}\ndrivers: {error.reason}".strip(), file=sys.stderr)
    return error.reason


def driver_of(feature):
    """Returns where the feature's driver with the student's unit stands in the build folder."""
    return os.path.join("impl", "assignments", feature.folder, feature.stem)


def link_drivers(toolchain, impl, only=None):
    """Makes impl/assignments/FOLDER/STEM for all features, or only for one; returns the sentence for
    captions."""
    features = read_features(toolchain.source)
    stems = [only] if only else list(features)
    if not os.path.isdir(impl) and not only:
        name = os.path.splitext(os.path.basename(impl))[0]
        stems = [name] if name in features else stems
    check_impl(features, impl, stems)
    own = {stem: find_unit(features[stem], impl) for stem in stems}
    own = {stem: unit for stem, unit in own.items() if unit.path}
    for unit in own.values():
        unit.shown = os.path.basename(unit.path)
    beside = {stem: unit_beside(feature, impl, toolchain.handed_out) for stem, feature in features.items()}
    folder = os.path.join(toolchain.build, "impl")
    parts = os.path.join(folder, "drivers")
    os.makedirs(parts, exist_ok=True)
    objects, unmade = {}, {}
    for unit in [*own.values(), *beside.values()]:
        key = unit.feature.stem, unit.is_reference
        if key in objects or key in unmade:
            continue
        try:
            objects[key] = _object(toolchain, unit, parts)
        except build.BuildError as error:
            unmade[key] = _told(error, only in (None, unit.feature.stem))
    # A unit that cannot be built costs its own driver only.
    for stem, unit in beside.items():
        if (stem, False) in unmade and not unit.is_reference:
            beside[stem] = reference_unit(features[stem])
            objects[stem, True] = _object(toolchain, beside[stem], parts)
    for feature in [features[only]] if only else features.values():
        driver = os.path.join(toolchain.build, driver_of(feature))
        os.makedirs(os.path.dirname(driver), exist_ok=True)
        units = list({**beside, feature.stem: own.get(feature.stem, beside[feature.stem])}.values())
        says = _object_that_says(toolchain, _sentence(units, impl), units, parts)
        keys = [(unit.feature.stem, unit.is_reference) for unit in units]
        reason = next((unmade[key] for key in keys if key in unmade), None)
        for path in (driver, driver + ".unmade"):
            if os.path.lexists(path):
                os.unlink(path)
        try:
            if not reason:
                build.link(toolchain, driver, [
                    *_objects_of_driver(toolchain, feature), says, *(objects[key] for key in keys),
                    toolchain.built("librkstages.a"), toolchain.built("librkbase.a"), *toolchain.libraries],
                           parts)
        except build.BuildError as error:
            reason = _told(error)
        if reason:
            write_whole(driver + ".unmade", reason + "\n")
            write_whole(driver, "#!/bin/sh\nexit 1\n")
            os.chmod(driver, 0o755)
    sentence = _sentence([own.get(stem, beside[stem]) for stem in features], impl)
    write_whole(os.path.join(folder, "units"), sentence + "\n")
    return sentence


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--only", metavar="STEM", help="make only this driver, and print its path")
    arguments = parser.parse_args()
    try:
        toolchain = build.Toolchain(arguments.build)
        sentence = link_drivers(toolchain, arguments.impl, arguments.only)
        if not arguments.only:
            print(f"report: {sentence}", file=sys.stderr)
            return 0
        path = driver_of(read_features(toolchain.source)[arguments.only])
        if os.path.exists(os.path.join(toolchain.build, path + ".unmade")):
            return 1
        units = f"; {_authors(sentence)}" if sentence else ""
        print(f"run {path} (--help lists its options){units}")
    except ToolError as error:
        print(f"drivers: {error}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"drivers: {error.cmd[0]} failed; its reason is above", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
