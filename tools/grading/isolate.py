"""Calls a function in a separate process, which the caller outlives: a unit that sends signals to
its parent ends that process, but no other grading. The answer is JSON, so whatever a unit might
write into its place, it is data."""

import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import time

from grading import sandbox
from grading.assignments import MachineError, ToolError, is_machines_fault
from grading.private_copy import make_folder

_PATIENCE = 5  # seconds to clean up after an interrupt
_LOOKS = 20  # so many times, 0.1 s apart, a process may be found stopped, as it is between Ctrl-Z and fg
_ANSWER_BYTES_MAX = 1 << 28
_SECONDS = 120  # of the process itself, without its children: what it reads of one submission takes a few


class Ended(Exception):
    """The process ended without an answer; the text says how."""


def call(function, *arguments):
    """Returns what the function does, as JSON; raises ToolError if it raised an error, MachineError for a
    fault of this machine, or Ended. Its temporary files and child processes are removed with it."""
    folder = make_folder()
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
        sandbox.end_strays()
        sandbox.end_those_in(folder)
        shutil.rmtree(folder, ignore_errors=True)
    if status != 0:
        number = signal.SIGSTOP if was_stopped else os.WIFSIGNALED(status) and os.WTERMSIG(status)
        raise Ended(signal.Signals(number).name if number else "an interrupt")
    try:
        answer = json.loads(answer)
        result, error = answer["result"], answer["error"]
    except (ValueError, TypeError, KeyError) as damage:
        raise Ended("a damaged answer") from damage
    if error:
        raise (MachineError if answer.get("is_machines") is True else ToolError)(str(error))
    return result


def _answer(writing, function, arguments):
    """The new process: sends its answer, and does not return."""
    status = 1
    try:
        sandbox.end_with_parent(signal.SIGTERM)
        # Its children begin with this limit, too, and those that run units set their own.
        resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, resource.getrlimit(resource.RLIMIT_CPU)[1]))
        try:
            answer = {"result": function(*arguments), "error": None}
        except Exception as error:  # the caller knows what to do with it
            answer = {"result": None, "error": str(error) or type(error).__name__,
                      "is_machines": is_machines_fault(error)}
        with os.fdopen(writing, "w", encoding="utf-8") as pipe:
            json.dump(answer, pipe)
        status = 0
    finally:
        sys.stdout.flush()
        os._exit(status)


def _listen(reading, process):
    """Returns the whole answer, and whether the process was stopped: nobody would wake it up, so it
    is killed."""
    answer, looks, was_stopped = b"", 0, False
    while True:
        if select.select([reading], [], [], 0.1)[0]:
            data = os.read(reading, 1 << 20)
            if not data:
                return answer, was_stopped
            answer += data
        news = os.waitid(os.P_PID, process, os.WSTOPPED | os.WEXITED | os.WNOHANG | os.WNOWAIT)
        looks = looks + 1 if news and news.si_code == os.CLD_STOPPED else 0
        was_stopped = was_stopped or looks > _LOOKS
        if was_stopped or len(answer) > _ANSWER_BYTES_MAX:
            os.kill(process, signal.SIGKILL)


def _end(process):
    """Lets the process clean up, if it does so in time."""
    os.kill(process, signal.SIGTERM)
    patience = time.monotonic() + _PATIENCE
    while os.waitpid(process, os.WNOHANG)[0] == 0:
        if time.monotonic() > patience:
            os.kill(process, signal.SIGKILL)
        time.sleep(0.02)
