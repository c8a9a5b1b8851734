#!/usr/bin/env python3
"""make bench-peers: its message without Embree, and with Embree a short measurement whose tables must agree
with each other. Speaks TAP, for make check-bench-peers; runs in a build folder. EMBREE is the version that
configure found, or empty."""

import csv
import os
import shutil
import sys
import tempfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True

from tap import check, finish, read, run, write  # noqa: E402

MAKE = os.environ.get("MAKE", "make")
EMBREE = os.environ.get("EMBREE", "")
COLUMNS = "workload,scene,engine,mode,threads,value,unit,ratio_to_raykit,mismatches"
TRACED = ("primary", "point-shadow", "area-shadow", "diffuse")
SCENES = ("statue:2000", "room:500")
PACKETS = [f"packet{width}-{kind}" for width in (4, 8, 16) for kind in ("coherent", "incoherent")]
STREAMS = ["stream-coherent", "stream-incoherent"] if EMBREE == "3" else []  # Embree 4 has none
ROUNDS = 5
# Figures have six significant digits, each off by 5e-6 at most: a ratio and the two of which it is.
DIGITS = 1.5e-5


def table(folder, name):
    with open(os.path.join(folder, "tables", name + ".csv"), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def key(row):
    return row["workload"], row["scene"], row["engine"], row["mode"], row["threads"]


def without_embree_it_says_what_to_install(folder):
    status, said = run(".", MAKE, "-s", "bench-peers", "EMBREE=", "OUT=" + folder)
    lines = [line for line in said.splitlines() if not line.startswith("make")]
    check(status != 0 and len(lines) == 1 and "Embree is missing" in lines[0] and "libembree-dev" in lines[0]
          and
          "./bootstrap --peers" in lines[0], "without Embree one sentence says what to install", said)
    check(os.listdir(folder) == [], "and nothing is written", os.listdir(folder))


def measure(folder, *settings):
    return run(".", MAKE, "-s", "bench-peers", "QUICK=1", "OUT=" + folder, *settings)


def mistakes_are_told(folder):
    for settings, part in ((["SCENES=no-such-scene"], "no-such-scene"), (["SCENES=shininess"], "spheres"),
                           (["SCENES=triangle", "MESHES=missing.ply"], "missing.ply")):
        status, said = measure(folder, *settings)
        lines = [line for line in said.splitlines() if line.startswith(("bench-peers: ", "MESHES: "))]
        check(status != 0 and len(lines) == 1 and part in lines[0] and os.listdir(folder) == [],
              f"{settings[-1]} is refused in one sentence, and nothing is written", said)


def rows_are_complete(rows):
    threads = sorted({row["threads"] for row in rows})
    check(threads == ["1", "2"], "modes are measured on one thread and on two", threads)
    check(len({key(row) for row in rows}) == len(rows), "no row is there twice")
    modes = {(row["workload"], row["scene"], row["threads"], row["engine"]): set() for row in rows}
    for row in rows:
        modes[row["workload"], row["scene"], row["threads"], row["engine"]].add(row["mode"])
    ways = {name + robust for name in ["single", *PACKETS, *STREAMS] for robust in ("", "-robust")}
    trees = {"low", "medium", "high", "medium-robust"}
    for scene in SCENES:
        for n in threads:
            of_raykit = [modes.get((workload, scene, n, "raykit"), set()) for workload in (*TRACED, "build")]
            check(len(of_raykit[0]) >= 3 and all(found == of_raykit[0] for found in of_raykit),
                  f"{scene}, threads {n}: all of raykit's trees are built and traced", of_raykit)
            check(all(modes.get((workload, scene, n, "embree")) == ways for workload in TRACED) and
                  modes.get(("build", scene, n, "embree")) == trees,
                  f"{scene}, threads {n}: so are Embree's modes")


def ratios_are_those_of_the_values(folder, rows):
    modes = {row["raykit_mode"] for row in table(folder, "peers_best")}
    check(len(modes) == 1, "raykit's usual mode is the same everywhere", str(modes))
    usual = {(row["workload"], row["scene"], row["threads"]): row for row in rows if row["mode"] in modes}
    off = []
    for row in rows:
        of = usual.get((row["workload"], row["scene"], row["threads"]))
        wanted = float(row["value"]) / float(of["value"]) if of else 0
        if not of or not float(row["value"]) > 0 or abs(float(row["ratio_to_raykit"]) / wanted - 1) > DIGITS:
            off.append(str(row))
    check(not off, "a ratio is the value over that of raykit's usual mode", off)
    check(all(row["unit"] == ("ms" if row["workload"] == "build" else "Mrays/s") for row in rows),
          "units are right")


def answers_agree(folder, rows):
    check(all(row["mismatches"] == "0" for row in rows if row["engine"] == "raykit"),
          "raykit's trees agree to the bit")
    counted, causes = {}, {row["cause"]: row for row in table(folder, "peers_causes")}
    for row in table(folder, "peers_mismatches"):
        place = (row["workload"], row["scene"], row["engine"], row["mode"])
        counted[place] = counted.get(place, 0) + int(row["rays"])
    check(all(int(row["mismatches"]) == counted.get(key(row)[:4], 0) for row in rows
              if row["threads"] == "1"),
          "each mismatch has a cause", str(counted))
    unexplained = [causes[name] for name in ("box", "values", "unknown")]
    check(all(row["embree"] == row["robust"] == "0" for row in unexplained),
          "and it is rounding at edges and ends", str(causes))
    check(int(causes["same"]["embree"]) > 10000 and int(causes["same"]["robust"]) > 10000,
          "nearly all answers are equal")
    values = table(folder, "peers_values")
    check([row["value"] for row in values] == ["t", "u and v", "normal"] and
          all(0 < float(row[mode]) <= 1 for row in values for mode in ("embree", "robust")),
          "t, u, v and normals are compared, and differ by rounding alone", str(values))


def companions_agree(folder, rows):
    medians = {key(row): row["value"] for row in rows}
    spread = table(folder, "peers_spread")
    check({key(row): row["median"] for row in spread} == medians, "the spread has the same medians")
    check(all(float(row["min"]) <= float(row["median"]) <= float(row["max"]) and int(row["rounds"]) >= ROUNDS
              for row in spread), "between the least and the largest of at least five rounds")
    wrong = []
    for row in table(folder, "peers_best"):
        here = {r["mode"]: float(r["value"]) for r in rows if r["engine"] == "embree" and
                (r["workload"], r["scene"], r["threads"]) == (row["workload"], row["scene"], row["threads"])}
        build = row["workload"] == "build"
        best = here["medium"] if build else max(here.values())
        robust = max(value for mode, value in here.items() if "robust" in mode)
        for value, ratio, wanted in ((row["embree"], row["speed_ratio"], best),
                                     (row["robust"], row["robust_speed_ratio"], robust)):
            faster = float(value) / float(row["raykit"]) if build else float(row["raykit"]) / float(value)
            reached = "yes" if float(row["speed_ratio"]) >= float(row["goal"]) else "no"
            is_off = abs(float(ratio) - faster) > 0.0006  # it has three decimals
            if float(value) != wanted or row["goal_reached"] != reached or is_off:
                wrong.append(str(row))
    check(not wrong,
          "the best mode is the fastest, and builds are those of medium quality; "
          "goals are compared with ratios", wrong)
    memory = table(folder, "peers_memory")
    check({row["engine"] for row in memory} >= {"embree"} and
          all(10 < float(row["bytes_per_triangle"]) < 1000 for row in memory), "trees take memory",
          str(memory))


def a_mesh_is_measured(folder):
    """A square pyramid."""
    path = os.path.join(folder, "pyramid.off")
    write("OFF\n5 6 0\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n0 0 1\n"
          "3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n3 0 2 1\n3 0 3 2\n", path)
    status, said = measure(folder, "SCENES=statue:100", "MESHES=" + path)
    check(status == 0 and {row["scene"] for row in table(folder, "peers")} == {"statue:100", "pyramid.off"},
          "MESHES adds a mesh, by its file's name", said)


def main():
    if "--list" in sys.argv:  # the driver asks for names of tests, which it can do without
        return 0
    folder = tempfile.mkdtemp(prefix="raykit-test-peers-")
    try:
        without_embree_it_says_what_to_install(folder)
        if EMBREE:
            mistakes_are_told(folder)
            status, said = measure(folder, "SCENES=" + " ".join(SCENES))
            check(status == 0 and "peers.csv" in said, "a quick measurement succeeds", said)
            rows = table(folder, "peers")
            check(read(folder, "tables", "peers.csv").splitlines()[0] == COLUMNS, "peers.csv has its columns")
            rows_are_complete(rows)
            ratios_are_those_of_the_values(folder, rows)
            answers_agree(folder, rows)
            companions_agree(folder, rows)
        if EMBREE and os.path.exists("raykit-mesh"):
            a_mesh_is_measured(tempfile.mkdtemp(dir=folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    sys.exit(main())
