"""What is measured without random samples: trees by number of bins and size of leaves, and float against
double."""

import csv
import os

from benchmark.measurements import write_table
from benchmark.schedule import Program
from benchmark.statistics import median

SCENE = "--scene statue --width 256 --height 256"
AXES = {"sah": "the longest", "sah3": "all"}
BINS = (2, 4, 8, 16, 32, 50, 64, 128, 256)
LEAVES = (1, 2, 4, 8, 16, 32, 64)

TREE_NUMBERS = ("build", "render", "leaves", "levels", "cost", "boxes", "triangles")
TREE_COLUMNS = ("study", "axes", "bins", "leaf", *TREE_NUMBERS, "runs", "program")
NUMBER_COLUMNS = ("function", "inputs", "largest", "rms", "largest_plain", "rms_plain")


def _plan():
    """(study, split, bins, leaf); a leaf of 0 triangles stands for leaves as built."""
    return [("bins", split, bins, 0) for split in AXES for bins in BINS] + \
        [("leaves", "sah3", 50, leaf) for leaf in LEAVES]


def measure_trees(program, folder, runs):
    """Trees take turns, as methods do; times are medians."""
    programs, answers = {}, {row: [] for row in _plan()}
    try:
        for _ in range(runs):
            for row in answers:
                _, split, bins, leaf = row
                if (split, bins) not in programs:
                    programs[split, bins] = Program(program, f"{SCENE} --split {split} --bins {bins}", folder)
                answers[row].append([float(cell) for cell in programs[split, bins].ask(f"tree {leaf}")])
    finally:
        for running in programs.values():
            running.close()
    return [[study, AXES[split], bins, leaf or "as built",
             *(f"{median(list(column)):.6g}" for column in zip(*measured))]
            for (study, split, bins, leaf), measured in answers.items()]


def measure_numbers(program, folder):
    with Program(program, "--scene triangle --width 1 --height 1", folder) as running:
        return [running.ask("numbers")] + [running.answer() for _ in range(2)]


def _is_measured(path, program, runs):
    """Does the file hold the measurement of this program, with as many runs?"""
    if not os.path.exists(path):
        return False
    with open(path, encoding="utf-8", errors="replace", newline="") as file:
        rows = list(csv.DictReader(file))
    return len(rows) == len(_plan()) and all(
        row.get("program") == program and (row.get("runs") or "0").isdigit() and int(row["runs"]) >= runs
        for row in rows)


def measure(program, checksum, folder, tables, runs):
    path = os.path.join(tables, "accuracy_trees.csv")
    if not _is_measured(path, checksum, runs):
        rows = measure_trees(program, folder, runs)
        write_table(path, TREE_COLUMNS, [[*row, runs, checksum] for row in rows])
    write_table(os.path.join(tables, "accuracy_numbers.csv"), NUMBER_COLUMNS,
                measure_numbers(program, folder))
