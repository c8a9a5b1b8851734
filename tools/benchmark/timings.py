"""Times of whole pictures, by the drivers' --timing, one call of a driver after the other. A call becomes a
row of timings.csv in the bench folder; what is there is not measured again."""

import csv
import glob
import os
import resource
import subprocess
import sys
import tempfile
import time

from benchmark.measurements import Kept, write_table
from benchmark.schedule import digest, processor
from grading.assignments import ToolError

KEY = ("program", "driver", "options", "threads")
SPANS = ("build", "render")  # milliseconds: the median, and the least and the largest of the runs
COUNTS = ("bytes_per_triangle",)
FIGURES = tuple(f"{span}_{part}" for span in SPANS for part in ("median", "min", "max")) + COUNTS
COST = ("seconds", "processor_seconds", "peak_mib")  # of the whole process
COLUMNS = KEY + ("isa", "runs", "date") + FIGURES + COST
SAID_EVERY = 5  # seconds
TRUSTED = 10  # seconds: guesses count as much as measurements of so long


def _number(cell):
    return float(cell) if cell else ""


KINDS = {**dict.fromkeys(FIGURES, _number), **dict.fromkeys(COST, float), "peak_mib": _number,
         "threads": int, "runs": int}


class Call:
    """A driver with options. `seconds` is a guess, from which the time that is left is estimated."""

    def __init__(self, driver, options, threads, runs, seconds):
        self.driver, self.options, self.threads = driver, options, threads
        self.runs, self.seconds = runs, seconds


def _figures(path):
    """A driver's timing rows as cells; its metric "render", whatever else is in the name."""
    rows = []
    if os.path.exists(path):
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    if not any(row["metric"].startswith("render") for row in rows):
        raise ToolError(f"{os.path.basename(path)[:-4]}: --timing gave no time to render; "
                        "name another driver in tests/bench/frames.tsv")
    found = {"isa": rows[0]["isa"]}
    for row in rows:
        name = "render" if row["metric"].startswith("render") else row["metric"]
        if name in SPANS and row["unit"] == "ms":
            found.update({f"{name}_{part}": float(row[part]) for part in ("median", "min", "max")})
        elif name in COUNTS:
            found[name] = float(row["median"])
    return found


def run(command, folder):
    """Returns the processor time and the largest memory of a process; ends it when it is interrupted. A
    process begins as a copy of this one, so that its memory is unknown where it is smaller."""
    process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True, errors="replace")
    try:
        said = process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
    except BaseException:
        process.kill()
        process.wait()
        raise
    finally:
        process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        ended = f"it ended with status {process.returncode}"
        raise ToolError(f"{' '.join(command)}: {said.strip() or ended}")
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024 if usage.ru_maxrss > own else ""


class Timings(Kept):
    def __init__(self, build, reset=False):
        self._build, self._folder, self._programs = os.path.abspath(build), os.path.join(build, "bench"), {}
        super().__init__(os.path.join(self._folder, "timings.csv"), COLUMNS, KEY, KINDS, reset)

    def take_over(self, rows):
        super().take_over([row for row in rows if row["program"] == self._find(row["driver"])[1]])

    def _find(self, driver):
        """A driver's path and checksum; (None, None) without such a driver."""
        if driver not in self._programs:
            found = glob.glob(os.path.join(glob.escape(self._build), "assignments", "*_" + driver, driver))
            self._programs[driver] = (found[0], digest(found[0])) if found else (None, None)
        return self._programs[driver]

    def program(self, driver):
        """A driver's path and checksum."""
        if not self._find(driver)[0]:
            raise ToolError(f"there is no driver {driver}: "
                            "run make, or name another one in tests/bench/frames.tsv")
        return self._find(driver)

    def _key(self, call):
        return self.program(call.driver)[1], call.driver, call.options, call.threads

    def row(self, call, runs=1):
        """What is known of a call by at least so many runs, or None."""
        row = self.rows.get(self._key(call))
        return row if row and row["runs"] >= runs else None

    def _measure(self, call):
        start = time.monotonic()
        with tempfile.TemporaryDirectory(dir=os.path.abspath(self._folder)) as out:
            words = ["--threads", str(call.threads), "--runs", str(call.runs), "--timing", "--quiet", "--out",
                     out]
            processor, peak = run([self.program(call.driver)[0], *call.options.split(), *words], self._folder)
            figures = _figures(os.path.join(out, "tables", call.driver + ".csv"))
        cost = (time.monotonic() - start, processor, peak)
        self.add({**dict.fromkeys(FIGURES, ""), **dict(zip(KEY, self._key(call))), **figures,
                  **dict(zip(COST, cost)), "runs": call.runs,
                  "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())})

    def measure(self, part, calls):
        """All that is missing of a part, such as "frames"."""
        missing = [call for call in calls if not self.row(call, call.runs)]
        guessed, began, said = 0.0, time.monotonic(), -SAID_EVERY
        for i, call in enumerate(missing):
            spent = time.monotonic() - began
            if spent - said >= SAID_EVERY:
                said = spent
                pace = (TRUSTED + spent) / (TRUSTED + guessed)
                left = pace * sum(waiting.seconds for waiting in missing[i:])
                print(f"bench: {call.driver} {call.options}; about {max(left, 1):.0f} s left for {part}",
                      file=sys.stderr, flush=True)
            self._measure(call)
            guessed += call.seconds


def machine_rows(rows):
    """How busy was the machine? A single thread's time that is not its processor time it has waited."""
    alone = [row for row in rows if row["threads"] == 1]
    waited = 1 - sum(row["processor_seconds"] for row in alone) / sum(row["seconds"]
                                                                      for row in alone) if alone else 0
    about = {"processor": f"{processor() or 'unknown'}, {os.cpu_count() or 1} processors",
             "instruction set": ", ".join(sorted({row["isa"] for row in rows})),
             "measured": " to ".join(sorted({min(row["date"] for row in rows),
                                             max(row["date"] for row in rows)})),
             "waited": f"{100 * max(waited, 0):.1f} % of the time of single threads"}
    return [{"item": item, "value": value} for item, value in about.items()]


def write(folder, name, rows):
    """A table of rows with the same columns; without rows there is none."""
    path = os.path.join(folder, name + ".csv")
    if rows:
        write_table(path, list(rows[0]),
                    [[f"{cell:.6g}" if isinstance(cell, float) else cell for cell in row.values()]
                                          for row in rows])
    elif os.path.exists(path):
        os.remove(path)
