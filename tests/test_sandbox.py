#!/usr/bin/env python3
"""Graded code tries to read, change, stop and outlive what is not its own. Speaks TAP, for make
check-grade; runs in a build folder. Where bubblewrap makes no sandbox, most claims are skipped."""

import contextlib
import csv
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from unittest import mock

import test_grade
from by_address import by_address
from tap import check, finish, start
from test_grade import EMPTY, FEATURE, FEATURES, ONE, SOURCE, put, run, unit

from grading import bubblewrap
from grading import build
from grading import idleness
from grading import isolate
from grading import private_copy
from grading import sandbox
from grading.assignments import ScoredTest, ToolError
import grade

HEADERS = """
#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <sys/stat.h>
""" + by_address("_exit", "atoi", "close", "connect", "fclose", "fopen", "fork", "fread", "getppid", "kill",
                 "open",
                 "opendir", "pause", "raise", "rename", "setsid", "socket", "usleep", "write")


def verdicts_on(toolchain, folder, units, **limits):
    """Builds and runs these units, a dictionary from name to text, as a submission would be: on copies.
    Returns their suites by name."""
    place = tempfile.mkdtemp(dir=folder)
    copied = private_copy.copy_kit(toolchain, FEATURES, [FEATURE.stem], place)
    suites = {name: test_grade.make_suite(place, number, text, [ScoredTest(EMPTY, 1, "#")])
              for number, (name, text) in enumerate(units.items())}
    grade.grade(copied, list(suites.values()), {}, **{"seconds": 60, **limits})
    sandbox.end_strays()
    return suites


def said_of(suite):
    verdict = suite.verdicts[EMPTY]
    return f"{verdict.reason}\n{verdict.place}\n{verdict.details}"


# --- What a run can reach -------------------------------------------------------------------------


def opens(paths, flags):
    """A unit that aborts if it can open one of these files."""
    tries = "\n    ".join(f'if (open("{path}", {flags}) >= 0) abort();' for path in paths)
    return unit(tries, HEADERS)


def reaches(folder, port):
    """Units that abort where they reach what is not theirs; without the sandbox, each does."""
    outside = os.path.join(folder, "outside")
    pathlib.Path(outside).write_text("a friend's program", encoding="utf-8")
    git = subprocess.run(["git", "-C", SOURCE, "rev-parse", "--absolute-git-dir"], capture_output=True,
                         text=True,
                         check=False).stdout.strip()
    kits = [os.path.abspath(path) for path in (f"tests/test_{FEATURE.stem}.o", "librktest.a", "config.status",
                                               "Makefile", FEATURE.points_table, FEATURE.reference)]
    return {
        "reads the reference": opens([FEATURE.reference], "O_RDONLY"),
        "reads its object": opens([os.path.abspath(f"src/features/{FEATURE.stem}.o")], "O_RDONLY"),
        "reads a program beside its source": opens([outside], "O_RDONLY"),
        "writes to the kit": opens([*kits, *([os.path.join(git, "HEAD")] if git else [])], "O_WRONLY"),
        "writes to a file of the user's": opens([outside], "O_WRONLY"),
        "reads the home of the user": unit(
            f'DIR *home = opendir("{os.path.expanduser("~")}");\n    if (home) abort();', HEADERS),
        "makes a file elsewhere": opens([outside + "-new"], "O_WRONLY | O_CREAT, 0600"),
        "sends a signal to its grader": unit(f"if (kill({os.getpid()}, 0) == 0) abort();", HEADERS),
        "finds the memory, the pipes and the environment of its grader": opens(
            [f"/proc/{os.getpid()}/{name}" for name in ("environ", "mem", "fd/1")], "O_RDONLY"),
        "connects to a program of this machine": unit(f"""
    struct sockaddr_in there = {{.sin_family = AF_INET, .sin_port = {socket.htons(port)},
                                .sin_addr.s_addr = {socket.htonl(0x7f000001)}}};
    if (connect(socket(AF_INET, SOCK_STREAM, 0), (struct sockaddr *)&there, sizeof there) == 0) abort();""",
                                                      HEADERS),
    }


def nothing_is_reached(toolchain, folder):
    with socket.create_server(("127.0.0.1", 0)) as server:
        units = reaches(folder, server.getsockname()[1])
        inside = verdicts_on(toolchain, folder, units)
        toolchain.sandbox, kept = None, toolchain.sandbox
        outside = verdicts_on(toolchain, folder, units)
        toolchain.sandbox = kept
    for name in units:
        check(inside[name].passed(), f"in the sandbox, no unit {name}", said_of(inside[name]))
        if name.startswith("finds the memory") and os.geteuid() != 0:
            check(outside[name].passed(), f"without it, none {name} either", said_of(outside[name]))
        else:
            check("crashed" in said_of(outside[name]), f"without it, one {name}", said_of(outside[name]))


SYSTEM_CALLS = {
    "makes a process": "fork() >= 0",
    "makes a process that shares its memory": "syscall(SYS_clone, 0x100 | 17, room + 8192, 0, 0, 0) >= 0",
    "makes a process without memory of its own": "syscall(SYS_vfork) >= 0",
    "holds memory that no file and no process has": 'syscall(SYS_memfd_create, "x", 0) >= 0',
    "makes shared memory": "syscall(SYS_shmget, 0, 4096, 01600) >= 0",
    "makes namespaces": "syscall(SYS_unshare, 0x10000000) >= 0 || syscall(SYS_unshare, 0x20000) >= 0",
    "has a ring of the kernel's": "syscall(SYS_io_uring_setup, 1, (char[256]){0}) >= 0",
    "handles the faults of others": "syscall(SYS_userfaultfd, 0) >= 0",
    "makes a socket": "socket(AF_UNIX, SOCK_STREAM, 0) >= 0",
    "keeps a key": "syscall(SYS_keyctl, 0, -3, 1) >= 0",
}


def few_system_calls_are_answered(toolchain, folder):
    """Without the list, the kernel answers some of them here, and others elsewhere."""
    before = HEADERS + "#include <sys/syscall.h>\nlong syscall(long number, ...);\n" + by_address("syscall")
    room = "static char room[8192];\n    memset(room, 0, sizeof room);\n"
    units = {name: unit(f"{room}    if ({call}) abort();", before) for name, call in SYSTEM_CALLS.items()}
    inside = verdicts_on(toolchain, folder, units)
    toolchain.sandbox.filter, kept = b"", toolchain.sandbox.filter
    outside = verdicts_on(toolchain, folder, units)
    toolchain.sandbox.filter = kept
    for name in units:
        check(inside[name].passed(), f"no unit {name}", said_of(inside[name]))
    threads = "#include <threads.h>\n" + by_address("thrd_create", "thrd_join")
    work = "static int work(void *nothing)\n{\n    return nothing != NULL;\n}"
    make = "thrd_t one;\n    if (thrd_create(&one, work, NULL)) abort();\n    thrd_join(one, NULL);"
    thread = verdicts_on(toolchain, folder, {"": unit(make, threads + work)})[""]
    check(thread.passed(), "but threads are made", said_of(thread))
    answered = [name for name in units if not outside[name].passed()]
    check("makes a process" in answered and "makes shared memory" in answered and len(answered) >= 4,
          "without the list of system calls, units do", answered)


def its_first_process_is_out_of_reach(toolchain, folder):
    """bubblewrap's own, which tells how the program ended."""
    before = (HEADERS + "#include <sys/ptrace.h>\n#include <sys/syscall.h>\nlong syscall(long number, ...);\n"
              + by_address("syscall", "ptrace"))
    units = {
        "writes to": opens(["/proc/1/mem", "/proc/1/task/1/mem"], "O_RDWR"),
        "traces": unit("if (ptrace(PTRACE_ATTACH, 1, NULL, NULL) == 0) abort();", before),
        "seizes": unit("if (ptrace(PTRACE_SEIZE, 1, NULL, NULL) == 0) abort();", before),
        "sees the descriptors of": opens(["/proc/1/fd/0", "/proc/1/fd/1"], "O_RDONLY"),
    }
    for name, suite in verdicts_on(toolchain, folder, units).items():
        check(suite.passed(), f"no unit {name} the sandbox's first process", said_of(suite))


def little_is_written(toolchain, folder):
    """Files in memory are limited, and go with the run."""
    fill = """
    static char block[1 << 20];
    memset(block, 1, sizeof block);
    size_t written = 0;
    for (int k = 0; k < 3; k++)
    {{
        char name[] = "{place}/0";
        name[sizeof name - 2] = (char)('0' + k);
        int file = open(name, O_WRONLY | O_CREAT, 0600);
        for (int m = 0; m < 140 && file >= 0 && write(file, block, sizeof block) == sizeof block; m++)
            written++;
    }}
    if (written > 256) abort();"""
    before = sorted(os.listdir("/dev/shm"))
    cases = {place: unit(fill.format(place=place), HEADERS) for place in ("/dev/shm", "/tmp", ".")}
    for place, suite in verdicts_on(toolchain, folder, cases).items():
        check(suite.passed(), f"no unit writes more than 256 MB to {place}", said_of(suite))
    check(sorted(os.listdir("/dev/shm")) == before, "what a unit wrote is gone")
    cases = {place: opens([f"{place}/new"], "O_WRONLY | O_CREAT, 0600")
             for place in ("", "/dev", "/usr", "/proc", "/var/tmp")}
    for place, suite in verdicts_on(toolchain, folder, cases).items():
        check(suite.passed(), f"no unit makes a file in {place}/", said_of(suite))


def each_process_has_limits(toolchain, folder):
    """Of processor seconds and of a file's blocks, in case that nobody watches it any more."""
    def limits():
        outcome = sandbox.run(["/bin/sh", "-c", "ulimit -t; ulimit -Ht; ulimit -f"], seconds=5, megabytes=100,
                              folder=folder, environment=dict(os.environ), enclose=toolchain.sandbox.around)
        return outcome.output.split()

    got = limits()
    check(got == ["100", "100", str((256 << 20) // 512)], "a unit's process has limits of its own", got)
    with mock.patch.object(sandbox.resource, "getrlimit", lambda _: (30, 30)):
        got = limits()
    check(got == ["30", "30", "0"], "none of them is above the grader's", got)


def the_compiler_sees_headers_only(toolchain, folder):
    """As assembly, which can include any bytes."""
    data, place = os.path.join(folder, "data.bin"), os.path.join(folder, "unit")
    pathlib.Path(data).write_text("a friend's program", encoding="utf-8")
    os.mkdir(place)
    copied = private_copy.copy_kit(toolchain, FEATURES, [FEATURE.stem], folder)

    def compiles(line, name="x.s"):
        put(line + "\n", place, name)
        return build._run_tool(copied,
                               [*copied.compiler, *copied.flags, "-c", os.path.join(place, name), "-o",
                                        os.path.join(place, "x.o")], place)

    cases = {"the reference": FEATURE.reference, "its object": f"src/features/{FEATURE.stem}.o",
             "a program": data}
    for name, path in cases.items():
        outcome = compiles(f'.incbin "{os.path.abspath(path)}"')
        check(outcome.status != 0 and "file not found" in outcome.output, f"no unit includes {name} as bytes",
              outcome.output)
    check(compiles(f'.incbin "{place}/x.s"').status == 0, "but a file beside it", "")
    for name in (os.path.abspath(FEATURE.reference), f"features/{FEATURE.stem}.c"):
        outcome = compiles(f'#include "{name}"', "x.c")
        check(outcome.status != 0 and "No such file" in outcome.output,
              f"no unit includes the reference as \"{'/'.join(name.split('/')[-3:])}\"", outcome.output)
    os.environ["SECRET_OF_THE_INSTRUCTOR"] = "xyzzy"
    outcome = compiles('.incbin "/proc/self/environ"')
    del os.environ["SECRET_OF_THE_INSTRUCTOR"]
    check(outcome.status == 0 and b"xyzzy" not in pathlib.Path(place, "x.o").read_bytes(),
          "no unit includes the environment of its grader", outcome.output)


def a_kit_among_the_systems_files_is_hidden(folder):
    kit = mock.Mock(source="/usr/include", build="/usr/share/doc", compiler=["cc"])
    box = bubblewrap.Bubblewrap(kit, shutil.which("bwrap"))
    outcome = sandbox.run(["/usr/bin/ls", "/usr/include", "/usr/share/doc"], seconds=10, megabytes=100,
                          folder=folder,
                          environment={}, enclose=box.around)
    check(outcome.output.split() == ["/usr/include:", "/usr/share/doc:"], "a kit in /usr is hidden",
          outcome.output)


def own_headers_are_there(toolchain, folder):
    """Those that are text, beside the unit or below it."""
    put('#pragma once\n#include "sub/two.h"\n', folder, "0", "one.h")
    put("#define ANSWER 42\n", folder, "0", "sub", "two.h")
    put("a\0b", folder, "0", "binary.h")
    put('#include "one.h"\n#include "binary.h"\n#include "../secret.h"\n', folder, "0", "x.c")
    put("", folder, "secret.h")
    original = grade.Unit(FEATURE, os.path.join(folder, "0", "x.c"), "x.c", False)
    copied = private_copy.copy_unit(original, os.path.join(folder, "copy"))
    found = sorted(os.path.relpath(path, folder) for path in pathlib.Path(folder, "copy").rglob("*")
                   if path.is_file())
    check(found == [f"copy/own/{FEATURE.stem}/{name}"
                    for name in (f"{FEATURE.stem}.c", "one.h", "sub/two.h")],
          "a unit is copied with the headers of its own that it includes, and with nothing else", found)
    check(copied.shown == "x.c", "and is called as before")


# --- How runs end ---------------------------------------------------------------------------------


def ends_are_told(toolchain, folder):
    cases = {
        "that hangs": (unit("for (volatile int k = 0; k < 2; k = 0) { }"), "was at mine/bvh_median.c:"),
        "that hangs without work": (unit("for (;;) pause();", HEADERS), "did not end"),
        "that kills itself": (unit("raise(SIGKILL);", HEADERS), "crashed: Killed"),
        "that exits with 137": (unit("_exit(137);", HEADERS), "Killed"),
        "that exits with 3": (unit("_exit(3);", HEADERS), "exit status 3"),
        "that pretends that there is no sandbox": (
            unit('puts("bwrap: no");\n    fflush(stdout);\n    _exit(2);', HEADERS), "exit status 2"),
        "that makes up a long reason": (unit(
            'printf("x.c:1:1: runtime error: ");\n    for (int k = 0; k < 5000; k++) putchar(\'x\');\n'
            "    putchar('\\n');\n    fflush(stdout);\n    _exit(1);", HEADERS),
            "the code ended the program, after it printed \"xxx"),
    }
    suites = verdicts_on(toolchain, folder, {name: text for name, (text, _) in cases.items()}, seconds=3)
    for name, suite in suites.items():
        check(not suite.passed() and cases[name][1] in said_of(suite), f"a unit {name} is told as such",
              said_of(suite))
    longest = max(len(suite.verdicts[EMPTY].reason) for suite in suites.values())
    check(longest <= grade.REASON_MAX + 4, "no reason is longer than a claim's", longest)
    text = unit("", '#line 1 "bwrap: no space left on device"\nint\n')
    liar = verdicts_on(toolchain, folder, {"x": text})["x"]
    check("does not compile" in liar.problem or "could not" in liar.problem,
          "a unit whose errors look like the sandbox's is one that does not compile", liar.problem)
    poor = os.path.join(folder, "poor")
    pathlib.Path(poor).write_text("#!/bin/sh\necho bwrap: no more namespaces\nexit 1\n", encoding="utf-8")
    os.chmod(poor, 0o755)
    try:
        sandbox.run(["true"], seconds=10, megabytes=100, folder=folder, environment=dict(os.environ),
                    enclose=lambda command: [poor])
        check(False, "a sandbox that cannot be made is nobody's mistake")
    except ToolError as error:
        check("no more namespaces" in str(error), "a sandbox that cannot be made is nobody's mistake", error)


def children_of_threads_are_seen():
    """The kernel lists a process under the thread that made it."""
    made, done = [], threading.Event()

    def make():
        made.append(subprocess.Popen(["sleep", "60"]))
        done.wait()

    thread = threading.Thread(target=make)
    thread.start()
    while not made:
        time.sleep(0.001)
    check(made[0].pid in sandbox._children(os.getpid()), "a process that a thread has made is seen")
    done.set()
    thread.join()
    made[0].kill()
    made[0].wait()


def who_has_nobody_to_answer_is_ended(folder):
    began = time.monotonic()
    outcome = sandbox.run(["sleep", "60"], seconds=30, megabytes=100, folder=folder,
                          environment=dict(os.environ), is_needless=lambda: time.monotonic() > began + 0.1)
    check(outcome.limit == "needless" and outcome.seconds < 20, "a unit ends when its judge has failed",
          [outcome.limit, str(outcome.seconds)])


def who_sleeps_is_ended_and_who_is_slow_is_not(folder):
    def run_it(command, **options):
        return sandbox.run(["/bin/sh", "-c", command], megabytes=100, folder=folder,
                           environment=dict(os.environ), **options)

    for what, command in {"sleeps": "sleep 60", "stops itself": "kill -STOP $$",
                          "sleeps again and again": "while :; do sleep 0.04; done"}.items():
        outcome = run_it(command, seconds=1, partners=())
        check(outcome.limit == "seconds" and outcome.seconds < 30, f"a program that {what} is ended",
              [outcome.limit, str(outcome.seconds)])
    partner = subprocess.Popen(["/bin/sh", "-c", "while :; do :; done"])
    outcome = run_it("sleep 4", seconds=1, partners=(partner.pid,))
    with mock.patch.object(sandbox, "_PATIENCE", 1):
        endless = run_it("sleep 60", seconds=1, partners=(partner.pid,))
    partner.kill()
    partner.wait()
    check(not outcome.limit, "but not one whose partner works meanwhile", str(outcome.limit))
    check(endless.limit == "seconds", "if that does not work forever", str(endless.limit))
    told = ""
    with mock.patch.object(idleness, "_look_at", lambda thread: ("R", 0)):
        outcome = run_it("sleep 4", seconds=0.25)
        with mock.patch.object(sandbox, "_STARVED", 2):
            try:
                run_it("sleep 60", seconds=1)
            except ToolError as error:
                told = str(error)
    check(not outcome.limit, "nor one that waits for a processor", str(outcome.limit))
    check("the machine is too busy" in told, "a machine that is too busy is no claim's fault", told)


def only_data_is_believed():
    def garble():
        for name in os.listdir("/proc/self/fd"):
            with contextlib.suppress(OSError):
                os.write(int(name), b"\x80\x04cos\nsystem\n(S'touch hacked'\ntR.") if int(name) > 2 else None

    for name, function in {"garbage": garble,
                           "a process that stops": lambda: os.kill(os.getpid(), signal.SIGSTOP),
                           "a process that is stopped as by Ctrl-Z": lambda: os.kill(os.getpid(),
                                                                                     signal.SIGTSTP),
                           "a process that is killed": lambda: os.kill(os.getpid(), signal.SIGKILL)}.items():
        try:
            said = isolate.call(function)
        except isolate.Ended as error:
            said = error
        # Ctrl-Z stops nothing where no shell could wake it up.
        ended = isinstance(said, isolate.Ended) or (said is None and "Ctrl-Z" in name)
        check(ended and not os.path.exists("hacked"), f"{name} is no answer", said)
    suite = test_grade.grade.Suite(FEATURE, None, [ScoredTest(EMPTY, 1, "#")])
    suite.take({"problem": "", "warnings": "", "beside": "", "excused": [],
                "verdicts": {EMPTY: ["yes", "", "", "", 0, "no"]}})
    check(not suite.verdicts[EMPTY].passed and not suite.verdicts[EMPTY].timed_out,
          "a verdict that is no boolean is none")


def what_was_left_is_removed(folder):
    process = subprocess.Popen(["true"])
    process.wait()
    old, alive, others, young = (os.path.join(folder, f"raykit-grade-{owner}-{k}") for k, owner in
                                 enumerate((process.pid, os.getpid(), process.pid, process.pid)))
    for path in (old, alive, others, young):
        os.mkdir(path)
    for path in (old, alive, others):
        os.utime(path, (0, 0))
    if os.geteuid() == 0:
        os.chown(others, 12345, -1)
    else:
        os.rmdir(others)
    tempfile.tempdir, kept = folder, tempfile.tempdir
    made = private_copy.make_folder()
    tempfile.tempdir = kept
    check(not os.path.exists(old) and os.path.exists(alive) and os.path.exists(young) and os.path.isdir(made)
          and os.path.exists(others) == (os.geteuid() == 0),
          "folders of graders that were killed are removed by the next one", os.listdir(folder))


# --- A class --------------------------------------------------------------------------------------


def start_class(place, out):
    return test_grade.launch(sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"),
                             FEATURE.stem,
                             "--submissions", place, "--out", out)


def grade_class(place, out, **environment):
    os.environ.update(environment)
    process = start_class(place, out)
    for name in environment:
        del os.environ[name]
    said = process.communicate()[0]
    return process.returncode, said


def rows_of(out):
    with open(os.path.join(out, "class.csv"), encoding="utf-8", newline="") as file:
        return {row[0]: row for row in csv.reader(file)}


def destroyer(number, files, folder):
    """A unit that sends a signal to its grader and to the class's; and whose daemon does so until later,
    and spoils these files and moves this folder."""
    tries = "\n".join(f'        if ((file = open("{path}", O_WRONLY | O_TRUNC)) >= 0) close(file);'
                      for path in files)
    return unit("if (count == 0) attack();", HEADERS + f"""
static int parent_of(int process)
{{
    char name[64], text[512] = "";
    snprintf(name, sizeof name, "/proc/%d/stat", process);
    FILE *file = fopen(name, "r");
    if (!file)
        return 0;
    size_t size = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    return size ? atoi(strrchr(text, ')') + 3) : 0;
}}

static void attack(void)
{{
    int parent = getppid(), grandparent = parent_of(parent), file;
    if (fork() == 0 && setsid() > 0 && fork() == 0)
    {{
        for (int k = 0; k < 30; k++)
        {{
{tries}
            rename("{folder}", "{folder}-moved");
            usleep(100000);
        }}
        _exit(0);
    }}
    if (grandparent > 1)
        kill(grandparent, {number});
    if (parent > 1)
        kill(parent, {number});
}}
""")


def a_class_outlives_everybody(folder):
    place, out = os.path.join(folder, "class"), os.path.join(folder, "results")
    put(unit(""), place, "ann", "bvh_median.c")
    put(unit(""), place, "zoe", "bvh_median.c")
    put("int early;\n", place, "early", "bvh_median.c")
    grade_class(place, out)  # the first results are there to be spoiled
    targets = [f"{place}/ann/bvh_median.c", f"{place}/zoe/bvh_median.c", f"{out}/class.csv",
               f"{out}/ann.json"]
    report = targets[-1]
    for number, name in ((signal.SIGKILL, "kills"), (signal.SIGSTOP, "stops")):
        put(destroyer(int(number), targets, out), place, name, "bvh_median.c")
    tests = json.loads(test_grade.read(report))["tests"]
    expected = rows_of(out)["ann"][1:7]
    status, said = grade_class(place, out)
    time.sleep(3.5)  # longer than the daemons work
    rows = rows_of(out)
    check(status == 0 and list(rows) == ["name", "ann", "early", "kills", "stops", "zoe"],
          "a class outlives signals to its graders", said)
    check(rows["ann"][1:7] == expected == rows["zoe"][1:7]
          and json.loads(test_grade.read(report))["tests"] == tests
          and all(test_grade.read(path) == unit("") for path in targets[:2]),
          "nobody changes another's work, report or points", rows)
    check("ended its grader" not in rows["kills"][5], "signals out of the sandbox arrive nowhere",
          rows["kills"])


def who_works_meanwhile_is_not_blamed(folder):
    """With an editor open in the kit, all the same."""
    place, out = os.path.join(folder, "calm"), os.path.join(folder, "calm-results")
    put(unit(""), place, "ann", "bvh_median.c")
    swap = os.path.join(SOURCE, "tests", ".test_bvh_median.c.swp")
    put(unit("usleep(20000);", HEADERS), place, "bob", "bvh_median.c")
    for mode in ("container",) if test_grade.NO_SANDBOX else ("", "container"):
        os.environ["RAYKIT_SANDBOX"] = mode
        process = start_class(place, out)
        del os.environ["RAYKIT_SANDBOX"]
        for _ in range(2 if mode else 1):  # one is graded, the other is not
            process.stdout.readline()
        pathlib.Path(swap).touch()
        said = process.communicate()[0]
        os.unlink(swap)
        check(process.returncode == 0 and "changed" not in rows_of(out)["bob"][6],
              f"an editor's swap file blames nobody (SANDBOX={mode})", said)


def without_a_sandbox_this_is_said(folder):
    place, out, tools = (os.path.join(folder, name) for name in ("plain", "plain-results", "tools"))
    put(unit(""), place, "ann", "bvh_median.c")
    put(unit(""), place, "bob", "bvh_median.c")
    os.mkdir(tools)
    put("#!/bin/sh\necho 'bwrap: No permissions to create new namespace' >&2\nexit 1\n", tools, "bwrap")
    os.chmod(os.path.join(tools, "bwrap"), 0o755)
    path = f"{tools}:{os.environ['PATH']}"
    kept = os.environ["PATH"]
    try:
        os.environ["PATH"] = path
        kept_mode = os.environ.pop("RAYKIT_SANDBOX", None)
        status, said = grade_class(place, out)
        way_out = f"SANDBOX={'no' if os.geteuid() else 'container'}"
        check(status == 2 and "No permissions to create new namespace" in said and way_out in said
              and not os.path.exists(os.path.join(out, "class.csv")),
              "where there is no sandbox, no class is graded, and the ways out are said", said)
        status, said = test_grade.graded("--impl", os.path.join(place, "ann"), "--test", ONE)
        check(status == 2 and "there is no sandbox" in said, "nor is a submission", said)
        status, said = grade_class(place, out, RAYKIT_SANDBOX="no")
        check(status == (2 if os.geteuid() == 0 else 0) and (os.geteuid() != 0 or "you are root" in said),
              "who is root cannot do without, unless all of this machine is thrown away", said)
        status, said = grade_class(place, out, RAYKIT_SANDBOX="container")
        first, rows = said.splitlines()[0], rows_of(out)
        report = pathlib.Path(out, "ann.json").read_text(encoding="utf-8")
        words = "without a sandbox (SANDBOX=container)"
        check(status == 0 and words in first and all(words in rows[name][6] for name in ("ann", "bob"))
              and words in report, "who does without reads it first, in each row and in each report",
              f"{said}\n{rows}\n{report}")
        if kept_mode is not None:
            os.environ["RAYKIT_SANDBOX"] = kept_mode
    finally:
        os.environ["PATH"] = kept
    status, said = grade_class(place, out, RAYKIT_SANDBOX="maybe")
    check(status == 2 and "say yes, no or container" in said, "SANDBOX is yes, no or container", said)
    status, said = run(os.environ.get("MAKE", "make"), "-s", "grade", "ASSIGNMENTS=" + FEATURE.stem,
                       "SANDBOX=maybe",
                       "IMPL=" + os.path.join(place, "ann"))
    check(status != 0 and "say yes, no or container" in said, "make passes it on", said)


def main():
    sandbox.prepare()
    toolchain = build.Toolchain(".")
    toolchain.sandbox = None if test_grade.NO_SANDBOX else bubblewrap.find(toolchain)[0]
    folder = tempfile.mkdtemp(prefix="raykit-test-sandbox-")
    places = iter(range(100))

    def place():
        path = os.path.join(folder, str(next(places)))
        os.mkdir(path)
        return path

    try:
        if toolchain.sandbox:
            test_grade.units_are_judged(toolchain, place())
            nothing_is_reached(toolchain, place())
            few_system_calls_are_answered(toolchain, place())
            its_first_process_is_out_of_reach(toolchain, place())
            little_is_written(toolchain, place())
            each_process_has_limits(toolchain, place())
            the_compiler_sees_headers_only(toolchain, place())
            a_kit_among_the_systems_files_is_hidden(place())
            ends_are_told(toolchain, place())
            a_class_outlives_everybody(place())
        else:
            check(True, f"what graded code can reach # SKIP {test_grade.NO_SANDBOX}")
        own_headers_are_there(toolchain, place())
        only_data_is_believed()
        children_of_threads_are_seen()
        who_has_nobody_to_answer_is_ended(place())
        who_sleeps_is_ended_and_who_is_slow_is_not(place())
        what_was_left_is_removed(place())
        who_works_meanwhile_is_not_blamed(place())
        without_a_sandbox_this_is_said(place())
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
