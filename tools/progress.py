#!/usr/bin/env python3
"""Shows which assignments pass, with points. Verdicts are kept in impl/progress of the build folder, so that
only what has changed since is tested again.

This is for a student's own eyes: grading never reads what is kept."""

import hashlib
import json
import os
import sys

import grade
from grading import results
from grading.assignments import (
    Parser, UnitError, choose, find_unit, read_features, run_command, submitted_unit, unit_beside,
    units_of_suite,
)
from grading.build import Toolchain
from grading.private_copy import own_headers


def _content(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def _kit_state(toolchain):
    """What all verdicts depend on."""
    tools = os.path.dirname(os.path.abspath(__file__))
    names = [os.path.join(where, name) for where, _, files in os.walk(tools) for name in sorted(files)
             if name.endswith(".py")]
    names += [toolchain.built(name) for name in ("impl/toolchain", "librkbase.a", "librktest.a")]
    return [_content(name) for name in names] + [str(grade.seconds_per_test())]


def _headers(impl):
    """The student's own headers, which any unit may include."""
    folder = impl if os.path.isdir(impl) else os.path.dirname(impl) or "."
    return [name for where, folders, files in os.walk(folder) for name in
            sorted(os.path.join(where, file) for file in files if file.endswith(".h"))]


def key_of(toolchain, features, feature, impl, common):
    """Returns a hash of everything that decides about a feature's verdicts, or None without a unit."""
    try:
        submitted_unit(feature, impl)
    except UnitError:
        return None
    beside = {stem: unit_beside(features[stem], impl, toolchain.handed_out)
              for stem in feature.needs + feature.uses}
    units = [find_unit(feature, impl), *units_of_suite(feature, beside)]
    names = [unit.path for unit in units] + [feature.points_table, feature.header]
    names += [toolchain.built(f"tests/test_{feature.stem}.o")] + [
        toolchain.built(f"src/features/{unit.feature.stem}.o") for unit in units]
    words = [*common, os.path.abspath(units[0].path), *map(_content, names)]
    return hashlib.sha256("\n".join(words).encode("utf-8", "surrogateescape")).hexdigest()


class Kept:
    """The verdicts of one feature in impl/progress/STEM.json."""

    def __init__(self, toolchain, stem, key):
        self._path, self._key = os.path.join(toolchain.build, "impl", "progress", stem + ".json"), key

    def read_into(self, suite):
        """Gives the suite its verdicts; none if there are none for this state."""
        try:
            with open(self._path, encoding="utf-8") as file:
                kept = json.load(file)
            if self._key and kept["key"] == self._key:
                suite.take(kept["judged"])
        except (OSError, ValueError, KeyError, TypeError):
            suite.verdicts = {}

    def write(self, suite):
        """Keeps what would be the same next time: no verdict of a test that ran out of time."""
        if not self._key or suite.problem or any(verdict.timed_out for verdict in suite.verdicts.values()):
            return
        os.makedirs(os.path.dirname(self._path), exist_ok=True)
        results.write_whole(self._path, json.dumps({"key": self._key, "judged": suite.judged()}) + "\n")


def progress_of(build, stems, impl, show=None):
    """Returns a Suite for each feature, and the stems that were tested again."""
    toolchain = Toolchain(build)
    features = read_features(toolchain.source)
    suites = grade.prepare_suites(features, choose(features, stems), impl, True)
    common = _kit_state(toolchain) + [_content(name) for name in _headers(impl)]
    kept = {suite.feature.stem: Kept(toolchain, suite.feature.stem,
                                     key_of(toolchain, features, suite.feature, impl, common))
            for suite in suites}
    for suite in suites:
        if not suite.problem:
            kept[suite.feature.stem].read_into(suite)
    due = [suite.feature.stem for suite in suites if not suite.verdicts]
    if due:
        tested = {suite.feature.stem: suite
                  for suite in grade.grade_impl(build, due, impl, True, progress=show)[1]}
        for stem, suite in tested.items():
            kept[stem].write(suite)
        suites = [tested.get(suite.feature.stem, suite) for suite in suites]
    return suites, due


def hand_in(units):
    """Returns the line about what to hand in: these units, with the headers beside them that they include."""
    files = [unit.path for unit in units]
    for unit in units:
        headers = [os.path.join(os.path.dirname(unit.path), name) for name in own_headers(unit)]
        files += [path for path in headers if path not in files]
    named = " and ".join(filter(None, [", ".join(files[:-1]), files[-1]]))
    return f"hand in {named}, nothing else"


def _show(arguments):
    show = grade.show_progress if sys.stderr.isatty() else grade.tell_progress
    suites, _ = progress_of(arguments.build, arguments.stems, arguments.impl, show)
    results.write(suites, "table", arguments.impl)
    if all(suite.passed() and not suite.unit.is_reference for suite in suites):
        print(hand_in([find_unit(suite.feature, arguments.impl) for suite in suites]))


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    arguments = parser.parse_args()
    grade.stop_on_signals()
    return run_command("progress", lambda: _show(arguments), 2)


if __name__ == "__main__":
    sys.exit(main())
