#!/usr/bin/env python3
"""Links each driver with the student's unit of its own feature: impl/assignments in the build folder
then corresponds to assignments/ with the reference's units.

All other units are the reference's, so that an unsolved assignment does not spoil the pictures of
the solved ones; in a pack, they are the workbook's where it has them. Pictures and impl/units name the
units' authors. If a unit cannot be built, a script that reports it replaces the driver of its own feature,
and STEM.unmade beside it has the reason."""

import contextlib
import os
import re
import shutil
import subprocess
import sys

from grading import build
from grading.assignments import (Parser, ToolError, check_impl, find_unit, read_features, reference_unit,
                                 unit_beside, run_command)
from grading.results import cannot_write, write_whole
from grading.starters import is_left_open, is_starter
from grading.temporary_folder import temporary_folder


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


def _authors_of(units, impl):
    """Returns a dictionary from authors to the stems of their units, and what the other units are."""
    work, own, others = os.path.realpath(impl), {}, set()
    for unit in units:
        if unit.is_reference:
            others.add("not asked for yet" if is_left_open(unit.path) else "the kit's")
        else:
            is_named = os.path.realpath(unit.path).startswith(work)
            author = os.path.basename(os.path.normpath(impl)) if is_named else "workbook"
            own.setdefault(author, []).append(unit.feature.stem)
    return own, " or ".join(sorted(others, reverse=True))


def _sentence(units, impl):
    """Names the units' authors, for captions; empty if all are the reference's."""
    own, others = _authors_of(units, impl)
    names = [f"{author} ({', '.join(stems)})" for author, stems in own.items()]
    return "units: " + ", ".join(names + [f"others: {others}"] * bool(others)) if own else ""


def _literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _authors(sentence):
    """The sentence without the list of units, if one author has written them all."""
    return re.sub(r" \([^)]*\)(?=$|, others)", "", sentence) if sentence.count("(") == 1 else sentence


def _object_that_says(toolchain, units, impl, folder):
    """Returns the object that tells a driver the units' authors, and the names of the starters."""
    sentence, (own, others) = _sentence(units, impl), _authors_of(units, impl)
    starters = " ".join(["", *(unit.feature.stem for unit in units if is_starter(unit)
                               or is_left_open(unit.path)), ""])
    authors = "".join(f"{{{_literal(stem)}, {_literal(author)}}}, " for author, stems in own.items()
                      for stem in stems)
    source = os.path.join(folder, "units.c")
    folder_of_pictures = "impl/out" if sentence else "out"
    write_whole(source, '#include "driver/implementation_note.h"\n\n#include <stddef.h>\n'
                f'const char rk_implementation_note[] = {_literal(sentence)};\n'
                f'const rk_implementation_author rk_implementation_authors[] = {{{authors}{{NULL, NULL}}}};\n'
                f'const char rk_implementation_others[] = {_literal(others)};\n'
                f'const char rk_pictures_folder[] = "{folder_of_pictures}";\n'
                f'const char rk_unsolved_features[] = "{starters}";\n')
    output = os.path.join(folder, "units.o")
    subprocess.run([*toolchain.compiler, *toolchain.flags, "-c", source, "-o", output], check=True)
    return output


def driver_of(feature):
    """Returns where the feature's driver with the student's unit stands in the build folder."""
    return os.path.join("impl", "assignments", feature.folder, feature.stem)


@contextlib.contextmanager
def private_folder(toolchain):
    """Gives a temporary folder beside the drivers, for one process: another that makes drivers at the same
    time, perhaps with other units, changes nothing in it."""
    parts = os.path.join(toolchain.build, "impl")
    with contextlib.ExitStack() as stack:
        try:
            os.makedirs(parts, exist_ok=True)
            folder = stack.enter_context(temporary_folder("drivers-", parts))
        except OSError as error:
            raise cannot_write(parts, error) from error
        yield folder


class Drivers:
    """Drivers with the units of one folder, linked in a folder that no other process uses."""

    def __init__(self, toolchain, impl, folder, only=None):
        self._toolchain, self._impl, self._folder = toolchain, impl, folder
        self._all, self._only = read_features(toolchain.source), only
        stems = [only] if only else list(self._all)
        if not os.path.isdir(impl) and not only:
            name = os.path.splitext(os.path.basename(impl))[0]
            stems = [name] if name in self._all else stems
        check_impl(self._all, impl, stems)
        own = {stem: find_unit(self._all[stem], impl) for stem in stems}
        self._own = {stem: unit for stem, unit in own.items() if unit.path}
        for unit in self._own.values():
            unit.shown = unit.path
        self._beside = {stem: unit_beside(feature, impl, toolchain.handed_out)
                        for stem, feature in self._all.items()}
        self.features = [self._all[only]] if only else list(self._all.values())
        self._objects, self._unmade = {}, {}
        self._compile()

    def _told(self, error, in_full=True):
        """Shows why a driver cannot be made, and returns it for the page."""
        details = error.details.strip() if in_full else ""
        reason = build.without_what_is_shown(error.reason, details)
        print(f"{details}\ndrivers: {reason}".strip(), file=sys.stderr)
        return error.reason

    def _compile(self):
        for unit in [*self._own.values(), *self._beside.values()]:
            key = unit.feature.stem, unit.is_reference
            if key in self._objects or key in self._unmade:
                continue
            try:
                self._objects[key] = _object(self._toolchain, unit, self._folder)
            except build.BuildError as error:
                self._unmade[key] = self._told(error, self._only in (None, unit.feature.stem))
        # A unit that cannot be built costs its own driver only.
        for stem, unit in self._beside.items():
            if (stem, False) in self._unmade and not unit.is_reference:
                self._beside[stem] = reference_unit(self._all[stem])
                self._objects[stem, True] = _object(self._toolchain, self._beside[stem], self._folder)

    def sentence(self):
        """Names the units' authors, for captions."""
        return _sentence([self._own.get(stem, self._beside[stem]) for stem in self._all], self._impl)

    def link(self, feature):
        """Links the feature's driver and returns (its path in the folder, ""), or (None, why not)."""
        units = list({**self._beside, feature.stem: self._own.get(feature.stem,
                                                                  self._beside[feature.stem])}.values())
        keys = [(unit.feature.stem, unit.is_reference) for unit in units]
        reason = next((self._unmade[key] for key in keys if key in self._unmade), None)
        if reason:
            return None, reason
        says = _object_that_says(self._toolchain, units, self._impl, self._folder)
        path = os.path.join(self._folder, feature.stem)
        try:
            build.link(self._toolchain, path, [
                *_objects_of_driver(self._toolchain, feature), says, *(self._objects[key] for key in keys),
                self._toolchain.built("librkstages.a"), self._toolchain.built("librkbase.a"),
                *self._toolchain.libraries], self._folder)
        except build.BuildError as error:
            return None, self._told(error)
        return path, ""

    def publish(self, feature, path, reason):
        """Puts the driver, or a script that fails, where users find it, in one step."""
        driver = os.path.join(self._toolchain.build, driver_of(feature))
        os.makedirs(os.path.dirname(driver), exist_ok=True)
        if path:
            copied = path + ".published"
            shutil.copy(path, copied)
            os.replace(copied, driver)
            with contextlib.suppress(FileNotFoundError):
                os.unlink(driver + ".unmade")
            return
        write_whole(driver + ".unmade", reason + "\n")
        script = os.path.join(self._folder, feature.stem + ".sh")
        write_whole(script, "#!/bin/sh\nexit 1\n")
        os.chmod(script, 0o755)
        os.replace(script, driver)


def made_driver(toolchain, impl, feature, stack):
    """Returns a driver, one with student's units until the stack is closed, and the name by which users run
    it."""
    if not impl:
        path = os.path.join("assignments", feature.folder, feature.stem)
        return os.path.join(toolchain.build, path), path
    folder = stack.enter_context(private_folder(toolchain))
    drivers = Drivers(toolchain, impl, folder, feature.stem)
    if not drivers.sentence():
        print(f"{impl} has no {feature.stem}.c: drawn by the kit's own units")
    driver, reason = drivers.link(feature)
    drivers.publish(feature, driver, reason)
    if not driver:
        raise ToolError("there is no driver, for the reason above")
    return driver, driver_of(feature)


def link_drivers(toolchain, impl, only=None):
    """Makes impl/assignments/FOLDER/STEM for all features, or only for one; returns the sentence for
    captions."""
    with private_folder(toolchain) as folder:
        drivers = Drivers(toolchain, impl, folder, only)
        for feature in drivers.features:
            drivers.publish(feature, *drivers.link(feature))
        write_whole(os.path.join(toolchain.build, "impl", "units"), drivers.sentence() + "\n")
        return drivers.sentence()


def _make_one(toolchain, impl, stem, folder):
    """Makes one driver, published and in the folder; prints how to run it. Returns whether it could."""
    drivers = Drivers(toolchain, impl, folder, stem)
    feature = drivers.features[0]
    path, reason = drivers.link(feature)
    drivers.publish(feature, path, reason)
    if path:
        units = f"; {_authors(drivers.sentence())}" if drivers.sentence() else ""
        print(f"run {driver_of(feature)} (--help lists its options){units}")
    return bool(path)


def _work(arguments):
    """Returns whether the only driver is missing."""
    toolchain = build.Toolchain(arguments.build)
    if not arguments.only:
        print(f"report: {link_drivers(toolchain, arguments.impl)}", file=sys.stderr)
        return False
    folder = contextlib.nullcontext(arguments.into) if arguments.into else private_folder(toolchain)
    with folder as place:
        return not _make_one(toolchain, arguments.impl, arguments.only, place)


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--only", metavar="STEM", help="make only this driver, and print its path")
    parser.add_argument("--into", metavar="DIR", help="with --only: keep it there, too, with its objects")
    arguments = parser.parse_args()
    return run_command("drivers", lambda: _work(arguments))


if __name__ == "__main__":
    sys.exit(main())
