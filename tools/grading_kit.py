#!/usr/bin/env python3
"""Packs what grading needs into one tar, for machines that do not build the kit: headers, suites and judges
as they were built here, the grader, the tables of points. It has the references, so it is the instructor's
alone.

There, tools/grade_one.py grades with --build build; C compiler, libraries of suites, bubblewrap and Python
have to be there, of the same versions."""

import io
import os
import sys
import tarfile

from grading import private_copy
from grading.assignments import Parser, ToolError, cannot_write, choose, read_features, run_command
from grading.build import Toolchain

_TABLES = ("features.tsv", "points.tsv")


def _files(toolchain, features, stems):
    """Yields what is packed: a path, and where it stands in the tar."""
    for path, place in private_copy.files_of_kit(toolchain, features, stems):
        top, _, below = place.partition(os.sep)
        yield path, os.path.join("build", below) if top == "objects" else below
    for room in ("tools", "assignments"):
        for where, _, names in os.walk(os.path.join(toolchain.source, room)):
            for name in names:
                if name in _TABLES or room == "tools" and name.endswith(".py"):
                    path = os.path.join(where, name)
                    yield path, os.path.relpath(path, toolchain.source)
    for feature in features.values():
        for path in (feature.reference, feature.header):
            yield path, os.path.relpath(path, feature.source)


def _settings(toolchain):
    """Returns impl/toolchain as it is right wherever the tar is unpacked."""
    path = toolchain.built(os.path.join("impl", "toolchain"))
    with open(path, encoding="utf-8") as file:
        lines = ["source=..\n" if line.startswith("source=") else line for line in file]
    return "".join(lines).encode()


def pack(build, stems, out):
    """Writes the tar."""
    if not out.endswith(".tar.gz"):
        raise ToolError(f"OUT: {out} should end in .tar.gz" if out else
                        "say where the kit goes: OUT=kit.tar.gz")
    toolchain = Toolchain(build)
    toolchain.judges = True
    features = read_features(toolchain.source)
    stems = [feature.stem for feature in choose(features, stems)]
    part = out + ".part"
    try:
        with tarfile.open(part, "w:gz") as archive:
            for path, place in sorted(set(_files(toolchain, features, stems)), key=lambda pair: pair[1]):
                archive.add(path, os.path.join("raykit-grading", place))
            settings = _settings(toolchain)
            entry = tarfile.TarInfo("raykit-grading/build/impl/toolchain")
            entry.size = len(settings)
            archive.addfile(entry, io.BytesIO(settings))
        os.replace(part, out)
    except OSError as error:
        raise cannot_write(out, error) from error
    finally:
        if os.path.exists(part):
            os.unlink(part)
    count = "1 assignment" if len(stems) == 1 else f"{len(stems)} assignments"
    print(f"wrote {out}, which grades {count}; it holds the solutions. Unpacked:\n"
          f"  python3 tools/grade_one.py {' '.join(stems)} --build build --submission PATH --out results")


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    parser.add_argument("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    parser.add_argument("--out", required=True, metavar="FILE", help="the tar, .tar.gz")
    arguments = parser.parse_args()
    return run_command("grading-kit", lambda: pack(arguments.build, arguments.stems, arguments.out), 2)


if __name__ == "__main__":
    sys.exit(main())
