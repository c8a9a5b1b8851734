#!/usr/bin/env python3
"""Packs what Gradescope grades by, `make autograder`: a zip of the kit and of the two scripts that it runs
(tools/autograder).

The kit has the solutions, so the zip is the instructor's alone.
"""

import os
import shutil
import sys
import tarfile
import tempfile
import zipfile

from grading.assignments import Parser, ToolError, cannot_write, choose, read_features
from handout import copy_release

_SCRIPTS = ("setup.sh", "run_autograder")


def _add(archive, name, text, mode):
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (0o100000 | mode) << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, text)


def pack(source, stems, out):
    """Writes the zip; the files stand at its top, as Gradescope wants them."""
    features = read_features(source)
    if not stems:
        raise ToolError("name the assignments: make autograder ASSIGNMENTS=\"...\", of: "
                        f"{' '.join(features)}")
    chosen = [feature.stem for feature in choose(features, stems)]
    if not out.endswith(".zip"):
        raise ToolError(f"OUT: {out} should end in .zip")
    if os.path.lexists(out):
        raise ToolError(f"{out} exists; remove it, or choose another name by OUT=...")
    work = tempfile.mkdtemp(prefix=".autograder-", dir=os.path.dirname(os.path.abspath(out)))
    try:
        copy_release(source, os.path.join(work, "kit"))
        # Gradescope's zip need not keep which files can be run.
        with tarfile.open(os.path.join(work, "kit.tar.gz"), "w:gz") as archive:
            archive.add(os.path.join(work, "kit"), "kit")
        with zipfile.ZipFile(os.path.join(work, "whole.zip"), "w") as archive:
            for name in _SCRIPTS:
                with open(os.path.join(source, "tools", "autograder", name), encoding="utf-8") as script:
                    _add(archive, name, script.read(), 0o755)
            _add(archive, "assignments", " ".join(chosen) + "\n", 0o644)
            archive.write(os.path.join(work, "kit.tar.gz"), "kit.tar.gz")
        os.rename(os.path.join(work, "whole.zip"), out)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return chosen


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features to grade")
    parser.add_argument("--source", required=True, metavar="DIR", help="raykit's source folder")
    parser.add_argument("--out", default="", metavar="FILE", help="the zip")
    arguments = parser.parse_args()
    out = os.path.normpath(arguments.out or "autograder.zip")
    try:
        chosen = pack(arguments.source, arguments.stems, out)
    except ToolError as error:
        print(f"autograder: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"autograder: {cannot_write(out, error)}", file=sys.stderr)
        return 1
    print(f"wrote {out}, which grades {', '.join(chosen)}; it holds the solutions, so give it to Gradescope "
          "only")
    return 0


if __name__ == "__main__":
    sys.exit(main())
