#!/usr/bin/env python3
"""A unit, its chapter and its handout, in one order and in others. Speaks TAP, for make check-suites."""

import os
import pathlib
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.abspath(os.environ.get("srcdir", ".")), "tools"))

from grading.reading_order import find_faults  # noqa: E402
from tap import check, finish, start  # noqa: E402

UNIT = """#include <math.h>

typedef struct fog {
    float density;
} fog;

static float depth_of(float t);
static float faded(float x);

static float depth_of(float t)
{
    /* solution */
    return 2 * t;
    /* starter
    // First step: think.
    return 0;
    end */
}

static const float limit = sqrtf(2);

/* Not solved by students. */
static float faded(float x)
{
    return x < limit ? x : limit;
}

float fog_at(float t)
{
    /* solution */
    return faded(depth_of(t));
    /* starter
    // Second step: think twice. Third step: once more.
    return 0;
    end */
}
"""
CHAPTER = """# Fog
``` {.code file=src/features/fog.h name=fog}
``` {.code file=src/features/fog.c name="fog depth_of"}
``` {.code file=src/features/fog.c name=fog_at}
"""
HANDOUT = "| 1 | `depth_of` | `a` |\n| 2 | part of `fog_at` | `b` |\n| 3 | all of `fog_at` | `c` |\n"


def faults_of(unit=UNIT, chapter=CHAPTER, handout=HANDOUT):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in (("src/features/fog.c", unit), ("docs/11_fog.md", chapter),
                           ("assignments/11_fog/handout.md", handout)):
            (root / name).parent.mkdir(parents=True)
            (root / name).write_text(text, encoding="utf-8")
        return find_faults(root, "fog", "11_fog")


def is_told(faults, begins, parts, name):
    check(len(faults) == 1 and faults[0].startswith(begins) and all(part in faults[0] for part in parts),
          name, faults)


def contents_are_held():
    first, second = "static float depth_of(float t);\n", "static float faded(float x);\n"
    is_told(faults_of(UNIT.replace(second, "")), "src/features/fog.c:22: faded has no prototype",
            ["write it there"],
            "a static function without a prototype is told")
    is_told(faults_of(UNIT.replace(first + second, second + first)), "src/features/fog.c:8: ",
            ["depth_of below faded", "line 10"],
            "prototypes in another order are told")
    is_told(faults_of(UNIT.replace(second, "") + second), "src/features/fog.c:36: ",
            ["below the first definition"],
            "a prototype below definitions is told")
    is_told(faults_of(UNIT.replace(second, second + "static float gone(void);\n")),
            "src/features/fog.c:9: gone", ["remove"],
            "a prototype without a definition is told")


def orders_are_held():
    is_told(faults_of(chapter=CHAPTER.replace('"fog depth_of"', "fog_at")
                      .replace("name=fog_at}\n```",
                               "name=fog_at}\n``` {.code file=src/features/fog.c name=depth_of}\n```")),
            "docs/11_fog.md:4: depth_of is shown after fog_at", ["src/features/fog.c:10"],
            "a chapter in another order is told")
    turned = HANDOUT.replace("| 1 |", "| 4 |")
    told = faults_of(handout=turned)
    check(any(fault.startswith("src/features/fog.c:28: fog_at of step 3") and "depth_of of step 4" in fault
              for fault in told),
          "steps in another order are told", told)
    is_told(faults_of(handout=HANDOUT.replace("| 2 |", "| 3 |")), "src/features/fog.c:28: ",
            ["[2, 3]", "[3, 3]"],
            "a starter that names other steps is told")
    is_told(faults_of(handout=HANDOUT.replace("`depth_of`", "depth")), "src/features/fog.c:10: ",
            ["[1]", "[]"],
            "a function that no step names is told")


def main():
    check(not faults_of(), "one order has no faults", faults_of())
    contents_are_held()
    orders_are_held()
    return finish()


if __name__ == "__main__":
    start(main)
