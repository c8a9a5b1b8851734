#!/usr/bin/env python3
"""Measures the error and the time of all methods: make bench. The cases are in tests/bench/cases.tsv, their
methods in methods.tsv beside it. Then whole pictures by the drivers, from frames.tsv, and how times and
memory grow. Measurements are kept in bench of the build folder, and only what is missing is measured; tables
are written to bench/tables.

With --out, as the report calls it: tables of errors into that folder, from the full measurement if it is
there, or if times are measured carefully (RAYKIT_MEASURED), else from the quick one."""

import math
import os
import shutil
import sys

sys.dont_write_bytecode = True  # the source folder may be read-only, and stays clean

from benchmark import (compare, exact, frames, growth, measurements, plan, profile, schedule, startup,
                       summary, timings)
from grading.assignments import Parser, ToolError

KEPT_PARTS = {"frames": frames, "growth": growth}  # of calls that are kept


def open_schedule(options, settings, names=()):
    folder = os.path.join(options.build, "bench")
    program = os.path.join(options.build, "tests", "bench", "bench")
    kept = measurements.Measurements(folder, schedule.digest(program), options.reset)
    options.reset = False  # once is enough
    tables = os.path.join(options.source, "tests", "bench")
    cases = plan.read_cases(tables, settings, schedule.kinds_of(os.path.abspath(program), folder), names)
    return schedule.Schedule(cases, settings, kept, os.path.abspath(program), folder)


def is_complete(work):
    """Is everything measured, so that running is a matter of references alone?"""
    return all(work.row(method, n, seed) for case in work.cases for method in case.methods
               for n in work.settings.counts() if work.wanted(method, n)
               for seed in range(1, work.settings.seeds + 1))


def print_cells(lines):
    widths = [max(map(len, column)) for column in zip(*lines)]
    for line in lines:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())


def print_summary(rows, quick):
    cells = [("feature", "best method", "time ratio", "goal", "slope", "its goal", "bias, %", "note")]
    for row in rows:
        ratio = "" if row["time_ratio"] is None else \
            f"{row['time_ratio']:.1f} ({row['time_ratio_low']:.1f} to {row['time_ratio_high']:.1f})"
        bias, low, high = (100 * row[name] for name in ("bias", "bias_low", "bias_high"))
        cells.append((row["feature"], row["best"], ratio, "" if row["goal"] is None else f"{row['goal']:g}",
                      "" if row["slope"] is None else f"{row['slope']:.2f}",
                      "" if row["slope_goal"] is None else f"{row['slope_goal']:g}",
                      f"{bias:+.3f} ({low:+.3f} to {high:+.3f})",
                      ", ".join(filter(None,
                                       [row["note"], "goal missed" if row["goal_reached"] == "no" else ""]))))
    print_cells(cells)
    print("In brackets: 95 % confidence intervals. "
          "Extrapolated: a time to an error of 1 % that lies beyond those measured.")
    if quick:
        print("Pictures are small and samples few: "
              "whether a goal is reached, the full measurement decides (make bench).")


def print_changes(old, rows):
    """Returns whether something got worse."""
    found = compare.changes(measurements.read(old), rows)
    if not found:
        raise ToolError(f"{old}: it has no method, size and seeds in common with this measurement")
    beyond = [change for change in found if change.beyond_noise]
    for change in sorted(beyond, key=lambda change: -change.factor):
        print(change.text())
    methods = {(change.case, change.method) for change in found}
    print(f"compared with {old}: {len(methods)} methods, {len(beyond)} changes beyond noise")
    return any(change.factor > 1 for change in beyond)


def check_references(work):
    for row in summary.reference_rows(work):
        if row["agree"] == "no":
            by = (f"differ by {row['difference']:.1f} standard errors"
                  if row["squares"] < summary.AGREE_SQUARED else
                  f"have pixels that differ by {math.sqrt(row['squares']):.1f} times their standard errors")
            raise ToolError(f"{row['feature']}: its two references {by}, so one method is biased: "
                            "compare their options in tests/bench/cases.tsv")


def write_tables(work, options):
    """Returns the summary. Trees and numbers belong to no case."""
    tables = os.path.join(options.build, "bench", "tables")
    if not options.cases:
        exact.measure(work.program, schedule.digest(work.program), work.folder, tables, work.settings.runs)
    return summary.write(work, tables)


def measure_accuracy(options, names):
    """Returns whether something got worse."""
    work = open_schedule(options, plan.QUICK if options.quick else plan.FULL, names)
    if options.compare:
        measurements.read(options.compare)  # a mistake is told before the work
    work.run()
    rows = write_tables(work, options)
    check_references(work)
    print_summary(rows, options.quick)
    print(f"bench: wrote {os.path.join(options.build, 'bench', 'tables')}/accuracy*.csv and {work.kept.path}")
    chosen = {case.name for case in work.cases}
    rows = [row for row in work.kept.rows.values() if row["case"] in chosen
            and row["size"] == str(work.settings.side)]
    return bool(options.compare) and print_changes(options.compare, rows)


def write_frames(tables, folder, kept):
    rows = frames.rows(folder, kept)
    timings.write(tables, "frames", rows)
    timings.write(tables, "frames_goals", frames.goal_rows(rows))
    print_cells([("frame", "threads", "ms", "goal", "classic")] + [
        (row["title"], *(f"{row[name]:.4g}" if row[name] else ""
                         for name in ("threads", "median_ms", "goal_ms", "classic_ms")))
        for row in rows])


def write_growth(tables, folder, kept):
    rows = growth.rows(folder, kept)
    points, slopes = growth.curve_rows(rows)
    timings.write(tables, "growth", rows)
    timings.write(tables, "growth_curves", points)
    timings.write(tables, "growth_slopes", slopes)
    timings.write(tables, "growth_goals", growth.goal_rows(rows))
    print_cells([("growth with", "of", "by", "slope")] + [
        (row["what"], row["quantity"], row["line"], f"{row['slope']:.2f}") for row in slopes])


def write_startup(tables, folder, kept, quick):
    rows = startup.measure(lambda driver: kept.program(driver)[0], folder, quick)
    timings.write(tables, "startup", rows)
    print_cells([("start-up with", "driver", "ms", "goal")] + [
        (row["scene"], row["driver"], f"{row['median_ms']:.3g}", f"{row['goal_ms']:g}") for row in rows])


def write_profile(tables, folder, kept, quick):
    rows = profile.measure(lambda driver: kept.program(driver)[0], frames.read_frames(folder), quick)
    timings.write(tables, "frames_profile", rows)
    if rows:
        print_cells([("frame", "where its processor time goes"),
                     *((row["title"], row["functions"]) for row in rows)])
    else:
        print("no profile of the frames: perf (package linux-perf) is missing, "
              "or may not look at programs here")


def measure_times(options, parts):
    folder = os.path.join(options.source, "tests", "bench")
    tables = os.path.join(options.build, "bench", "tables")
    calls = {part: KEPT_PARTS[part].calls(folder, options.quick) for part in parts if part in KEPT_PARTS}
    if "startup" in parts:
        startup.read_scenes(folder)  # a mistake is told before the work
    kept = timings.Timings(options.build, options.reset)
    for part in calls:
        kept.measure(part, calls[part])
    if "frames" in parts:
        write_frames(tables, folder, kept)
    if "growth" in parts:
        write_growth(tables, folder, kept)
    if calls:
        timings.write(tables, "timings_machine", timings.machine_rows(list(kept.rows.values())))
    if "startup" in parts:
        write_startup(tables, folder, kept, options.quick)
    if "profile" in parts:
        write_profile(tables, folder, kept, options.quick)
    names = ["frames_profile" if part == "profile" else part for part in parts]
    written = [f"{tables}/{name}*.csv" for name in names if os.path.exists(f"{tables}/{name}.csv")]
    print(f"bench: wrote {', '.join(written) or 'no tables'}; times are kept in {kept.path}")


def measure(options):
    names = options.cases.split()
    usual = [name for name in plan.PARTS
             if not (options.quick and name == "profile")]  # which takes as long as all else
    parts = [name for name in plan.PARTS if name in names] if names else usual
    cases = [name for name in names if name not in plan.PARTS]
    reset, worse = options.reset, False
    if options.compare and names and not cases:
        raise ToolError(f"COMPARE: {' and '.join(parts)} have no seeds to compare: "
                        "name cases, too, or leave it out")
    if cases or not names:
        worse = measure_accuracy(options, cases)
        options.reset = reset
    if parts:
        measure_times(options, parts)
    return int(worse)


def for_report(options):
    work = open_schedule(options, plan.FULL)
    if not is_complete(work) and not os.environ.get("RAYKIT_MEASURED"):
        print("bench: there is no full measurement by this build (make bench), so this is the quick one",
              file=sys.stderr)
        work = open_schedule(options, plan.QUICK)
        print("quick")  # the weaver reads it
    work.run()
    write_tables(work, options)
    check_references(work)
    try:
        shutil.copytree(os.path.join(options.build, "bench", "tables"), os.path.join(options.out, "tables"),
                        dirs_exist_ok=True)
    except OSError as error:
        raise ToolError(f"{options.out}: cannot be written: {error}") from None
    return 0


def main():
    parser = Parser(description=__doc__)
    parser.add_argument("--build", default=".", help="the build folder")
    parser.add_argument("--source", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    parser.add_argument("--quick", action="store_true",
                        help="small pictures and few samples: less than a minute")
    parser.add_argument("--reset", action="store_true", help="forget what was measured")
    parser.add_argument("--cases", default="",
                        help="measure only these; also frames, growth, startup, profile")
    parser.add_argument("--compare", default="", help="an older measurements.csv")
    parser.add_argument("--out", help="write tables for the report into this folder")
    parser.add_argument("--quiet", action="store_true", help="as drivers have it")
    options = parser.parse_args()
    try:
        return for_report(options) if options.out else measure(options)
    except ToolError as error:
        print(f"bench: {str(error).removeprefix('bench: ')}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("bench: interrupted; what was measured is kept, and make bench goes on there", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
