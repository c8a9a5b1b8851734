"""Start-up: how long a driver takes for one pixel of each built-in scene, from its start to its end, by the
wall clock: tests/bench/startup.tsv has the scenes, with their drivers and goals. It makes the scene and its
tree, and writes the picture."""

import os
import statistics
import tempfile
import time

from benchmark import timings
from grading.assignments import ToolError, read_table

COLUMNS = ["scene", "driver", "goal_ms"]
OPTIONS = "--width 1 --height 1 --quiet"
RUNS, QUICK_RUNS = 9, 3


def read_scenes(folder):
    path = os.path.join(folder, "startup.tsv")
    scenes = []
    for number, (scene, driver, goal) in enumerate(read_table(path, COLUMNS), 2):
        try:
            scenes.append((scene, driver, float(goal)))
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


def _row(scene, driver, goal, times):
    median = statistics.median(times)
    return {"scene": scene, "driver": driver, "median_ms": median, "min_ms": min(times), "max_ms": max(times),
            "runs": len(times), "goal_ms": goal, "goal_reached": "yes" if median <= goal else "no"}


def measure(program_of, folder, quick):
    """Rows of startup.csv; `program_of` returns a driver's path."""
    runs = QUICK_RUNS if quick else RUNS
    with tempfile.TemporaryDirectory() as out:
        return [_row(scene, driver, goal, _times(program_of(driver), scene, runs, out))
                for scene, driver, goal in read_scenes(folder)]
