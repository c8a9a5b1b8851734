#!/usr/bin/env python3
"""Prints docs/speed.md with its tables made anew: `make speed-page`.

They come from the last `make bench` and `make bench-peers` in this build, and stand between the
lines <!-- speed --> and <!-- speed end -->. Without these measurements nothing is printed, and the
exit status is 1.
"""

import argparse
import csv
import os
import re
import sys

WORKLOADS = ("primary", "point-shadow", "area-shadow", "diffuse", "build")


def rows_of(path, command):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    except OSError:
        sys.exit(f"speed-page: {path} is missing: run {command} first")


def table(head, rows):
    lines = [head, ["---"] + ["--:"] * (len(head) - 1)] + rows
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def duration(text):
    """Milliseconds with three digits at most, from a second on as seconds."""
    if not text:
        return ""
    ms = float(text)
    return f"{ms:.3g} ms" if ms < 1000 else f"{float(f'{ms / 1000:.3g}'):g} s"


def frames(rows):
    """A line for each picture."""
    pictures = {}
    for row in rows:
        picture = pictures.setdefault(row["title"], {"threads": {}, "goal": "", "classic": ""})
        picture["threads"][row["threads"]] = duration(row["median_ms"])
        if row["goal_ms"]:
            picture["goal"] = f"{duration(row['goal_ms'])} on {row['threads']}"
            picture["classic"] = duration(row["classic_ms"])
    lines = [[title, p["threads"].get("1", ""), p["threads"].get("2", ""), p["goal"], p["classic"]]
             for title, p in pictures.items()]
    return table(["800 × 800 pixels", "1 thread", "2 threads", "goal", "classic program"], lines)


def peers(rows):
    """A line for each scene; a ratio beside Embree's fastest mode, and beside its fastest robust one."""
    scenes, goals = {}, {}
    for row in rows:
        if row["threads"] == "1":
            goals[row["workload"]] = row["goal"]
            ratios = f"{float(row['speed_ratio']):.2f} ({float(row['robust_speed_ratio']):.2f})"
            scenes.setdefault((row["scene"], int(row["triangles"])), {})[row["workload"]] = ratios
    lines = [[f"{scene.split(':')[0]}, {triangles:,} triangles"] + [ratios.get(workload, "")
                                                                    for workload in WORKLOADS]
             for (scene, triangles), ratios in scenes.items()]
    lines.append(["goal"] + [goals.get(workload, "") for workload in WORKLOADS])
    return table(["times as fast as Embree, 1 thread", "camera rays", "shadow rays, point",
                  "shadow rays, area", "diffuse rays", "building"], lines)


def section(build):
    timings = os.path.join(build, "bench", "tables")
    machine = {row["item"]: row["value"]
               for row in rows_of(os.path.join(timings, "timings_machine.csv"), "make bench")}
    return (f"Measured on: {machine['processor']}, {machine['instruction set']}. Medians. "
            "Above 1, a ratio says that raykit is faster than Embree's fastest mode for these rays; "
            "in brackets, than its fastest robust one, whose triangle test leaves hardly any gaps.\n\n"
            + frames(rows_of(os.path.join(timings, "frames.csv"), "make bench")) + "\n"
            + peers(rows_of(os.path.join(build, "reports", "out", "tables", "peers_best.csv"),
                            "make bench-peers")))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", default=".", help="the folder of the build")
    parser.add_argument("page", help="docs/speed.md")
    options = parser.parse_args()
    with open(options.page, encoding="utf-8") as file:
        text = file.read()
    made = section(options.build)
    text, count = re.subn(r"(?s)(<!-- speed[^\n]*-->\n).*?(<!-- speed end -->)",
                          lambda found: found[1] + made + found[2], text)
    if count != 1:
        sys.exit("speed-page: docs/speed.md has no lines <!-- speed --> and <!-- speed end -->")
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
