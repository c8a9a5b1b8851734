#!/usr/bin/env python3
"""Classes of made-up submissions of normals: graded at once, one by one, interrupted, with a worker killed, a
full disk, or by machines that know nothing of each other, they have the same table. Speaks TAP, for make
check-class; runs in a build folder."""

import contextlib
import csv
import glob
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from unittest import mock

import test_grade
from test_grade import FEATURES, SOURCE, put, read, run
from grading import build
from grading import parallel_jobs
from grading import private_copy
from grading import sandbox
from grading.assignments import MachineError, Unit
from grading.starters import starter_of
from tap import check, finish, start, wait

FEATURE = FEATURES["normals"]
STARTER, RIGHT = starter_of(FEATURE.reference), read(FEATURE.reference)
WHEN = 7  # the column of class.csv that says when


def tool(name, *arguments):
    return [sys.executable, "-B", os.path.join(SOURCE, "tools", name + ".py"), "normals", *arguments]


def class_command(place, out, *more):
    return tool("grade_class", "--submissions", place, "--out", out, *more)


def grade_class(place, out, *more):
    return run(*class_command(place, out, *more))


def rows_of(out):
    """Returns the rows of class.csv by name, without when they were made."""
    with open(os.path.join(out, "class.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return {row[0]: row[:WHEN] + row[WHEN + 1:] for row in rows[1:]}


def made_class(folder, size):
    """Right, wrong, unfinished and ungradable submissions, with names of all kinds. Returns the folder."""
    place = os.path.join(folder, f"class of {size}")
    wrong = RIGHT.replace("rk_cross(", "rk_cross_of_two(", 1)
    kinds = [RIGHT, STARTER, "int early;\n", RIGHT.replace("return", "return ", 1), wrong]
    for number in range(size):
        put(kinds[number % len(kinds)], place, f"{number:02} O'Neil & \"co\" $(x) %s {{}}", "normals.c")
    put("", place, "99.zip")
    put(RIGHT, place, "98", "Normals.C")
    return place


def expected(folder, size):
    """Returns a class, and its table, of one by one."""
    place, out = made_class(folder, size), os.path.join(folder, f"expected {size}")
    if not os.path.exists(out):
        status, said = grade_class(place, out, "--jobs", "1")
        rows = rows_of(out)
        check(status == 1 and len(rows) == size + 2 and rows["99.zip"][1] == rows["98"][1] == ""
              and {row[1] for row in rows.values()} == {"", "0", "100"},
              "one by one, a class has its table, with empty cells where nobody knows", said)
    return place, rows_of(out)


def at_once_is_the_same(folder):
    place, rows = expected(folder, 5)
    out = os.path.join(folder, "at once {} {#} \\")
    with mock.patch.dict(os.environ, SHELL="/bin/false"):
        status, said = grade_class(place, out, "--jobs", "2")
    check(status == 1 and rows_of(out) == rows, "two at once give the same table, whatever one's shell", said)
    status, said = grade_class(place, out)
    check(rows_of(out) == rows and said.count("unchanged") == 5 and "no verdict" not in said,
          "a second time, nothing is graded again", said)
    reports = {path: read(path) for path in glob.glob(os.path.join(glob.escape(out), "*.json"))}
    check(len(reports) == 7 and all(json.loads(text)["tests"] for text in reports.values()),
          "each has its report", list(reports))
    status, said = grade_class(place, os.path.join(folder, "by hosts"), "--hosts", ":", "--jobs", "2")
    check(rows_of(os.path.join(folder, "by hosts")) == rows and not glob.glob(
        os.path.join(folder, "by hosts", ".*")), "so does this machine as one of HOSTS", said)


def lines_that_run_together_lose_nobody(folder):
    engine = parallel_jobs.Engine(2, [], folder)
    said = [(ended.number, ended.fault) for ended in engine.run(
        ["sh", "-c", 'printf \'{"number": 1}{"number": 2}\'; test "$2" != 3', "sh"], [1, 2, 3])]
    check(sorted(said) == [(1, ""), (2, ""), (3, "its grader was ended, by status 1")],
          "lines that run together lose nobody", said)


def what_changes_is_graded_again(folder):
    place, out = os.path.join(folder, "changing"), os.path.join(folder, "changed")
    for name in ("ann", "bob"):
        put('#include "own.h"\n' + RIGHT, place, name, "normals.c")
        put("/* nothing */\n", place, name, "own.h")
    grade_class(place, out)

    def again(*more):
        status, said = grade_class(place, out, *more)
        return status == 0 and [name for name in ("ann", "bob")
                                if not re.search(rf"{name} .*unchanged", said) and f"  {name} " in said]

    check(again() == [], "submissions that have not changed are not graded again")
    put("#error \"no\"\n", place, "ann", "own.h")
    check(again() == ["ann"] and rows_of(out)["ann"][1] == "0", "who changed a header of their own is",
          rows_of(out))
    check(again("--only", "b*", "--again") == ["bob"],
          "AGAIN grades what has not changed, ONLY what it names")
    status, said = grade_class(place, out, "--only", "carl")
    check(status == 2 and "ONLY=carl: there is no such submission" in said, "who is not there is told", said)
    with mock.patch.dict(os.environ, RAYKIT_SEED="7"):
        check(again() == ["ann", "bob"], "other random cases are another grade")


def workers(out):
    """Returns the numbers of this class's workers."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{name}/cmdline", "rb") as file:
            words = file.read().split(b"\0")
            if any(word.endswith(b"grade_one.py") for word in words[:6]) and os.fsencode(out) in words:
                found.append(int(name))
    return found


def hidden(out):
    return sorted(name for name in os.listdir(out) if name.startswith("."))


def only_folders_of_the_dead_are_removed(folder):
    """Many at once, of which each removes what the others leave: processes that are killed while they have a
    folder, and others that look at theirs as long as they live."""
    place = os.path.join(folder, "many")
    os.mkdir(place)
    put("a", place, ".jobs-foreign-file")
    script = ("import os, sys, time\nfrom grading.temporary_folder import temporary_folder\n"
              "for _ in range(100):\n"
              "    with temporary_folder('.jobs-', sys.argv[1]) as folder:\n"
              "        open(os.path.join(folder, 'a'), 'w').close()\n"
              "        time.sleep(0.002)\n"
              "        assert os.path.exists(os.path.join(folder, 'a'))\n"
              "        if sys.argv[2] == 'killed':\n"
              "            os.kill(os.getpid(), 9)\n")
    command = [sys.executable, "-B", "-c", script, place]
    environment = dict(os.environ, PYTHONPATH=os.path.join(SOURCE, "tools"))
    living = [subprocess.Popen([*command, "living"], env=environment, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True) for _ in range(4)]
    killed = [subprocess.run([*command, "killed"], env=environment, check=False).returncode for _ in range(8)]
    said = [process.communicate()[0] for process in living]
    check(not any(process.returncode for process in living) and set(killed) == {-signal.SIGKILL},
          "no folder of a living process is removed", [*said, *map(str, killed)])
    left = hidden(place)
    subprocess.run([*command, "living"], env=environment, check=False)
    check(hidden(place) == [".jobs-foreign-file"], "those of killed ones are, and nothing else",
          [*left, *hidden(place)])


def a_class_is_interrupted(folder):
    place, rows = expected(folder, 5)
    for name, number, status in (("stopped", signal.SIGINT, 130),
                                 ("killed", signal.SIGKILL, -signal.SIGKILL)):
        out = os.path.join(folder, name)
        process = subprocess.Popen(class_command(place, out, "--jobs", "2"), stdout=subprocess.PIPE,
                                   text=True, stderr=subprocess.STDOUT, start_new_session=True)
        begun = wait(lambda out=out: workers(out))
        process.send_signal(number)
        said = process.communicate()[0]
        check(begun and process.returncode == status and (number == signal.SIGKILL or "goes on" in said),
              f"a class can be {name}", said)
        check(wait(lambda out=out: not workers(out)), f"no worker outlives it ({name})", said)
        left = hidden(out)
        _, said = grade_class(place, out, "--jobs", "2")
        check(rows_of(out) == rows, f"the same command goes on ({name})", said)
        check(bool(left) == (name == "killed") and not hidden(out),
              f"and removes what was left there ({name})", [*left, *hidden(out)])


def a_killed_worker_is_replaced(folder):
    place, rows = expected(folder, 5)
    out = os.path.join(folder, "worker")
    process = subprocess.Popen(class_command(place, out, "--jobs", "2"), stdout=subprocess.PIPE,
                               text=True, stderr=subprocess.STDOUT)
    victims = wait(lambda: workers(out))
    for victim in victims or []:
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
    said = process.communicate()[0]
    check(victims and rows_of(out) == rows and process.returncode == 1,
          "the submission of a worker that is killed is put back", said)


def kit_bytes():
    """Returns how large the copy of the kit is that a class is graded with."""
    toolchain = build.Toolchain(".")
    toolchain.judges = True
    with private_copy.borrowed(None, toolchain, FEATURES, [FEATURE.stem]) as kit:
        return sum(-(-os.path.getsize(os.path.join(where, name)) // 4096) * 4096
                   for where, _, names in os.walk(kit) for name in names)


def a_full_disk_is_nobodys_fault(folder):
    """A small disk of our own, in a namespace: what is written there is lost with it."""
    place, rows = expected(folder, 5)
    out, small = os.path.join(folder, "full"), os.path.join(folder, "small")
    grade_class(place, out, "--jobs", "1", "--only", "00*")
    os.mkdir(small)
    kit = kit_bytes()
    for jobs, size in (("1", kit + (1 << 20)), ("2", kit + (1 << 20)), ("2", kit // 2)):
        full = f"mount -t tmpfs -o size={size} none \"$0\" && TMPDIR=\"$0\" exec \"$@\""
        status, said = run("unshare", "--user", "--map-root-user", "--mount", "sh", "-c", full, small,
                           *class_command(place, out, "--jobs", jobs))
        told = rows_of(out)
        check(status == 75 and ("free some space" in said and "give the same command again" in said
                                or size < kit and "No space left" in said),
              f"a full disk is said, and what to do (JOBS={jobs})", f"{status}: {said}")
        first = next(name for name in rows if name.startswith("00"))
        wrong = [row for name, row in told.items() if row[1] and row != rows[name]]
        check(told[first] == rows[first] and not wrong,
              f"what was graded stays, and no full disk is 0 points (JOBS={jobs})", wrong)
    _, said = grade_class(place, out)
    check(rows_of(out) == rows, "with space, the same command goes on", said)


def tools_that_fail_on_a_full_disk(folder):
    full = mock.Mock(f_bavail=0, f_frsize=4096, f_files=0, f_favail=0)
    with mock.patch.object(os, "statvfs", lambda _: full):
        try:
            build.compile_unit(build.Toolchain("."), Unit(FEATURE, put_broken(folder), "x.c", False), folder)
            said = ""
        except MachineError as error:
            said = str(error)
    check("is full" in said, "a compiler that fails on a full disk says nothing of the unit", said)


def no_memory_is_nobodys_fault(folder):
    """A program is killed from outside, while Linux counts one more that it has ended for want of memory."""
    command = [sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"]
    for more in (0, 1):
        count = sandbox._KILLED_BEFORE + more
        with mock.patch.object(sandbox, "_killed_for_memory", lambda count=count: count):
            try:
                outcome = sandbox.run(command, seconds=60, megabytes=1000, folder=folder, environment={})
                said = outcome.status
            except MachineError as error:
                said = str(error)
        check("no memory left" in said if more else said == -signal.SIGKILL,
              "who is ended for want of memory has no verdict" if more else "who ends itself has", said)


def put_broken(folder):
    put("int x\n", folder, "broken", "normals.c")
    return os.path.join(folder, "broken", "normals.c")


def machines_apart_are_one_class(folder):
    """One submission each, by the command that queues run; then the table of all."""
    place, rows = expected(folder, 5)
    outs = [os.path.join(folder, name) for name in ("machine a", "machine b")]
    wanted = {"99.zip": 3, "98": 3}
    for number, name in enumerate(sorted(os.listdir(place))):
        status, said = run(*tool("grade_one", "--submission", os.path.join(place, name), "--name", name,
                                 "--out", outs[number % 2]))
        check(status == wanted.get(name, 0) and said.count("\n") == 1,
              f"one submission has its status ({name})", f"{status}: {said}")
    table = os.path.join(folder, "merged")
    os.mkdir(table)
    status, said = run(*tool("class_table", "--folders", *outs, "--out", table))
    check(status == 0 and rows_of(table) == rows, "verdicts of several machines are one table", said)
    status, said = run(*tool("class_table", "--folders", folder, "--out", table))
    check(status == 2 and "no verdict files" in said, "a folder without verdicts is told", said)
    put("#!/bin/sh\nexit 1\n", folder, "no sandbox", "bwrap")
    os.chmod(os.path.join(folder, "no sandbox", "bwrap"), 0o755)
    with mock.patch.dict(os.environ, PATH=os.path.join(folder, "no sandbox") + ":" + os.environ["PATH"]):
        status, said = run(*tool("grade_one", "--submission", os.path.join(place, "98"),
                                 "--out", os.path.join(folder, "nothing")))
    check(status == 75 and "there is no sandbox" in said
          and not os.path.exists(os.path.join(folder, "nothing")),
          "a machine without a sandbox writes nothing, and has another one try", f"{status}: {said}")
    status, said = run(*tool("grade_one", "--submission", os.path.join(place, "nobody"), "--out", outs[0]))
    check(status == 2 and "there is no submission" in said, "so is a submission that is not there", said)


def a_grading_kit_grades_anywhere(folder):
    place, rows = expected(folder, 5)
    kit, there, out = (os.path.join(folder, name) for name in ("kit.tar.gz", "else where", "of the kit"))
    status, said = run(*tool("grading_kit", "--out", kit))
    check(status == 0 and os.path.exists(kit), "a grading kit is packed", said)
    with tarfile.open(kit) as archive:
        archive.extractall(there)
    top = os.path.join(there, "raykit-grading")
    status, said = run(sys.executable, "-B", os.path.join(top, "tools", "grade_class.py"), "normals",
                       "--build", os.path.join(top, "build"), "--submissions", place, "--out", out)
    check(status == 1 and rows_of(out) == rows, "unpacked elsewhere, it gives the same table", said)
    status, said = grade_class(place, out)
    check(said.count("unchanged") == 5, "its verdicts have the keys of the build that it was made of", said)


def other_programs_of_that_name(folder):
    place, _ = expected(folder, 5)
    put("#!/bin/sh\necho 'parallel: invalid option'\n", folder, "tools", "parallel")
    os.chmod(os.path.join(folder, "tools", "parallel"), 0o755)
    with mock.patch.dict(os.environ, PATH=os.path.join(folder, "tools") + ":" + os.environ["PATH"]):
        check(parallel_jobs.find_parallel() == "", "moreutils' parallel is not GNU's")
        status, said = grade_class(place, os.path.join(folder, "without"), "--jobs", "2")
        check(status == 2 and "need GNU parallel" in said, "JOBS without GNU parallel is told", said)
        _, said = grade_class(place, os.path.join(folder, "expected 5"))
        check("one after the other, as GNU parallel is not installed" in said,
              "without JOBS it is done without", said)
    status, said = grade_class(place, os.path.join(folder, "without"), "--jobs", "many")
    check(status == 2 and "JOBS=many" in said, "JOBS is a number", said)


def main():
    sandbox.prepare()
    folder = tempfile.mkdtemp(prefix="raykit-test-class-")
    try:
        if not parallel_jobs.find_parallel() or test_grade.NO_SANDBOX:
            print("1..0 # SKIP needs GNU parallel and bubblewrap")
            return 0
        for claim in (at_once_is_the_same, lines_that_run_together_lose_nobody,
                      what_changes_is_graded_again, only_folders_of_the_dead_are_removed,
                      a_class_is_interrupted, a_killed_worker_is_replaced, a_full_disk_is_nobodys_fault,
                      tools_that_fail_on_a_full_disk, no_memory_is_nobodys_fault,
                      machines_apart_are_one_class, a_grading_kit_grades_anywhere,
                      other_programs_of_that_name):
            claim(folder)
    finally:
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
