#!/usr/bin/env python3
"""Links the student's unit of each feature into a module of its own for live figures: impl/live/STEM.wasm in
the build folder. As in the drivers, all other units are the reference's. A unit that cannot be built has no
module; its driver, which is linked first, has told why."""

import os
import shlex
import subprocess
import sys

from grading import build
from grading.assignments import Parser, ToolError, check_impl, find_unit, read_features


def make_module(unit, folder):
    """Compiles and links one unit; returns whether that was possible."""
    stem, tools = unit.feature.stem, {name: shlex.split(os.environ[name])
                                      for name in ("LIVE_COMPILE", "LIVE_LINK", "LIVE_OBJECTS")}
    own, module = (os.path.join(folder, stem + end) for end in (".o", ".wasm"))
    objects = [own if path == f"live/src/features/{stem}.o" else path for path in tools["LIVE_OBJECTS"]]
    include = "-I" + os.path.dirname(os.path.abspath(unit.path))
    return all(subprocess.run(command, stderr=subprocess.PIPE).returncode == 0 for command in (
        [*tools["LIVE_COMPILE"], include, "-c", unit.path, "-o", own],
        [*tools["LIVE_LINK"], *objects, "-o", module]))


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    arguments = parser.parse_args()
    try:
        features = read_features(build.Toolchain(".").source)
        stems = list(features)
        if not os.path.isdir(arguments.impl):
            name = os.path.splitext(os.path.basename(arguments.impl))[0]
            stems = [name] if name in features else stems
        check_impl(features, arguments.impl, stems)
        folder = os.path.join("impl", "live")
        os.makedirs(folder, exist_ok=True)
        for old in os.listdir(folder):
            os.unlink(os.path.join(folder, old))
        for unit in (find_unit(features[stem], arguments.impl) for stem in stems):
            if unit.path and not make_module(unit, folder):
                print(f"live: {os.path.basename(unit.path)} is not in live figures: "
                      "it cannot be built for WebAssembly", file=sys.stderr)
    except ToolError as error:
        print(f"live: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
