#!/usr/bin/env python3
"""Leads through the assignments: what to read, which file to edit, the picture in the browser, a verdict on
each save, and then the next assignment; at the end, what to hand in. Ctrl-C ends it."""

import os
import re
import shutil
import subprocess
import sys
from time import sleep

import live_loop
from drivers import private_folder
from grade import stop_on_signals
from grading.assignments import (Parser, ToolError, cause_of, check_impl, choose, find_unit,
                                 missing_unit, read_features, read_points)
from grading.build import Toolchain
from grading.private_copy import make_folder
from grading.results import command_of
from grading.starters import is_starter
from handout_text import handout_of, sheet_of
from progress import hand_in, progress_of
from watch import Screen, state

_REASON = 20  # lines of a build that failed


def make(build, target, what, screen):
    """Makes what a command needs, on all processors, with a line about it if that takes a while."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    kept = {name: value for name, value in os.environ.items()
            if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    command = [kept.get("MAKE", "make"), f"-j{processors}", "--no-print-directory", target]
    said, told = [], False
    with subprocess.Popen(command, cwd=build, env=kept, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace") as process:
        for line in process.stdout:
            said.append(line)
            if not told and line.startswith("  CC "):
                told = True
                screen.end_status()
                print(f"building {what}, once ...", flush=True)
    if process.returncode:
        screen.end_status()
        print("".join(said[-_REASON:]), end="", file=sys.stderr)
        raise ToolError(f"{what} could not be built; the reason is above")


class Course:
    """The assignments that have a file in IMPL, in the course's order."""

    def __init__(self, build, impl, stems, screen):
        self.build, self.impl, self.toolchain, self.screen = build, impl, Toolchain(build), screen
        self._all, self._claims = read_features(self.toolchain.source), {}
        self.features = choose(self._all, stems)
        check_impl(self._all, impl, [feature.stem for feature in self.features])
        missing = [feature for feature in self.features if not find_unit(feature, impl).path]
        if missing and self.toolchain.handed_out:
            raise missing_unit(missing[0], impl)
        self.features = [feature for feature in self.features if feature not in missing]
        self.note = f"; {missing_unit(missing[0], impl)}" if missing else ""

    def chosen(self, stem):
        """Returns the assignment of this name."""
        check_impl(self._all, self.impl, [stem])
        return choose(self._all, [stem])[0]

    def unit(self, feature):
        """Returns the student's unit. An editor that saves may be replacing the file; two seconds are enough
        for that."""
        for _ in range(20):
            found = find_unit(feature, self.impl)
            if found.path:
                return found
            sleep(0.1)
        raise missing_unit(feature, self.impl)

    def first_claim(self, feature):
        """Returns the first claim that fails, None if none does; looks anew only after a save."""
        now = state(self.impl)
        if self._claims.get(feature.stem, (None, None))[0] != now:
            self._claims[feature.stem] = now, self._look_for_claim(feature)
        return self._claims[feature.stem][1]

    def _look_for_claim(self, feature):
        tests = [test for test in read_points(feature) if test.points]
        if is_starter(self.unit(feature)):
            return tests[0]
        self.screen.status(f"looking at what is done so far: {feature.stem} ...")
        make(self.build, f"grade-ready-{feature.stem}", f"what checks {feature.stem}", self.screen)
        suite = progress_of(self.build, [feature.stem], self.impl)[0][0]
        return next((test for test in suite.tests if not suite.verdicts[test.name].passed), None)

    def next(self):
        """Returns the first assignment that is not done, None if all are."""
        return next((feature for feature in self.features if self.first_claim(feature)), None)

    def end(self):
        """Returns what to do when all is done."""
        return hand_in([self.unit(feature) for feature in self.features])

    def make_page(self, feature):
        """Makes what the page of an assignment needs."""
        make(self.build, f"live-ready-{feature.stem}", f"what {feature.stem} needs", self.screen)

    def show(self, feature):
        """Prints what to do in an assignment."""
        lines = self.lines(feature, self.first_claim(feature))
        self.screen.end_status()
        print("\n".join(lines), flush=True)

    def lines(self, feature, claim):
        """Returns what to do for a claim: its assignment, what to read, which file to edit, how to get a
        hint."""
        text = handout_of(self.toolchain.source, feature)
        time = re.search(r"^\*\*Time:\*\* (about .*)\.$", text, re.MULTILINE)
        step = f", step {claim.step}" if claim and claim.step else ""
        sheet = sheet_of(feature, self.impl)
        hint = command_of("hint", feature) + (f" STEP={claim.step}" if claim and claim.step else "")
        return [text.splitlines()[0].lstrip("# ") + (f" ({time[1]})" if time else "") + step,
                f"    read  {feature.where_to_read(claim.section if claim else '')}",
                *([f"    task  {sheet}"] if sheet else []),
                f"    edit  {self.unit(feature).path}",
                f"    hint  {hint}"]


def browse(url):
    """Opens the page, where there is a screen for a browser; its own messages are nobody's concern."""
    if sys.platform == "darwin" or any(map(os.environ.get, ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY"))):
        subprocess.Popen([sys.executable, "-m", "webbrowser", url], stdin=subprocess.DEVNULL,
                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def work_on(course, feature, server):
    """Shows one assignment until the student goes on; returns the next one."""
    kept, following, screen = make_folder(), [], course.screen

    def judged(verdict):
        if not verdict.startswith("ok"):
            screen.verdict(verdict)
            screen.status(f"save {feature.stem}.c for the next verdict; the page: {server.url} ; Ctrl-C ends")
            return ""
        following[:] = filter(None, [course.next()])
        lines = course.lines(following[0], course.first_claim(following[0])) if following else [course.end()]
        verdict = re.sub("^ +next: make start.*\n", "", verdict, flags=re.MULTILINE)  # it has begun
        screen.verdict("\n".join([verdict, *lines, ""]))
        screen.status(f"save {following[0].stem}.c to go on, or press the page's button; Ctrl-C ends"
                      if following else f"all assignments are done; the page: {server.url} ; Ctrl-C ends")
        return following[0].stem if following else ""

    try:
        with private_folder(course.toolchain) as folder:
            loop = live_loop.Loop(course.toolchain, feature, course.impl, "", folder)
            server.show(loop)
            screen.status(f"checking {feature.stem} ...")
            loop.run(live_loop.grader_of(feature.stem, course.build, course.impl, kept), kept, judged, screen)
            loop.tell(begins=[f"building what {following[0].stem} needs"])
            course.make_page(following[0])
    finally:
        shutil.rmtree(kept, ignore_errors=True)
    return following[0]


def start(course, first):
    """Goes through the assignments, from this one on."""
    feature = course.chosen(first) if first else course.next()
    if not feature:
        course.screen.end_status()
        which = "the assignments here" if course.note else "all assignments"
        print(f"{which} have all their points; make start-STEM shows one again{course.note}")
        print(course.end())
        return
    course.show(feature)
    course.make_page(feature)
    server = live_loop.Server()
    print(f"    page  {server.url}", flush=True)
    browse(server.url)
    while True:
        feature = work_on(course, feature, server)
        course.show(feature)


def main():
    parser = Parser(description=__doc__.split("\n\n")[0])
    parser.add_argument("stems", nargs="*", metavar="STEM", help="assignments; default: all")
    parser.add_argument("--impl", required=True, metavar="DIR")
    parser.add_argument("--build", default=".", metavar="DIR")
    parser.add_argument("--first", default="", metavar="STEM", help="default: the first that is not done")
    arguments = parser.parse_args()
    stop_on_signals()
    build, screen = os.path.abspath(arguments.build), Screen()
    try:
        stems = [arguments.first] if os.path.isfile(arguments.impl) and arguments.first else arguments.stems
        start(Course(arguments.build, arguments.impl, stems, screen), arguments.first)
    except ToolError as error:
        screen.end_status()
        print(f"start: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        screen.end_status()
        print(f"start: {cause_of(error, build)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
