#!/usr/bin/env python3
"""make bench: its statistics against known distributions; its schedule, what it keeps and its messages with a
program that invents errors of known size; and the program itself. Speaks TAP, for make check-bench; runs in a
build folder."""

import csv
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import types
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import bench as bench_tool  # noqa: E402
from benchmark import (compare, frames, growth, measurements, plan, profile, startup,  # noqa: E402
                       statistics, summary, timings)
from benchmark.schedule import Program, kinds_of  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

BENCH = os.path.join(SOURCE, "tools", "bench.py")

# --- statistics ----------------------------------------------------------------------------------


def quantiles_are_those_of_tables():
    # Abramowitz and Stegun, table 26.10
    wanted = {(0.95, 1): 12.706, (0.95, 2): 4.303, (0.95, 15): 2.131, (0.99, 15): 2.947, (0.9, 120): 1.658}
    off = {key: statistics.student_quantile(*key) for key, value in wanted.items()
           if abs(statistics.student_quantile(*key) - value) > 0.0005}  # they have three decimals
    check(not off, "Student's quantiles are those of printed tables", off)


def share(count, what):
    return sum(what() for _ in range(count)) / count


# The share of 1000 intervals that hold the truth is 95 % +- 0.7 %; 4 standard deviations are allowed.
COVERED = (0.922, 0.978)


def intervals_hold_the_truth():
    chance = random.Random(5)

    def rmse():
        """Sixteen seeds, 50 pixels: errors of 0.2, and a reference that is off by 0.1, which is
        subtracted."""
        squares = [statistics.mean([chance.gauss(0, math.hypot(0.2, 0.1)) ** 2 for _ in range(50)])
                   for _ in range(16)]
        _, low, high = statistics.rmse_interval(squares, 0.01)
        return low <= 0.2 <= high

    def bias():
        """A reference that all seeds share, off by a random amount of the same size."""
        shared = chance.gauss(0, 1)
        errors = [chance.gauss(0.3, 4) + shared for _ in range(16)]
        _, low, high = statistics.mean_interval(errors, more_error=1)
        return low <= 0.3 <= high

    def slope():
        xs = list(range(8))
        (_, low, high), _ = statistics.fit_line(xs, [2 - 0.75 * x + chance.gauss(0, 0.1) for x in xs])
        return low <= -0.75 <= high

    for name, what in (("a root mean squared error", rmse), ("a bias", bias), ("a slope", slope)):
        covered = share(1000, what)
        check(COVERED[0] <= covered <= COVERED[1], f"95 % of the intervals of {name} hold it", covered)


def lines_and_crossings_are_exact():
    (slope, low, high), start = statistics.fit_line([0, 1, 2, 3], [5, 3, 1, -1])
    check((slope, low, high, start) == (-2, -2, -2, 5),
          "a straight line is found exactly", (slope, low, high, start))
    points = [(n, n ** -0.5) for n in (1, 4, 16, 64)]
    for level, x, how in ((0.2, 25, "measured"), (0.05, 400, "extrapolated"), (2, 1, "at most")):
        got = statistics.crossing(points, level)
        check(got[0] is not None and abs(got[0] / x - 1) < 1e-12 and got[1] == how,
              f"a power law reaches its {level} ({how})", got)
    check(statistics.crossing([(n, 0.3) for n in (1, 2, 4, 8)], 0.01) == (None, "never"),
          "a level curve never gets there")
    check(statistics.crossing([(1, 0.5), (2, 0.1), (4, 0.5), (8, 0.1)], 0.3)[0] > 4,
          "a curve that rises again counts from its last passage")


def differences_are_told_from_noise():
    found = statistics.beyond_chance([0.04, 0.001, 0.02, 0.3], 0.05)
    check(found == [False, True, False, False],
          "Holm's procedure stops at the first that may be chance", found)
    check(statistics.paired_change([1, 2], [1, 2]) == (0, 1), "equal pairs are no change")
    check(statistics.paired_change([1, 2], [2, 3])[1] == 0, "pairs that all differ by the same are no chance")


def curve_of(seconds, error, counts_samples=True):
    """With these seconds and errors by number of samples."""
    curve = object.__new__(summary.Curve)
    curve.method = types.SimpleNamespace(counts_samples=counts_samples)
    curve.reference, curve.pixels = {"own": 0}, 100
    curve.rows = {n: [{"seconds": seconds(n), "mse": error(n) ** 2, "camera_rays": 200 * n}] * 4
                  for n in (1, 4, 16, 64)}
    return curve


def times_are_split_into_fixed_and_growing():
    fast = curve_of(lambda n: 0.003 + n * 0.001, lambda n: 0.16 / n)  # 1 % with 16 samples
    slow = curve_of(lambda n: 0.003 + n * 0.001, lambda n: 0.08 / math.sqrt(n))  # with 64
    found = fast.fixed_seconds(), summary.fixed_part(fast), summary.sample_ratio(slow, fast)
    check(all(abs(x / wanted - 1) < 1e-9 for x, wanted in zip(found, (0.003, 3 / 19, 4))),
          "the fixed part of a time, and a ratio of samples", found)
    other = curve_of(lambda n: 0.1, lambda n: 0.16 / n, counts_samples=False)
    check((other.fixed_seconds(), summary.fixed_part(other)) == (None, None),
          "asked for an error, a method has no fixed part")
    found = other.samples_to(0.01)[0], summary.sample_ratio(slow, other), other.slope()[0]
    check(all(abs(x / wanted - 1) < 1e-9 for x, wanted in zip(found, (32, 4, -1))),
          "its samples are camera rays per pixel, of which all methods have as many per sample", found)


def errors_beyond_the_most_samples_draw_one_picture():
    settings = types.SimpleNamespace(side=10, seeds=2, counts=lambda: (1, 4, 16, 64))
    schedule = types.SimpleNamespace(
        settings=settings, references={"pixel": {"own": 0}}, wanted=lambda method, samples: True,
        row=lambda method, samples, seed: {"camera_rays": 100 * min(samples, 16)})
    for counts_samples, wanted in ((False, [1, 4, 16]), (True, [1, 4, 16, 64])):
        method = types.SimpleNamespace(counts_samples=counts_samples,
                                       case=types.SimpleNamespace(name="pixel"))
        found = list(summary.Curve(schedule, method).rows)
        check(found == wanted, "where a smaller error takes no more samples, its picture is left out", found)


# --- comparing -----------------------------------------------------------------------------------

METHODS, SEEDS = 10, 16


def measured(chance, slower=1.0, worse=1.0, pace=1.0):
    """Invented measurements; the first method is slower or worse by these factors, all by the pace. Between
    seeds, times vary by 3 %, and mean squared errors as those of 100 pixels, by 14 %."""
    rows = []
    for method in range(METHODS):
        for seed in range(1, SEEDS + 1):
            for samples in (1, 4, 16, 64):
                first = method == 0
                rows.append(dict(
                    case="case", method=str(method), size="48", samples=samples, seed=seed,
                    seconds=(samples * 1e-3 * math.exp(chance.gauss(0, 0.03)) *
                             (slower if first else 1) * pace),
                    mse=max(chance.gauss(1, 0.14), 0.2) / samples * (worse ** 2 if first else 1)))
    return rows


def alarms(chance, **what):
    changes = compare.changes(measured(chance), measured(chance, **what))
    return [change for change in changes if change.beyond_noise]


def comparisons_find_losses_and_nothing_else():
    chance = random.Random(7)
    false = sum(bool(alarms(chance)) for _ in range(100))
    # 1 expected of 100 at the level of 1 %; 6 or more have a probability of 5e-4
    check(false <= 5, "equal programs look different no more often than stated", f"{false} of 100")
    for name, what, worse in (("slower", {"slower": 1.1}, "time"),
                              ("less accurate", {"worse": 1.1}, "error")):
        missed = 0
        for _ in range(20):
            found = alarms(chance, **what)
            missed += not any(change.what == worse and change.method == "0" and change.factor > 1
                              for change in found)
        check(missed == 0, f"a method that is 10 % {name} is found", f"missed {missed} times of 20")
    check(not alarms(chance, pace=1.03), "a machine that runs 3 % slower is no loss")
    check(len([c for c in alarms(chance, pace=1.2) if c.what == "time"]) == METHODS,
          "a program that is 20 % slower is a loss everywhere")
    found = alarms(chance, slower=1 / 1.2)
    check([change.text().split(",")[1] for change in found] == [" 0: faster"], "gains are told as gains",
          [change.text() for change in found])
    same = measured(random.Random(1))
    check(not any(change.beyond_noise for change in compare.changes(same, same)),
          "a measurement equals itself")
    least = min(row["samples"] for row in same)
    exact = [dict(row, mse=0.0) if row["samples"] == least else row for row in same]
    check(not any(change.beyond_noise for pair in ((same, exact), (exact, same))
                  for change in compare.changes(*pair)),
          "pictures without error on one side alone make no method look changed")


# --- the schedule, with invented pictures --------------------------------------------------------

INVENTED = '''#!/usr/bin/env python3
"""Answers as tests/bench/bench does. Methods with --kind fast have errors of 0.5 / n, others of
0.5 / sqrt(n), on 1000 values; a picture of n samples takes n * 1e-4 s, half as long again after one of more
than 2 n. Each question is noted in the file "asked"."""
import random, sys, time
last = 0
for line in sys.stdin:
    with open("asked", "a") as file:
        file.write(line)
    words = line.split()
    if words[0] == "kinds":
        print("plain,fast", flush=True)
    elif words[0] == "tree":
        print("0.1,0.2,3,4,5,6,7", flush=True)
    elif words[0] == "numbers":
        print("one,1,2,3,4,5", "two,1,2,3,4,5", "three,1,2,3,4,5", sep="\\n", flush=True)
    elif words[0] == "reference":
        print("1000,1,1e-12,1e-8,{z},{off}", flush=True)
    else:
        n, seed = int(words[words.index("--n") + 1]), int(words[words.index("--seed") + 1])
        chance = random.Random(line)
        fast = "fast" in words
        error = 0.5 / n if fast else 0.5 / n ** 0.5
        squares = error ** 2 * chance.gauss(1, 0.045)
        cold, last = 1.5 if last > 2 * n else 1, n
        time.sleep({sleep})
        seconds = n * 1e-4 * cold * {slower}
        print(f"{seconds},{squares},{chance.gauss(0, error / 32)},{3 * error},{n},0,0", flush=True)
'''


def invent(folder, z=0.5, sleep=0, slower=1, squares=1):
    """A build folder with such a program, and tables beside it."""
    program = os.path.join(folder, "tests", "bench", "bench")
    text = INVENTED
    for name, value in (("{z}", z), ("{off}", squares), ("{sleep}", sleep), ("{slower}", slower)):
        text = text.replace(name, str(value))
    write(text, program)
    os.chmod(program, 0o755)
    write("case\ttitle\toptions\tfirst\tsecond\tgoal\tslope\n"
          "one\tthe first\t--scene one\t--n {n}\t--n {n}\t20\t-1\n"
          "two\tthe second\t--scene two\t--n {n}\t--n {n}\t\t\n", folder, "tests", "bench", "cases.tsv")
    write("case\tmethod\toptions\none\t{kind}\t--kind {kind} --n {n}\ntwo\tplain\t--kind plain --n {n}\n",
          folder, "tests", "bench", "methods.tsv")
    invent_drivers(folder)


def bench(folder, *words):
    return run(folder, sys.executable, "-B", BENCH, "--build", folder, "--source", folder, *words)


def asked(folder, forget=True):
    """The number of pictures asked for since it was last called."""
    path = os.path.join(folder, "bench", "asked")
    count = read(path).count("picture ") if os.path.exists(path) else 0
    if forget and os.path.exists(path):
        os.remove(path)
    return count


def table(folder, name):
    return list(csv.DictReader(read(folder, "bench", "tables", name + ".csv").splitlines()))


def known_errors_are_found(folder):
    status, said = bench(folder, "--quick")
    check(status == 0 and "wrote" in said, "everything is measured", said)
    row = table(folder, "accuracy")[0]
    check(row["classic"] == "plain" and row["best"] == "fast", "the best method is found", row)
    at = next(i for i, line in enumerate(said.splitlines()) if line.startswith("feature"))
    heads, line = (re.split("  +", line) for line in said.splitlines()[at:at + 2])
    check(heads == ["feature", "best method", "time ratio", "goal", "slope", "its goal", "bias, %", "note"],
          "the table has a heading", said)
    bias, low, high = (100 * float(row[name]) for name in ("bias", "bias_low", "bias_high"))
    interval = f"{bias:+.3f} ({low:+.3f} to {high:+.3f})"
    check(line[-2:] == [interval, "extrapolated"],
          "the bias has an interval, and a ratio that is extrapolated a note", said)
    check("the full measurement decides" in said, "a quick measurement says that it decides nothing", said)
    # An error of 1 % takes 2500 plain samples, beyond the measured ones, and 50 fast ones.
    low, high = float(row["time_ratio_low"]), float(row["time_ratio_high"])
    check(low <= 50 <= high and row["goal_reached"] == "yes" and "extrapolated" in row["note"],
          "so is its gain in time", row)
    check(abs(float(row["slope"]) + 1) < 0.03 and float(row["slope_low"]) <= -1 <= float(row["slope_high"]),
          "and its slope", row)
    rows = [row for row in table(folder, "accuracy_convergence")
            if row["method"] == "plain" and row["feature"] == "one"]
    held = [float(row["rmse_low"]) <= 0.5 / math.sqrt(int(row["samples"])) <= float(row["rmse_high"])
            for row in rows]
    check(len(rows) == 7 and sum(held) >= 5, "each number of samples has an interval for its error", rows)
    off = [row for row in rows if abs(float(row["seconds"]) / (1e-4 * int(row["samples"])) - 1) > 1e-6]
    check(not off, "no picture's time is that after a much longer one", off)
    check([row["samples"] for row in rows] == ["1", "2", "4", "8", "16", "32", "64"],
          "samples are powers of 2", rows)
    check(asked(folder) == 3 * 7 * plan.QUICK.seeds, "each picture is rendered once")
    check(table(folder, "accuracy_trees")[0]["render"] == "0.2" and
          len(table(folder, "accuracy_numbers")) == 3, "trees and numbers have tables")


def finished_work_is_kept(folder):
    path = os.path.join(folder, "bench", "measurements.csv")
    before = read(path)
    status, said = bench(folder, "--quick")
    check(status == 0 and asked(folder) == 0 and read(path) == before,
          "what is measured is not measured again", said)
    write(before[:-30], path)
    status, said = bench(folder, "--quick")
    check(status == 0 and asked(folder) == 1 and len(read(path).splitlines()) == len(before.splitlines()),
          "an unfinished last line is measured again, and nothing else", said)
    bench(folder, "--quick", "--reset")
    check(asked(folder) == 3 * 7 * plan.QUICK.seeds, "RESET=1 measures all again")
    status, said = bench(folder, "--quick", "--compare", path)
    check(status == 0 and "0 changes beyond noise" in said, "compared with itself nothing has changed", said)
    invent(folder, slower=1.2)
    status, said = bench(folder, "--quick", "--compare", os.path.join("bench", "previous.csv"))
    check(asked(folder) == 3 * 7 * plan.QUICK.seeds, "another program is measured anew")
    check(status == 1 and said.count("slower, 20.0 % more time") == 3,
          "and compared with the one before, which is kept", said)


def begin_bench(folder, *words):
    """Starts make bench, with the usual handler of SIGINT, which commands in a script's background ignore."""
    return subprocess.Popen(
        [sys.executable, "-B", BENCH, "--build", folder, "--source", folder, "--quick", *words],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def begin(folder, pictures):
    """Starts make bench, and returns once so many pictures have been asked for."""
    process = begin_bench(folder)
    patience = time.monotonic() + 60
    while asked(folder, forget=False) < pictures and time.monotonic() < patience:
        time.sleep(0.05)
    return process


def interruptions_cost_one_picture(folder):
    invent(folder, sleep=100)
    process = begin(folder, 1)
    process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=50)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
    check(process.returncode == 130, "an interruption does not wait for a long picture", process.returncode)
    asked(folder)
    invent(folder, sleep=0.02)
    process = begin(folder, 40)
    os.killpg(process.pid, signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    check(process.returncode == 130 and "Traceback" not in said and "goes on" in said,
          "an interruption is told in a sentence", said)
    kept = len(measurements.read(os.path.join(folder, "bench", "measurements.csv")))
    check(kept >= 40 - (os.cpu_count() or 1), "what was finished before is kept", kept)
    asked(folder)
    status, said = bench(folder, "--quick")
    check(status == 0 and asked(folder) == 3 * 7 * plan.QUICK.seeds - kept,
          "the rest is measured, and nothing else", said)


def mistakes_are_told(folder):
    path = os.path.join(folder, "bench", "measurements.csv")
    before = read(path)

    def refuses(name, words, *parts):
        status, said = bench(folder, "--quick", *words)
        lines = said.splitlines()  # the last of which is the message; before it only progress is told
        good = status == 2 and all(part in lines[-1] for part in parts) and \
            all(line.startswith("bench: ") for line in lines)
        check(good, name, said)

    lines = before.splitlines(keepends=True)
    write("".join([*lines[:2], "junk\n", *lines[3:]]), path)
    refuses("a corrupt line is told with its place and a remedy", (), "measurements.csv:3:", "RESET=1")
    write("".join([*lines[:2], lines[2].replace(lines[2].split(",")[7], "fast"), *lines[3:]]), path)
    refuses("so is a cell that is no number", (), "measurements.csv:3:", "RESET=1")
    for number in ("nan", "inf", "-1"):
        write("".join([*lines[:2], lines[2].replace(lines[2].split(",")[7], number), *lines[3:]]), path)
        refuses(f"so is {number}", (), "measurements.csv:3:", f"seconds is {number}")
    write(before.replace(",bias,", ",", 1), path)
    refuses("a missing column is named", (), "measurements.csv:1:", "bias")
    write(before, path)
    refuses("COMPARE names a file that is there", ("--compare", "none.csv"), "none.csv", "cannot be read")
    write("a,b\n1,2\n", folder, "other.csv")
    refuses("COMPARE takes no other table", ("--compare", "other.csv"), "other.csv:1:", "measurements.csv")
    refuses("CASES names cases that exist", ("--cases", "three"), "there is no case three", "one two")
    methods = os.path.join(folder, "tests", "bench", "methods.tsv")
    tables = read(methods)
    write(tables + "three\tplain\t--n {n}\n", methods)
    refuses("a method belongs to a case", (), "methods.tsv", "three")
    write(tables + "one\tplain\n", methods)
    refuses("a row has all columns", (), "methods.tsv:4", "tabs")
    write(tables, methods)
    invent(folder, z=-5)
    refuses("references that disagree are told", (), "differ by -5.0 standard errors")
    invent(folder, squares=4)
    refuses("so are those that disagree here and there", (),
            "have pixels that differ by 2.0 times their standard errors")
    write("#!/bin/sh\necho 'bench: --n: there is no such option' >&2\nexit 1\n",
          folder, "tests", "bench", "bench")
    refuses("the program's own message is passed on", (), "there is no such option")
    os.remove(os.path.join(folder, "tests", "bench", "bench"))
    refuses("a missing program is told", (), "run make bench")
    invent(folder)
    shutil.rmtree(os.path.join(folder, "bench"))
    write("", folder, "bench")
    refuses("a folder that cannot be made is told", (), "cannot be written")
    os.remove(os.path.join(folder, "bench"))
    os.mkdir(os.path.join(folder, "bench"), 0o555)
    if os.geteuid() != 0:  # root may write anyway
        refuses("a read-only folder is told", (), "cannot be written")


# --- frames and growth, with invented drivers -----------------------------------------------------

INVENTED_DRIVER = '''#!/bin/sh
# Answers to --timing as drivers do: times proportional to triangles, pixels and lights, halved by a second
# thread; runs differ by a tenth. Each call is noted in the file "called".
threads=1 runs=1 width=1 height=1 triangles=87130 lights=1 name=$(basename "$0")
while [ $# -gt 0 ]; do
    case $1 in
    --scene) triangles=${2#statue} triangles=${triangles#:} ;;
    --threads) threads=$2 ;;
    --runs) runs=$2 ;;
    --width) width=$2 ;;
    --height) height=$2 ;;
    --lights) lights=$2 ;;
    --out) out=$2 ;;
    esac
    shift
done
case $triangles in *[!0-9]* | "") triangles=87130 ;; esac
echo "$name $triangles $threads $runs" >>called
FAULT
mkdir -p "$out/tables"
case $triangles in
100000 | 10000000) head -c 100000000 /dev/zero | tail -c 99000000 >"$out/tables/zeros" ;;
esac
render=$((width * height * lights / 1000 / threads)) build=$((triangles / 100 / threads))
renders="$render,$((render * 9 / 10)),$((render * 11 / 10))"
{
    echo feature,scene,triangles,method,isa,threads,metric,unit,median,min,max,runs
    echo "$name,s,$triangles,wide,invented,$threads,build,ms,$build,$build,$build,$runs"
    echo "$name,s,$triangles,wide,invented,$threads,render_3_30,ms,$renders,$runs"
    echo "$name,s,$triangles,wide,invented,$threads,bytes_per_triangle,1,70,70,70,1"
} >"$out/tables/$name.csv"
'''
DRIVERS = {"wide_bvh": "15_wide_bvh", "parallelogram_light": "04_parallelogram_light"}
FRAMES = "frame\ttitle\tdriver\toptions\tthreads\tgoal_ms\tclassic_ms\tspeedup\n"
SLOW = "slow\tthe slow one\twide_bvh\t--width 1000 --height 1000\t1\t900\t4000\t1.9\n"
FAST = "fast\tthe fast one\tparallelogram_light\t--width 100 --height 100 --lights 4\t2\t30\t\t2.1\n"


def invent_drivers(folder, fault=""):
    for name, place in DRIVERS.items():
        path = os.path.join(folder, "assignments", place, name)
        write(INVENTED_DRIVER.replace("FAULT", fault), path)
        os.chmod(path, 0o755)
    write(FRAMES + SLOW + FAST, folder, "tests", "bench", "frames.tsv")
    write("scene\tdriver\tgoal_ms\ncube\twide_bvh\t60000\n", folder, "tests", "bench", "startup.tsv")


def called(folder):
    """The calls of drivers since it was last asked."""
    path = os.path.join(folder, "bench", "called")
    if not os.path.exists(path):
        return []
    lines = read(path).splitlines()
    os.remove(path)
    return lines


def drive(folder, *words, cases="frames growth"):
    return run(folder, sys.executable, "-B", BENCH, "--build", ".", "--source", folder, "--cases", cases,
               *words)


def frames_are_compared_with_goals(folder):
    status, said = drive(folder, cases="frames")
    rows = {(row["frame"], row["threads"]): row for row in table(folder, "frames")}
    check(status == 0 and list(rows) == [("slow", "1"), ("slow", "2"), ("fast", "1"), ("fast", "2")],
          "each frame is measured on one thread and on two", said)
    slow, pair, fast = rows["slow", "1"], rows["slow", "2"], rows["fast", "2"]
    check((slow["median_ms"], slow["min_ms"], slow["max_ms"], slow["runs"]) == ("1000", "900", "1100", "3"),
          "with the median and the spread of its runs", slow)
    check((slow["goal_ms"], slow["goal_reached"]) == ("900", "no") and
          (fast["goal_ms"], fast["goal_reached"]) == ("30", "yes"),
          "a goal is reached by at most so many milliseconds", rows)
    check(pair["goal_ms"] == pair["classic_ms"] == rows["fast", "1"]["goal_ms"] == "",
          "on the threads for which it is meant", rows)
    check(slow["times_as_fast"] == "4" and fast["times_as_fast"] == "",
          "the classic program's time is divided by raykit's", rows)
    check((pair["speedup"], pair["speedup_reached"]) == ("2", "yes") and
          fast["speedup_reached"] == "no" and slow["speedup"] == "",
          "two threads are compared with one", rows)
    goals = [(row["frame"], float(row["of_goal"])) for row in table(folder, "frames_goals")]
    check(goals == [("slow", 1.11111), ("fast", 0.666667)], "bars are times over goals", goals)
    left = re.search("wide_bvh --width 1000 --height 1000; about ([0-9]+) s left for frames", said)
    # Guessed at first: 0.3 s and the runs of each of four calls, two of 3 x 900 ms, and two of 5 x 60, halved
    # by two threads.
    check(left and abs(int(left[1]) - (4 * 0.3 + 2.7 + 1.35 + 0.3 + 0.15)) <= 0.5,
          "how long it takes is estimated", said)
    printed = [re.split("  +", line) for line in said.splitlines()]
    check(["the slow one", "1", "1000", "900", "4000"] in printed, "the table is printed, too", said)


def growth_has_slopes(folder):
    status, said = drive(folder, "--quick", cases="growth")
    rows = table(folder, "growth")
    triangles = [row for row in rows if row["what"] == "triangles" and row["threads"] == "1"]
    check(status == 0 and [row["n"] for row in triangles] == ["1000", "10000", "100000"],
          "the quick form stops at 100,000 triangles", said)
    check([row["build_median"] for row in triangles] == ["10", "100", "1000"] and
          all(row["trace_ns_per_ray"] == "1000" and row["bytes_per_triangle"] == "70" for row in triangles),
          "times per ray and memory per triangle are those of the drivers", rows)
    peak = float(triangles[2]["peak_mib"])  # of tail, which keeps 99,000,000 bytes
    per_triangle = float(triangles[2]["peak_bytes_per_triangle"])
    check(94 < peak < 130 and abs(per_triangle / (peak * 2 ** 20 / 1e5) - 1) < 1e-4,
          "so is the process's memory", triangles)
    check(triangles[0]["peak_mib"] == triangles[0]["peak_bytes_per_triangle"] == "",
          "where it is more than the tool's own", triangles)
    slopes = {(row["what"], row["quantity"], row["line"]): float(row["slope"])
              for row in table(folder, "growth_slopes")}
    wanted = {("triangles", "build"): 1, ("triangles", "trace"): 0, ("megapixels", "render"): 1,
              ("lights", "render"): 1}
    # Invented times are whole milliseconds, so that slopes are off by less than 0.01.
    off = [key for key, slope in slopes.items() if key[:2] in wanted and abs(slope - wanted[key[:2]]) > 0.01]
    found = {key[:2] for key in slopes}
    check(not off and found == {*wanted, ("triangles", "memory")},
          "slopes are those of the invented times", slopes)
    points = [row for row in table(folder, "growth_curves") if row["quantity"] == "build"]
    lines = sorted({row["line"] for row in points})
    check(lines == ["1 thread, slope 1.00", "2 threads, slope 1.00"],
          "lines of plots are named with their slopes", lines)
    check(not os.path.exists(os.path.join(folder, "bench", "tables", "growth_goals.csv")),
          "ten million triangles have no verdict yet")
    about = {row["item"]: row["value"] for row in table(folder, "timings_machine")}
    check(about["instruction set"] == "invented" and "processors" in about["processor"],
          "the machine is named", about)


def times_are_kept(folder):
    called(folder)
    status, said = drive(folder, "--quick")
    check(status == 0 and called(folder) == [], "what is measured is not measured again", said)
    path = os.path.join(folder, "bench", "timings.csv")
    before = read(path)
    write(before[:-20], path)
    drive(folder, "--quick")
    check(len(called(folder)) == 1 and len(read(path).splitlines()) == len(before.splitlines()),
          "an unfinished last line is measured again, and nothing else")
    status, said = drive(folder)
    calls = called(folder)
    check(status == 0 and "wide_bvh 10000000 2 3" in calls and not any(call.endswith(" 1") for call in calls),
          "the full form goes to ten million triangles, and repeats what the quick one ran once", calls)
    goals = {row["unit"]: row for row in table(folder, "growth_goals")}
    check((goals["ms"]["value"], goals["ms"]["limit"], goals["ms"]["reached"]) == ("50000", "5000", "no") and
          (goals["MiB"]["limit"], goals["MiB"]["reached"]) == ("2048", "yes"),
          "which have their goals", goals)
    drive(folder, "--quick")
    check(called(folder) == [] and len(table(folder, "growth")) == 40,
          "after it the quick form measures nothing, and shows all")
    write(read(folder, "assignments", "04_parallelogram_light", "parallelogram_light") + "# changed\n",
          folder, "assignments", "04_parallelogram_light", "parallelogram_light")
    drive(folder, "--quick")
    calls = called(folder)
    check(calls and all(call.startswith("parallelogram_light") for call in calls),
          "a driver that changed is measured anew, alone", calls)
    drive(folder, "--quick", "--reset", cases="frames")
    check(len(called(folder)) == 2, "RESET=1 measures all again")


def an_interruption_costs_one_call(folder):
    invent_drivers(folder, "[ $lights = 1 ] || exec sleep 100")
    process = begin_bench(folder, "--cases", "frames")
    patience, path = time.monotonic() + 60, os.path.join(folder, "bench", "called")
    while time.monotonic() < patience and not (os.path.exists(path) and "parallelogram_light" in read(path)):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    try:
        said, _ = process.communicate(timeout=50)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        said, _ = process.communicate()
    check(process.returncode == 130 and "Traceback" not in said and "goes on" in said,
          "an interruption does not wait for a driver", said)
    called(folder)
    invent_drivers(folder)
    kept = read(folder, "bench", "timings.csv").splitlines()
    check(len(kept) == 2, "what was finished before is kept", kept)
    left = sorted(os.listdir(os.path.join(folder, "bench")))
    check(not any(name.startswith("tmp") for name in left), "and no driver's folder is left over", left)


def mistakes_of_frames_are_told(folder):
    def refuses(name, *parts, words=(), cases="frames"):
        status, said = drive(folder, "--quick", *words, cases=cases)
        lines = said.splitlines()
        good = status == 2 and all(part in lines[-1] for part in parts) and \
            all(line.startswith("bench: ") for line in lines)
        check(good, name, said)

    frames_table = os.path.join(folder, "tests", "bench", "frames.tsv")
    drive(folder, "--quick", cases="frames")
    path = os.path.join(folder, "bench", "timings.csv")
    before = read(path)
    write(before + "junk\n", path)
    refuses("a corrupt line of kept times is told with its place and a remedy", "timings.csv:4:", "RESET=1")
    write(before, path)
    for name, row, parts in (
            ("a driver that does not exist", SLOW.replace("wide_bvh", "tall_bvh"),
             ("tall_bvh", "frames.tsv")),
            ("a goal that is no number", SLOW.replace("900", "soon"), ("frames.tsv:2", "soon")),
            ("a goal for three threads", SLOW.replace("\t1\t900", "\t3\t900"), ("frames.tsv:2", "not 3")),
            ("a row without all columns", "slow\twide_bvh\n", ("frames.tsv:2", "tabs"))):
        write(FRAMES + row, frames_table)
        refuses(f"{name} is told", *parts)
    write(FRAMES + SLOW + FAST, frames_table)
    refuses("COMPARE goes with cases", "COMPARE", "frames", words=("--compare", "old.csv"))
    refuses("a misspelt part is told, with all names", "there is no case frame",
            "one two frames growth startup profile", cases="frame")
    invent_drivers(folder, "exit 0")
    refuses("a driver that gives no times is told", "wide_bvh", "frames.tsv")
    invent_drivers(folder, 'echo "$name: --nonsense: there is no such option" >&2; exit 1')
    refuses("a driver's own message is passed on", "--width 1000", "there is no such option")
    invent_drivers(folder)


def drivers_take_the_options(folder):
    """The real ones: each frame, small, and the smallest of growth."""
    os.symlink(os.path.abspath("assignments"), os.path.join(folder, "assignments"))
    kept = timings.Timings(folder)
    tables = os.path.join(SOURCE, "tests", "bench")
    rows = []
    for call in frames.calls(tables, True):
        small = re.sub("--(width|height) [0-9]+", r"--\1 8", call.options)
        small = small.replace("statue:87130", "statue:100")
        kept.measure("frames", [timings.Call(call.driver, small, call.threads, 3, 0)])
        rows.append(kept.row(timings.Call(call.driver, small, call.threads, 3, 0)))
    check(all(row["render_median"] > 0 and
              row["render_min"] <= row["render_median"] <= row["render_max"] for row in rows),
          "the drivers take each frame's options, and time it", rows)
    calls = [call for call in growth.calls(tables, True)
             if "statue:1000 " in call.options or "--lights" in call.options]
    kept.measure("growth", calls)
    found = {(row["what"], row["n"], row["threads"]): row for row in growth.rows(tables, kept)}
    check(len(found) == len(calls) == 8, "and those of growth", list(found))
    tree = found["triangles", 1000, 1]
    # A triangle's corners alone are 36 bytes.
    check(36 < tree["bytes_per_triangle"] < 1000 and tree["build_median"] > 0,
          "trees are timed and measured", tree)


# --- start-up and profiles ------------------------------------------------------------------------


def startup_is_timed_for_each_scene(folder):
    """By the real driver, but fewer scenes."""
    os.symlink(os.path.abspath("assignments"), os.path.join(folder, "assignments"))
    write("scene\tdriver\tgoal_ms\ncube\tshading\t60000\nstatue:50000\twide_bvh\t0.001\n",
          folder, "tests", "bench", "startup.tsv")
    status, said = drive(folder, "--quick", cases="startup")
    rows = table(folder, "startup")
    check(status == 0 and [(row["scene"], row["driver"], row["goal_reached"]) for row in rows] ==
          [("cube", "shading", "yes"), ("statue:50000", "wide_bvh", "no")],
          "start-up: each scene's time is compared with its goal", said)
    cube, statue = ([float(row[name]) for name in ("min_ms", "median_ms", "max_ms")] for row in rows)
    check(0 < cube[0] <= cube[1] <= cube[2] and cube[0] < statue[0],
          "start-up: 50,000 triangles take longer than 12", (cube, statue))
    write("scene\tdriver\tgoal_ms\ncube\tshading\tsoon\n", folder, "tests", "bench", "startup.tsv")
    status, said = drive(folder, "--quick", cases="startup")
    check(status == 2 and "startup.tsv:2: soon" in said, "start-up: a goal that is no number is told", said)
    driver = os.path.join(folder, "assignments", "15_wide_bvh", "wide_bvh")
    status, said = run(folder, driver, "--scene", "nothing")
    named = [name.split(":")[0] for name in said.split("choose one of ")[1].strip().split(", ")]
    scenes = startup.read_scenes(os.path.join(SOURCE, "tests", "bench"))
    listed = [scene.split(":")[0] for scene, driver, _ in scenes if driver == "shading"]
    check(listed == named, "start-up: the table has all built-in scenes", (listed, named))


PERF_REPORT = """
# To display the perf.data header info, please use --header/--header-only options.
#
#     Samples  Symbol
# ...........  ......................
#
          600  [.] trace.constprop.0
          200  [.] trace
          150  [.] build
          100  [k] clear_page
"""


def profiles_are_of_the_picture_alone():
    counts = profile.counts_of(PERF_REPORT)
    check(counts == {"trace": 800, "build": 150, "clear_page": 100},
          "profile: parts of a function count for it", counts)
    text = profile.text_of(counts, {"build": 150, "trace": 100})
    check(text == "trace 88 %, clear_page 12 %", "profile: what a tiny picture takes is subtracted", text)
    check(profile.text_of({}, {}) == "" and profile.text_of({"trace": 1}, {"trace": 2}) == "",
          "profile: without samples there is none")
    few = profile.text_of({"trace": 990, "rest": 10}, {})
    check(few == "trace 99 %", "profile: small shares are left out", few)


# --- the program ---------------------------------------------------------------------------------


def numbers_of(program, line):
    return [float(cell) for cell in program.ask(line)]


def the_program_measures(folder):
    path = os.path.abspath(os.path.join("tests", "bench", "bench"))
    kinds = kinds_of(path, folder)
    check(kinds[0] == "uniform" and "low-discrepancy" in kinds, "it names the kinds of samplers", kinds)
    cases = plan.read_cases(os.path.join(SOURCE, "tests", "bench"), plan.QUICK, kinds)
    check(all({method.name for method in case.methods} >= set(kinds)
              for case in cases if case.name != "time"),
          "each kind is measured in each case", [[method.name for method in case.methods] for case in cases])
    adaptive = plan.Method(cases[0], "adaptive", "--error {error}")
    options = adaptive.options(4, 1)
    check(options == f"--error {1 / 64} --seed {plan.SEED_STEP}" and not adaptive.counts_samples,
          "a method may choose its number of samples by an error", options)
    light = next(case for case in cases if case.name == "light")
    with Program(path, light.options, folder) as program:
        reference = numbers_of(program, f"reference kept {light.reference}")
        plain = light.methods[0]
        squares = {n: [numbers_of(program, "picture " + plain.options(n, seed))[1] for seed in range(1, 17)]
                   for n in (4, 16)}
        # Independent samples: four times as many, a quarter of the squared error.
        ratio = [math.log(a - reference[2]) - math.log(b - reference[2])
                 for a, b in zip(squares[4], squares[16])]
        middle, low, high = statistics.mean_interval(ratio, 0.999)
        check(low <= math.log(4) <= high,
              "errors of independent samples fall as they must", (middle, low, high))
        again = numbers_of(program, "picture " + plain.options(4, 1))
        check(again[1] == squares[4][0], "the same picture has the same error")
        rays = numbers_of(program, "picture " + plain.options(4, 1))[4]
        check(rays == plan.QUICK.side ** 2, "rays are counted", rays)
        mean = numbers_of(program, "picture --pictures 4 " + plain.options(4, 1))
        check(mean[1] < squares[4][0] / 2 and mean[4] == 4 * rays,
              "the mean of four pictures has less error, and four times the rays", mean)
    with Program(path, "--scene statue:1000 --split sah --width 32 --height 32", folder) as program:
        trees = {leaf: numbers_of(program, f"tree {leaf}") for leaf in (0, 1, 8, 64)}
        check(trees[1][2] == 1000 and trees[64][2] < trees[8][2] < trees[0][2] < 1000,
              "leaves get the wanted size", trees)
        check(trees[64][5] < trees[1][5] and trees[64][6] > trees[1][6],
              "larger leaves cost fewer boxes and more triangles", trees)
        rows = [program.ask("numbers"), program.answer(), program.answer()]
        # Irradiance is computed in double and rounded once: at most half a unit in the last place.
        check(float(rows[1][2]) <= 2 ** -24 < float(rows[1][4]) and all(float(row[3]) < 2e-5 for row in rows),
              "float is compared with double", rows)
    before = read_bytes(folder, "kept")
    with open(os.path.join(folder, "kept"), "wb") as file:
        file.write(before[:-8])
    with Program(path, light.options, folder) as program:
        again = numbers_of(program, f"reference kept {light.reference}")
        check(again == reference and read_bytes(folder, "kept") == before,
              "a reference that is not whole is made again", again)
    for name, line, part in (
            ("an option that does not exist", "picture --nonsense 3", "no such option"),
            ("a word that is no question", "nonsense", "neither reference"),
            ("a picture without a reference", "picture --seed 3", "reference before"),
            ("a reference by one method", "reference kept --seed 3", "two lists"),
            ("a reference without noise", "reference still --early-out 0 --seed 1 | --seed 2",
             "do not vary")):
        scene = "--scene cube --width 8 --height 8 --out ."
        answer = subprocess.run([path, *scene.split()], cwd=folder, input=line + "\n", text=True, check=False,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        check(answer.returncode == 1 and part in answer.stdout and len(answer.stdout.splitlines()) == 1,
              f"{name} is refused", answer.stdout)


def the_report_measures_carefully_if_asked(folder):
    asked = []
    with mock.patch.multiple(
            bench_tool, is_complete=lambda work: False, write_tables=mock.DEFAULT,
            check_references=mock.DEFAULT,
            open_schedule=lambda options, settings: mock.Mock(run=lambda: asked.append(settings))):
        os.makedirs(os.path.join(folder, "bench", "tables"))
        for measured in ("", "yes"):
            with mock.patch.dict(os.environ, RAYKIT_MEASURED=measured):
                bench_tool.for_report(types.SimpleNamespace(build=folder, out=os.path.join(folder, "out")))
    check(asked == [plan.QUICK, plan.FULL],
          "the report measures in full where MEASURED=1 asks for it, else quickly", asked)


# --- The page of speed ---------------------------------------------------------------------------

SPEED_PAGE = os.path.join(SOURCE, "tools", "speed_page.py")
BEFORE, AFTER = "# a kit\n<!-- speed: made -->\n", "<!-- speed end -->\nthe end\n"


def the_page_of_speed_is_made_anew(folder):
    timings_folder = os.path.join(folder, "bench", "tables")
    peers = os.path.join(folder, "reports", "out", "tables")

    def make():
        return run(folder, sys.executable, "-B", SPEED_PAGE, "--build", ".", "speed.md")

    write(BEFORE + "an old table\n" + AFTER, folder, "speed.md")
    status, said = make()
    check(status == 1 and said.count("\n") == 1 and "run make bench first" in said,
          "the page of speed: without measurements there is only the command", said)
    write("item,value\nprocessor,an abacus\ninstruction set,beads\n", timings_folder, "timings_machine.csv")
    write("title,threads,median_ms,goal_ms,classic_ms\na cat,1,1234.5,,\na cat,2,617.12,700,9000\n",
          timings_folder, "frames.csv")
    status, said = make()
    check(status == 1 and said.count("\n") == 1 and "run make bench-peers first" in said,
          "the page of speed: without Embree's measurements there is only the command", said)
    write("scene,triangles,workload,threads,speed_ratio,goal,robust_speed_ratio\n"
          "cat:7,7000,primary,1,0.876,1.4,1.25\ncat:7,7000,primary,2,3,1.4,4\n"
          "cat:7,7000,build,1,2,1.2,3\n", peers, "peers_best.csv")
    status, said = make()
    wanted = ["| a cat | 1.23 s | 617 ms | 700 ms on 2 | 9 s |",
              "| cat, 7,000 triangles | 0.88 (1.25) |  |  |  | 2.00 (3.00) |",
              "| goal | 1.4 |  |  |  | 1.2 |", "an abacus"]
    check(status == 0 and all(part in said for part in wanted) and "an old table" not in said,
          "the page of speed: a line for each picture and scene, of one thread, in place of the old ones",
          said)
    check(said.startswith(BEFORE) and said.endswith(AFTER),
          "the page of speed: the text around them stays", said)
    write("no place for tables\n", folder, "speed.md")
    status, said = make()
    check(status != 0 and said.count("\n") == 1 and "has no lines" in said,
          "the page of speed: a text without a place for them is an error", said)


def read_bytes(*path):
    with open(os.path.join(*path), "rb") as file:
        return file.read()


def main():
    quantiles_are_those_of_tables()
    intervals_hold_the_truth()
    lines_and_crossings_are_exact()
    differences_are_told_from_noise()
    times_are_split_into_fixed_and_growing()
    errors_beyond_the_most_samples_draw_one_picture()
    comparisons_find_losses_and_nothing_else()
    profiles_are_of_the_picture_alone()
    folder = tempfile.mkdtemp(prefix="raykit-test-bench-")
    try:
        invent(folder)
        known_errors_are_found(folder)
        finished_work_is_kept(folder)
        interruptions_cost_one_picture(folder)
        mistakes_are_told(folder)
        driven = tempfile.mkdtemp(dir=folder)
        invent(driven)
        frames_are_compared_with_goals(driven)
        growth_has_slopes(driven)
        times_are_kept(driven)
        an_interruption_costs_one_call(driven)
        mistakes_of_frames_are_told(driven)
        drivers_take_the_options(tempfile.mkdtemp(dir=folder))
        startup_is_timed_for_each_scene(tempfile.mkdtemp(dir=folder))
        the_report_measures_carefully_if_asked(tempfile.mkdtemp(dir=folder))
        the_page_of_speed_is_made_anew(tempfile.mkdtemp(dir=folder))
        the_program_measures(tempfile.mkdtemp(dir=folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
