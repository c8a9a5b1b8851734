"""Start-up: how long a driver takes for one pixel of each built-in scene, from its start to its end, by the wall clock:
tests/bench/startup.tsv has the scenes, with their goals. It makes the scene and its tree, and writes the picture."""

import os
import statistics
import tempfile
import time

from benchmark import timings
from grading.assignments import ToolError, read_table

COLUMNS = ["scene", "goal_ms"]
DRIVER, OPTIONS = "wide_bvh", "--width 1 --height 1 --quiet"
RUNS, QUICK_RUNS = 9, 3


def read_scenes(folder):
    path = os.path.join(folder, "startup.tsv")
    scenes = []
    for number, (scene, goal) in enumerate(read_table(path, COLUMNS), 2):
        try:
            scenes.append((scene, float(goal)))
        except ValueError:
            raise ToolError(f"{path}:{number}: {goal} is no number of milliseconds") from None
    return scenes


def _times(program, scene, runs, out):
    """Milliseconds of each run; a first one, which reads the program from the disk, is left out."""
    times = []
    for _ in range(runs + 1):
        began = time.monotonic()
        timings.run([program, "--scene", scene, *OPTIONS.split(), "--out", out], out)
        times.append(1000 * (time.monotonic() - began))
    return times[1:]


def _row(scene, goal, times):
    median = statistics.median(times)
    return {"scene": scene, "median_ms": median, "min_ms": min(times), "max_ms": max(times), "runs": len(times),
            "goal_ms": goal, "goal_reached": "yes" if median <= goal else "no"}


def measure(program, folder, quick):
    """Rows of startup.csv."""
    with tempfile.TemporaryDirectory() as out:
        return [_row(scene, goal, _times(program, scene, QUICK_RUNS if quick else RUNS, out))
                for scene, goal in read_scenes(folder)]
