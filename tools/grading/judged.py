"""Runs a claim in two processes: a judge, which is the suite, and one in the sandbox that runs the unit and
answers the judge's calls (tests/judge/judge.h). A unit can then neither read what is wanted nor write the
verdict: it has to answer.
"""

import fcntl
import os
import signal
import socket
import subprocess
import time

from grading import build
from grading import sandbox

_BYTES = 256 << 20  # RK_JUDGE_BYTES of tests/judge/protocol.h
_LEAKS = 23  # RK_JUDGE_LEAKS there
_GET_SEALS, _SEAL_FUTURE_WRITE = 1034, 0x10  # of <linux/fcntl.h>
_ANSWERED = 4  # bytes, the head of rk_judge_answered there
_GRACE = 1  # seconds that a unit's process may need to end when its judge has failed
_PATIENCE = 20  # seconds that a judge may work on when the unit's process has ended


def files(stem):
    """Returns the files of the build folder that a judge of this feature needs."""
    return [f"impl/judge/{name}" for name in (f"{stem}-judge", f"{stem}-serve.o", "unit.o", "wait.o")]


def is_possible(toolchain, stem):
    """Whether the build has a judge of this feature."""
    parts = [os.path.join(toolchain.build, path) for path in files(stem)]
    return all(map(os.path.exists, [calls_file(toolchain, stem), *parts]))


def calls_file(toolchain, stem):
    return os.path.join(toolchain.source, "tests", "judge", stem + ".calls")


def claims_together(toolchain, stem):
    """Returns the claims that unit and suite must share a process for: they look at time, or at memory."""
    with open(calls_file(toolchain, stem), encoding="utf-8") as file:
        return [words[1] for words in map(str.split, file) if words[:1] == ["together"]]


def link_unit(toolchain, units, objects, folder):
    """Links the program that runs the first unit. Returns its path, or raises BuildError."""
    stem = units[0].feature.stem
    output = os.path.join(folder, "unit_" + stem)
    _, serve, unit, wait = map(toolchain.built, files(stem))
    return build.link_program(toolchain, units, [serve, unit, wait, *objects], output, toolchain.sanitize)


def _shared_memory(name):
    descriptor = os.memfd_create(name, os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
    os.ftruncate(descriptor, _BYTES)
    fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW)
    return descriptor


class _Judge:
    """The process that runs the suite, which makes one of the memories read-only for all others before a unit
    runs."""

    def __init__(self, toolchain, stem, names, descriptors, secret):
        asked, answered, alive = descriptors
        self._ours, theirs = socket.socketpair()
        self._secret, self._failed_at = secret, None
        self._ours.send(secret)
        self._said = open(os.memfd_create("said", os.MFD_CLOEXEC), "w+b")
        environment = dict(sandbox.bare_environment("/"), CMOCKA_MESSAGE_OUTPUT="TAP",
                           RAYKIT_JUDGE=f"{asked},{answered},{alive},{os.getpid()}",
                           RAYKIT_ATTEST=str(theirs.fileno()))
        with theirs:
            self.process = subprocess.Popen(
                [toolchain.built(files(stem)[0]), "--only", *names], env=environment,
                stdin=subprocess.DEVNULL, stdout=self._said, stderr=subprocess.STDOUT, start_new_session=True,
                pass_fds=(*descriptors, theirs.fileno()))
        while not fcntl.fcntl(asked, _GET_SEALS) & _SEAL_FUTURE_WRITE and self.process.poll() is None:
            time.sleep(0.0005)

    def has_failed(self):
        """Whether it ended some time ago, so that nobody will ever ask the unit again: a judge that crashed
        told it nothing."""
        if self.process.poll() in (None, 0):
            return False
        self._failed_at = self._failed_at or time.monotonic()
        return time.monotonic() > self._failed_at + _GRACE

    def finish(self):
        """Returns the exit status, whether the secret came back, what came beside it, and the output."""
        try:
            status = self.process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            status = -signal.SIGKILL
        self.end()
        with self._ours:
            self._ours.setblocking(False)
            try:
                answer = self._ours.recv(4096)
            except (BlockingIOError, ConnectionResetError):
                answer = b""
        with self._said:
            self._said.seek(0)
            said = self._said.read(64 << 10).decode("utf-8", "replace")
        attested = status == 0 and answer.startswith(self._secret)
        return status, attested, answer.removeprefix(self._secret).decode("utf-8", "replace"), said

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


def run(toolchain, stem, names, program, secret, call_seconds=None, **options):
    """Runs claims with the unit's program, which may work in one call for so many seconds; `options` are
    those of sandbox.run. Returns their Outcome, as of one process that would have run both. Several are
    attested if all hold; the testimony is then the seconds of each."""
    asked, answered = _shared_memory("requests"), _shared_memory("answers")
    alive, held = os.pipe()
    judge, descriptors = None, [asked, answered, alive, held]
    calls = call_seconds and (lambda: os.pread(answered, _ANSWERED, 0), call_seconds)
    try:
        judge = _Judge(toolchain, stem, names, (asked, answered, alive), secret)
        options["environment"] = dict(options["environment"], RAYKIT_JUDGE=f"{asked},{answered}")
        # The judge sees by the pipe that the unit's process has ended.
        outcome = sandbox.run(["unit_" + stem], program=program, descriptors=(asked, answered, held),
                              when_begun=lambda: os.close(descriptors.pop()),
                              is_needless=judge.has_failed, partners=(judge.process.pid,), calls=calls,
                              **options)
        status, attested, testimony, said = judge.finish()
    finally:
        if judge:
            judge.end()
        for descriptor in descriptors:
            os.close(descriptor)
    if outcome.limit == "needless":
        outcome.limit, outcome.status = None, 0
    if outcome.limit or outcome.status not in (0, _LEAKS):
        return outcome
    leaks = outcome.status == _LEAKS
    outcome.status, outcome.attested, outcome.testimony = status, attested, testimony
    if leaks and attested:
        outcome.testimony = "leaks"
    outcome.output = said + outcome.output
    return outcome
