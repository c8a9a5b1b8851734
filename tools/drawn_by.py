#!/usr/bin/env python3
"""Prints a digest of all that draws and measures for the book: the programs of this build, the mistakes that it shows,
what make bench has measured, and how often programs run. A book with the same digest has the same figures and numbers,
and another edition need not draw them anew."""

import hashlib
import os

from grading.assignments import Parser, read_features
from wrong import mutants_of, wrong_table

BOOK = "docs/out"  # of the build folder; the file drawn_by in it has its digest


def drawn_by(features, build="."):
    """Returns the digest. QUICK and GNUPLOT, in the environment, count."""
    digest = hashlib.sha256(repr([os.environ.get(name, "") for name in ("QUICK", "GNUPLOT")]).encode())
    programs = [f"assignments/{feature.folder}/{feature.stem}" for feature in features]
    made = [os.path.join(build, path) for path in [*programs, "raykit-mesh", "raykit-image", "bench/measurements.csv"]]
    for path in [*made, *(path for feature in features for path in (wrong_table(feature), mutants_of(feature)))]:
        digest.update(os.path.basename(path).encode())
        if os.path.exists(path):
            with open(path, "rb") as file:
                digest.update(file.read())
    return digest.hexdigest()


def is_drawn_by(folder, digest):
    """Does a folder have figures with this digest?"""
    try:
        with open(os.path.join(folder, "drawn_by"), encoding="utf-8") as file:
            return file.read().strip() == digest
    except OSError:
        return False


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("--source", required=True, help="the folder of the kit")
    parser.add_argument("--build", default=".", help="the build folder")
    arguments = parser.parse_args()
    print(drawn_by(read_features(arguments.source).values(), arguments.build))


if __name__ == "__main__":
    main()
