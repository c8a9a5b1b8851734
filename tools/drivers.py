#!/usr/bin/env python3
"""Links the drivers with a student's units, below impl/ in the build folder: impl/assignments is
then to those units what assignments/ is to the reference's.

The units that IMPL does not have are the reference's; pictures, captions and impl/units say which
is which."""

import argparse
import os
import shutil
import subprocess
import sys

import building
from assignments import ToolError, check_impl, find_unit, read_features, reference_unit
from results import write_whole


def _objects(toolchain, units, folder):
    """Compiles the student's units, and returns an object for every feature."""
    objects = []
    for unit in units:
        path = toolchain.built(f"src/features/{unit.feature.stem}.o")
        if not unit.is_reference:
            flags = [*toolchain.base_sanitize]
            interface = building.global_symbols(toolchain, path)
            path, warnings = building.compile_unit(toolchain, unit, folder, flags)
            if warnings:
                print(warnings, file=sys.stderr)
            building.keep_interface(toolchain, unit.feature, path)
            missing = sorted(set(interface) - set(building.global_symbols(toolchain, path)))
            if missing:
                raise building.BuildError(f"{unit.shown} does not define {' and '.join(missing)}")
        objects.append(path)
    return objects


def _renderer_without_features(toolchain, features, folder):
    """Returns a copy of librkrender.a that holds no feature, so that none is picked up unasked."""
    archive = os.path.join(folder, "librkrender.a")
    shutil.copyfile(toolchain.built("librkrender.a"), archive)
    members = [stem + ".o" for stem in features]
    subprocess.run([toolchain.tools["ar"], "d", archive, *members], check=True)
    return archive


def _say_units(toolchain, units, impl, folder):
    """Returns the sentence for captions, and the object that brings it into the drivers."""
    own = [unit.feature.stem for unit in units if not unit.is_reference]
    name = os.path.basename(os.path.normpath(impl))
    sentence = f"units: {name} ({', '.join(own)})" + (", others: reference" if len(own) < len(units) else "")
    literal = sentence.replace("\\", "\\\\").replace('"', '\\"')
    source = os.path.join(folder, "units.c")
    write_whole(source, f'#include "render/units.h"\n\nconst char rk_units[] = "{literal}";\n')
    output = os.path.join(folder, "units.o")
    subprocess.run([*toolchain.compiler, *toolchain.flags, "-c", source, "-o", output], check=True)
    return sentence, output


def link_drivers(toolchain, impl):
    """Makes impl/assignments/FOLDER/STEM for all features; returns the sentence for captions."""
    features = read_features(toolchain.source)
    stems = list(features)
    if not os.path.isdir(impl):
        name = os.path.splitext(os.path.basename(impl))[0]
        stems = [name] if name in features else stems
    check_impl(features, impl, stems)
    found = {stem: find_unit(features[stem], impl) for stem in stems}
    units = [found[stem] if stem in found and found[stem].path else reference_unit(features[stem])
             for stem in features]
    folder = os.path.join(toolchain.build, "impl")
    parts = os.path.join(folder, "drivers")
    os.makedirs(parts, exist_ok=True)
    objects = _objects(toolchain, units, parts)
    sentence, object_of_sentence = _say_units(toolchain, units, impl, parts)
    archive = _renderer_without_features(toolchain, features, parts)
    for feature in features.values():
        place = os.path.join(folder, "assignments", feature.folder)
        os.makedirs(place, exist_ok=True)
        building.link(
            toolchain, os.path.join(place, feature.stem),
            [toolchain.built(f"assignments/{feature.folder}/driver.o"), object_of_sentence, *objects,
             archive, toolchain.built("librkbase.a"), *toolchain.libraries], parts,
        )
    write_whole(os.path.join(folder, "units"), sentence + "\n")
    return sentence


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    arguments = parser.parse_args()
    try:
        print(f"report: {link_drivers(building.Toolchain(arguments.build), arguments.impl)}", file=sys.stderr)
    except ToolError as error:
        print(f"report: {error}", file=sys.stderr)
        return 1
    except building.BuildError as error:
        print(f"{error.details}\nreport: {error.reason}".strip(), file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"report: {error.cmd[0]} failed; its reason stands above", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
