#!/usr/bin/env python3
"""Grades a class: each folder or C file in SUBMISSIONS. Writes a report for each and class.csv, which is
rewritten after each, so that an interruption loses no results: what has not changed is not graded again.

Points of a submission that cannot be graded are empty cells, with the reason; so are those of one that this
machine failed to grade. Rows of class.csv and reports of submissions that are not graded this time stay as
they are; each row says when it was made.
"""

import collections
import fnmatch
import json
import os
import re
import sys

from grading import bubblewrap
from grading import build
from grading import class_jobs
from grading import integrity
from grading import parallel_jobs
from grading import private_copy
from grading import results
from grading import sandbox
from grading import verdict_files
from grading.assignments import (
    MachineError, Parser, ToolError, cannot_write, choose, choose_format, is_archive, is_misnamed_c,
    read_features, read_points, run_command,
)
from grading.class_table import Table
from grading.collect_write import LIST, RECORD, TABLE
from grading.parallel_jobs import processors, stop_on_signals
from grading.temporary_folder import remove_left
from grade import check_seed
from grade_one import ELSEWHERE, ENDINGS, Grader, student_of, summary

_SHOWN = 3  # claims that the class failed most often
# What systems, editors and version control leave behind.
_LEFT_BEHIND = re.compile(r"\.(_.*|DS_Store|localized|Spotlight-V100|Trash.*|fseventsd|directory|nfs.*"
                          r"|git(ignore|attributes|modules|keep|hub)?|svn|hg(ignore|tags)?"
                          r"|vscode|vs|idea|project|editorconfig|clang-format|clangd|cache"
                          r"|~lock\..*|.*\.sw[a-p]|part-.*)")


def submissions_in(folder):
    """Returns a dictionary from name to path, and the names of strays: a table of grades is nobody's work,
    nor is what is hidden."""
    if not folder or not os.path.isdir(folder):
        raise ToolError(f"SUBMISSIONS: there is no folder {folder}" if folder else
                        "say where the submissions are: make grade-class SUBMISSIONS=folder OUT=results")
    found, strays = {}, []
    for entry in sorted(os.listdir(folder)):
        path, stem = os.path.join(folder, entry), entry.removesuffix(".c")
        if entry in (TABLE, LIST, RECORD):
            continue  # make collect's
        if entry.startswith("."):
            strays += [] if _LEFT_BEHIND.fullmatch(entry) else [entry]
            continue
        is_unpacked = is_archive(entry) and os.path.isdir(os.path.join(folder, student_of(entry)))
        if is_unpacked or not (os.path.isdir(path) or os.path.islink(path) or entry.endswith(".c")
                               or is_archive(entry) or is_misnamed_c(entry)):
            strays.append(entry)
            continue
        found[entry if stem != entry and os.path.lexists(os.path.join(folder, stem)) else stem] = path
    if not found:
        raise ToolError(f"SUBMISSIONS: the folder {folder} holds neither folders nor C files")
    return found, strays


def _namesakes(found):
    """Returns a dictionary from the names of submissions that may be one student's to the others' names."""
    students = {}
    for name, path in found.items():
        entry = os.path.basename(path)
        students.setdefault(entry if os.path.isdir(path) else student_of(entry), []).append(name)
    return {name: [other for other in names if other != name] for names in students.values()
            for name in names}


def _check_is_a_class(folder, found, features):
    """One student's folder would be graded as students called bloom and so on."""
    work = {name: path for name, path in found.items() if path.endswith(".c") or os.path.isdir(path)}
    if work and all(name in features and os.path.isfile(path) for name, path in work.items()):
        raise ToolError(f"SUBMISSIONS: the folder {folder} holds one student's units ({', '.join(work)}); "
                        f"give the folder that it is in, or grade it by make grade IMPL={folder}")


def _chosen(found, only):
    """Returns the submissions whose names fit one of the patterns in ONLY."""
    patterns = only.split()
    shown = {name: results.name_of(name) for name in found}
    for pattern in patterns:
        if not fnmatch.filter(shown.values(), pattern):
            raise ToolError(f"ONLY={pattern}: there is no such submission")
    return {name: path for name, path in found.items()
            if not patterns or any(fnmatch.fnmatchcase(shown[name], pattern) for pattern in patterns)}


def _check_out(out, submissions):
    if not out:
        raise ToolError("say where the results go: OUT=results, a folder")
    if os.path.join(os.path.realpath(out), "").startswith(os.path.join(os.path.realpath(submissions), "")):
        raise ToolError(f"OUT: {out} lies among the submissions; choose another place")
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise cannot_write(out, error) from error
    for prefix in (".jobs-", ".kit-"):
        remove_left(prefix, out)


def _engine(arguments, sandboxed):
    """Returns the parallel_jobs.Engine, or None for one submission after the other, on all processors."""
    hosts = (arguments.hosts or "").split()
    jobs = parallel_jobs.read_jobs(arguments.jobs or "", "submissions are graded")
    if not sandboxed:  # who changed the kit shows only between two
        if jobs > 1 or hosts:
            raise ToolError("without a sandbox, submissions are graded one after the other: leave out JOBS "
                            "and HOSTS")
        return None
    return parallel_jobs.choose_engine("grade-class", jobs, hosts, arguments.out)


class _Class:
    """A class that is being graded."""

    def __init__(self, stems, found, out, engine, watch):
        self.found, self.out, self.engine, self.watch = found, out, engine, watch
        self.stems, self.table = stems, Table(os.path.join(out, "class.csv"), stems)
        self.done, self.faults = 0, {}
        self._names, self._namesakes = list(found), _namesakes(found)
        self._failed, self._judged, self._told = collections.Counter(), collections.Counter(), None

    def begin(self, number):
        """Says whose turn it is: who ends this process is then the last one named."""
        name = self._names[number - 1]
        width = len(str(len(self.found)))
        print(f"{number:>{width}} of {len(self.found)}  {results.name_of(name):<24}", end="", flush=True)
        self._told = number

    def _say(self, number, text):
        if self._told != number:
            self.begin(number)
        print(results.printable(text), flush=True)
        self._told = None

    def take(self, number, found, remark=""):
        """Adds what was found of a submission to the table."""
        name = self._names[number - 1]
        twins = [results.name_of(other) for other in self._namesakes.get(name, [])]
        doubts = [f"{changed} changed since grading began, so these points may be wrong"
                  for changed in filter(None, [self._changed(name)])]
        remarks = [f"another submission has the same name: {', '.join(twins)}"] if twins else []
        self.table.put(name, found, "; ".join([*doubts, *remarks]))
        self.table.write()
        if self.watch:
            self.watch.accept(self.out, ["class.csv"])
        self.done += not doubts and not any(part["not_graded"] for part in found)
        for part in found:
            if not part["problem"]:  # what does not build says nothing of single claims
                for claim in part["claims"]:
                    key = f"{part['assignment']}: {claim['name']}"
                    self._judged[key] += 1
                    self._failed[key] += not claim["passed"]
        self._say(number, "; ".join([summary(found) + remark, *doubts]))

    def _changed(self, name):
        if not self.watch:
            return ""
        written = [verdict_files.file_name(name) + ending for ending in set(ENDINGS.values())]
        self.watch.accept(self.out, written)
        for stem in self.stems:
            path = verdict_files.path_of(self.out, stem, name)
            self.watch.accept(os.path.dirname(path), [os.path.basename(path)])
        return self.watch.changed()

    def fail(self, number, fault):
        """Notes a submission that this machine did not grade. A row that is there stays."""
        name = self._names[number - 1]
        self.faults[name] = fault
        if not self.table.has(name):
            self.table.put_unknown(name, fault)
            self.table.write()
            if self.watch:
                self.watch.accept(self.out, ["class.csv"])
        self._say(number, f"   no verdict: {fault}")

    def read(self, number):
        """Returns what a worker wrote about a submission."""
        name = self._names[number - 1]
        found = [verdict_files.read(self.out, stem, name) for stem in self.stems]
        if None in found:
            raise ToolError(f"the verdicts on {results.name_of(name)} are not in {self.out}: is it the same "
                            "folder on all HOSTS?")
        return found

    def summarize(self):
        most = self._failed.most_common(_SHOWN)
        if any(count for _, count in most):
            print("grade-class: failed most often: " + ", ".join(
                f"{claim} ({count} of {self._judged[claim]})" for claim, count in most if count))


def _known(job, grader):
    """Takes over what has not changed; returns the numbers of the others."""
    numbers = []
    for number, (name, path) in enumerate(job.found.items(), 1):
        found = grader.known(path, name)
        if found:
            is_old = any(part["key"] for part in found)
            job.take(number, found, ", unchanged" if is_old else "")
        else:
            numbers.append(number)
    return numbers


def _work(job, numbers, command):
    """Grades these; ends early where this machine fails again and again."""
    left = set(numbers)
    jobs = (job.engine.run(command(max(1, processors() // job.engine.jobs)), numbers) if job.engine
            else parallel_jobs.one_by_one(command(processors()), numbers, job.begin))
    for ended in jobs:
        left.discard(ended.number)
        if ended.fault:
            job.fail(ended.number, ended.fault)
        else:
            job.take(ended.number, job.read(ended.number))
    return left


def _list_of(found, folder):
    """Writes the list that workers read: names of files can be any bytes."""
    path = os.path.join(folder, "class.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump([[os.fsencode(name).hex(), os.fsencode(os.path.abspath(path)).hex()]
                   for name, path in found.items()], file)
    return path


def grade_class(arguments):
    """Grades all; returns the exit status."""
    submissions, out = arguments.submissions, arguments.out
    check_seed()
    results.check_visibility()
    choose_format(arguments.format, ENDINGS)
    toolchain = build.Toolchain(arguments.build)
    all_features = read_features(toolchain.source)
    features = choose(all_features, arguments.stems)
    stems = [feature.stem for feature in features]
    found, strays = submissions_in(submissions)
    _check_is_a_class(submissions, found, all_features)
    found = _chosen(found, arguments.only or "")
    _check_out(out, submissions)
    sandbox.prepare()
    try:
        toolchain.sandbox, toolchain.remark = bubblewrap.find(toolchain)
    except MachineError as error:  # a class does not begin without one; a queue tries another machine
        raise ToolError(error) from error
    toolchain.judges = True
    if toolchain.remark:
        print(f"grade-class: {toolchain.remark}", flush=True)
    engine = _engine(arguments, bool(toolchain.sandbox))
    again = arguments.again or not toolchain.sandbox  # without one, what was found before may be wrong
    watch = None if toolchain.sandbox else integrity.Watch(toolchain, submissions, out)
    job = _Class(stems, found, out, engine, watch)
    if strays:
        print("grade-class: no submissions, so ignored: " + ", ".join(map(results.name_of, strays)))
    with private_copy.borrowed(None, toolchain, all_features, stems, out if arguments.hosts else None) as kit:
        toolchain.kit_copy = kit
        numbers = _known(job, Grader(toolchain, stems, out, arguments.format, again))
        listed = _list_of(found, kit)
        left = _work(job, numbers, lambda count: class_jobs.command_of(
            arguments.build, stems, out, arguments.format, kit, listed, count, again))
    job.summarize()
    most = sum(test.points for feature in features for test in read_points(feature))
    print(f"grade-class: {job.done} of {len(found)} graded, of {most} points each; wrote {job.table.path}")
    if job.faults:
        reason = next(iter(job.faults.values()))
        others = f", and {len(left)} were not begun" if left else ""
        print(f"grade-class: this machine failed: {reason}{others}; mend that, and give the same command "
              "again: what is there stays", file=sys.stderr)
        return ELSEWHERE
    return 0 if job.done == len(found) else 1


def main():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog="Exit status: 0 all were graded, whatever their points; 1 some could not be, or their points "
        f"may be wrong; 2 it could not begin; {ELSEWHERE} this machine failed some: give the command again.",
    )
    add = parser.add_argument
    add("stems", nargs="*", metavar="STEM", help="features; default: all")
    add("--submissions", required=True, metavar="DIR", help="a folder or C file for each student")
    add("--out", required=True, metavar="DIR", help="where the results go")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    add("--format", metavar="FORMAT", default="gradescope",
        help=f"of the reports: {', '.join(sorted(ENDINGS))}")
    add("--jobs", metavar="N",
        help="so many submissions at once, with GNU parallel; default: one for each processor")
    add("--hosts", metavar="NAMES",
        help="machines for ssh that have the same folders at the same paths; : is this one")
    add("--only", metavar="NAMES", help="only submissions of these names, such as 'ann b*'")
    add("--again", action="store_true", help="also what has not changed")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    stop_on_signals()
    return run_command("grade-class", lambda: grade_class(arguments), 2,
                       "; what is finished is in the results, and the same command goes on", ELSEWHERE)


if __name__ == "__main__":
    sys.exit(main())
