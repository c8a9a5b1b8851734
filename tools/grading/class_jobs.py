"""Runs tools/grade_one.py for each submission of a class: one after the other, or under GNU parallel, on all
processors and other machines (Tange, "GNU Parallel: The Command-Line Power Tool", ;login: 36, 2011)."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile

from grading import sandbox
from grading.assignments import MachineError, ToolError

_TRIES = 3  # a worker that was killed, or whose machine fails, is replaced so often
_FAULTS = 3  # after so many submissions that fail all the same, it is no single one's fault
_TOOLS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def find_parallel():
    """Returns the path of GNU parallel, or "": moreutils has another program of this name."""
    path = shutil.which("parallel")
    said = path and subprocess.run([path, "--version"], stdin=subprocess.DEVNULL, capture_output=True,
                                   text=True, errors="replace", check=False).stdout
    return path if said and said.startswith("GNU parallel") else ""


class Ended:
    """How a job ended: `number` is its place in the list, from 1 on; `fault` says why there is no verdict, or
    is ""."""

    def __init__(self, number, said, status):
        self.number, self.fault = number, said.get("fault", "")
        if not said:
            how = signal.Signals(-status).name if status < 0 else f"status {status}"
            self.fault = f"its grader was ended, by {how}"


def _said(line):
    """Returns the JSON that a worker says, {} for anything else."""
    try:
        said = json.loads(line)
        return said if isinstance(said, dict) and isinstance(said.get("number"), int) else {}
    except ValueError:
        return {}


def one_by_one(command, numbers, beginning):
    """Yields an Ended for each number. `beginning` is called with each before."""
    faults = 0
    for number in numbers:
        beginning(number)
        process = subprocess.Popen([*command, "--number", str(number)], stdout=subprocess.PIPE, text=True,
                                   stdin=subprocess.DEVNULL, errors="replace")
        try:
            text = process.communicate()[0]
        except BaseException:
            process.terminate()
            process.wait()
            raise
        ended = Ended(number, _said(text), process.returncode)
        yield ended
        faults += bool(ended.fault) and process.returncode > 0
        if faults == _FAULTS:
            return


class Engine:
    """GNU parallel with so many jobs for each machine; `hosts` are names for ssh, ":" is this one. It needs a
    little space, and ends without: it gets it in the folder of the results, `out`."""

    def __init__(self, jobs, hosts, out):
        self._program, self.jobs, self._hosts, self._out = find_parallel(), jobs, hosts, out
        if not self._program:
            raise ToolError("JOBS and HOSTS need GNU parallel (Debian: apt-get install parallel); without "
                            "it, say JOBS=1")

    def run(self, command, numbers):
        """Yields an Ended for each number, as they end. Workers print a short line each, ungrouped: grouped,
        their output would need space on a disk that may be full. Who ended, and how, is in the job log, if
        two lines should run together."""
        with tempfile.TemporaryDirectory(prefix=".jobs-", dir=self._out) as folder:
            log, reasons, told = os.path.join(folder, "log"), {}, set()
            hosts = ["--sshlogin", ",".join(self._hosts), "--workdir", os.getcwd()] if self._hosts else []
            if self._hosts:
                names = [name for name in os.environ if name.startswith("RAYKIT_")]
                hosts += [option for name in names for option in ("--env", name)]
            # It takes its own temporary folder for the workers', too.
            workers = [f"TMPDIR={os.environ['TMPDIR']}"] if "TMPDIR" in os.environ else ["-u", "TMPDIR"]
            process = subprocess.Popen(
                [self._program, "--will-cite", "--plain", "--quote", "--ungroup", "--jobs", str(self.jobs),
                 "--tmpdir", folder, "--joblog", log, "--retries", str(_TRIES),
                 "--halt", f"soon,fail={_FAULTS}", *hosts,
                 "env", *workers, *command, "--number", "{}"],
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

    @staticmethod
    def _untold(log, numbers, reasons, told):
        """Yields those that were begun and did not say that they have a verdict."""
        rows = {}
        if os.path.exists(log):
            with open(log, encoding="utf-8", errors="replace") as file:
                for row in (line.split("\t") for line in file.read().splitlines()[1:]):
                    rows[numbers[int(row[0]) - 1]] = int(row[6]), int(row[7])
        for number, (status, name) in rows.items():
            if number not in told:
                is_good = not status and not name
                said = {"number": number} if is_good else reasons.get(number, {})
                yield Ended(number, said, -name if name else status)


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


def command_of(build, stems, out, format_name, kit, listed, processors, again):
    """Returns the command that grades one submission of the list, but for its number."""
    launch, tool = (os.path.join(_TOOLS, name) for name in ("launch.py", "grade_one.py"))
    return [sys.executable, "-B", "-S", launch, tool, *stems, "--build", os.path.abspath(build),
            "--out", os.path.abspath(out), "--format", format_name, "--kit", kit, "--list", listed,
            "--jobs", str(processors), *(["--again"] if again else [])]
