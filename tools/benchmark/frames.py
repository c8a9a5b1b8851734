"""Whole pictures on one thread and on two, beside goals and the classic course's program:
tests/bench/frames.tsv.

Its columns: a short name, a title, the driver and its options; the number of threads for which goal and
classic time, in milliseconds, are meant; and how many times as fast two threads should be as one, where this
is set."""

import os

from benchmark.timings import Call
from grading.assignments import ToolError, read_table

COLUMNS = ["frame", "title", "driver", "options", "threads", "goal_ms", "classic_ms", "speedup"]
THREADS = (1, 2)
RUNS, FEW_RUNS, SLOW = 5, 3, 500  # a frame whose goal is so many milliseconds of processor time has few runs
USUAL = 100  # milliseconds of a frame without a goal; a guess


def read_frames(folder):
    path = os.path.join(folder, "frames.tsv")
    frames = []
    for number, row in enumerate(read_table(path, COLUMNS), 2):
        frame = dict(zip(COLUMNS, row))
        try:
            frame["threads"] = int(frame["threads"])
            for name in ("goal_ms", "classic_ms", "speedup"):
                frame[name] = float(frame[name]) if frame[name] else None
        except ValueError as error:
            raise ToolError(f"{path}:{number}: {error}") from None
        if frame["threads"] not in THREADS:
            raise ToolError(f"{path}:{number}: frames are measured on 1 and 2 threads, "
                            f"not {frame['threads']}")
        frames.append(frame)
    return frames


def _call(frame, threads, quick):
    work = (frame["goal_ms"] or USUAL) * frame["threads"]
    runs = 1 if quick else FEW_RUNS if work >= SLOW else RUNS
    return Call(frame["driver"], frame["options"], threads, runs, 0.3 + runs * work / threads / 1000)


def calls(folder, quick):
    """A quick measurement has the threads for which the goals are meant."""
    return [_call(frame, threads, quick) for frame in read_frames(folder)
            for threads in ((frame["threads"],) if quick else THREADS)]


def _yes(is_so):
    return "yes" if is_so else "no"


def _row(frame, threads, measured, alone):
    """Goal and classic time stand in the row of the threads for which they are meant."""
    median, meant = measured["render_median"], threads == frame["threads"]
    goal, classic = (frame[name] if meant else None for name in ("goal_ms", "classic_ms"))
    speedup = alone["render_median"] / median if alone and threads > 1 else None
    wanted = frame["speedup"] if speedup else None
    return {
        "frame": frame["frame"], "title": frame["title"], "driver": frame["driver"],
        "options": frame["options"],
        "threads": threads, "median_ms": median, "min_ms": measured["render_min"],
        "max_ms": measured["render_max"],
        "runs": measured["runs"], "goal_ms": goal or "", "of_goal": median / goal if goal else "",
        "goal_reached": _yes(median <= goal) if goal else "", "classic_ms": classic or "",
        "times_as_fast": classic / median if classic else "", "speedup": speedup or "",
        "speedup_goal": wanted or "",
        "speedup_reached": _yes(speedup >= wanted) if wanted else "",
    }


def rows(folder, timings):
    """Of frames.csv, as far as they are measured."""
    found = []
    for frame in read_frames(folder):
        measured = {threads: timings.row(_call(frame, threads, quick=True)) for threads in THREADS}
        found += [_row(frame, threads, row, measured[1]) for threads, row in measured.items() if row]
    return found


def goal_rows(of_frames):
    """Of frames_goals.csv, whose bars the report shows: how much of the goal's time was taken."""
    return [{"frame": row["frame"], "threads": row["threads"], "what": "time over goal",
             "of_goal": row["of_goal"]}
            for row in of_frames if row["of_goal"] != ""]
