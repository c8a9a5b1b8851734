#!/usr/bin/env python3
"""Renders many pictures by one driver, with options walked through values: `make sweep`. On all processors
and other machines, by GNU parallel; it can be interrupted, and the same command goes on.

OUT then has a picture for each frame, 0001.png and so on, and the table sweep.csv. A frame with the same
options, driver and mesh files as before is not rendered again."""

import collections
import contextlib
import fcntl
import glob
import json
import os
import re
import shlex
import shutil
import sys

from drivers import made_driver, private_folder
from grading import build, parallel_jobs
from grading.assignments import (
    Parser, ToolError, cannot_write, read_features, run_command)
from grading.results import printable
from grading.temporary_folder import remove_left, temporary_folder
from sweeping import film
from sweeping.keys import Keys
from sweeping.picture import stem_of
from sweeping.table import NAME as TABLE, Table
from sweeping.values import frames, words_of

_ELSEWHERE = 75  # as in <sysexits.h>: this machine is to blame
_TOOLS = os.path.dirname(os.path.abspath(__file__))
_REFUSED = 3  # after so many, the mistake is in what all have
_NOTES = 5  # of the driver, that are shown


# --- Before it begins ------------------------------------------------------------------------------


def _choose_driver(toolchain, name):
    features = read_features(toolchain.source)
    if name not in features:
        raise ToolError(f"DRIVER={name}: there is no such driver; choose one of: {', '.join(features)}"
                        if name else "say which driver renders: make sweep DRIVER=depth_of_field "
                        "VARY=\"--aperture=10,20,40\" OPTIONS=\"--samples 16\" OUT=pictures")
    return features[name]


def _make_folder(out):
    if not out:
        raise ToolError("say where the pictures go: OUT=pictures, a folder")
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise cannot_write(out, error) from error


@contextlib.contextmanager
def _alone(out):
    """Holds the folder, so that no other sweep writes there, and clears what one left that was killed."""
    folder = os.open(out, os.O_RDONLY)
    try:
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ToolError(f"OUT: another sweep is writing into {out}; wait for it, or choose another "
                            "folder") from error
        except OSError:
            pass  # some file systems have no locks
        for prefix in (".sweep-", ".jobs-"):
            remove_left(prefix, out)
        yield
    finally:
        os.close(folder)


def _check_frames(out, count):
    """The frames of a longer sweep would be taken for some of this one, and pictures of others replaced."""
    names = sorted(name for name in os.listdir(out) if re.fullmatch(r"\d{4}(\.png|_.*\.(png|csv|txt))", name))
    if names and not os.path.exists(os.path.join(out, TABLE)):
        raise ToolError(f"OUT: {out} has a file {names[0]}, but no {TABLE} that lists it, so it is not a "
                        "sweep's; choose another folder")
    names = [name for name in names if int(name[:4]) > count]
    if names:
        raise ToolError(f"OUT: {out} has frames of a longer sweep, such as {names[0]}, and this one ends "
                        f"with {stem_of(count)}; choose another folder, or remove them")


def _is_measuring(words):
    """Whether the driver's own threads or its times are asked for, which others at the same time would
    spoil."""
    names = [word.split("=")[0] for word in words]
    return any(option.startswith(name) for name in names if len(name) > 4
               for option in ("--threads", "--timing", "--runs"))


def _engine(arguments, words, count):
    """Returns the parallel_jobs.Engine, or None for one frame after the other."""
    hosts = (arguments.hosts or "").split()
    jobs = parallel_jobs.read_jobs(arguments.jobs or "", "frames are rendered")
    if not hosts and (count <= 1 or not jobs and _is_measuring(words)):
        return None
    engine = parallel_jobs.choose_engine("sweep", jobs, hosts, arguments.out, "its process")
    if engine and not hosts:
        engine.jobs = min(engine.jobs, count)
    return engine


# --- The frames ------------------------------------------------------------------------------------


class _Sweep:
    """A sweep under way."""

    def __init__(self, table, words, out, folder):
        self.table, self._words, self._out, self._folder = table, words, out, folder
        self.done, self.refused, self.faults, self._notes = 0, {}, {}, collections.Counter()
        self._taken, self._is_new = set(), not os.path.exists(table.path)
        if self._is_new:
            table.write()  # so that the next command knows whose frames these are

    def _say(self, number, text):
        width, words = len(str(len(self._words))), shlex.join(self._words[number - 1])
        print(printable(f"{number:>{width}} of {len(self._words)}  {words}  {text}"), flush=True)

    def take(self, ended):
        """Adds what a worker found out about a frame to the table."""
        if ended.fault:
            self.faults[ended.number] = ended.fault
            self._say(ended.number, f"no picture: {ended.fault}")
            return
        try:
            self._read(ended.number)
        except FileNotFoundError as error:
            raise ToolError(f"frame {ended.number} is not in {self._out}: is it the same folder on all HOSTS?"
                            ) from error

    def _read(self, number):
        with open(os.path.join(self._folder, f"{number}.json"), encoding="utf-8") as file:
            said = json.load(file)
        self._taken.add(number)
        self.table.put(number, said)
        if "reason" in said:
            self.refused[number] = said["reason"]
            return
        self.done += 1
        self._notes.update(said["notes"])
        self.table.write_soon()
        self._say(number, f"{said['seconds']:.2f} s")

    def run(self, numbers, engine, command):
        """Renders these; ends early where all fail alike."""
        jobs = engine.run(command, numbers) if engine else parallel_jobs.one_by_one(
            command, numbers, lambda number: None, parallel_jobs.TRIES, "its process")
        with contextlib.closing(jobs):
            for ended in jobs:
                self.take(ended)
                if len(self.refused) == _REFUSED:
                    return

    def keep(self):
        """Writes the table, with frames that ended while it was stopped. One of other frames stays until
        there is a new one."""
        for name in glob.glob(os.path.join(glob.escape(self._folder), "*.json")):
            number = int(os.path.basename(name).removesuffix(".json"))
            if number not in self._taken:
                self._read(number)
        shutil.rmtree(self._folder, ignore_errors=True)  # on a full disk, the table takes its place
        if self.done or self._is_new:
            self.table.write()

    def conclude(self, kept):
        """Says how it ended; returns the exit status."""
        for note, count in self._notes.most_common(_NOTES):
            print(printable(f"{note} ({count} frame{'s' * (count > 1)})"))
        count = len(self._words)
        print(f"sweep: {self.done + kept} of {count} frames are done, {kept} of them before; "
              f"{self.table.path} lists them", flush=True)
        if self.refused:
            number = min(self.refused)
            others = f", and {len(self.refused) - 1} more" if len(self.refused) > 1 else ""
            print(printable(f"sweep: {self.refused[number]}\nsweep: that was frame {number}, "
                            f"{shlex.join(self._words[number - 1])}{others}; mend VARY or OPTIONS, and give "
                            "the command again: what is done stays"), file=sys.stderr)
        if self.faults:
            print(printable(f"sweep: this machine failed: {next(iter(self.faults.values()))}; mend that, "
                            "and give the same command again: what is there stays"), file=sys.stderr)
        return 1 if self.refused else _ELSEWHERE if self.faults else 0


def _plan(arguments, feature, driver, options, words, jobs, folder):
    """Writes what workers read; returns the command for a frame, but for its number."""
    path = os.path.join(folder, "plan")
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"driver": driver, "name": feature.stem, "options": options, "frames": words, "jobs": jobs,
                   "out": os.path.abspath(arguments.out)}, file)
    launch, tool = (os.path.join(_TOOLS, name) for name in ("launch.py", "sweep_frame.py"))
    return [sys.executable, "-B", "-S", launch, tool, "--plan", os.path.abspath(path)]


def _render(arguments, toolchain, feature, options, names, values):
    """Renders what is not there yet; returns the exit status."""
    words = [[f"--{name}={value}" for name, value in zip(names, chosen)] for chosen in values]
    out = arguments.out
    with contextlib.ExitStack() as stack:
        stack.enter_context(_alone(out))
        _check_frames(out, len(words))
        driver, _ = made_driver(toolchain, arguments.impl, feature, stack)
        driver = shutil.copy(toolchain.built(driver), stack.enter_context(private_folder(toolchain)))
        helpers = [os.path.join(toolchain.build, name) for name in ("raykit-mesh", "raykit-image")]
        keys = Keys(driver, toolchain.tools["objcopy"], helpers, options)
        table = Table(out, names, values, [keys.of(frame) for frame in words])
        if not arguments.again:
            table.read()
        numbers = [number for number in range(1, len(words) + 1) if not table.has(number)]
        kept = len(words) - len(numbers)
        folder = stack.enter_context(temporary_folder(".sweep-", out))
        sweep = _Sweep(table, words, out, folder)
        engine = _engine(arguments, [*options, *(word for word in words[0])], len(numbers))
        command = _plan(arguments, feature, driver, options, words, engine.jobs if engine else 1, folder)
        try:
            sweep.run(numbers, engine, command)
        finally:
            sweep.keep()
        return sweep.conclude(kept)


def _animate(arguments, rate, count):
    names = [f"{stem_of(number)}.png" for number in range(1, count + 1)]
    missing = next((name for name in names if not os.path.exists(os.path.join(arguments.out, name))), None)
    if missing:
        raise ToolError(f"ANIMATE: there is no {missing}: the driver draws no picture with these options")
    print(f"sweep: wrote {film.write(arguments.out, names, rate)}")


def _work(arguments):
    rate = film.read_rate(arguments.animate or "")
    toolchain = build.Toolchain(arguments.build)
    feature = _choose_driver(toolchain, arguments.driver)
    options = words_of("OPTIONS", arguments.options or "")
    names, values = frames(arguments.vary or "", options)
    _make_folder(arguments.out)
    status = _render(arguments, toolchain, feature, options, names, values)
    if rate and not status:
        _animate(arguments, rate, len(values))
    return status


def main():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog="Exit status: 0 all frames are there; 1 the driver refused some; 2 it could not begin; "
        f"{_ELSEWHERE} this machine failed some: give the command again.")
    add = parser.add_argument
    add("--driver", required=True, metavar="NAME", help="of a feature, such as depth_of_field")
    add("--vary", required=True, metavar="WORDS",
        help="--option=a,b,c or --option=from:to:count, both ends included; of several, all combinations, "
        "the last one changing fastest")
    add("--options", metavar="WORDS", help="of the driver, for all frames")
    add("--out", required=True, metavar="DIR", help="where the pictures and sweep.csv go")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    add("--impl", default="", metavar="FILE_OR_DIR", help="none: the kit's own units")
    add("--jobs", metavar="N",
        help="so many frames at once, with GNU parallel; default: one for each processor, but one after the "
        "other with --threads, --timing or --runs")
    add("--hosts", metavar="NAMES",
        help="machines for ssh that have the same folders at the same paths; : is this one")
    add("--animate", metavar="RATE", help="yes, or frames per second: also a film, sweep.mp4, by ffmpeg")
    add("--again", action="store_true", help="also what is there already")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    sys.stderr.reconfigure(errors="backslashreplace")
    parallel_jobs.stop_on_signals()
    return run_command("sweep", lambda: _work(arguments), 2,
                       "; what is finished stays, and the same command goes on", _ELSEWHERE)


if __name__ == "__main__":
    sys.exit(main())
