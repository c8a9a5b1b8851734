#!/usr/bin/env python3
"""Grades one submission: writes a verdict file for each assignment and a report, whatever happens. What was
graded before in the same state, by the hash of unit, suite, points, grader and compiler, is not graded
again.

It needs nothing but a build, the submission and the folder for results, so queues of any kind can run many at
once, on several machines; make grade-class runs it for a whole class, and puts the results into a table.
"""

import json
import os
import re
import sys

from grading import bubblewrap
from grading import build
from grading import private_copy
from grading import results
from grading import sandbox
from grading import verdict_files
from grading.assignments import (
    MachineError, Parser, ToolError, Unit, choose, choose_format, is_archive, is_machines_fault,
    is_misnamed_c, read_features, read_points,
)
from grading.c_source import tokens_of
from grading.parallel_jobs import tell
from grading.starters import is_handed_out
from grade import Suite, check_seed, grade_prepared, prepare_submission, seconds_per_test, stop_on_signals

ENDINGS = {"text": ".txt", "table": ".txt", "tap": ".tap", "junit": ".xml", "gradescope": ".json"}
UNGRADABLE, ELSEWHERE = 3, 75  # the second as in <sysexits.h>, for queues: try again


def student_of(entry):
    """Returns the name of a file without the endings that submissions have."""
    return re.sub(r"(\.c|\.c\.txt|\.tar\.\w+|\.\w+)$", "", entry, flags=re.IGNORECASE)


def _check_submission(path):
    """Raises ToolError unless the path itself holds a student's work."""
    if os.path.islink(path):
        raise ToolError("it is a link; a submission is a folder or C file of its own")
    name = os.path.basename(path)
    if is_archive(name) and not os.path.isdir(path):
        raise ToolError(f"unpack {name} into a folder {student_of(name)}")
    if is_misnamed_c(name) and not os.path.isdir(path):
        raise ToolError(f"rename {name} to {student_of(name)}.c")


def _is_reference_text(suite):
    """Whether the unit's code is the reference's, whatever its comments and layout."""
    reference, path = suite.feature.reference, suite.unit.path
    if not path or not os.path.exists(reference) or is_handed_out(reference):
        return False
    texts = []
    for name in (path, reference):
        with open(name, encoding="utf-8", errors="replace") as file:
            texts.append([token.text for token in tokens_of(file.read(1 << 20))])
    return texts[0] == texts[1]


def _notes(suite):
    """Remarks for the instructor beside the points."""
    stem, hung = suite.feature.stem, sum(verdict.timed_out for verdict in suite.verdicts.values())
    claims = "1 claim" if hung == 1 else f"{hung} claims"
    notes = [*suite.remarks, *([f"{stem}: {claims} timed out"] if hung else [])]
    if suite.unit.is_reference:
        notes.append(f"{stem}: this is the reference")
    elif not suite.not_graded and _is_reference_text(suite):
        notes.append(f"{stem}: the same text as the reference")
    return notes


def _none_of(features, reason):
    """Returns suites of a submission that cannot be graded."""
    suites = [Suite(feature, Unit(feature, None, feature.stem + ".c", False), read_points(feature))
              for feature in features]
    for suite in suites:
        suite.not_graded, suite.is_own = reason, False
        suite.give_up(f"not graded: {reason}")
    return suites


def _said_of(error):
    """Returns an error's text without the path to the submission."""
    name = getattr(error, "filename", None)
    return f"{os.path.basename(name)}: {error.strerror}" if name else str(error)


class Grader:
    """Grades submissions with one build, into the folder `out`."""

    def __init__(self, toolchain, stems, out, format_name, again=False):
        self.toolchain, self.out, self.format_name, self.again = toolchain, out, format_name, again
        features = read_features(toolchain.source)
        self.features = choose(features, stems)
        self.digest = verdict_files.kit_digest(toolchain, features, toolchain.kit_copy, seconds_per_test())

    def _prepared(self, path):
        """Returns the suites of a submission; those that cannot be graded say why."""
        try:
            _check_submission(path)
            return prepare_submission(self.toolchain, [feature.stem for feature in self.features], path)
        except Exception as error:  # whatever one submission brings about
            if is_machines_fault(error):
                raise
            gone = f"{os.path.basename(path)} vanished while the class was graded"
            return _none_of(self.features, str(error) if os.path.lexists(path) else gone)

    def _judge(self, suite, name, path):
        """Gives a suite its verdicts, from before where nothing has changed. Returns what is known of it."""
        key = ""
        if not suite.problem:
            try:
                key, before = self._before(suite, name)
                if before:
                    suite.take(before["judged"])
                    return before
                grade_prepared(self.toolchain, [suite], path)
            except Exception as error:
                if is_machines_fault(error):
                    raise
                suite.not_graded = _said_of(error)
                suite.give_up(f"not graded: {suite.not_graded}")
        return verdict_files.write(self.out, name, suite, "" if suite.not_graded else key,
                                   _notes(suite))

    def grade(self, path, name):
        """Grades a submission. Returns what is known of each assignment."""
        suites = self._prepared(path)
        found = [self._judge(suite, name, path) for suite in suites]
        self._write_report(suites, name)
        return found

    def known(self, path, name):
        """Returns what is known of a submission, with a report, if none of its code has to run for it; or
        None."""
        suites = self._prepared(path)
        try:
            is_known = all(suite.problem or self._before(suite, name)[1] for suite in suites)
        except OSError:  # of one submission, which its worker tells
            is_known = False
        if is_known:
            found = [self._judge(suite, name, path) for suite in suites]
            self._write_report(suites, name)
            return found
        return None

    def _before(self, suite, name):
        """Returns a suite's key, and what was found of the same state before, or None."""
        key = verdict_files.key_of(self.digest, self.toolchain, suite)
        before = None if self.again else verdict_files.read(self.out, suite.feature.stem, name)
        return key, before if before and before["key"] == key else None

    def _write_report(self, suites, name):
        """Writes the report in place of those that earlier runs made, in any format."""
        path = os.path.join(self.out, verdict_files.file_name(name))
        results.write_whole(path + ENDINGS[self.format_name], results.FORMATS[self.format_name](suites, name))
        for ending in set(ENDINGS.values()) - {ENDINGS[self.format_name]}:
            if os.path.lexists(path + ending):
                os.unlink(path + ending)


def summary(found):
    """Returns a few words on what was found."""
    if all(part["not_graded"] for part in found):
        return f"   not graded: {found[0]['not_graded']}"
    points, most = (sum(part[key] for part in found) for key in ("points", "maximum"))
    left = sum(bool(part["not_graded"]) for part in found)
    return f"{points:>5} of {most} points" + (f", {left} not graded" if left else "")


def _job(path, number):
    """Returns the path and the name of a submission of a class's list."""
    with open(path, encoding="utf-8") as file:
        name, submission = json.load(file)[number - 1]
    return os.fsdecode(bytes.fromhex(submission)), os.fsdecode(bytes.fromhex(name))


def _arguments():
    parser = Parser(
        description=__doc__.split("\n\n")[0],
        epilog=f"Exit status: 0 graded, whatever the points; {UNGRADABLE} it cannot be graded until somebody "
        "does what its report says; 2 the command is wrong; "
        f"{ELSEWHERE} this machine is to blame (a full disk, no memory, no sandbox), nothing was written: "
        "try again, or elsewhere.",
    )
    parser.add_argument("stems", nargs="*", metavar="STEM", help="features; default: all")
    add = parser.add_argument
    add("--submission", metavar="PATH", help="a folder or C file")
    add("--name", metavar="NAME", help="in the results; default: the file's or folder's")
    add("--out", required=True, metavar="DIR", help="where the results go")
    add("--build", default=".", metavar="DIR", help="where raykit was built (default: here)")
    add("--format", metavar="FORMAT", default="gradescope",
        help=f"of the report: {', '.join(sorted(ENDINGS))}")
    add("--again", action="store_true", help="also what has not changed")
    add("--jobs", type=int, metavar="N", help="so many processors at most; default: all")
    add("--kit", metavar="DIR", help="a copy of the kit that make grade-class made")
    add("--list", metavar="FILE", help="of make grade-class: the class, of which it grades one")
    add("--number", type=int, metavar="N", help="this one, from 1 on; how it ended is said as JSON")
    return parser.parse_args()


def _grade(arguments):
    check_seed()
    results.check_visibility()
    choose_format(arguments.format, ENDINGS)
    toolchain = build.Toolchain(arguments.build)
    features = read_features(toolchain.source)
    choose(features, arguments.stems)
    toolchain.sandbox, toolchain.remark = bubblewrap.find(toolchain)
    toolchain.judges, toolchain.workers = True, arguments.jobs
    if arguments.list:
        path, name = _job(arguments.list, arguments.number)
    elif arguments.submission:
        path = os.path.normpath(arguments.submission)
        name = arguments.name or os.path.basename(path).removesuffix(".c")
        if not os.path.lexists(path):
            raise ToolError(f"there is no submission {path}")
    else:
        raise ToolError("say which: --submission PATH")
    os.makedirs(arguments.out, exist_ok=True)
    with private_copy.borrowed(arguments.kit, toolchain, features, arguments.stems) as kit:
        toolchain.kit_copy = kit
        grader = Grader(toolchain, arguments.stems, arguments.out, arguments.format, arguments.again)
        found = grader.grade(path, name)
    if arguments.list:
        tell(number=arguments.number)
        return 0
    print(results.printable(f"{results.name_of(name)}: {summary(found).strip()}"))
    return UNGRADABLE if any(part["not_graded"] for part in found) else 0


def main():
    arguments = _arguments()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files can be any bytes
    stop_on_signals()
    sandbox.prepare()
    try:
        return _grade(arguments)
    except (MachineError, MemoryError, OSError) as error:
        if not is_machines_fault(error):
            print(f"grade-one: {getattr(error, 'filename', '') or 'the system'}: {error}", file=sys.stderr)
            return 2
        if arguments.list:
            tell(number=arguments.number, fault=str(error)[:500] or "no memory")
        else:
            print(f"grade-one: {error or 'no memory'}", file=sys.stderr)
        return ELSEWHERE
    except ToolError as error:
        print(f"grade-one: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("grade-one: stopped", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
