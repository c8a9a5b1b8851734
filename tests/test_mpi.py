#!/usr/bin/env python3
"""--mpi: pictures of several processes are those of one to the bit; what is wrong is said once, and ends all
of them; a process that is killed leaves no picture. Speaks TAP, for make check-mpi; runs in a build folder.
MPIRUN is the program that configure found, or empty."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from png import filtered_rows, size_of  # noqa: E402
from tap import check, finish, start, write  # noqa: E402

MPIRUN = os.environ.get("MPIRUN", "")
MODULE = "raykit-mpi.so"
# Containers often have no other user; the machine may have fewer processors than the test processes. Open MPI
# itself keeps some memory to its end.
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "ASAN_OPTIONS": "detect_leaks=0"}
LONGEST = 120  # seconds, after which a run counts as hanging
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
SMALL = ("--width", "150", "--height", "90")


def driver(stem):
    folder = next(name for name in os.listdir("assignments") if name.endswith("_" + stem))
    return os.path.abspath(os.path.join("assignments", folder, stem))


def run(*command):
    """Returns the exit status and all output; 124 if it hangs."""
    with subprocess.Popen(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace") as process:
        try:
            said, _ = process.communicate(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            process.terminate()
            return 124, process.communicate()[0] + f"\nno end after {LONGEST} s"
    return process.returncode, said


def mpirun(processes, *command):
    return run(MPIRUN, "--oversubscribe", "--bind-to", "none", "-n", str(processes), *command)


def own_lines(said, stem):
    """What the driver said; mpirun adds how its processes ended."""
    return [line for line in said.splitlines() if line.startswith(stem + ": ")]


def pictures(folder):
    """Of each picture what its pixels follow from; texts in it tell the time."""
    found = {}
    for name in sorted(os.listdir(os.path.join(folder, "figures"))):
        path = os.path.join(folder, "figures", name)
        found[name] = size_of(path), filtered_rows(path)
    return found


def numbers(said):
    """The caption without its times, threads and folder: what was counted."""
    said = re.sub(r"^rendering: .*\n|^\S*/", "", said, flags=re.MULTILINE)
    return re.sub(r", (built|rendered) in [^,]*", "", said)


CASES = (("shading", ("--scene", "cornell", "--shadows", "--samples", "2")),
         ("motion_blur", ("--scene", "moving", "--time-samples", "4", "--lens-samples", "4", "--bloom",
                          "--bloom-threshold", "0.5")),
         ("adaptive_sampling", ("--error", "0.05", "--max-samples", "64")))


def pictures_are_those_of_one_process(folder):
    for stem, options in CASES:
        command = (driver(stem), *SMALL, *options)
        alone = os.path.join(folder, stem)
        status, want = run(*command, "--out", alone, "--threads", "2")
        check(status == 0, f"{stem}: one process draws", want)
        for processes in (1, 2, 3, 8):
            for threads in ("1", "2"):
                out = os.path.join(folder, f"{stem}-{processes}-{threads}")
                status, said = mpirun(processes, *command, "--mpi", "--out", out, "--threads", threads)
                name = f"{stem}: {processes} processes of {threads} threads draw the same picture"
                check(status == 0 and pictures(out) == pictures(alone), name, said)
                check(numbers(said) == numbers(want), "and one of them says the same of it",
                      f"{numbers(want)}{numbers(said)}")


def few_tiles_are_enough(folder):
    command = (driver("shading"), "--width", "5", "--height", "40")
    run(*command, "--out", folder + "/few")
    status, said = mpirun(8, *command, "--mpi", "--out", folder + "/few-8")
    check(status == 0 and pictures(folder + "/few-8") == pictures(folder + "/few"),
          "eight processes share three tiles", said)


def a_network_serves_as_well(folder):
    """By TCP, as if each process had a machine of its own."""
    stem, options = CASES[0]
    over_tcp = ("--mca", "btl", "self,tcp", "--mca", "osc", "pt2pt")
    status, said = run(MPIRUN, "--oversubscribe", "--bind-to", "none", *over_tcp, "-n", "3", driver(stem),
                       *SMALL, *options, "--mpi", "--out", folder + "/tcp")
    check(status == 0 and pictures(folder + "/tcp") == pictures(os.path.join(folder, stem)),
          "three processes that are connected by TCP draw the same picture", said)


def machines_with_other_instructions_fit(folder):
    stem, options = CASES[0]
    command = (driver(stem), *SMALL, *options, "--mpi", "--out", folder + "/isas")
    status, said = run(MPIRUN, "--oversubscribe", "--bind-to", "none", "-n", "1", *command,
                       ":", "-n", "1", "-x", "RAYKIT_ISA=scalar", *command)
    check(status == 0 and pictures(folder + "/isas") == pictures(os.path.join(folder, stem)),
          "a process of plain C and one of the widest instructions draw the same picture", said)


def it_works_without_mpirun(folder):
    stem, options = CASES[0]
    status, said = run(driver(stem), *SMALL, *options, "--mpi", "--out", folder + "/alone")
    same = pictures(folder + "/alone") == pictures(os.path.join(folder, stem))
    check(status == 0 and "of 1 process," in said and same, "without mpirun it is one process", said)


def is_refused(name, answer, stem, *parts):
    """Everybody ends, with one message, which has these parts."""
    status, said = answer
    lines = own_lines(said, stem)
    check(status not in (0, 124) and len(lines) == 1 and all(part in lines[0] for part in parts), name, said)


def mistakes_are_told_once(folder):
    command = (driver("shading"), "--mpi", "--out", folder + "/none")
    for options, part in ((("--samples", "x"), "--samples x"), (("--mesh", "missing.obj"), "missing.obj"),
                          (("--timing",), "--mpi and --timing"), (("--pixel", "1,1"), "--mpi and --pixel"),
                          (("--debug", "nothing"), "--debug")):
        is_refused(f"{options[0]} is refused once", mpirun(3, *command, *options), "shading", part)
    write("", folder, "file")
    is_refused("a folder that cannot be made is told once",
               mpirun(3, driver("shading"), "--mpi", "--out", folder + "/file"), "shading", folder)
    stem, options = CASES[0]
    picture = os.path.join(folder, "folder/figures", next(iter(pictures(os.path.join(folder, stem)))))
    os.makedirs(picture)
    is_refused("a picture that cannot be written is told once",
               mpirun(3, driver(stem), *options, *SMALL, "--mpi", "--out", folder + "/folder"), stem, picture)
    status, said = mpirun(3, driver("shading"), "--mpi", "--help")
    check(status == 0 and said.count("usage: ") == 1, "help is printed once", said)
    check(not os.path.exists(folder + "/none/figures") or os.listdir(folder + "/none/figures") == [],
          "and no picture is drawn")


def differing(folder, here, there):
    """Two processes, the second in another folder or with other options."""
    first = ("-n", "1", "-wdir", folder + "/here", driver("shading"), "--mpi", *here)
    second = (":", "-n", "1", "-wdir", folder + "/there", driver("shading"), "--mpi", *there)
    return run(MPIRUN, "--oversubscribe", "--bind-to", "none", *first, *second)


def processes_that_differ_are_refused(folder):
    write(TRIANGLE, folder, "here", "a.obj")
    write(TRIANGLE.replace("1 0 0", "2 0 0"), folder, "there", "a.obj")
    write(TRIANGLE, folder, "here", "b.obj")
    if os.path.exists("raykit-mesh"):
        mesh = ("--out", "x", "--mesh")
        is_refused("another file of the same name is told",
                   differing(folder, (*mesh, "a.obj"), (*mesh, "a.obj")), "shading", "process 1 on ",
                   "another scene")
        is_refused("a file that one lacks is told",
                   differing(folder, (*mesh, "b.obj"), (*mesh, "b.obj")), "shading", "process 1 on ", "b.obj")
    is_refused("other options are told", differing(folder, ("--samples", "2"), ("--samples", "3")),
               "shading", "process 1 on ", "other options")
    is_refused("a wrong option of one is told", differing(folder, (), ("--sampels", "3")), "shading",
               "process 1 on ", "--sampels")
    status, said = differing(folder, ("--out", "x", *SMALL), ("--out", "y", *SMALL))
    check(status == 0 and os.listdir(folder + "/there") == ["a.obj"],
          "process 0 alone writes, wherever the others are", said + str(os.listdir(folder + "/there")))


def member(number, folder):
    """The process of this number that writes into the folder, where /proc tells; None."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/environ", "rb") as file:
                environment = file.read().split(b"\0")
            with open(f"/proc/{pid}/cmdline", "rb") as file:
                words = file.read().split(b"\0")
        except OSError:
            continue
        if f"OMPI_COMM_WORLD_RANK={number}".encode() in environment and folder.encode() in words:
            return int(pid)
    return None


def a_killed_process_leaves_no_picture(folder):
    for number in (0, 2):
        out = f"{folder}/killed-{number}"
        command = (MPIRUN, "--oversubscribe", "--bind-to", "none", "-n", "3", driver("shading"), "--mpi",
                   "--samples", "4096", "--width", "2000", "--height", "2000", "--threads", "1", "--out", out)
        with subprocess.Popen(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True) as process:
            victim, deadline = None, time.monotonic() + LONGEST
            while (victim is None or not os.path.isdir(out + "/figures")) and time.monotonic() < deadline:
                time.sleep(0.1)
                victim = member(number, out)
            time.sleep(1)  # it renders by now
            if victim:
                os.kill(victim, signal.SIGKILL)
            try:
                said, _ = process.communicate(timeout=LONGEST)
            except subprocess.TimeoutExpired:
                process.terminate()
                said = "it goes on without the process"
        check(victim and process.returncode != 0 and "signal 9" in said and not own_lines(said, "shading"),
              f"without process {number} all end", said)
        left = os.listdir(out + "/figures")
        check(left == [], "and leave no picture, not even a part", left)


def a_model_tells_of_many_machines(folder):
    for options in (("--scene", "cornell", "--samples", "4"), ("--error", "0.1", "--max-samples", "64")):
        status, said = run("tests/bench/processes", "--quiet", *SMALL, *options, "--out", folder)
        rows = [list(map(float, line.split())) for line in said.splitlines()[2:]]
        check(status == 0 and [row[0] for row in rows] == [1, 2, 4, 8, 16, 32, 64] and
              rows[0][2:] == [1, 1, 1], f"{options[0]}: a model has rows for 1 to 64 processes", said)
        perfect = [row[4] for row in rows]
        check(perfect == sorted(perfect) and
              all(row[2] <= row[4] <= row[0] for row in rows),
              "which are as many times as fast at most, and less so by an ordinary network", said)


def main():
    with tempfile.TemporaryDirectory() as folder:
        a_model_tells_of_many_machines(folder)
        if not os.path.exists(MODULE):
            status, said = run(driver("shading"), "--mpi", "--out", folder + "/none")
            check(status == 1 and said.count("\n") == 1 and "libopenmpi-dev" in said and
                  not os.path.exists(folder + "/none"), "without MPI one sentence says what to install", said)
            check(True, "pictures of several processes # SKIP Open MPI is missing: ./bootstrap --mpi")
            return finish()
        if not MPIRUN:
            check(True, "pictures of several processes # SKIP mpirun is missing: ./bootstrap --mpi")
            return finish()
        pictures_are_those_of_one_process(folder)
        few_tiles_are_enough(folder)
        a_network_serves_as_well(folder)
        machines_with_other_instructions_fit(folder)
        it_works_without_mpirun(folder)
        mistakes_are_told_once(folder)
        processes_that_differ_are_refused(folder)
        a_killed_process_leaves_no_picture(folder)
    return finish()


if __name__ == "__main__":
    start(main)
