#!/usr/bin/env python3
"""A made-up class on its way from the download to the grade book. It is graded twice, once with nothing in
the way and once with a worker killed and the disk full; both tables are equal, and all that can be known of
each student beforehand holds. Speaks TAP, for make check-class-500; runs in a build folder."""

import collections
import contextlib
import csv
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import zipfile

import test_class
import test_grade
from test_class import rows_of
from test_grade import SOURCE
import made_up_class
from grading import parallel_jobs
from grading import sandbox
from tap import check, finish, read, start

_SIZE = os.environ.get("RAYKIT_SIZE") or "500"
_LEAST = 30  # a student of each kind, and a group
DUE = ("DUE=" + made_up_class.DUE, f"GRACE={made_up_class.GRACE}")
_PENALTY = 10


def launch(*command, stdout=subprocess.PIPE):
    """Starts a command as at an instructor's prompt, with little time for claims: many do not end."""
    dropped = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "srcdir", "TESTS_ENVIRONMENT")
    environment = {name: value for name, value in os.environ.items() if name not in dropped}
    return subprocess.Popen(command, env=dict(environment, RAYKIT_TEST_SECONDS="3"), text=True,
                            stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.STDOUT,
                            errors="replace")


def make(*words):
    return [os.environ.get("MAKE", "make"), "-s", *words, "ASSIGNMENTS=normals"]


def grading(place, out):
    return make("grade-class", f"SUBMISSIONS={place}", f"OUT={out}", "JOBS=2")


def timed(what, *command):
    """Returns the exit status and what was said; prints what it took."""
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    process = launch(*command)
    said = process.communicate()[0]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    worked = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"# {what}: {time.monotonic() - begin:.0f} s, {worked:.0f} s of processors, load "
          f"{os.getloadavg()[0]:.1f}", flush=True)
    return process.returncode, said


def table(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def wrong_in(members, fault):
    """Returns what is wrong with each member, as `fault` says it."""
    return [f"{member.id} {member.name} ({member.work.kind}): {said}"
            for member, said in ((member, fault(member)) for member in members) if said]


def one_of_each(members):
    """Returns the submissions' first members."""
    return [member for member in members if member.team == member.id]


# --- The way -------------------------------------------------------------------------------------


def collected(folder, members):
    place = os.path.join(folder, "submissions")
    status, said = timed("make collect", *make(
        "collect", f"DOWNLOAD={folder}/moodle.zip", f"ROSTER={folder}/roster.csv", f"OUT={place}", *DUE))
    rows = {row["id"]: row for row in table(os.path.join(place, "collected.csv"))}

    def fault(member):
        row = rows[member.id]
        days = str(member.days) if member.team else ""
        if (row["submission"], row["days_late"]) != (member.team, days):
            return f"wanted {member.team!r}, {days!r} days late: {row}"
        if not member.team:
            wanted = "missing" if member.work.kind == "missing" else "handed in, but no normals.c"
            return "" if wanted in row["remarks"] else row["remarks"]
        with open(os.path.join(place, member.team, "normals.c"), "rb") as file:
            return "" if file.read() == member.work.text else "another file was taken"

    wrong = wrong_in(members, fault)
    check(not wrong and list(rows) == [member.id for member in members],
          "who handed in what, how many days late, for whom, and who is missing", wrong or said)
    asked = any(member.work.kind == "no unit" for member in members)
    check(status == (2 if asked else 0), "it ends with an error where somebody has handed in something else",
          f"{status}\n{said}")
    return place


def expected_rows_hold(members, rows):
    def fault(member):
        row = rows[member.id]
        points, reason = row[1], row[5]
        if not points or (int(points) != member.work.points if member.work.points is not None
                          else int(points) >= 100):
            return f"wanted {member.work.points} points: {row}"
        return "" if member.work.says in reason else f"wanted the reason {member.work.says}: {row}"

    teams = one_of_each(members)
    wrong = wrong_in(teams, fault)
    check(not wrong and len(rows) == len(teams), "each submission has its points and its reason", wrong)


def expected_claims_fail(members, out):
    def fault(member):
        with open(os.path.join(out, "verdicts", "normals", f"{member.id}.json"), encoding="utf-8") as file:
            failed = [claim["name"] for claim in json.load(file)["claims"] if not claim["passed"]]
        return "" if set(member.work.fails) <= set(failed) else f"wanted {member.work.fails}, failed {failed}"

    wrong = wrong_in(one_of_each(members), fault)
    check(not wrong, "the claims that a mistake is known to fail do fail", wrong)


class SmallDisk:
    """A file system of so many bytes in namespaces of its own, with all that runs there. `inside` is its
    folder for those; `outside` is the same for everybody else."""

    def __init__(self, folder, size):
        self.inside = os.path.join(folder, "small")
        os.mkdir(self.inside)
        self._keeper = subprocess.Popen(
            ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c",
             "mount -t tmpfs -o size=$1 none \"$0\" && mkdir \"$0/tmp\" && echo && exec cat",
             self.inside, str(size)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._keeper.stdout.readline()
        self.outside = f"/proc/{self._keeper.pid}/root{self.inside}"

    def around(self, command):
        return ["nsenter", f"--target={self._keeper.pid}", "--user", "--mount", "--preserve-credentials",
                "sh", "-c", "cd \"$0\" && TMPDIR=\"$1/tmp\" && export TMPDIR && shift && exec \"$@\"",
                os.getcwd(), self.inside, *command]

    def fill(self):
        with contextlib.suppress(OSError), open(os.path.join(self.outside, "ballast"), "wb", 0) as file:
            while True:
                file.write(bytes(1 << 16))

    def empty(self):
        os.unlink(os.path.join(self.outside, "ballast"))

    def close(self):
        self._keeper.communicate()


def _verdicts(out):
    with contextlib.suppress(FileNotFoundError):
        return len(os.listdir(os.path.join(out, "verdicts", "normals")))
    return 0


def _until(process, condition):
    """Waits until something holds; returns whether it did before the process ended."""
    while process.poll() is None:
        if condition():
            return True
        time.sleep(0.02)
    return False


def _killed_one(process, out):
    """Kills a worker; returns whether there was one before the process ended."""
    while process.poll() is None:
        for number in test_class.workers(out):
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
                return True
        time.sleep(0.02)
    return False


def disturbed(folder, place, members, rows):
    """Grades the class on a small disk, with a worker killed after a third, and no space after two."""
    count = len(rows)
    disk = SmallDisk(folder, test_class.kit_bytes() + (32 << 20) + count * (64 << 10))
    try:
        inside, out = (os.path.join(name, "results") for name in (disk.inside, disk.outside))
        begin = time.monotonic()
        with open(os.path.join(folder, "said"), "w", encoding="utf-8") as file:
            process = launch(*disk.around(grading(place, inside)), stdout=file)
        _until(process, lambda: _verdicts(out) >= count / 3)
        check(_killed_one(process, inside), "a worker is killed after a third of the class")
        is_full = _until(process, lambda: _verdicts(out) >= count * 2 / 3)
        disk.fill()
        process.wait()
        said, told = read(folder, "said"), rows_of(out)
        check(is_full and process.returncode == 2 and "Error 75" in said
              and "give the same command again" in said,
              "a disk that is full after two thirds is said, with what to do",
              f"{process.returncode}\n{said}")
        graded = [name for name, row in told.items() if row[1]]
        check(count / 3 < len(graded) < count and all(told[name] == rows[name] for name in graded),
              "what has points by then has the right ones",
              [f"{told[name]} for {rows[name]}" for name in graded if told[name] != rows[name]])
        disk.empty()
        status, said = timed("the same command again, with space", *disk.around(grading(place, inside)))
        print(f"# disturbed, in all: {time.monotonic() - begin:.0f} s", flush=True)
        now = rows_of(out)
        check(status == 0 and now == rows, "with space, the same command ends with the same table",
              [f"{now.get(name)} for {row}" for name, row in rows.items() if now.get(name) != row] or said)
        before = time.monotonic()
        status, said = timed("once more, unchanged", *disk.around(grading(place, inside)))
        check(status == 0 and said.count("unchanged") == count and rows_of(out) == rows
              and time.monotonic() - before < 10 + count / 5, "once more, nothing is graded again", said)
    finally:
        disk.close()


# --- What is made of it --------------------------------------------------------------------------


def grade_book_has_all(folder, place, out, members, rows):
    book = os.path.join(folder, "grades.csv")
    status, said = timed("make grade-book", *make(
        "grade-book", f"RESULTS={out}", f"ROSTER={place}/collected.csv", "FORMAT=csv", f"OUT={book}",
        f"PENALTY={_PENALTY}"))
    found = {row["id"]: row for row in table(book)}

    def fault(member):
        wanted = ""
        if member.team:  # a half is rounded up
            wanted = str((int(rows[member.team][1]) * (100 - _PENALTY * member.days) + 50) // 100)
        got = found[member.id]["normals"]
        return "" if got == wanted else f"wanted {wanted!r}, {member.days} days late: {found[member.id]}"

    wrong = wrong_in(members, fault)
    listed = said.count("not collected: handed in, but no normals.c")
    check((status == 0) == (listed == 0) and not wrong and len(found) == len(members)
          and listed == sum(member.work.kind == "no unit" for member in members),
          "the grade book has all, a group's members alike, with what being late costs", wrong or said)


def feedback_agrees(folder, place, out, members):
    """What each student reads is what the grade book has."""
    feedback = os.path.join(folder, "feedback.zip")
    _, said = timed("make feedback", *make("feedback", f"RESULTS={out}", f"ROSTER={place}/collected.csv",
                                           "FORMAT=plain", f"OUT={feedback}", f"PENALTY={_PENALTY}"))
    book = {row["id"]: row["normals"] for row in table(os.path.join(folder, "grades.csv"))}
    with zipfile.ZipFile(feedback) as archive:
        texts = {name.partition("/")[0]: archive.read(name).decode() for name in archive.namelist()}

    def fault(member):
        line = next((line for line in texts.get(member.id, "").splitlines() if line.startswith("normals: ")),
                    "")
        found = re.search(r": (\d+) counts?\.$", line) or re.match(r"normals: (\d+) of 100 points", line)
        got = found[1] if found else ""
        return "" if got == book[member.id] else f"the grade book has {book[member.id]!r}: {line}"

    wrong = wrong_in(members, fault)
    check(not wrong and len(texts) == sum(bool(member.team) for member in members)
          and any("cost" in text for text in texts.values()),
          "each student reads the number that the grade book has", wrong or said)


def copies_are_found(place, out, members):
    """Those who make the same mistake have the same text here, and are not looked at."""
    status, said = timed("make similar", *make("similar", f"SUBMISSIONS={place}", f"OUT={out}"))
    works = {member.id: member.work for member in one_of_each(members)}
    writers = collections.defaultdict(list)
    for name, work in works.items():
        writers[work.like].append(name)
    wanted = {frozenset(names) for text, names in writers.items() if text and len(names) == 2}
    found = {frozenset((row["submission"], row["other"]))
             for row in table(os.path.join(out, "similar.csv")) if row["other"] in works
             and {works[row[name]].kind for name in ("submission", "other")} & {"own work", "copy", "right"}}
    check(status == 0 and found == wanted and wanted,
          "similar.csv has the copies, and nobody else who is right",
          f"lacks {wanted - found}, has {found - wanted}\n{said}")


def page_is_made(place, out, members):
    status, said = timed("make class-page", *make("class-page", f"RESULTS={out}",
                                                  f"ROSTER={place}/collected.csv"))
    missing = sum(member.work.kind == "missing" for member in members)
    check(status == 0 and f"{len(one_of_each(members))} verdicts, {missing} missing" in said
          and os.path.getsize(os.path.join(out, "class.html")), "the class's page is of all of them", said)


def the_class_has_all(members):
    counts = collections.Counter(member.work.kind for member in one_of_each(members))
    counts.update(member.work.kind for member in members if member.work.text is None)
    late = sum(bool(member.days) for member in one_of_each(members))
    print(f"# {len(members)} students, {len(one_of_each(members))} submissions, {late} of them late, "
          f"{sum(bool(member.group) for member in members)} students in groups")
    print("# " + ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())), flush=True)
    check(len(members) == int(_SIZE) and len(counts) == len(made_up_class.KINDS)
          and late and any(member.group for member in members),
          "the class is as large as it was asked for, with students of each kind, late and in groups", counts)


def main():
    sandbox.prepare()
    if not _SIZE.isdecimal() or int(_SIZE) < _LEAST:
        print(f"1..1\nnot ok 1 - SIZE={_SIZE}: give a number of students, {_LEAST} at least")
        return 1
    if not parallel_jobs.find_parallel() or test_grade.NO_SANDBOX:
        print("1..0 # SKIP needs GNU parallel and bubblewrap")
        return 0
    folder = tempfile.mkdtemp(prefix="raykit-test-class-")
    try:
        members, out = made_up_class.make(SOURCE, folder, int(_SIZE)), os.path.join(folder, "results")
        the_class_has_all(members)
        place = collected(folder, members)
        status, said = timed("make grade-class, undisturbed", *grading(place, out))
        check(status == 0, "a class is graded", said)
        rows = rows_of(out)
        expected_rows_hold(members, rows)
        expected_claims_fail(members, out)
        disturbed(folder, place, members, rows)
        grade_book_has_all(folder, place, out, members, rows)
        feedback_agrees(folder, place, out, members)
        copies_are_found(place, out, members)
        page_is_made(place, out, members)
    finally:
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
