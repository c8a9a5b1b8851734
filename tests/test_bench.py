#!/usr/bin/env python3
"""make bench: its statistics against known distributions; its schedule, what it keeps and its messages with a program
that invents errors of known size; and the program itself. Speaks TAP, for make check-bench; runs in a build folder."""

import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from benchmark import compare, measurements, plan, statistics  # noqa: E402
from benchmark.schedule import Program, kinds_of  # noqa: E402
from tap import check, finish, read, run, write  # noqa: E402

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
        """Sixteen seeds, 50 pixels: errors of 0.2, and a reference that is off by 0.1, which is subtracted."""
        squares = [statistics.mean([chance.gauss(0, math.hypot(0.2, 0.1)) ** 2 for _ in range(50)]) for _ in range(16)]
        _, low, high = statistics.rmse_interval(squares, 0.01)
        return low <= 0.2 <= high

    def bias():
        """A reference that all seeds share, off by a random amount of the same size."""
        shared = chance.gauss(0, 1)
        _, low, high = statistics.mean_interval([chance.gauss(0.3, 4) + shared for _ in range(16)], more_error=1)
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
    check((slope, low, high, start) == (-2, -2, -2, 5), "a straight line is found exactly", (slope, low, high, start))
    points = [(n, n ** -0.5) for n in (1, 4, 16, 64)]
    for level, x, how in ((0.2, 25, "measured"), (0.05, 400, "extrapolated"), (2, 1, "at most")):
        got = statistics.crossing(points, level)
        check(got[0] is not None and abs(got[0] / x - 1) < 1e-12 and got[1] == how, f"a power law reaches its {level} ({how})", got)
    check(statistics.crossing([(n, 0.3) for n in (1, 2, 4, 8)], 0.01) == (None, "never"), "a level curve never gets there")
    check(statistics.crossing([(1, 0.5), (2, 0.1), (4, 0.5), (8, 0.1)], 0.3)[0] > 4, "a curve that rises again counts from its last passage")


def differences_are_told_from_noise():
    found = statistics.beyond_chance([0.04, 0.001, 0.02, 0.3], 0.05)
    check(found == [False, True, False, False], "Holm's procedure stops at the first that may be chance", found)
    check(statistics.paired_change([1, 2], [1, 2]) == (0, 1), "equal pairs are no change")
    check(statistics.paired_change([1, 2], [2, 3])[1] == 0, "pairs that all differ by the same are no chance")


# --- comparing -----------------------------------------------------------------------------------

METHODS, SEEDS = 10, 16


def measured(chance, slower=1.0, worse=1.0, pace=1.0):
    """Invented measurements; the first method is slower or worse by these factors, all by the pace. Between seeds,
    times vary by 3 %, and mean squared errors as those of 100 pixels, by 14 %."""
    rows = []
    for method in range(METHODS):
        for seed in range(1, SEEDS + 1):
            for samples in (1, 4, 16, 64):
                first = method == 0
                rows.append(measurements.Row(
                    case="case", method=str(method), size="48", samples=samples, seed=seed,
                    seconds=samples * 1e-3 * math.exp(chance.gauss(0, 0.03)) * (slower if first else 1) * pace,
                    mse=max(chance.gauss(1, 0.14), 0.2) / samples * (worse ** 2 if first else 1)))
    return rows


def alarms(chance, **what):
    return [change for change in compare.changes(measured(chance), measured(chance, **what)) if change.beyond_noise]


def comparisons_find_losses_and_nothing_else():
    chance = random.Random(7)
    false = sum(bool(alarms(chance)) for _ in range(100))
    # 1 expected of 100 at the level of 1 %; 6 or more have a probability of 5e-4
    check(false <= 5, "equal programs look different no more often than stated", f"{false} of 100")
    for name, what, worse in (("slower", {"slower": 1.1}, "time"), ("less accurate", {"worse": 1.1}, "error")):
        missed = 0
        for _ in range(20):
            found = alarms(chance, **what)
            missed += not any(change.what == worse and change.method == "0" and change.factor > 1 for change in found)
        check(missed == 0, f"a method that is 10 % {name} is found", f"missed {missed} times of 20")
    check(not alarms(chance, pace=1.03), "a machine that runs 3 % slower is no loss")
    check(len([c for c in alarms(chance, pace=1.2) if c.what == "time"]) == METHODS, "a program that is 20 % slower is a loss everywhere")
    found = alarms(chance, slower=1 / 1.2)
    check([change.text().split(",")[1] for change in found] == [" 0: faster"], "gains are told as gains",
          [change.text() for change in found])
    same = measured(random.Random(1))
    check(not any(change.beyond_noise for change in compare.changes(same, same)), "a measurement equals itself")


# --- the schedule, with invented pictures --------------------------------------------------------

INVENTED = '''#!/usr/bin/env python3
"""Answers as tests/bench/bench does. Methods with --kind fast have errors of 0.5 / n, others of 0.5 / sqrt(n), on 1000
values; a picture of n samples takes n * 1e-4 s. Each question is noted in the file "asked"."""
import random, sys, time
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
        print("1000,1,1e-12,1e-8,{z},1", flush=True)
    else:
        n, seed = int(words[words.index("--n") + 1]), int(words[words.index("--seed") + 1])
        chance = random.Random(line)
        fast = "fast" in words
        error = 0.5 / n if fast else 0.5 / n ** 0.5
        squares = error ** 2 * chance.gauss(1, 0.045)
        time.sleep({sleep})
        print(f"{n * 1e-4 * {slower}},{squares},{chance.gauss(0, error / 32)},{3 * error},{n},0,0", flush=True)
'''


def invent(folder, z=0.5, sleep=0, slower=1):
    """A build folder with such a program, and tables beside it."""
    program = os.path.join(folder, "tests", "bench", "bench")
    text = INVENTED.replace("{z}", str(z)).replace("{sleep}", str(sleep)).replace("{slower}", str(slower))
    write(text, program)
    os.chmod(program, 0o755)
    write("case\ttitle\toptions\tfirst\tsecond\tgoal\tslope\n"
          "one\tthe first\t--scene one\t--n {n}\t--n {n}\t20\t-1\n"
          "two\tthe second\t--scene two\t--n {n}\t--n {n}\t\t\n", folder, "tests", "bench", "cases.tsv")
    write("case\tmethod\toptions\none\t{kind}\t--kind {kind} --n {n}\ntwo\tplain\t--kind plain --n {n}\n",
          folder, "tests", "bench", "methods.tsv")


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
    lines = read(folder, "bench", "tables", name + ".csv").splitlines()
    return [dict(zip(lines[0].split(","), line.split(","))) for line in lines[1:]]


def known_errors_are_found(folder):
    status, said = bench(folder, "--quick")
    check(status == 0 and "wrote" in said, "everything is measured", said)
    row = table(folder, "accuracy")[0]
    check(row["classic"] == "plain" and row["best"] == "fast", "the best method is found", row)
    # An error of 1 % takes 2500 plain samples, beyond the measured ones, and 50 fast ones.
    low, high = float(row["time_ratio_low"]), float(row["time_ratio_high"])
    check(low <= 50 <= high and row["goal_reached"] == "yes" and "extrapolated" in row["note"], "so is its gain in time", row)
    check(abs(float(row["slope"]) + 1) < 0.03 and float(row["slope_low"]) <= -1 <= float(row["slope_high"]), "and its slope", row)
    rows = [row for row in table(folder, "accuracy_convergence") if row["method"] == "plain" and row["feature"] == "one"]
    held = [float(row["rmse_low"]) <= 0.5 / math.sqrt(int(row["samples"])) <= float(row["rmse_high"]) for row in rows]
    check(len(rows) == 7 and sum(held) >= 5, "each number of samples has an interval for its error", rows)
    check([row["samples"] for row in rows] == ["1", "2", "4", "8", "16", "32", "64"], "samples are powers of 2", rows)
    check(asked(folder) == 3 * 7 * plan.QUICK.seeds, "each picture is rendered once")
    check(table(folder, "accuracy_trees")[0]["render"] == "0.2" and len(table(folder, "accuracy_numbers")) == 3,
          "trees and numbers have tables")


def finished_work_is_kept(folder):
    path = os.path.join(folder, "bench", "measurements.csv")
    before = read(path)
    status, said = bench(folder, "--quick")
    check(status == 0 and asked(folder) == 0 and read(path) == before, "what is measured is not measured again", said)
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
    check(status == 1 and said.count("slower, 20.0 % more time") == 3, "and compared with the one before, which is kept", said)


def begin(folder, pictures):
    """Starts make bench, and returns once so many pictures have been asked for."""
    process = subprocess.Popen([sys.executable, "-B", BENCH, "--build", folder, "--source", folder, "--quick"],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
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
    check(process.returncode == 130 and "Traceback" not in said and "goes on" in said, "an interruption is told in a sentence", said)
    kept = len(measurements.read(os.path.join(folder, "bench", "measurements.csv")))
    check(kept >= 40 - (os.cpu_count() or 1), "what was finished before is kept", kept)
    asked(folder)
    status, said = bench(folder, "--quick")
    check(status == 0 and asked(folder) == 3 * 7 * plan.QUICK.seeds - kept, "the rest is measured, and nothing else", said)


def mistakes_are_told(folder):
    path = os.path.join(folder, "bench", "measurements.csv")
    before = read(path)

    def refuses(name, words, *parts):
        status, said = bench(folder, "--quick", *words)
        lines = said.splitlines()  # the last of which is the message; before it only progress is told
        good = status == 2 and all(part in lines[-1] for part in parts) and all(line.startswith("bench: ") for line in lines)
        check(good, name, said)

    lines = before.splitlines(keepends=True)
    write("".join([*lines[:2], "junk\n", *lines[3:]]), path)
    refuses("a corrupt line is told with its place and a remedy", (), "measurements.csv:3:", "RESET=1")
    write("".join([*lines[:2], lines[2].replace(lines[2].split(",")[7], "fast"), *lines[3:]]), path)
    refuses("so is a cell that is no number", (), "measurements.csv:3:", "RESET=1")
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
    write("#!/bin/sh\necho 'bench: --n: there is no such option' >&2\nexit 1\n", folder, "tests", "bench", "bench")
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


# --- the program ---------------------------------------------------------------------------------


def numbers_of(program, line):
    return [float(cell) for cell in program.ask(line)]


def the_program_measures(folder):
    path = os.path.abspath(os.path.join("tests", "bench", "bench"))
    kinds = kinds_of(path, folder)
    check(kinds[0] == "uniform" and "low-discrepancy" in kinds, "it names the kinds of samplers", kinds)
    cases = plan.read_cases(os.path.join(SOURCE, "tests", "bench"), plan.QUICK, kinds)
    check(all({method.name for method in case.methods} >= set(kinds) for case in cases if case.name != "time"),
          "each kind is measured in each case", [[method.name for method in case.methods] for case in cases])
    adaptive = plan.Method(cases[0], "adaptive", "--error {error}")
    check(adaptive.options(4, 1) == f"--error 0.25 --seed {plan.SEED_STEP}" and not adaptive.counts_samples,
          "a method may choose its number of samples by an error", adaptive.options(4, 1))
    light = next(case for case in cases if case.name == "light")
    with Program(path, light.options, folder) as program:
        reference = numbers_of(program, f"reference kept {light.reference}")
        plain = light.methods[0]
        squares = {n: [numbers_of(program, "picture " + plain.options(n, seed))[1] for seed in range(1, 17)] for n in (4, 16)}
        # Independent samples: four times as many, a quarter of the squared error.
        ratio = [math.log(a - reference[2]) - math.log(b - reference[2]) for a, b in zip(squares[4], squares[16])]
        middle, low, high = statistics.mean_interval(ratio, 0.999)
        check(low <= math.log(4) <= high, "errors of independent samples fall as they must", (middle, low, high))
        again = numbers_of(program, "picture " + plain.options(4, 1))
        check(again[1] == squares[4][0], "the same picture has the same error")
        rays = numbers_of(program, "picture " + plain.options(4, 1))[4]
        check(rays == plan.QUICK.side ** 2, "rays are counted", rays)
        mean = numbers_of(program, "picture --pictures 4 " + plain.options(4, 1))
        check(mean[1] < squares[4][0] / 2 and mean[4] == 4 * rays, "the mean of four pictures has less error, and four times the rays", mean)
    with Program(path, "--scene statue:1000 --width 32 --height 32", folder) as program:
        trees = {leaf: numbers_of(program, f"tree {leaf}") for leaf in (0, 1, 8, 64)}
        check(trees[1][2] == 1000 and trees[64][2] < trees[8][2] < trees[0][2] < 1000, "leaves get the wanted size", trees)
        check(trees[64][5] < trees[1][5] and trees[64][6] > trees[1][6], "larger leaves cost fewer boxes and more triangles", trees)
        rows = [program.ask("numbers"), program.answer(), program.answer()]
        # Irradiance is computed in double and rounded once: at most half a unit in the last place.
        check(float(rows[1][2]) <= 2 ** -24 < float(rows[1][4]) and all(float(row[3]) < 2e-5 for row in rows),
              "float is compared with double", rows)
    before = read_bytes(folder, "kept")
    with open(os.path.join(folder, "kept"), "wb") as file:
        file.write(before[:-8])
    with Program(path, light.options, folder) as program:
        again = numbers_of(program, f"reference kept {light.reference}")
        check(again == reference and read_bytes(folder, "kept") == before, "a reference that is not whole is made again", again)
    for name, line, part in (("an option that does not exist", "picture --nonsense 3", "no such option"),
                             ("a word that is no question", "nonsense", "neither reference"),
                             ("a picture without a reference", "picture --seed 3", "reference before"),
                             ("a reference by one method", "reference kept --seed 3", "two lists"),
                             ("a reference without noise", "reference still --early-out 0 --seed 1 | --seed 2", "do not vary")):
        scene = "--scene cube --width 8 --height 8 --out ."
        answer = subprocess.run([path, *scene.split()], cwd=folder, input=line + "\n", text=True, check=False,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        check(answer.returncode == 1 and part in answer.stdout and len(answer.stdout.splitlines()) == 1,
              f"{name} is refused", answer.stdout)


def read_bytes(*path):
    with open(os.path.join(*path), "rb") as file:
        return file.read()


def main():
    if "--list" in sys.argv:  # the driver asks for names of tests, which it can do without
        return 0
    quantiles_are_those_of_tables()
    intervals_hold_the_truth()
    lines_and_crossings_are_exact()
    differences_are_told_from_noise()
    comparisons_find_losses_and_nothing_else()
    folder = tempfile.mkdtemp(prefix="raykit-test-bench-")
    try:
        invent(folder)
        known_errors_are_found(folder)
        finished_work_is_kept(folder)
        interruptions_cost_one_picture(folder)
        mistakes_are_told(folder)
        the_program_measures(tempfile.mkdtemp(dir=folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    sys.exit(main())
