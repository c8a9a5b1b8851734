"""Runs an untrusted program: it ends in time, within its memory, with bounded output, and all of its
child processes end with it. What it can see of this machine is up to bubblewrap.py.

The program has no input, leads a session of its own, and leaves no core file. Its memory and its
children's is read from Linux's /proc; on other systems there is no such limit.
"""

import ctypes
import fcntl
import os
import resource
import selectors
import shutil
import signal
import socket
import subprocess
import threading
import time

from grading.assignments import MachineError
from grading.idleness import Idleness

stop = threading.Event()  # set: every run ends at once

_prctl = getattr(ctypes.CDLL(None), "prctl", lambda *_: None)  # Linux has it

_PAGE = os.sysconf("SC_PAGE_SIZE")
_PROCESSES_MAX = 64
FILE_BYTES_MAX = 256 << 20
_LOOK = 0.05  # seconds from one look at a program's memory to the next
_PATIENCE = 12  # so many times a program's seconds those that it works with may work
_STARVED = 60  # so many times its seconds may pass if it neither works nor sleeps as long: a busy machine
_KEPT = 64 << 10  # bytes of the output's beginning, and as many of its end
_ENDED_BY_SIGNAL = 128  # bubblewrap's exit status is then this and the signal's number


class Outcome:
    """How a run went. `status` is the exit status, negative for a signal; `limit` is None or the
    limit that ended the run: "seconds", "memory", "output", "processes", "needless" or "stopped". `testimony`
    is the witness's answer beside the secret: the claim that failed, or that memory leaks. `occupied` is the
    largest number of bytes of memory that was seen, and `worked` of seconds of processors."""

    def __init__(self):
        self.status, self.limit, self.output, self.seconds = None, None, "", 0.0
        self.attested, self.testimony, self.occupied, self.worked = False, "", 0, 0.0


class Program:
    """A copy of a program in memory, sealed, so that no run of it can change the next one. On a
    system without such copies it is the file itself."""

    def __init__(self, path):
        self.path, self.descriptor = path, None
        if not hasattr(os, "memfd_create"):
            return
        self.descriptor = os.memfd_create(os.path.basename(path), os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
        with open(path, "rb") as source, open(self.descriptor, "wb", closefd=False) as copy:
            shutil.copyfileobj(source, copy)
        seals = fcntl.F_SEAL_WRITE | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
        fcntl.fcntl(self.descriptor, fcntl.F_ADD_SEALS, seals)
        os.unlink(path)
        self.path = f"/proc/self/fd/{self.descriptor}"

    def close(self):
        if self.descriptor is not None:
            os.close(self.descriptor)
            self.descriptor = None


def seed():
    """Returns what SEED says: the number of the suites' random cases."""
    return os.environ.get("RAYKIT_SEED", "")


def bare_environment(folder):
    """Of the caller's environment only the paths of libraries and what suites look at, and this folder to
    write to."""
    kept = ("LD_LIBRARY_PATH", "RAYKIT_ISA", "RAYKIT_SEED")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    return dict(environment, HOME=folder, TMPDIR=folder, LC_ALL="C")


def prepare():
    """Called once: no core files, orphans become children of this process, where end_strays finds
    them, and child processes cannot read its memory (unless they run as root)."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    set_dumpable, set_child_subreaper = 4, 36  # PR_SET_... of <linux/prctl.h>
    _prctl(set_dumpable, 0, 0, 0, 0)
    _prctl(set_child_subreaper, 1, 0, 0, 0)


def end_with_parent(number=signal.SIGKILL):
    """Has the system send this signal when the parent ends. A process that outlived a killed grader
    would get the next process up as its parent, and could kill that, too."""
    set_parent_death_signal = 1
    _prctl(set_parent_death_signal, int(number), 0, 0, 0)


def _killed_for_memory():
    """Returns how many processes Linux has ended because there was no memory."""
    try:
        with open("/proc/vmstat", encoding="ascii") as file:
            return next((int(line.split()[1]) for line in file if line.startswith("oom_kill ")), 0)
    except OSError:
        return 0


_KILLED_BEFORE = _killed_for_memory()


def _children(pid):
    """Returns the processes that any of its threads has made, or got as a reaper."""
    children = []
    for thread in _listed(f"/proc/{pid}/task"):
        try:
            with open(f"/proc/{pid}/task/{thread}/children", encoding="ascii") as file:
                children += map(int, file.read().split())
        except (OSError, ValueError):  # it has ended meanwhile
            continue
    return children


def _listed(folder):
    try:
        return os.listdir(folder)
    except OSError:
        return []


def _family(pid):
    """Returns a process and its children, a few more than are allowed at most."""
    family, waiting = [], [pid]
    while waiting and len(family) <= _PROCESSES_MAX:
        family.append(waiting.pop())
        waiting += _children(family[-1])
    return family


def _worked(pid, unknown=float("inf"), family=None):
    """Returns the processor seconds of a process and its children. With these, a busy machine makes no
    program fail."""
    ticks = 0
    for process in family or _family(pid):
        try:
            with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:
                ticks += sum(map(int, file.read().rpartition(")")[2].split()[11:15]))
        except (OSError, ValueError):
            if process == pid:
                return unknown
    return ticks / os.sysconf("SC_CLK_TCK")


def _occupied(family):
    """Returns the resident bytes of processes."""
    total = 0
    for process in family:
        try:
            with open(f"/proc/{process}/statm", encoding="ascii") as file:
                total += int(file.read().split()[1]) * _PAGE
        except (OSError, IndexError, ValueError):
            continue
    return total


def _kill(pid):
    """Kills a session's first process, its group, and children that left the group."""
    family, waiting = [], [pid]
    while waiting and len(family) < 10 * _PROCESSES_MAX:
        family.append(waiting.pop())
        waiting += _children(family[-1])
    for target in family:
        for kill in (os.killpg, os.kill):
            try:
                kill(target, signal.SIGKILL)
            except (ProcessLookupError, PermissionError):
                pass


def end_strays():
    """Kills processes that escaped from their session and lost their parent. Called when no run is under
    way."""
    for _ in range(100):
        strays = _children(os.getpid())
        if not strays:
            return
        for pid in strays:
            _kill(pid)
            try:
                os.waitpid(pid, 0)
            except ChildProcessError:
                pass


def end_those_in(folder):
    """Kills processes with a home in this folder, after their grader was killed and could not. They
    are not children of this process, so their parents do not identify them."""
    if not os.path.isdir("/proc"):
        return
    home = b"HOME=" + os.fsencode(folder) + b"/"
    for _ in range(100):
        found = [int(name) for name in os.listdir("/proc") if name.isdigit() and home in _environ(name)]
        for pid in found:
            _kill(pid)
        if not found:
            return


def _environ(pid):
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            return file.read()
    except OSError:
        return b""


def _has_ended(process):
    """Checks without reaping it, so that its number stays reserved until its group is killed."""
    return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


class _Tail:
    """Keeps the beginning and the end of its input."""

    def __init__(self):
        self.head, self.tail, self.total = b"", b"", 0

    def add(self, data):
        self.total += len(data)
        room = _KEPT - len(self.head)
        self.head += data[:room] if room > 0 else b""
        if room < len(data):
            self.tail = (self.tail + data[max(room, 0):])[-_KEPT:]

    def text(self):
        left_out = self.total - len(self.head) - len(self.tail)
        middle = f"\n[... {left_out} bytes ...]\n".encode() if left_out else b""
        return (self.head + middle + self.tail).decode("utf-8", "replace")


def _limits(seconds):
    """Returns a process's own limits by their names: in case this script is killed, a program that loops
    ends, too. None is higher than this process's."""
    wanted = {"CPU": int(seconds) * 8 + 60, "FSIZE": FILE_BYTES_MAX}
    most = {name: resource.getrlimit(getattr(resource, "RLIMIT_" + name))[1] for name in wanted}
    return {name: value if most[name] == resource.RLIM_INFINITY else min(value, most[name])
            for name, value in wanted.items()}


def _limit_process(seconds, parent):
    end_with_parent()
    if os.getppid() != parent:  # it has ended before, and the next one up must not be hit in its place
        os._exit(1)
    for name, value in _limits(seconds).items():
        resource.setrlimit(getattr(resource, "RLIMIT_" + name), (value, value))


def _limited(command, seconds):
    """Returns the command and options of Popen with which it is limited and ends with this process.
    bubblewrap ends with its parent by itself, and a program that sets limits costs less than a copy of
    this interpreter, which `preexec_fn` makes."""
    prlimit = shutil.which("prlimit")
    if not prlimit or "--die-with-parent" not in command:
        parent = os.getpid()
        return command, {"preexec_fn": lambda: _limit_process(seconds, parent)}
    limits = [f"--{name.lower()}={value}" for name, value in _limits(seconds).items()]
    return [prlimit, *limits, *command], {}


def run(command, *, seconds, megabytes, folder, environment, output_bytes=16 << 20, program=None,
        secret=b"", enclose=None, system_calls=b"", descriptors=(), when_begun=None,
        is_needless=lambda: False, partners=(), asks_where=True, calls=None):
    """Runs the command in `folder` and returns its Outcome. A Program as `program` is run instead; if there
    is a secret, in RAYKIT_ATTEST it gets a descriptor from which it reads that, and outcome.attested tells
    whether it came back; outcome.testimony is what else came. `enclose` puts a command into bubblewrap.
    `when_begun` is called when the program has its descriptors; it ends when it `is_needless`. It may work
    no longer than its seconds, and sleep no longer while its `partners`, the processes that it works with,
    do nothing either; they may work some times as long. `calls` is a function that counts the calls which it
    has answered, and the seconds that it may work without another one. If it `asks_where`, a program at its
    limit prints where it is, which takes a second. Raises MachineError where this machine is to blame."""
    outcome, kept = Outcome(), _Tail()
    descriptors, options = tuple(descriptors), {}
    status = os.pipe() if enclose else ()
    if secret:
        ours, theirs = socket.socketpair()
        ours.send(secret)
        environment = dict(environment, RAYKIT_ATTEST=str(theirs.fileno()))
        descriptors += (theirs.fileno(),)
    if program:
        descriptors += (program.descriptor,) if program.descriptor is not None else ()
        if enclose:
            command = [program.path, *command[1:]]
        else:
            options = {"executable": program.path}
    if enclose:
        wrapper, *rest = enclose(command)
        command = [wrapper, "--json-status-fd", str(status[1]), *rest]
        descriptors += (status[1],)
    if enclose and system_calls:
        listed = _pipe_with(system_calls)
        command[1:1] = ["--seccomp", str(listed)]
        descriptors += (listed,)
    command, limits = _limited(command, seconds)
    began = time.monotonic()
    try:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True, pass_fds=descriptors,
            **limits, **options,
        )
    except BaseException:
        if enclose:
            os.close(status[0])
        raise
    finally:
        if secret:
            theirs.close()
        if when_begun:
            when_begun()
        if enclose:
            os.close(status[1])
        if enclose and system_calls:
            os.close(listed)
    try:
        _watch(process, partners, outcome, kept, (began, seconds), megabytes << 20, output_bytes, is_needless,
               _Calls(*calls) if calls else None)
        if outcome.limit in ("seconds", "call") and asks_where:
            _ask_where(process, kept, bool(enclose))
    finally:
        _kill(process.pid)
        outcome.status = process.wait()
        _drain(process.stdout, kept)
        process.stdout.close()
        has_run = not enclose or _tells_of_an_end(status[0])
    if secret:
        with ours:
            ours.setblocking(False)
            try:
                answer = ours.recv(4096)
            except (BlockingIOError, ConnectionResetError):
                answer = b""
        outcome.attested = answer.startswith(secret)
        outcome.testimony = answer.removeprefix(secret).decode("utf-8", "replace")
    outcome.seconds = time.monotonic() - began
    outcome.output = kept.text()
    if enclose and outcome.status > _ENDED_BY_SIGNAL:
        outcome.status = _ENDED_BY_SIGNAL - outcome.status
    if not has_run and not outcome.limit and outcome.status >= 0:
        raise MachineError(f"the sandbox cannot be made: {outcome.output.strip()}")
    if outcome.status == -signal.SIGKILL and not outcome.limit and _killed_for_memory() > _KILLED_BEFORE:
        raise MachineError("this machine has no memory left, and ended a program for it")
    return outcome


def _pipe_with(data):
    """Returns a descriptor that these bytes, few enough for a pipe, can be read from."""
    reading, writing = os.pipe()
    os.write(writing, data)
    os.close(writing)
    return reading


def _tells_of_an_end(descriptor):
    """Whether bubblewrap tells how the program ended, which it does only if it began. Not guessed from what
    is printed: that may be the program's."""
    with os.fdopen(descriptor, "rb") as pipe:
        os.set_blocking(pipe.fileno(), False)
        return b'"exit-code"' in (pipe.read(1 << 16) or b"")


def _drain(pipe, kept):
    """Reads the pipe's present contents; another process may still have its other end open."""
    os.set_blocking(pipe.fileno(), False)
    try:
        for _ in range(64):
            data = os.read(pipe.fileno(), 1 << 16)
            if not data:
                return
            kept.add(data)
    except BlockingIOError:
        pass


class _Calls:
    """Tells whether a program works longer in one call than it may, or sleeps four times as long."""

    def __init__(self, count, seconds):
        self._count, self._seconds = count, seconds
        self._counted, self._worked = b"", 0.0

    def last_too_long(self, worked, slept):
        """`worked` are the seconds that the program has worked so far."""
        counted = self._count()
        if counted != self._counted:
            self._counted, self._worked = counted, worked
        return worked > self._worked + self._seconds or slept > 4 * self._seconds


def _watch(process, partners, outcome, kept, times, memory_bytes, output_bytes, is_needless, calls):
    """Reads until the program ends or is ended, with the reason in outcome.limit."""
    began, seconds = times
    idle, next_look = Idleness(), time.monotonic() + _LOOK
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while not _has_ended(process):
            if selector.select(_LOOK):  # returns at once when the program ends and so closes its output
                data = os.read(process.stdout.fileno(), 1 << 16)
                kept.add(data)
                if not data:
                    selector.unregister(process.stdout)
            elif not selector.get_map():
                time.sleep(0.005)
            now = time.monotonic()
            occupied, processes, slept, is_long = 0, 1, 0.0, False
            if now >= next_look:
                family = _family(process.pid)
                slept = idle.look([*family, *(pid for partner in partners for pid in _family(partner))])
                occupied, processes = _occupied(family), len(family)
                next_look = now + _LOOK
                outcome.occupied = max(outcome.occupied, occupied)
                outcome.worked = max(outcome.worked, _worked(process.pid, 0, family))
                is_long = calls is not None and calls.last_too_long(outcome.worked, slept)
            if stop.is_set():
                outcome.limit = "stopped"
            elif is_needless():
                outcome.limit = "needless"
            elif kept.total > output_bytes:
                outcome.limit = "output"
            elif occupied > memory_bytes:
                outcome.limit = "memory"
            elif processes > _PROCESSES_MAX:
                outcome.limit = "processes"
            elif slept > seconds or now - began > seconds and _have_worked(process, partners, seconds):
                outcome.limit = "seconds"
            elif is_long:
                outcome.limit = "call"
            elif now - began > _STARVED * seconds:
                raise MachineError(
                    f"the machine is too busy: what worked {_worked(process.pid, 0):.1f} s did not end in "
                    f"{now - began:.0f} s; grade again when less else runs")
            if outcome.limit:
                return


def _have_worked(process, partners, seconds):
    return _worked(process.pid) > seconds or any(_worked(pid, 0) > _PATIENCE * seconds for pid in partners)


def _ask_where(process, kept, is_enclosed):
    """On SIGABRT the address sanitizer prints the program's current position. In the sandbox, the program
    is the child of its first process."""
    program = process.pid
    for _ in range(2 if is_enclosed else 0):
        program = next(iter(_children(program)), program)
    try:
        os.kill(program, signal.SIGABRT)
    except ProcessLookupError:
        pass
    worked, patience = _worked(process.pid), time.monotonic() + 4
    while not _has_ended(process) and time.monotonic() < patience and not stop.is_set():
        if _worked(process.pid) > worked + 1:
            break
        _drain(process.stdout, kept)
        time.sleep(0.01)
