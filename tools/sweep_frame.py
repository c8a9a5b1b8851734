#!/usr/bin/env python3
"""Renders one frame of a sweep: runs the driver with its options, and puts what it wrote where it belongs,
under names that sort. `make sweep` runs it for each frame."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from grading import sandbox
from grading.assignments import Parser
from grading.parallel_jobs import processors, stop_on_signals, tell
from sweeping.picture import stem_of, texts_of

_MACHINE = 75  # GNU parallel tries again, perhaps elsewhere
# Reasons of a driver that are no fault of its options.
_FAULTS = [os.strerror(number) for number in (
    errno.ENOSPC, errno.EDQUOT, errno.ENOMEM, errno.EIO, errno.EROFS, errno.EMFILE, errno.ENFILE,
    errno.EAGAIN, errno.ESTALE)]


class _Fault(Exception):
    """What may go better another time, or on another machine."""


def _run(plan, words, place):
    """Runs the driver; returns its status, and what it printed and complained."""
    threads = max(1, processors() // plan["jobs"])
    command = [plan["driver"], "--threads", str(threads), *plan["options"], *words, "--out", place]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        errors="replace", env=dict(os.environ, LC_ALL="C"), preexec_fn=sandbox.end_with_parent)
    try:
        printed, complained = process.communicate()
    except BaseException:
        process.kill()
        process.wait()
        raise
    # It also says where the picture is, and what is written there.
    lines = [line for line in printed.splitlines(True) if not line.startswith(place)]
    return process.returncode, "".join(lines), complained.strip()


def _move(plan, number, place):
    """Puts what the driver wrote into OUT, the picture last; returns the names."""
    names, stem = [], stem_of(number)
    for room in ("tables", "figures"):
        folder = os.path.join(place, room)
        # Beside a picture x.png may stand x_difference.png.
        found = sorted(os.listdir(folder), reverse=True) if os.path.isdir(folder) else []
        for name in found:
            is_frame = room == "figures" and name == found[-1]
            names.append(stem + os.path.splitext(name)[1] if is_frame else f"{stem}_{name}")
            os.replace(os.path.join(folder, name), os.path.join(plan["out"], names[-1]))
    return names[::-1]


def _reason(plan, complained):
    """Returns why a driver failed, in one line."""
    last = complained.splitlines()[-1] if complained else "it gave no reason"
    return last if last.startswith(plan["name"]) else f"{plan['name']}: {last}"


def _render(plan, number, place):
    """Returns what is to be known of a frame, for its row in the table."""
    words, begin = plan["frames"][number - 1], time.monotonic()
    status, printed, complained = _run(plan, words, place)
    said = {"seconds": time.monotonic() - begin, "status": status}
    if status < 0:
        raise _Fault(f"{plan['name']} was ended, by {signal.Signals(-status).name}, with {' '.join(words)}")
    if status:
        reason = _reason(plan, complained)
        if any(fault in reason for fault in _FAULTS):
            raise _Fault(reason)
        return {**said, "reason": reason}
    if printed:
        os.makedirs(os.path.join(place, "tables"), exist_ok=True)
        with open(os.path.join(place, "tables", "said.txt"), "w", encoding="utf-8") as file:
            file.write(printed)
    files = _move(plan, number, place)
    if not files:
        return {**said, "status": 1, "reason": f"{plan['name']}: it wrote neither a picture nor a table"}
    picture = os.path.join(plan["out"], files[0])
    return {**said, "files": files, "notes": complained.splitlines(),
            "texts": texts_of(picture) if picture.endswith(".png") else {}}


def _work(arguments):
    """Prints a line for whoever waits; returns the exit status."""
    with open(arguments.plan, encoding="utf-8") as file:
        plan = json.load(file)
    number, folder = arguments.number, os.path.dirname(arguments.plan)
    place = tempfile.mkdtemp(prefix=f"{number}-", dir=folder)
    try:
        said = _render(plan, number, place)
        with open(os.path.join(place, "said"), "w", encoding="utf-8") as file:
            json.dump(said, file)
        os.replace(file.name, os.path.join(folder, f"{number}.json"))
    finally:
        shutil.rmtree(place, ignore_errors=True)
    return 0


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--plan", required=True, metavar="FILE", help="what make sweep wrote")
    parser.add_argument("--number", required=True, type=int, metavar="N", help="of the frame, from 1 on")
    arguments = parser.parse_args()
    stop_on_signals()
    said = {"number": arguments.number}
    try:
        _work(arguments)
    except (_Fault, OSError, MemoryError) as error:
        said["fault"] = (str(error) if isinstance(error, _Fault) else
                         f"{getattr(error, 'filename', '') or 'the system'}: "
                         f"{getattr(error, 'strerror', '') or error or 'no memory'}")
    except KeyboardInterrupt:
        return 130
    tell(**said)
    return _MACHINE if "fault" in said else 0


if __name__ == "__main__":
    sys.exit(main())
