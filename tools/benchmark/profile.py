"""Where the time of each frame of tests/bench/frames.tsv goes: the functions with the largest shares of the
processor time, on one thread, as perf finds them. Without perf, or where it may not look, there is no
profile."""

import os
import re
import shutil
import subprocess
import tempfile

LASTING = 2000  # milliseconds of all pictures of a frame
FEWEST_RUNS, MOST_RUNS = 3, 60
RATE = 997  # samples per second; a prime, so that no loop keeps step with it
SMALL = "--width 8 --height 8"  # options of a picture that takes no time: the rest makes scene and tree
SHOWN, LEAST = 6, 0.02  # functions, and parts of the time


def counts_of(report):
    """Samples of each function, by lines of perf report; parts that the compiler split off count for their
    function."""
    counts = {}
    for line in report.splitlines():
        found = re.match(r"\s*(\d+)\s+\[.\]\s+(\S+)", line)
        if found:
            name = re.sub(r"\.(constprop|isra|part|cold)\b.*", "", found[2])
            counts[name] = counts.get(name, 0) + int(found[1])
    return counts


def text_of(counts, without):
    """The largest shares, once the samples of another program are subtracted; empty without samples."""
    left = {name: count - without.get(name, 0) for name, count in counts.items()}
    total = sum(max(count, 0) for count in left.values())
    largest = sorted(left.items(), key=lambda item: -item[1])[:SHOWN]
    return ", ".join(f"{name} {100 * count / total:.0f} %" for name, count in largest if total > 0
                     and count >= LEAST * total)


def _counts(program, options, runs):
    with tempfile.TemporaryDirectory() as out:
        data = os.path.join(out, "perf.data")
        command = [program, *options.split(), "--threads", "1", "--runs", str(runs), "--timing", "--quiet",
                   "--out", out]
        quiet = {"stdin": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "check": False}
        if subprocess.run(["perf", "record", "-q", "-e", "cpu-clock:u", "-F", str(RATE), "-o", data,
                           *command],
                          stdout=subprocess.DEVNULL, **quiet).returncode:
            return {}
        report = subprocess.run(["perf", "report", "-i", data, "--stdio", "--no-children", "-F",
                                 "sample,sym"],
                                stdout=subprocess.PIPE, text=True, **quiet)
        return counts_of(report.stdout)


def _runs(frame, quick):
    if quick:
        return FEWEST_RUNS
    lasting = (frame["goal_ms"] or LASTING) * frame["threads"]
    return int(min(max(LASTING / lasting, FEWEST_RUNS), MOST_RUNS))


def measure(program_of, frames, quick):
    """Rows of frames_profile.csv, or none."""
    rows = []
    for frame in frames if shutil.which("perf") else []:
        program, runs = program_of(frame["driver"]), _runs(frame, quick)
        text = text_of(_counts(program, frame["options"], runs),
                       _counts(program, f"{frame['options']} {SMALL}", runs))
        if not text:
            return []
        rows.append({"frame": frame["frame"], "title": frame["title"], "functions": text})
    return rows
