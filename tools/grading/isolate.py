"""Calls a function in a separate process, which the caller outlives: a unit that sends signals to
its parent ends that process, but no other grading."""

import os
import pickle
import select
import shutil
import signal
import sys
import tempfile
import time

from grading import sandbox

_PATIENCE = 5  # seconds to clean up after an interrupt


class Ended(Exception):
    """The process ended without an answer; the text says how."""


def call(function, *arguments):
    """Returns or raises what the function does, or raises Ended. Its temporary files and
    child processes are removed with it."""
    folder = tempfile.mkdtemp(prefix="raykit-grade-")
    sys.stdout.flush()
    reading, writing = os.pipe()
    process = os.fork()
    if process == 0:
        tempfile.tempdir = folder
        _answer(writing, function, arguments)
    os.close(writing)
    status = None
    try:
        answer, was_stopped = _listen(reading, process)
        status = os.waitpid(process, 0)[1]
    finally:
        os.close(reading)
        if status is None:
            _end(process)
        sandbox.end_those_in(folder)
        shutil.rmtree(folder, ignore_errors=True)
    if status != 0:
        number = signal.SIGSTOP if was_stopped else os.WIFSIGNALED(status) and os.WTERMSIG(status)
        raise Ended(signal.Signals(number).name if number else "an interrupt")
    result, error = pickle.loads(answer)
    if error:
        raise error
    return result


def _answer(writing, function, arguments):
    """The new process: sends its answer, and does not return."""
    status = 1
    try:
        sandbox.end_with_parent(signal.SIGTERM)
        try:
            answer = function(*arguments), None
        except Exception as error:  # the caller knows what to do with it
            answer = None, error
        with os.fdopen(writing, "wb") as pipe:
            pickle.dump(answer, pipe)
        status = 0
    finally:
        sys.stdout.flush()
        os._exit(status)


def _listen(reading, process):
    """Returns the whole answer, and whether the process was stopped: nobody would wake it up, so it
    is killed. Ctrl-Z is another signal, and stops the caller, too."""
    answer, was_stopped = b"", False
    while True:
        if select.select([reading], [], [], 0.1)[0]:
            data = os.read(reading, 1 << 20)
            if not data:
                return answer, was_stopped
            answer += data
        news = os.waitid(os.P_PID, process, os.WSTOPPED | os.WEXITED | os.WNOHANG | os.WNOWAIT)
        if news and news.si_code == os.CLD_STOPPED and news.si_status == signal.SIGSTOP:
            was_stopped = True
            os.kill(process, signal.SIGKILL)


def _end(process):
    """Lets the process clean up, if it does so in time."""
    os.kill(process, signal.SIGTERM)
    patience = time.monotonic() + _PATIENCE
    while os.waitpid(process, os.WNOHANG)[0] == 0:
        if time.monotonic() > patience:
            os.kill(process, signal.SIGKILL)
        time.sleep(0.02)
