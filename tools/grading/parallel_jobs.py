"""Runs a command for each number of a list: one after the other, or under GNU parallel, on all processors and
other machines (Tange, "GNU Parallel: The Command-Line Power Tool", ;login: 36, 2011)."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading

from grading import sandbox
from grading.assignments import MachineError, ToolError
from grading.temporary_folder import temporary_folder

TRIES = 3  # a worker that was killed, or whose machine fails, is replaced so often
FAULTS = 3  # after so many jobs that fail all the same, it is no single one's fault


def processors():
    """Returns how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def stop_on_signals():
    """SIGTERM and SIGHUP end a script as Ctrl-C does: with everything that it started. A second one would
    only end the cleaning up, which does not take long, so it changes nothing."""
    numbers = [signal.SIGTERM, signal.SIGHUP]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # it is ignored in the background
        numbers.append(signal.SIGINT)

    def interrupt(_number, _frame):
        for number in numbers:
            signal.signal(number, lambda *_: None)  # with SIG_IGN, Python complains of one under way
        raise KeyboardInterrupt

    if threading.current_thread() is threading.main_thread():
        for number in numbers:
            signal.signal(number, interrupt)


def find_parallel():
    """Returns the path of GNU parallel, or "": moreutils has another program of this name."""
    path = shutil.which("parallel")
    said = path and subprocess.run([path, "--version"], stdin=subprocess.DEVNULL, capture_output=True,
                                   text=True, errors="replace", check=False).stdout
    return path if said and said.startswith("GNU parallel") else ""


class Ended:
    """How a job ended: `number` is its place in the list, from 1 on; `fault` says why it did not do its work,
    of which `worker` is the name, or is ""."""

    def __init__(self, number, said, status, worker="its grader"):
        self.number, self.fault = number, said.get("fault", "")
        if not said:
            how = signal.Signals(-status).name if status < 0 else f"status {status}"
            self.fault = f"{worker} was ended, by {how}"


def tell(**said):
    """Has a worker say how it ended, in one write: others' lines go to the same pipe. Signals then come too
    late to stop anything."""
    sys.stdout.flush()
    os.write(sys.stdout.fileno(), json.dumps(said).encode() + b"\n")
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, lambda *_: None)


def _said(line):
    """Returns the JSON that a worker says, {} for anything else."""
    try:
        said = json.loads(line)
        return said if isinstance(said, dict) and isinstance(said.get("number"), int) else {}
    except ValueError:
        return {}


def _run_one(command, number):
    """Runs one job here; returns what it says, and its status."""
    process = subprocess.Popen([*command, "--number", str(number)], stdout=subprocess.PIPE, text=True,
                               stdin=subprocess.DEVNULL, errors="replace")
    try:
        text = process.communicate()[0]
    except BaseException:
        process.terminate()
        process.wait()
        raise
    return _said(text), process.returncode


def one_by_one(command, numbers, beginning, tries=1, worker="its grader"):
    """Yields an Ended for each number. `beginning` is called with each before."""
    faults = 0
    for number in numbers:
        beginning(number)
        for _ in range(tries):
            said, status = _run_one(command, number)
            if not status:
                break
        ended = Ended(number, said, status, worker)
        yield ended
        faults += bool(ended.fault) and status > 0
        if faults == FAULTS:
            return


# GNU parallel replaces {}, {#}, {..} and others wherever they stand: braces in names reach it as \0173.
_DECODE = ('n=$#; while test $n -gt 0; do set -- "$@" "$(printf %b "$1")"; shift; n=$((n-1)); done; '
           'exec "$@" --number "$0"')


def _without_braces(command):
    """Returns a command that runs this one with the number of the job."""
    if not any("{" in word for word in command):
        return [*command, "--number", "{}"]
    return ["sh", "-c", _DECODE, "{}",
            *(word.replace("\\", r"\0134").replace("{", r"\0173") for word in command)]


class Engine:
    """GNU parallel with so many jobs for each machine; `hosts` are names for ssh, ":" is this one. It needs a
    little space, and ends without: it gets it in the folder of the results, `out`."""

    def __init__(self, jobs, hosts, out, worker="its grader"):
        self._program, self.jobs, self._hosts, self._out = find_parallel(), jobs, hosts, out
        self._worker = worker
        if not self._program:
            raise ToolError("JOBS and HOSTS need GNU parallel (Debian: apt-get install parallel); without "
                            "it, say JOBS=1")

    def run(self, command, numbers):
        """Yields an Ended for each number, as they end. Workers print a short line each, ungrouped: grouped,
        their output would need space on a disk that may be full. Who ended, and how, is in the job log, if
        two lines should run together."""
        with temporary_folder(".jobs-", self._out) as folder:
            log, reasons, told = os.path.join(folder, "log"), {}, set()
            hosts = ["--sshlogin", ",".join(self._hosts), "--workdir", os.getcwd()] if self._hosts else []
            if self._hosts:
                names = [name for name in os.environ if name.startswith("RAYKIT_")]
                hosts += [option for name in names for option in ("--env", name)]
            # It takes its own temporary folder for the workers', too.
            workers = [f"TMPDIR={os.environ['TMPDIR']}"] if "TMPDIR" in os.environ else ["-u", "TMPDIR"]
            process = subprocess.Popen(
                [self._program, "--will-cite", "--plain", "--quote", "--ungroup", "--jobs", str(self.jobs),
                 "--tmpdir", folder, "--joblog", log, "--retries", str(TRIES),
                 "--halt", f"soon,fail={FAULTS}", *hosts,
                 *_without_braces(["env", *workers, *command])],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, errors="replace",
                env=dict(os.environ, PARALLEL_HOME=folder, PARALLEL_SHELL="/bin/sh"), start_new_session=True,
                preexec_fn=lambda: sandbox.end_with_parent(signal.SIGTERM))
            try:
                with process.stdin as pipe:
                    pipe.write("".join(f"{number}\n" for number in numbers))
                for line in process.stdout:
                    said = _said(line)
                    if said and "fault" in said:
                        reasons[said["number"]] = said  # it is tried again
                    elif said:
                        told.add(said["number"])
                        yield Ended(said["number"], said, 0)
                if process.wait() == 255:
                    raise MachineError("GNU parallel failed, its reason is above; mend that, and give the "
                                       "same command again: what is there stays")
                yield from self._untold(log, numbers, reasons, told)
            except BaseException:
                _stop(process)
                raise

    def _untold(self, log, numbers, reasons, told):
        """Yields those that were begun and did not say that their work is done."""
        rows = {}
        if os.path.exists(log):
            with open(log, encoding="utf-8", errors="replace") as file:
                for row in (line.split("\t") for line in file.read().splitlines()[1:]):
                    rows[numbers[int(row[0]) - 1]] = int(row[6]), int(row[7])
        for number, (status, name) in rows.items():
            if number not in told:
                is_good = not status and not name
                said = {"number": number} if is_good else reasons.get(number, {})
                yield Ended(number, said, -name if name else status, self._worker)


def read_jobs(text, what):
    """Returns how many jobs JOBS asks for, 0 where it says nothing."""
    if not re.fullmatch(r"([1-9][0-9]{0,3})?", text):
        raise ToolError(f"JOBS={text}: give how many {what} at once, from 1 on")
    return int(text or 0)


def choose_engine(command, jobs, hosts, out, worker="its grader"):
    """Returns the Engine for so many jobs, by default one for each processor; or None for one after the
    other, which `command` says if it is for want of GNU parallel."""
    if not jobs and not hosts and not find_parallel():
        print(f"{command}: one after the other, as GNU parallel is not installed (Debian: apt-get install "
              "parallel)", flush=True)
        return None
    jobs = jobs or processors()
    return Engine(jobs, hosts, out, worker) if jobs > 1 or hosts else None


def _stop(process):
    """Ends GNU parallel with its jobs: the first signal starts no more, the second ends those that run."""
    for _ in range(2):
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(0.2)
            except subprocess.TimeoutExpired:
                pass
    try:
        process.wait(15)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
