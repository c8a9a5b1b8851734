#!/usr/bin/env python3
"""Grades a unit again whenever it is saved. Ctrl-C ends it.

The last verdict stays on the screen until the next. A save during a check ends it and starts another,
because its result would be about an old file."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from grading.assignments import Parser, choose, read_features, run_loop
from grading.build import Toolchain
from grading.private_copy import own_folder
from grade import prepare_suites, require_units, stop_on_signals

_LOOK_SECONDS = 0.15  # between looks at the files: soon enough, and no load
_GOODBYE_SECONDS = 5  # for a check to end what it started; it takes a fraction of one


def state(impl):
    """Returns a value that changes when a C file or header of IMPL is saved."""
    folder = impl if os.path.isdir(impl) else os.path.dirname(impl) or "."
    files = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.endswith((".c", ".h")) and not entry.name.startswith("."):
                    status = entry.stat()
                    files.append((entry.name, status.st_mtime_ns, status.st_size, status.st_ino))
    except OSError:
        pass  # an editor is replacing something; the next look sees it
    return sorted(files)


def changed_at(path):
    """Returns when a file has changed, 0 if there is none."""
    return os.stat(path).st_mtime_ns if os.path.exists(path) else 0


def claims_in(record):
    """Returns what the grader's record tells of each claim that has ended, or is late."""
    with open(record, encoding="utf-8") as file:
        claims = map(json.loads, (line for line in file if line.endswith("\n")))
        return {claim["name"]: claim for claim in claims}


def late_line(claim):
    """Returns what to say of a claim that is late."""
    return f"checking; {claim['name']} is {claim['reason']} ..."


class Check:
    """One run of the grader, in a session of its own: Ctrl-C goes to the watcher, which ends it."""

    def __init__(self, command):
        self._said = tempfile.TemporaryFile()
        environment = dict(os.environ, COLUMNS=str(shutil.get_terminal_size((100, 24)).columns))
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=self._said,
                                         env=environment,
                                         stderr=subprocess.STDOUT, start_new_session=True)

    def is_over(self):
        return self._process.poll() is not None

    def verdict(self):
        """Returns the grader's output."""
        self._said.seek(0)
        return self._said.read().decode(errors="replace")

    def end(self):
        """Ends the grader, if need be, with everything that it started."""
        self._process.terminate()
        try:
            self._process.wait(_GOODBYE_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._said.close()


class Screen:
    """A terminal shows one verdict and a status line; other output gets one verdict after the other."""

    def __init__(self):
        self._is_terminal, self._has_status = sys.stdout.isatty(), False

    def status(self, text):
        """Replaces the line below the verdict."""
        if self._is_terminal:
            print(f"\r\033[K{text}", end="", flush=True)
            self._has_status = True
        else:
            print(text, flush=True)

    def verdict(self, text):
        """Replaces everything."""
        if self._is_terminal:
            text = re.sub("^ok ", "\033[32mok\033[m ", text, flags=re.M)
            text = re.sub("^FAIL ", "\033[31mFAIL\033[m ", text, flags=re.M)
            text = "\033[H\033[2J\033[3J" + text
        print(text, end="", flush=True)
        self._has_status = False

    def end_status(self):
        """Keeps the status line, so that what follows begins a line."""
        if self._has_status:
            print(flush=True)
        self._has_status = False


def watch(command, impl, record):
    """Checks at once and after every save, until interrupted; says which claim is late."""
    screen, check, seen, told = Screen(), None, None, None
    try:
        while True:
            now = state(impl)
            if now != seen:
                again = " again, as you have saved" if check else ""
                if check:
                    check.end()
                before = changed_at(record)
                seen, check, told = now, Check(command), None
                screen.status(f"{time.strftime('%H:%M:%S')}, checking{again} ...")
            elif check and check.is_over():
                screen.verdict(check.verdict())
                check.end()
                check = None
                screen.status(f"{time.strftime('%H:%M:%S')}, waiting for you to save; Ctrl-C ends")
            elif check and changed_at(record) != before:
                before = changed_at(record)
                late = [claim for claim in claims_in(record).values() if claim["is_open"]]
                if late and late[0] != told:
                    told = late[0]
                    screen.status(late_line(told))
            time.sleep(_LOOK_SECONDS)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C changes nothing
        if check:
            check.end()


def command_of_tool(stem, *options):
    """Returns the command that starts another tool, with options for Python, as make does."""
    folder = os.path.dirname(os.path.abspath(__file__))
    return [sys.executable, "-S", *options, os.path.join(folder, "launch.py"),
            os.path.join(folder, stem + ".py")]


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stem", metavar="STEM")
    parser.add_argument("--impl", required=True, metavar="FILE_OR_DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--test", metavar="NAME")
    arguments = parser.parse_args()
    stop_on_signals()
    cache = f"pycache_prefix={os.path.join(arguments.build, 'impl', 'python')}"
    command = [*command_of_tool("grade", "-X", cache), arguments.stem, "--build", arguments.build,
               "--impl", arguments.impl, "--own", *(["--test", arguments.test] if arguments.test else [])]

    def work():
        features = read_features(Toolchain(arguments.build).source)
        require_units(arguments.build, [arguments.stem], arguments.impl)
        prepare_suites(features, choose(features, [arguments.stem]), arguments.impl, True, arguments.test)
        with own_folder() as kept:
            watch([*command, "--kept", kept], arguments.impl, os.path.join(kept, "claims"))

    return run_loop("watch", os.path.abspath(arguments.build), work)


if __name__ == "__main__":
    sys.exit(main())
