#!/usr/bin/env python3
"""A class of made-up submissions under SLURM, by the lines of docs/tools.md: the same table as by GNU
parallel, and what a machine failed is tried again. It makes a cluster of this one machine for itself, in a
folder of its own. Speaks TAP, for make check-slurm; runs in a build folder."""

import contextlib
import csv
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile

import test_grade
from test_grade import FEATURES, SOURCE, put, read, run
from grading import sandbox
from grading.starters import starter_of
from tap import check, finish, start, wait

NEEDED = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue")
RIGHT = read(FEATURES["normals"].reference)
KINDS = [RIGHT, starter_of(FEATURES["normals"].reference), "int early;\n"]
WHEN = 7  # the column of class.csv that says when
CONF = """ClusterName=raykit
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
StateSaveLocation={folder}
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MinJobAge=300
NodeName={host} NodeAddr=127.0.0.1 CPUs={count} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def script():
    """Returns the file grade.sh of docs/tools.md, and the command that submits it."""
    text = read(SOURCE, "docs", "tools.md")
    lines = re.search(r"For SLURM, .*?\n\n((?:    .*\n|\n)+)", text, re.DOTALL)[1]
    command = re.search(r"`(sbatch [^`]*)`", text)[1]
    return re.sub("^    ", "", lines, flags=re.MULTILINE), command


class Cluster:
    """SLURM's daemons in a folder, for this process's user."""

    def __init__(self, folder):
        self._folder, self._daemons = folder, []
        self.environment = dict(os.environ, SLURM_CONF=os.path.join(folder, "slurm.conf"))
        os.makedirs(os.path.join(folder, "spool"))
        sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]
        ports = [made.getsockname()[1] for made in sockets]
        for made in sockets:
            made.close()
        host = socket.gethostname().partition(".")[0]
        put(CONF.format(host=host, user=_user(), folder=folder, ports=ports, count=os.cpu_count()), folder,
            "slurm.conf")
        key = os.path.join(folder, "munge.key")
        subprocess.run(["mungekey", "--create", "--keyfile", key], check=True)
        self._begin("munged", "--foreground", "--force", "--key-file", key, "--socket",
                    os.path.join(folder, "munge.socket"), *[f"--{name}-file={folder}/munge.{name}"
                                                            for name in ("pid", "log", "seed")])
        self._begin("slurmctld", "-D")
        self._begin("slurmd", "-D", "-N", host)

    def _begin(self, *command):
        with open(os.path.join(self._folder, command[0] + ".said"), "wb") as said:
            self._daemons.append(subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL,
                                                  stdout=said, stderr=said))

    def said(self, *command):
        return subprocess.run(command, env=self.environment, text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False).stdout

    def is_up(self):
        """Waits for the machine to be ready."""
        return wait(lambda: "idle" in self.said("sinfo", "--noheader", "--format=%t"), pause=0.2)

    def logs(self):
        return [line for name in ("munged", "slurmctld", "slurmd")
                for line in read(self._folder, name + ".said").splitlines()[-8:]]

    def close(self):
        for daemon in reversed(self._daemons):
            daemon.terminate()
        for daemon in self._daemons:
            with contextlib.suppress(subprocess.TimeoutExpired):
                daemon.wait(20)
            daemon.kill()


def _user():
    return subprocess.run(["id", "-un"], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def table_of(path):
    """Returns the rows of a class.csv, without when they were made."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return [row[:WHEN] + row[WHEN + 1:] for row in csv.reader(file)]


def put_a_broken_sandbox(folder):
    """Puts a bwrap first in a folder of programs, which fails once and then is the real one."""
    put(f'#!/bin/sh\nif [ "$1" != --help ] && mkdir "{folder}/failed" 2>/dev/null; then exit 1; fi\n'
        f'exec "{shutil.which("bwrap")}" "$@"\n', folder, "programs", "bwrap")
    os.chmod(os.path.join(folder, "programs", "bwrap"), 0o755)


def a_class_is_the_same(folder, cluster):
    work = os.path.join(folder, "kit")
    os.makedirs(work)
    for number in range(6):
        put(KINDS[number % len(KINDS)], work, "submissions", f"{number} O'Neil & co", "normals.c")
    put("id,name\n", work, "submissions", "collected.csv")
    lines, command = script()
    build = os.getcwd()
    put(lines.replace("tools/grade_one.py", f"{SOURCE}/tools/grade_one.py --build {build}").replace(
        "bvh_median", "normals"), work, "grade.sh")
    put_a_broken_sandbox(folder)
    cluster.environment["PATH"] = os.path.join(folder, "programs") + ":" + os.environ["PATH"]
    said = subprocess.run(["sh", "-c", command], cwd=work, env=cluster.environment, text=True, check=False,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
    check("Submitted batch job" in said, "the class is one array of jobs", said)
    is_done = wait(lambda: not cluster.said("squeue", "--noheader").strip(), 500, 0.2)
    check(is_done, "all jobs end", cluster.said("squeue") + cluster.said("scontrol", "show", "jobs"))
    check(os.path.isdir(os.path.join(folder, "failed")), "the sandbox has failed once")
    tools, out = os.path.join(SOURCE, "tools"), os.path.join(folder, "by parallel")
    results = os.path.join(work, "results")
    said = run(sys.executable, "-B", os.path.join(tools, "class_table.py"), "normals", "--folders", results,
               "--out", results)[1]
    run(sys.executable, "-B", os.path.join(tools, "grade_class.py"), "normals", "--submissions",
        os.path.join(work, "submissions"), "--out", out, "--jobs", "2")
    rows = [table_of(os.path.join(place, "class.csv")) for place in (results, out)]
    check(len(rows[0]) == 7 and rows[0] == rows[1], "the table is that of GNU parallel",
          [said, *map(str, rows), *cluster.logs()])


def main():
    sandbox.prepare()
    missing = [name for name in NEEDED if not shutil.which(name)]
    if missing or test_grade.NO_SANDBOX:
        print("1..0 # SKIP needs SLURM and munge (Debian: apt-get install slurm-wlm munge) and bubblewrap")
        return 0
    folder, cluster = tempfile.mkdtemp(prefix="raykit-test-slurm-"), None
    try:
        cluster = Cluster(os.path.join(folder, "cluster"))
        is_up = cluster.is_up()
        check(is_up, "a cluster of one machine begins", cluster.logs())
        if is_up:
            a_class_is_the_same(folder, cluster)
    finally:
        if cluster:
            cluster.close()
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
