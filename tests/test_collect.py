#!/usr/bin/env python3
"""From a download to a folder for each student, tried on made-up downloads of each platform, right, late,
ambiguous and wicked. Speaks TAP, for make check; runs in a build folder."""

import contextlib
import csv
import datetime
import errno
import io
import os
import resource
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unicodedata
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import collect  # noqa: E402
import downloads  # noqa: E402
import grade_class  # noqa: E402
from grading import collect_names  # noqa: E402
from grading.collect_roster import Student  # noqa: E402
from downloads import put, tarred, zipped  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

ROSTER = """id,name,email,group
1001,Ann Mason,amason@uni.edu,
1002,"Müller, Jörg",joerg.mueller@uni.edu,
1003,Kim Lou,klou@uni.edu,A
1004,Tom Jarvis,tjarvis@uni.edu,A
1005,Zoë van der Berg,zberg@uni.edu,
"""
DUE = "2026-10-05 23:59 +0200"
ZONE = datetime.timezone(datetime.timedelta(hours=2))


def at(day, hour, minute=0):
    return (2026, 10, day, hour, minute, 0)


class Class:
    """A folder with a roster, where downloads are collected."""

    def __init__(self, top, roster=ROSTER):
        self.folder = tempfile.mkdtemp(dir=top)
        write(roster, self.folder, "roster.csv")
        self.said, self.status, self.rows = "", None, {}

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def collect(self, download, *options, stems=("bloom",), out="out"):
        """Collects bytes, put into a file, or a dictionary of files, put into a folder, or a path."""
        if not isinstance(download, str):
            shutil.rmtree(self.path("download"), ignore_errors=True)
            if isinstance(download, dict):
                put(self.path("download"), download)
            else:
                shutil.rmtree(self.path("download.zip"), ignore_errors=True)
                put(self.folder, {"download.zip": download})
            download = self.path("download" if isinstance(download, dict) else "download.zip")
        arguments = [*stems, "--source", SOURCE, "--download", download, "--out", self.path(out), "--roster",
                     self.path("roster.csv"), *options]
        self.status, self.said = self.run(arguments)
        self.rows = {}
        if os.path.exists(self.path(out, "collected.csv")):
            with open(self.path(out, "collected.csv"), encoding="utf-8", newline="") as file:
                self.rows = {row.get("id"): row for row in csv.DictReader(file)}
        return self

    def run(self, arguments):
        """Returns the exit status and what was said."""
        said = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
        with mock.patch.object(sys, "argv", ["collect.py", *arguments]), contextlib.redirect_stdout(said), \
                contextlib.redirect_stderr(said):
            status = collect.main()
        said.flush()
        return status, said.buffer.getvalue().decode()

    def work(self, student="1001", name="bloom.c", out="out"):
        """Returns a collected file's text, or None."""
        path = self.path(out, student, name)
        return read(path) if os.path.isfile(path) else None

    def files(self, out="out"):
        return sorted(os.path.relpath(os.path.join(where, name), self.path(out))
                      for where, _, names in os.walk(self.path(out)) for name in names
                      if name != ".collected.json")

    def __str__(self):
        """What a failed claim shows."""
        return f"{self.status}\n{self.said}\n{self.files()}\n" + "\n".join(map(str, self.rows.values()))


def moodle(name, number=123456, file="bloom.c"):
    return f"{name}_{number}_assignsubmission_file_/{file}"


class ClassApart(Class):
    """The same in a process of its own, whose time and memory count."""

    def run(self, arguments):
        return run(self.folder, sys.executable, "-B", os.path.join(SOURCE, "tools", "collect.py"), *arguments)


# --- Platforms ----------------------------------------------------------------------------------


def moodles_folders_are_read(top):
    one = Class(top).collect(zipped(
        (moodle("Ann Mason"), "ann", at(5, 22)), (moodle("Jörg Müller", 7), "joerg", at(7, 22)),
        (moodle("Ann Mason", 123456, "report.pdf"), "no C"),
        ("Zoë van der Berg_99_assignsubmission_file_bloom.c", "zoe", at(6, 1))), "--due", DUE, "--grace", "2")
    check(one.status == 0 and [one.work(name) for name in ("1001", "1002", "1005")] == ["ann", "joerg",
                                                                                        "zoe"],
          "Moodle's folders, and its files without folders, are their students'", one)
    check([one.rows[name]["days_late"] for name in ("1001", "1002", "1005", "1003")] == ["0", "2", "0", ""],
          "days late are counted after the hours of grace; who is missing has none", one)
    check("by the archive's time" in one.rows["1001"]["remarks"] and
          one.rows["1001"]["submitted"] == "2026-10-05 22:00:00 +0200", "by what a time is known is said",
          one)
    check(list(one.rows) == ["1001", "1002", "1003", "1004", "1005"] and one.rows["1003"]["submission"] == ""
          and one.rows["1003"]["remarks"] == "missing"
          and "no work collected from Kim Lou (1003)" in one.said,
          "collected.csv has a row for each student, and missing ones are said", one)
    one = Class(top).collect(zipped((moodle("A-Ann Mason"), "ann"),
                                    (moodle("A-Tom Jarvis"), "tom")))
    check(one.work("1003") == "tom" and one.work() == "ann" and one.status == 0,
          "Moodle's name of the group may stand before a student's", one)


def canvas_files_are_read(top):
    one = Class(top).collect(zipped(
        ("masonann_55_901_bloom.c", "old"), ("masonann_55_905_bloom-1.c", "new"),
        ("müllerjörg_LATE_56_902_bloom.c", '#include "own.h"\n'), ("müllerjörg_LATE_56_903_own.h", "own"),
        ("vanderbergzoë_57_907_text.html", "<p>")), "--due", DUE)
    check(one.work() == "new" and "bloom.c was bloom-1.c" in one.rows["1001"]["remarks"],
          "of Canvas's files of one name the last one counts, with a remark", one)
    check(one.work("1002", "own.h") == "own", "a header that Canvas has renamed is beside its unit", one)
    check(one.rows["1002"]["days_late"] == "?" and one.rows["1001"]["days_late"] == "0" and one.status == 1
          and "how many days late" in one.said, "LATE without a number of days is asked for", one)


def blackboards_files_are_read(top):
    name = "Homework 3_amason_attempt_2026-10-0{}-23-11-02{}"
    one = Class(top).collect(zipped(
        (name.format(5, ".txt"), "Name: Ann"), (name.format(5, "_bloom.c"), "in time"),
        (name.format(6, "_bloom.c"), "late"), ("Homework 3_klou_attempt_2026-10-06-23-58-00_Bloom.C", "kim"),
        (name.format(4, "_bloom.c"), "early")), "--due", DUE)
    check(one.status == 0 and one.work() == "in time" and one.rows["1001"]["days_late"] == "0"
          and "a later bloom.c was not taken" in one.rows["1001"]["remarks"],
          "the last attempt before the deadline counts, by the time in its name", one)
    check(one.work("1003") == "kim" and one.rows["1003"]["days_late"] == "1" and
          "the time in its name" in one.rows["1003"]["remarks"], "a day late is one that has begun", one)


METADATA = """---
submission_71:
  :submitters:
  - :name: Ann Mason
    :sid: '1001'
    :email: amason@uni.edu
  :created_at: 2026-10-05 20:11:02.123456000 Z
  :score: 0.0
  :history:
  - :id: 5
    :created_at: 2026-10-01 01:01:01.000000000 Z
submission_72:
  :submitters:
  - :name: Jörg Müller
    :sid:
    :email: joerg.mueller@uni.edu
  - :name: "Zo\\xEB van der Berg"
    :sid: '1005'
    :email: null
  :created_at: 2026-10-06 22:30:00 Z
submission_73:
  :submitters:
  - :name: Nobody
    :sid: '1'
    :email: nobody@uni.edu
"""


def gradescopes_export_is_read(top):
    folder = "assignment_4711_export/"
    one = Class(top).collect(zipped(
        (folder + "submission_metadata.yml", METADATA), (folder + "submission_71/bloom.c", "ann"),
        (folder + "submission_72/src/bloom.c", "two"), (folder + "submission_73/bloom.c", "who")), "--due",
                             DUE)
    check(one.work() == "ann" and one.rows["1001"]["submitted"] == "2026-10-05 22:11:02 +0200"
          and "Gradescope's time" in one.rows["1001"]["remarks"], "Gradescope's list says who and when", one)
    check(one.work("1002") == one.work("1005") == "two" and one.rows["1005"]["days_late"] == "2",
          "all who share a submission there get it", one)
    check(one.status == 1 and "submission_73: it fits nobody" in one.said, "a stranger there is named", one)


def clones_and_mail_are_read(top):
    one = Class(top)
    place = one.path("clones", "homework-bloom-amason")
    put(place, {"bloom.c": "ann"})
    when = {"GIT_AUTHOR_DATE": "2026-10-06T23:00:00 +0200", "GIT_COMMITTER_DATE": "2026-10-06T23:00:00 +0200",
            "GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    for command in ("init -q", "add .", "-c user.name=A -c user.email=a@b commit -q -m A"):
        subprocess.run(["git", "-C", place, *command.split()], env=os.environ | when, check=True)
    one.collect(one.path("clones"), "--due", DUE)
    check(one.work() == "ann" and one.rows["1001"]["days_late"] == "1"
          and "last commit" in one.rows["1001"]["remarks"]
          and ".git" not in str(one.files()), "a clone is its login's, of the time of its last commit", one)
    one = Class(top)
    put(one.path("mail"), {"amason@uni.edu/bloom.c": "by address", "1002.zip": zipped(("bloom.c", "by id")),
                           "Tom Jarvis.tar.gz": tarred(("x/bloom.c", b"by name"), mode="w:gz"),
                           "zberg_bloom.c": "by login"},
        datetime.datetime(2026, 10, 5, 23, 59, 30, tzinfo=ZONE))
    one.collect(one.path("mail"), "--due", DUE)
    check([one.work(name) for name in ("1001", "1002", "1003", "1005")]
          == ["by address", "by id", "by name", "by login"] and one.status == 0,
          "saved mail is found by address, id, name and login", one)
    check({row["days_late"] for row in one.rows.values()} == {"0"} and "the file's time" in str(one.rows),
          "a deadline of 23:59 ends with that minute", one)


# --- Whose it is --------------------------------------------------------------------------------


def names_in_all_spellings_are_one(top):
    for kind in ("NFC", "NFD"):
        name = unicodedata.normalize(kind, moodle("Jörg Müller"))
        for how, data in (("", zipped((name, "joerg"))),
                          (", not said to be UTF-8", downloads.as_mac(name, "joerg"))):
            one = Class(top).collect(data)
            check(one.work("1002") == "joerg", f"a name in {kind}{how} is its student's", one)
    one = Class(top).collect(zipped((moodle("\u202eAnn\u200b Mason\u200f"), "ann"),
                                    (moodle("Muller Jorg"), "x"),
                                    (moodle("ZOE VAN DER BERG"), "zoe")))
    check([one.work(name) for name in ("1001", "1002", "1005")] == ["ann", "x", "zoe"],
          "marks of direction, accents that were lost, and capitals do not hide a name", one)
    one = Class(top, unicodedata.normalize("NFD", ROSTER).replace("Ann Mason", "Ann\u200f Mason")).collect(
        zipped((moodle("Jörg Müller"), "joerg"), (moodle("Ann Mason"), "ann")))
    check(one.work("1002") == "joerg" and one.work() == "ann", "a roster may spell them so, too", one)
    one = Class(top).collect({"Kim Lou/bloom.c": "kim", os.fsdecode(b"J\xf6rg/bloom.c"): "latin-1"})
    check(one.work("1003") == "kim" and one.status == 1 and "fits nobody" in one.said,
          "bytes that are no UTF-8 are "
          "nobody's", one)
    one = Class(top).collect(zipped((moodle("Joerg Mueller"), "joerg")))
    check(one.work("1002") == "joerg", "ö may be oe", one)


def nobody_is_guessed(top):
    one = Class(top, ROSTER + "1006,Ann Mason,other@uni.edu,\n").collect(zipped(
        (moodle("Ann Mason"), "which"), (moodle("Ann Masonry"), "who"), (moodle("Tom"), "who"),
        ("klou2_bloom.c", "who")))
    check(one.status == 1 and one.files() == ["collected.csv"], "names that fit in part fit nobody", one)
    check("it fits Ann Mason (1001) and Ann Mason (1006); give the right one a pattern in the roster, "
          "such as Ann Mason_123456_assignsubmission_file_" in one.said
          and "; Moodle's number is another in each assignment" in one.said, "two of a name are listed",
          one)
    one = Class(top, "id,name,email,pattern\n1001,Ann Mason,a@uni.edu,Ann Mason_1_*\n"
                     "1006,Ann Mason,b@uni.edu,Ann Mason_2_*\n").collect(
        zipped((moodle("Ann Mason", 1), "one"), (moodle("Ann Mason", 2), "two")))
    check(one.status == 0 and one.work() == "one" and one.work("1006") == "two", "patterns tell them apart",
          one)
    one = Class(top, "id,name,email,pattern\n1001,Ann Mason,a@uni.edu,ann*\n").collect(
        zipped(("annbloom.c", "x"), ("ann_x.txt", "")))
    check(one.work() is None and one.status == 1 and "found: annbloom.c" in one.said,
          "a pattern says whose it is, not what", one)
    one = Class(top, "id,name,email\n55,Kim Lou,k@uni.edu\n56,Ann Mason,a@uni.edu\n").collect(
        zipped(("masonann_55_901_bloom.c", "whose")))
    check(one.status == 1 and "it fits Ann Mason (56) and Kim Lou (55)" in one.said,
          "a name and an id that disagree are listed", one)
    one = Class(top, "id,name,email\n123456,Kim Lou,k@uni.edu\n56,Ann Mason,a@uni.edu\n").collect(
        zipped((moodle("Ann Mason", 123456), "ann")))
    check(one.status == 0 and one.work("56") == "ann", "Moodle's number is nobody's id", one)
    one = Class(top).collect({"Stranger/amason_bloom.c": "copied", "Ann Mason/bloom.c": "ann",
                              "notes.txt": "", "Kim Lou/bloom.c": "kim"})
    check(one.status == 1 and one.work() == "ann" and "Stranger: it fits nobody" in one.said
          and "no work, so ignored: notes.txt" in one.said, "a stranger's folder is not taken apart", one)


def what_was_not_collected_is_not_missing(top):
    """So that nobody gets 0 points for work that is there."""
    def remarks(one, *names):
        return [one.rows[name]["remarks"] for name in names]

    one = Class(top, ROSTER + "1006,Ann Mason,other@uni.edu,B\n1007,Eve Fox,efox@uni.edu,B\n").collect(
        zipped((moodle("Ann Mason"), "whose"), (moodle("Zoë van der Berg", 9, "report.pdf"), "%PDF"),
               (moodle("Jörg Müller", 8, "w.7z"), b"7z\xbc\xaf\x27\x1c" + bytes(99)),
               (moodle("A-A Stranger", 7), "of A")))
    check(all("not collected: Ann Mason_123456_assignsubmission_file_: it fits Ann Mason (1001) and" in text
              for text in remarks(one, "1001", "1006", "1007")),
          "of namesakes, and their groups, nobody is missing", one)
    check(remarks(one, "1002")[0].startswith("not collected: w.7z: 7z archives") and
          remarks(one, "1005") == ["not collected: handed in, but no bloom.c; found: report.pdf"],
          "nor is who handed in a 7z or a PDF", one)
    check(all(text.startswith("not collected: A-A Stranger_7_assignsubmission_file_: it fits nobody")
              for text in remarks(one, "1003", "1004")) and not any(row["submission"]
                                                                    for row in one.rows.values()),
          "nor is a group, one of which is not on the roster", one)
    one = Class(top, ROSTER + "1006,Ann Mason,other@uni.edu,\n").collect(
        zipped(("masonann_5_901_report.pdf", "%PDF"), ("loukim_5_7_bloom.c", "kim")))
    check(all(text.startswith("not collected: masonann_5_901_report.pdf") for text in
              remarks(one, "1001", "1006")), "nor are namesakes, one of whom handed in a PDF", one)
    one = Class(top).collect(zipped((moodle("Group A"), "of A")))
    check(all("it fits nobody" in text for text in remarks(one, "1003", "1004"))
          and remarks(one, "1001") == ["missing"], "nor is a group that handed in by its name", one)
    one = Class(top)
    put(one.path("folder"), {"Ann Mason/bloom.c": "x" * (5 << 20), "Kim Lou/bloom.c": "x"})
    one.collect(one.path("folder"))
    check(remarks(one, "1001") == ["not collected: bloom.c: it is larger than 4 MB, and was left out"],
          "nor is who handed in too much", one)
    one = Class(top).collect(zipped((moodle("Ann Mason"), "1"), (moodle("Ann Mason", 1, "a/shading.c"), "2"),
                                    (moodle("Ann Mason", 1, "b/shading.c"), "3")),
                             stems=("shading", "bloom"))
    check(one.rows["1001"]["submission"] == "1001" and "not collected: shading.c: nobody knows which" in
          one.rows["1001"]["remarks"], "of two assignments the one that was not collected is said", one)
    check({row["assignments"] for row in one.rows.values()} == {"bloom shading"},
          "collected.csv says for which assignments it was made", one)
    one = Class(top).collect({f"Who{number}/bloom.c": "x" for number in range(60)})
    listed = one.path("out", "collected.txt")
    check("and 20 more" in one.said and f"all of these are in {listed}" in one.said and one.status == 1
          and read(listed).count("fits nobody") == 60, "what is too much for the screen is in a file", one)
    found = grade_class.submissions_in(one.collect({"Ann Mason/bloom.c": "x"} | {
        f"Who{number}/bloom.c": "x" for number in range(60)}).path("out"))
    check(list(found[0]) == ["1001"] and not found[1] and one.status == 1,
          "which is written anew, and nobody's work", f"{found} {one}")
    one = Class(top).collect(zipped((moodle("Ann Mason", file="report.pdf"), "%PDF")), stems=())
    check("handed in, but no C file of an assignment; found: report.pdf" in one.said,
          "what else was handed in is named, and not all assignments", one)


def patterns_last(top):
    """A pattern that is proposed fits the next delivery, too, where the platform allows."""
    for name, pattern in (("schmidtemil_LATE_4404_901_bloom.c", "schmidtemil*_4404_*"),
                          ("Homework 3_eschmidt_attempt_2026-10-05-23-11-02_bloom.c", "*_eschmidt_attempt_*"),
                          ("e[s]_bloom.c", "e[[]s]_*"), ("Emil S.zip", "Emil S.zip")):
        data = zipped(("bloom.c", "x")) if name.endswith("zip") else "x"
        one = Class(top).collect(zipped((name, data), ("Ann Mason/bloom.c", "y")))
        check(f"such as {pattern}, or add the student to the roster" in one.said,
              f"for {name} the pattern {pattern} is proposed", one)
        one = Class(top, f"id,name,email,pattern\n7,Emil,x@uni.edu,{pattern}\n8,Ann Mason,,\n").collect(
            zipped((name, data), ("Ann Mason/bloom.c", "y")))
        check(one.work("7") == "x", "and fits", one)


def patterns_of_all_are_quick(_):
    """Each pattern and each name is brought into one spelling once, not once for each pair."""
    students = [Student(str(k), f"Ann Mason {k}", "", pattern=f"Ann*_{k}_*") for k in range(200)]
    with mock.patch.object(collect_names, "plain", side_effect=collect_names.plain) as plain:
        matcher = collect_names.Matcher(students)
        found = [matcher.by_pattern(moodle("Ann Mason", k)) for k in range(200)]
    check(found == [{student} for student in students] and plain.call_count <= 400,
          "where all have patterns, twice as many take twice as long to read", plain.call_count)


def a_group_has_one_submission(top):
    one = Class(top).collect(zipped((moodle("Kim Lou"), "kim", at(4, 12)),
                                    (moodle("Tom Jarvis"), "tom", at(5, 12)),
                                    (moodle("Ann Mason"), "ann", at(5, 12))), "--due", DUE)
    check(one.files() == ["1001/bloom.c", "1003/bloom.c", "collected.csv"] and one.work("1003") == "tom"
          and one.rows["1003"]["submission"] == one.rows["1004"]["submission"] == "1003"
          and "handed in by Tom Jarvis" in one.rows["1003"]["remarks"],
          "the last of a group's members' hand-ins is that of all", one)
    found, strays = grade_class.submissions_in(one.path("out"))
    check(sorted(found) == ["1001", "1003"] and not strays, "make grade-class finds folders, and no strays",
          f"{found} {strays}")


# --- What counts --------------------------------------------------------------------------------


def deadlines_are_kept(top):
    name = "H_amason_attempt_2026-10-{}_bloom.c"
    files = zipped((name.format("07-12-00-00"), "two days"), (name.format("06-12-00-00"), "one day"))
    one = Class(top).collect(files, "--due", DUE)
    check(one.work() == "two days" and one.rows["1001"]["days_late"] == "2", "of late ones the last counts",
          one)
    one.collect(files, "--due", DUE, "--until", "1")
    check(one.work() == "one day" and one.rows["1001"]["days_late"] == "1",
          "what comes after UNTIL does not count",
          one)
    one.collect(files, "--due", DUE, "--until", "0")
    check(one.status == 0 and one.work() is None and "came 1 day late, so it was not taken" in
          one.rows["1001"]["remarks"] and one.rows["1001"]["submission"] == "", "it is told if nothing does",
          one)
    one.collect(files, "--due", DUE, "--grace", "12.02")
    check(one.rows["1001"]["days_late"] == "0" and one.work() == "one day", "grace counts in hours", one)
    one.collect(files)
    check(one.rows["1001"]["days_late"] == "" and one.work() == "two days",
          "without a deadline the last counts",
          one)
    inner = zipped(("bloom.c", "old clock", (2020, 1, 1, 0, 0, 0)))
    one.collect(zipped((moodle("Ann Mason", 1, "w.zip"), inner, at(8, 12)),
                       (moodle("Kim Lou"), "", at(4, 1))),
                "--due", DUE)
    check(one.rows["1001"]["days_late"] == "3", "times within a student's archive do not count", one)
    late = datetime.datetime(2026, 10, 6, 23, tzinfo=ZONE)
    one.collect(downloads.with_zoned_time(moodle("Ann Mason"), "", late), "--due", DUE)
    check(one.rows["1001"]["submitted"] == "2026-10-06 23:00:00 +0200",
          "an archive's time with a zone is read as that",
          one)
    one.collect(zipped((moodle("Ann Mason"), "", at(9, 12)), (moodle("Kim Lou"), "", at(9, 12, 3))), "--due",
                DUE)
    check(one.status == 1 and one.rows["1001"]["days_late"] == "?" and "time of the download" in one.said,
          "times that are the download's are nobody's", one)
    check(one.said.count("time of the download") == 1 and "Ann Mason (1001), Kim Lou (1003)" in one.said
          and "0 late; lateness unknown: 3)" in one.said,
          "which is said once, and nobody counts as late", one)
    one.collect(files, "--due", DUE[:-6], "--until", "3")
    zone = f"{datetime.datetime(2026, 10, 5, 23).astimezone():%z}"
    check(f"DUE says no time zone, so it was taken in this machine's, {zone}" in one.said
          and ", taken up to 3 days late; 1 late)" in one.said,
          "the zone that is taken, and UNTIL, are said", one)
    for options, said in ((("--due", "5.10.2026"), "write the date, the time and the zone"),
                          (("--grace", "2"), "GRACE counts from the deadline"),
                          (("--until", "2"), "UNTIL counts from the deadline"),
                          (("--due", DUE, "--until", "soon"), "a number of days")):
        one.collect(files, *options, out="other")
        check(one.status == 2 and said in one.said and not os.path.exists(one.path("other")),
              f"{options[-1]} is refused", one)


def the_last_upload_counts(top):
    """However it is named, and wherever it lies."""
    def of_ann(*files):
        return Class(top).collect(zipped(*((moodle("Ann Mason", 1, name), text, time)
                                           for name, text, time in files)))

    one = of_ann(("bloom.c", "old", at(4, 10)), ("bloom (1).c", "new", at(4, 20)))
    check(one.work() == "new" and one.status == 0 and "bloom.c was bloom (1).c" in one.rows["1001"]["remarks"]
          and "another bloom.c was not taken: bloom.c" in one.rows["1001"]["remarks"],
          "a later upload counts before an earlier one of the plain name", one)
    one = of_ann(("bloom.c", "new", at(4, 20)), ("bloom (1).c", "old", at(4, 10)))
    check(one.work() == "new" and "not taken: bloom (1).c" in one.rows["1001"]["remarks"],
          "times count before numbers", one)
    one = of_ann(("bloom.c", "old", at(4, 10)), ("bloom (1).c", "mid", at(4, 10)),
                 ("bloom (2).c", "new", at(4, 10)))
    check(one.work() == "new" and one.status == 0 and "the highest number was taken"
          in one.rows["1001"]["remarks"] and "not taken: bloom.c, bloom (1).c" in one.rows["1001"]["remarks"],
          "of one time the highest number counts, with a remark", one)
    one = of_ann(("pack.zip", zipped(("pack/workbook/bloom.c", "old")), at(4, 10)),
                 ("bloom.c", "new", at(4, 20)))
    check(one.work() == "new" and "not taken: pack.zip/pack/workbook/bloom.c" in one.rows["1001"]["remarks"],
          "a file after a whole pack counts", one)
    for files in ((("bloom.c", "x", at(4, 10)), ("sub/bloom (1).c", "y", at(4, 10))),
                  (("a/bloom.c", "x", at(4, 10)), ("bloom.c", "y", at(4, 10))),
                  (("Bloom.c", "x", at(4, 10)), ("bloom.c", "y", at(4, 10)))):
        one = of_ann(*files)
        check(one.work() is None and one.status == 1 and "nobody knows which" in one.said
              and "nobody knows which" in one.rows["1001"]["remarks"],
              f"{files[0][0]} and {files[1][0]} of one time are told", one)
    one = of_ann(("a/bloom.c", "old", at(4, 10)), ("b/bloom.c", "new", at(4, 20)))
    check(one.work() == "new" and "not taken: a/bloom.c" in one.rows["1001"]["remarks"],
          "of two folders the later file counts", one)
    one = Class(top).collect(zipped((moodle("Ann Mason", 1, "bloom.c"), "in time", at(5, 10)),
                                    (moodle("Ann Mason", 1, "bloom (1).c"), "late", at(6, 10)),
                                    (moodle("Ann Mason", 1, "bloom (2).c"), "too late", at(9, 10))),
                             "--due", DUE, "--until", "2")
    check(one.work() == "in time" and "a later bloom.c was not taken: bloom (1).c, bloom (2).c"
          in one.rows["1001"]["remarks"], "the last one in time counts, within a folder, too", one)
    unit = '#include "own.h"\n'
    one = of_ann(("bloom.c", unit, at(4, 10)), ("own.h", "old", at(4, 10)), ("bloom (1).c", unit, at(4, 20)),
                 ("own (1).h", "new", at(4, 20)))
    check(one.work(name="own.h") == "new" and "own.h was own (1).h" in one.rows["1001"]["remarks"],
          "the last header counts, too", one)
    one = of_ann(("bloom.c", unit, at(4, 10)), ("own (1).h", "old", at(4, 10)), ("own.h", "new", at(4, 20)))
    check(one.work(name="own.h") == "new" and "own.h was" not in one.rows["1001"]["remarks"],
          "by its time", one)
    one = of_ann(("bloom.c", unit, at(4, 10)), ("own (1).h", "new", at(4, 10)), ("own.h", "old", at(4, 10)))
    check(one.work(name="own.h") == "new", "then by its number", one)
    one = Class(top)
    put(one.path("mail"), {"amason_bloom.c": "old", "amason_bloom (1).c": "new"},
        datetime.datetime(2026, 10, 5, 12, tzinfo=ZONE))
    one.collect(one.path("mail"))
    check(one.work() == "new" and "not taken: amason_bloom.c" in one.rows["1001"]["remarks"],
          "saved attachments of one name count by their numbers", one)


def files_are_found_under_their_names(top):
    for name in ("bloom-1.c", "bloom (1).c", "Bloom.C", "bloom.c.txt", "bloom(12).c", "BLOOM.c"):
        one = Class(top).collect(zipped((moodle("Ann Mason", 1, name), "ann")))
        check(one.work() == "ann" and f"bloom.c was {name}" in one.rows["1001"]["remarks"]
              and one.status == 0,
              f"{name} is taken, with a remark", one)
    for name in ("my_bloom.c", "bloomer.c", "bloom.cpp", "bloom.o"):
        one = Class(top).collect(zipped((moodle("Ann Mason", 1, name), "ann")))
        check(one.work() is None and one.status == 1 and f"found: {name}" in one.said, f"{name} is not", one)
    one = Class(top).collect(zipped((moodle("Ann Mason", 1, "a/bloom.c"), "a"),
                                    (moodle("Ann Mason", 1, "b/bloom.c"),
                                                                                 "b")))
    check(one.work() is None and one.status == 1 and "several bloom.c" in one.said, "of two nobody takes one",
          one)
    one.collect(zipped((moodle("Ann Mason", 1, "a/bloom.c"), "a"),
                       (moodle("Ann Mason", 1, "b/bloom.c"), "a")))
    check(one.work() == "a" and one.status == 0, "unless they are the same", one)
    one.collect(zipped((moodle("Ann Mason", 1, "pack/workbook/bloom.c"), "own"),
                       (moodle("Ann Mason", 1, "pack/src/features/bloom.c"), "kit's")))
    check(one.work() == "own", "in a whole pack the workbook's counts", one)
    one.collect(zipped((moodle("Ann Mason", 1, "pack/workbook/bloom.c"), "own", at(4, 10)),
                       (moodle("Ann Mason", 1, "pack/src/features/bloom.c"), "kit's", at(4, 20))))
    check(one.work() == "own" and "not taken" not in one.rows["1001"]["remarks"],
          "even if the kit's has a later time", one)
    one.collect(zipped((moodle("Ann Mason", 1, "bloom.c"),
                        '#include "mine.h"\n#include "features/bloom.h"\n'),
                       (moodle("Ann Mason", 1, "mine.h"), '# include "sub/more.h"\n'),
                       (moodle("Ann Mason", 1, "sub/more.h"), '#include "../../../evil.h"\n'),
                       (moodle("Ann Mason", 1, "unused.h"), "")))
    check(one.files() == ["1001/bloom.c", "1001/mine.h", "1001/sub/more.h", "collected.csv"],
          "headers beside a unit that it includes are taken, others are not", one)
    one.collect(zipped((moodle("Ann Mason", 1, "a/bloom.c"), '#include "Own.h"'),
                       (moodle("Ann Mason", 1, "a/own.h"), "1"),
                       (moodle("Ann Mason", 1, "b/shading.c"), '#include "Own.h"\n#include "o\0wn.h"'),
                       (moodle("Ann Mason", 1, "b/own.h"), "2")), stems=("bloom", "shading"))
    check(one.work(name="Own.h") and "two Own.h of different text" in one.said and one.status == 1
          and len(one.files()) == 4, "headers of one name and different texts are told", one)
    one.collect(zipped((moodle("Ann Mason", 1, "sampling.c"), "s"),
                       (moodle("Ann Mason", 1, "adaptive_sampling.c"), "a"),
                       (moodle("Ann Mason", 1, "bloom.c"), "b")), stems=("sampling", "adaptive_sampling"))
    check(one.files() == ["1001/adaptive_sampling.c", "1001/sampling.c", "collected.csv"],
          "only the assignments that were asked for are taken, by their whole names", one)


# --- Archives -----------------------------------------------------------------------------------


def archives_are_unpacked(top):
    inner = zipped(("p/bloom.c", "deep"))
    for kind, data in (("zip", inner), ("tar", tarred(("bloom.c", b"deep"))),
                       ("tar.gz", tarred(("./bloom.c", b"deep"), mode="w:gz")),
                       ("tar.xz", tarred(("bloom.c", b"deep"), mode="w:xz"))):
        one = Class(top).collect(zipped((moodle("Ann Mason", 1, "work." + kind), data)))
        check(one.work() == "deep" and one.status == 0, f"a {kind} in a zip is unpacked", one)
        one = Class(top).collect(tarred((moodle("Ann Mason", 1, "work." + kind), data), mode="w:gz"))
        check(one.work() == "deep", f"a {kind} in a tar.gz is unpacked", one)
    for count, taken in ((1, True), (2, True), (3, False)):
        data = inner
        for _ in range(count - 1):
            data = zipped(("again.zip", data))
        one = Class(top).collect(zipped((moodle("Ann Mason", 1, "w.zip"), data)))
        check((one.work() == "deep") == taken and one.status == (not taken), f"a zip {count} deep is "
              f"{'unpacked' if taken else 'told'}", one)
    one = Class(top).collect({"monday.zip": zipped(("masonann_55_901_bloom.c", "ann"),
                                                   ("loukim_5_7_bloom.c", "kim"))})
    check(one.work() == "ann" and one.work("1003") == "kim", "a platform's zip may lie in a folder", one)
    one = Class(top).collect({"monday.zip": zipped((moodle("Ann Mason"), "", at(4, 9)),
                                                   (moodle("Kim Lou"), ""))},
                             "--due", DUE)
    check(one.rows["1001"]["submitted"].startswith("2026-10-04 09:00:00"), "and its times count, not its own",
          one)


def wicked_archives_do_no_harm(top):
    one = Class(top)
    data = zipped(("../../bloom.c", "up"), ("/bloom.c", "root"), ("C:\\bloom.c", "drive"),
                  ("a\\..\\..\\bloom.c", "up"),
                  ("bloom.c", "right"))
    one.collect(zipped((moodle("Ann Mason", 1, "w.zip"), data)))
    check(one.work() == "right" and one.status == 1 and one.said.count("leads out of the archive") == 4,
          "paths that lead out of an archive are left out and told", one)
    check(sorted(os.listdir(one.folder)) == ["download.zip", "out", "roster.csv"], "nothing else is written",
          os.listdir(one.folder))
    one.collect(zipped((moodle("Ann Mason", 1, "w.zip"), downloads.with_link("bloom.c", "/etc/passwd"))))
    check(one.work() is None and "it is a link" in one.said and one.status == 1
          and "it is a link" in one.rows["1001"]["remarks"], "a link in a zip is left out and told", one)
    kinds = (("bloom.c", tarfile.SYMTYPE), ("hard/bloom.c", tarfile.LNKTYPE),
             ("fifo/bloom.c", tarfile.FIFOTYPE),
             ("device/bloom.c", tarfile.CHRTYPE))
    one.collect(zipped((moodle("Ann Mason", 1, "w.tar"), tarred(*(
        downloads.special(name, kind, "/etc/passwd") for name, kind in kinds)))))
    check(one.work() is None and one.said.count("it is a link") == 2 and one.said.count("no plain file") == 2,
          "links and devices in a tar are left out and told", one)
    put(one.path("folder", "Ann Mason"), {"report.txt": ""})
    os.symlink("/etc/passwd", one.path("folder", "Ann Mason", "bloom.c"))
    os.mkfifo(one.path("folder", "bloom.c"))
    one.collect(one.path("folder"))
    check(one.status == 1 and one.work() is None and "it is a link" in one.said
          and "no plain file" in one.said,
          "links and pipes in a folder are left out and told", one)
    shifted = bytearray(zipped(("bloom.c", "x")))
    shifted[-6] += 10  # where its directory begins: what is in it then lies before the file
    for name, data, said in (
            ("shifted.zip", bytes(shifted), "it is damaged"),
            ("encrypted.zip", zipped(("bloom.c", "secret"), encrypted=True), "it needs a password"),
            ("w.7z", b"7z\xbc\xaf\x27\x1c" + bytes(99),
             "7z archives are not unpacked here; unpack it by hand"),
            ("w.rar", b"Rar!\x1a\x07" + bytes(99), "rar archives are not unpacked here"),
            ("cut.zip", zipped(("bloom.c", "x" * 999))[:-30], "it is damaged"),
            ("cut.tar.gz", tarred(("bloom.c", os.urandom(999)), mode="w:gz")[:-600], "it is damaged"),
            ("text.zip", b"this is no archive", "it is damaged, or no archive"),
            ("many.zip", downloads.many_files(20001), "more than 20000 files")):
        one.collect(zipped((moodle("Ann Mason", 1, name), data), (moodle("Kim Lou"), "kim")))
        check(one.status == 1 and said in one.said and one.work() is None and one.work("1003") == "kim"
              and said in one.rows["1001"]["remarks"], f"{name} is told, and the others are collected", one)
    one.collect(b"no archive at all", out="none")
    check(one.status == 2 and "DOWNLOAD" in one.said and not os.path.exists(one.path("none")),
          "a download that is none is refused", one)


def bombs_do_not_go_off(top):
    one = ClassApart(top)
    bomb_zip, bomb_tar = downloads.zip_bomb("bloom.c"), downloads.tar_bomb("bloom.c")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    for name, data in (("w.zip", bomb_zip), ("w.tar.gz", bomb_tar),
                       ("z.zip", downloads.zip_bomb("inner.zip"))):
        one.collect(zipped((moodle("Ann Mason", 1, name), data), (moodle("Kim Lou"), "kim")))
        check(one.status == 1 and one.work() is None and one.work("1003") == "kim" and len(one.files()) == 2
              and ("far more than it takes up" in one.said or "larger than" in one.said),
              f"a bomb {name} is told",
              one)
    one.collect(zipped((moodle("Ann Mason", 1, "w.zip"), zipped(("bloom.c", bytes(3 << 20)))),
                       (moodle("Kim Lou"), "kim")))
    check(one.work() is None and "far more than it takes up" in one.said, "so is a small one", one)
    one.collect(bomb_zip)
    check(one.status == 1 and one.files() == ["collected.csv"], "a download that is a bomb is told", one)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime - before.ru_utime
    check(seconds < 20 and after.ru_maxrss < 400_000, "bombs cost neither time nor memory",
          f"{seconds} s, {after.ru_maxrss} kB")


# --- Rosters and OUT ----------------------------------------------------------------------------


def rosters_are_checked(top):
    good = zipped((moodle("Jörg Müller"), "joerg"))
    for how, text in (("a byte-order mark", "\ufeff" + ROSTER),
                      ("semicolons", ROSTER.replace('"Müller, Jörg"', "Jörg Müller").replace(",", ";")),
                      ("lines of Windows", ROSTER.replace("\n", "\r\n")),
                      ("capitals", ROSTER.replace("id,name,email,group", "ID,Name,EMail,Group")),
                      ("blank lines", ROSTER.replace("\n", "\n\n"))):
        one = Class(top)
        with open(one.path("roster.csv"), "w", encoding="utf-8", newline="") as file:
            file.write(text)
        one.collect(good)
        check(one.work("1002") == "joerg" and one.status == 0, f"a roster with {how} is read", one)
    one = Class(top, "Student ID,Last name,First name,Email address,Group\n1002,Müller,Jörg,,A\n")
    one.collect(good)
    check(one.work("1002") == "joerg" and one.rows["1002"]["name"] == "Jörg Müller"
          and one.rows["1002"]["group"] == "A" and "not used" not in one.said,
          "a registry's names of columns are read", one)
    one = Class(top, "id,student id,name,first name,last name,email\n1002,3,Jörg Müller,a,b,\n").collect(good)
    check(one.work("1002") == "joerg" and "not used: student id, first name, last name" in one.said,
          "the roster's own go before them", one)
    one = Class(top, ROSTER.replace("group", "gruop")).collect(good)
    check(one.status == 0 and "columns of the roster that are not used: gruop" in one.said,
          "a column of another name is told", one)
    for text, line, said in (
            ("id,name\n1,A\n", 1, 'no column "email"'), ("", 1, 'no column "id"'),
            ("id,name,email\n1,A,a@b\n\n1,B,b@b\n", 4, "is that of line 2, too"),
            ("id,name,email\n1,A,a@b\n2,B,A@b\n", 3, "is that of line 2, too"),
            ("id,name,email\n../x,A,a@b\n", 2, "cannot name a folder"),
            ("id,name,email\n,A,a@b\n", 2, "is empty"),
            ("id,name,email\n-rf,A,a@b\n", 2, "cannot name a folder"),
            ("id,name,email\nx.zip,A,a@b\n", 2, "a file's name"),
            ("id,name,email\n1,Mason, Ann,a@b\n", 2, "4 cells for 3 columns"),
            ("id,name,email\n1,A,ab\n", 2, "no e-mail"),
            ("id,name,email\n", 0, "nobody in it"), ('id,name,email\n1,"A,a@b\n', 0, "quotation mark")):
        one = Class(top, text).collect(good)
        check(one.status == 2 and said in one.said and (f"roster.csv:{line}: " in one.said or not line)
              and not os.path.exists(one.path("out")), f"a roster is refused: {said}, line {line}", one)
    one = Class(top)
    with open(one.path("roster.csv"), "wb") as file:
        file.write(ROSTER.encode("latin-1"))
    one.collect(good)
    check(one.status == 2 and "roster.csv:3: this is not UTF-8" in one.said, "so is one that is not UTF-8",
          one)
    one = Class(top, 'id,name,email\n1,=HYPERLINK(1),a@b\n2,"\'t Hooft",t@b\n').collect(zipped(("1/bloom.c",
                                                                                                "x")))
    check([row["name"] for row in one.rows.values()] == ["'=HYPERLINK(1)", "''t Hooft"]
          and one.work("1") == "x",
          "no cell is a formula", one)


MOODLE_GRADES = """"First name","Last name","ID number",Institution,"Email address","Assignment: Bloom (Real)"
Ann,Mason,1001,,amason@uni.edu,-
Jörg,Müller,1002,,joerg.mueller@uni.edu,-
"""
MOODLE_WORKSHEET = """Identifier,"Full name","Email address",Status,Grade
"Participant 71","Ann Mason",amason@uni.edu,"No submission",
"""
CANVAS_GRADES = """Student,ID,SIS User ID,SIS Login ID,Section,Bloom (4711),Final Score
,,,,,Manual Posting,
    Points Possible,,,,,100,(read only)
"Mason, Ann",1001,m1,amason,S1,,
"Müller, Jörg",1002,m2,joerg.mueller@uni.edu,S1,,
"Student, Test",1009,,,S1,,
"""
SPREADSHEET = """id;"Last name, first name";"E-mail, at the university"
1001;Mason, Ann;amason@uni.edu
1002;Müller, Jörg;joerg.mueller@uni.edu
"""


def exports_are_rosters(top):
    """As Moodle, Canvas and spreadsheets write them."""
    good = zipped((moodle("Jörg Müller"), "joerg"), (moodle("Ann Mason"), "ann"))
    sheet = SPREADSHEET.replace("E-mail, at the university", "Email")
    for how, text, encoding in (
            ("Moodle's grades", MOODLE_GRADES, "utf-8"),
            ("Moodle's with a mark", MOODLE_GRADES, "utf-8-sig"),
            ("Canvas's gradebook", CANVAS_GRADES, "utf-8"),
            ("Canvas's with a mark", CANVAS_GRADES, "utf-8-sig"),
            ("a spreadsheet's, with semicolons and commas", sheet, "utf-8-sig"),
            ("a spreadsheet's, with a line that names the separator", "sep=;\n" + sheet, "utf-8"),
            ("a spreadsheet's Unicode text", sheet.replace(";", "\t").replace("\n", "\r\n"), "utf-16"),
            ("the same, most significant byte first", "\ufeff" + sheet.replace(";", "\t"), "utf-16-be"),
            ("names in quotation marks", sheet.replace(";Mason, Ann;", ';"Mason, Ann";'), "utf-8"),
            ("a full name", ROSTER.replace("id,name", "ID number,Full name"), "utf-8")):
        one = Class(top)
        with open(one.path("roster.csv"), "wb") as file:
            file.write(text.encode(encoding))
        one.collect(good)
        names = {one.rows[name]["name"] for name in ("1001", "1002") if name in one.rows}
        check(one.status == 0 and one.work() == "ann" and one.work("1002") == "joerg"
              and "1009" not in one.rows and len(names) == 2
              and names <= {"Ann Mason", "Mason, Ann", "Jörg Müller", "Müller, Jörg"},
              f"{how} is a roster", one)
    one = Class(top, CANVAS_GRADES).collect(zipped(("mueller_1002_9_bloom.c", "joerg")))
    check(one.rows["1001"]["email"] == "" and one.rows["1002"]["email"] == "joerg.mueller@uni.edu"
          and one.work("1002") == "joerg", "Canvas's numbers are the ids, a login with an @ the address",
          one)
    many = CANVAS_GRADES.replace("Final Score", ",".join(f"Essay ({k})" for k in range(30)))
    one = Class(top, many.replace(",(read only)", "," * 29 + ",x").replace(",,\n", "," * 31 + "\n").replace(
        "Posting,\n", "Posting" + "," * 30 + "\n")).collect(good)
    check(one.status == 0 and "and 23 more" in one.said,
          "of many columns that are not used the first are told", one)


def exports_that_are_no_rosters_are_refused(top):
    def said_of(text, encoding="utf-8"):
        one = Class(top)
        with open(one.path("roster.csv"), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode(encoding))
        one.collect(zipped((moodle("Ann Mason"), "ann")))
        check(one.status == 2 and not os.path.exists(one.path("out")) and one.said.count("\n") == 1,
              "it is refused in one line", one)
        return one.said

    said = said_of(ROSTER, "latin-1")
    check("roster.csv:3: this is not UTF-8" in said and '1002,"Müller, Jörg"' in said
          and "iconv -f WINDOWS-1252 -t UTF-8" in said and "CSV UTF-8" in said,
          "a roster in Latin-1 is refused, with how the line may read, and what to do", said)
    for encoding in ("utf-16-le", "utf-16-be"):
        said = said_of(ROSTER, encoding)
        check("UTF-16 without a byte order mark" in said and "CSV UTF-8" in said,
              f"so is one in {encoding} without a mark", said)
    said = said_of(b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!\0\xff\xfe")
    check("is a spreadsheet's own file; save it as \"CSV UTF-8\"" in said,
          "and a spreadsheet's own file", said)
    said = said_of(MOODLE_WORKSHEET)
    check('there is no column "id" among Identifier, Full name, Email address, Status, Grade' in said
          and "rename" in said, "a table without ids names its columns", said)
    said = said_of("id,name,email\n1,Mason, Ann,a@b\n2,Lou, Kim,k@b\n3,Fox, Eve,e@b\n")
    check("each line has 4 cells for 3 columns" in said
          and "quotation marks around it, or another separator" in said,
          "names with commas and without quotation marks are told once", said)
    said = said_of("id;name;email\n1;A;B;a@b\n2;B;b@b\n")
    check("roster.csv:2: 4 cells for 3 columns; a semicolon within" in said,
          "by the table's own separator", said)
    said = said_of("sep=;\n\nid;name;email\n1;A;a@b\n1;B;b@b\n")
    check("roster.csv:5: the id 1 is that of line 4, too" in said,
          "lines are counted from the file's first", said)
    said = said_of("id,name,email\n1.23E+09,A,a@b\n")
    check("roster.csv:2: the id 1.23E+09 has lost digits in a spreadsheet" in said,
          "an id that lost digits is told", said)


def tables_come_back_from_spreadsheets(top):
    """collected.csv is corrected there."""
    data = zipped(("masonann_LATE_55_901_bloom.c", "ann"), (moodle("Jörg Müller"), "joerg"))
    for how, change in (("with semicolons", lambda text: text.replace(",", ";").replace('"', "").encode()),
                        ("in UTF-16 with tabs", lambda text: text.replace(",", "\t").encode("utf-16"))):
        one = Class(top, ROSTER.replace('"Müller, Jörg"', "Jörg Müller")).collect(data, "--due", DUE)
        text = read(one.path("out", "collected.csv")).replace(",?,", ",3,", 1)
        with open(one.path("out", "collected.csv"), "wb") as file:
            file.write(change(text))
        one.collect(data, "--due", DUE)
        check(one.rows["1001"]["days_late"] == "3", f"a table that was saved {how} is read", one)
    text = read(one.path("out", "collected.csv"))
    with open(one.path("out", "collected.csv"), "wb") as file:
        file.write(text.encode("latin-1"))
    status, said = one.run(["bloom", "--source", SOURCE, "--download", one.path("download.zip"), "--out",
                            one.path("out"), "--roster", one.path("roster.csv")])
    check(status == 2 and "collected.csv:3: this is not UTF-8" in said and "iconv" in said,
          "one in Latin-1 is refused with what to do", said)


def out_is_replaced_whole(top):
    one = Class(top).collect(zipped((moodle("Ann Mason"), "old"), (moodle("Kim Lou"), "kim")))
    one.collect(zipped((moodle("Ann Mason"), "new")))
    check(one.status == 0 and one.files() == ["1001/bloom.c", "collected.csv"] and one.work() == "new",
          "run again, it replaces what it wrote", one)
    write("mine", one.path("out", "notes.txt"))
    one.collect(zipped((moodle("Ann Mason"), "newer")))
    check(one.status == 2 and "notes.txt" in one.said and one.work() == "new", "not beside another's files",
          one)
    write("mine", one.path("other", "notes.txt"))
    one.collect(zipped((moodle("Ann Mason"), "newer")), out="other")
    check(one.status == 2 and one.files("other") == ["notes.txt"], "nor another's folder", one)
    write("a,b\n1,2\n", one.path("third", "collected.csv"))
    one.collect(zipped((moodle("Ann Mason"), "newer")), out="third")
    check(one.status == 2 and one.files("third") == ["collected.csv"], "nor where that table is another's",
          one)
    put(one.path("from"), {"Ann Mason/bloom.c": "x"})
    one.collect(one.path("from"), out="from/out")
    check(one.status == 2 and "lie in each other" in one.said, "OUT is not in the download", one)
    before = {name: os.stat(one.path("from", name)).st_mtime_ns for name in ("Ann Mason",
                                                                             "Ann Mason/bloom.c")}
    one.collect(one.path("from"), out="fourth")
    check(before == {name: os.stat(one.path("from", name)).st_mtime_ns for name in before} and one.work(
        out="fourth") == "x", "a download is not changed", one)
    put(one.path("from"), {"Ann Mason/bloom.c": "y"})
    full, rename, count = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), os.rename, []

    def fails_in_the_middle(*paths):
        count.append(paths)
        if len(count) == 2:
            raise full
        rename(*paths)

    for what, patch in (("copied", mock.patch.object(shutil, "copyfile", side_effect=full)),
                        ("put in place", mock.patch.object(os, "rename", fails_in_the_middle))):
        with patch:
            one.collect(one.path("from"), out="fourth")
        check(one.status == 2 and "free some space" in one.said and one.work(out="fourth") == "x",
              f"what cannot be {what} is said, and leaves all as it was", one)
    check(not [name for name in os.listdir(one.folder) if name.startswith(".part")], "no parts are left",
          os.listdir(one.folder))


def corrections_stay(top):
    """What was corrected by hand is not lost when the roster changes, or a late delivery comes."""
    def correct(one, old, new):
        text = read(one.path("out", "collected.csv"))
        check(text.count(old) == 1, f"{old.strip()} is there to be corrected", text)
        write(text.replace(old, new), one.path("out", "collected.csv"))

    files = (("masonann_LATE_55_901_bloom.c", "ann"), ("loukim_5_7_bloom.c", "kim"))
    one = Class(top).collect(zipped(*files), "--due", DUE)
    correct(one, "1001,Ann Mason,amason@uni.edu,,,?,", "1001,Ann Mason,amason@uni.edu,,,2,ill; ")
    write(ROSTER + "1006,Eve Fox,efox@uni.edu,\n", one.folder, "roster.csv")
    for time in ("again", "once more"):
        one.collect(zipped(*files), "--due", DUE)
        check(one.status == 0 and one.rows["1001"]["days_late"] == "2" and "Ann Mason (1001): days_late was "
              "corrected by hand, and stays 2" in one.said and "1006" in one.rows,
              f"a corrected cell stays when it is collected {time}", one)
        check(one.rows["1001"]["remarks"].startswith("ill; ") and one.rows["1001"]["remarks"].count(
            "days_late was corrected by hand") == one.rows["1001"]["remarks"].count("ill") == 1,
              "with a remark, and the instructor's own", one)
    one.collect(zipped(("masonann_55_909_bloom.c", "ann"), files[1]), "--due", DUE)
    check(one.status == 1 and one.rows["1001"]["days_late"] == "2" and "from this download it would be 0"
          in one.said, "it is told if something else is collected now", one)
    one.collect(zipped(*files), "--due", DUE, "--again")
    check(one.rows["1001"]["days_late"] == "?" and "ill" not in one.rows["1001"]["remarks"],
          "AGAIN=yes discards corrections", one)
    unit = one.path("out", "1001", "bloom.c")
    write("mended", unit)
    one.collect(zipped(("masonann_55_901_bloom.c", "ann"), files[1]), "--due", DUE)
    check(one.status == 0 and one.work() == "mended" and f"{unit} was changed by hand, and stays" in one.said
          and "bloom.c was changed by hand" in one.rows["1001"]["remarks"], "an edited unit stays", one)
    one.collect(zipped(("masonann_55_909_bloom.c", "newer"), files[1]), "--due", DUE)
    check(one.status == 1 and one.work() == "mended" and "a text that was handed in since" in one.said,
          "it is told if another was handed in", one)
    one.collect(zipped(files[1]), "--due", DUE)
    check(one.work() == "mended" and one.rows["1001"]["submission"] == "1001"
          and "missing" not in one.rows["1001"]["remarks"], "it stays if nothing was handed in", one)
    one.collect(zipped(files[1]), "--due", DUE)
    check(one.work() == "mended" and one.rows["1001"]["submission"] == "1001", "and once more", one)
    write(ROSTER.replace("1001", "2001"), one.folder, "roster.csv")
    one.collect(zipped(*files), "--due", DUE)
    check(one.status == 2 and "move it away" in one.said and one.work() == "mended",
          "no edited unit is lost with the roster", one)
    write(ROSTER, one.folder, "roster.csv")
    one.collect(zipped(("masonann_55_909_bloom.c", "newer"), files[1]), "--due", DUE, "--again")
    check(one.work() == "newer" and one.status == 0, "AGAIN=yes collects units anew", one)
    correct(one, "\n,1005,Zoë van der Berg,zberg@uni.edu,,,,missing", "\nby_mail,1005,Zoë van der Berg,,,,0,")
    write("by mail", one.path("out", "by_mail"), "bloom.c")
    one.collect(zipped(*files), "--due", DUE)
    check(one.work("by_mail") == "by mail" and one.rows["1005"]["submission"] == "by_mail"
          and one.rows["1005"]["days_late"] == "0" and "missing" not in one.rows["1005"]["remarks"],
          "a submission that was put in by hand stays", one)
    one.collect(zipped(*files), "--due", DUE, stems=("shading",))
    check(one.status == 2 and "was collected for bloom, and corrected by hand since" in one.said
          and one.work("by_mail") == "by mail", "no correction is lost to another assignment", one)
    table = read(one.path("out", "collected.csv"))
    lines = [",".join(cells[:5] + cells[6:]) for cells in (line.split(",") for line in table.splitlines())
             if "Müller" not in str(cells)]
    write("\n".join(lines) + "\n", one.path("out", "collected.csv"))
    one.collect(zipped(*files), "--due", DUE)
    check("submitted was corrected" not in one.said and one.rows["1005"]["submission"] == "by_mail",
          "a column and a row that were removed are written anew", one)
    write("{", one.path("out", ".collected.json"))
    one.collect(zipped(*files), "--due", DUE)
    check(one.status == 2 and "AGAIN=yes" in one.said and one.work("by_mail") == "by mail",
          "nor where nobody knows what was corrected", one)
    one.collect(zipped(*files), "--due", DUE, "--again")
    check(one.status == 1 and one.rows["1001"]["days_late"] == "?" and one.work("by_mail") is None,
          "AGAIN=yes writes all anew, then, too", one)


def students_have_deadlines_of_their_own(top):
    head, name = "id,name,email,group,due,days_late\n", "H_{}_attempt_2026-10-{}-12-00-00_bloom.c"
    files = zipped((name.format("amason", "07"), "late"), (name.format("amason", "05"), "ann"),
                   (name.format("klou", "07"), "kim"), (name.format("efox", "09"), "eve"))
    people = ("1001,Ann Mason,amason@uni.edu,,{},\n1003,Kim Lou,klou@uni.edu,A,,\n"
              "1004,Tom Jarvis,tjarvis@uni.edu,A,{},\n1007,Eve Fox,efox@uni.edu,,,{}\n")
    due = "2026-10-07 23:59 +0200"
    one = Class(top, head + people.format(due, due, "1")).collect(files, "--due", DUE, "--until", "2")
    check(one.work() == "late" and one.rows["1001"]["days_late"] == "0" and f"due {due}, as the roster says"
          in one.rows["1001"]["remarks"], "a deadline of one's own counts in place of DUE", one)
    check(one.rows["1003"]["days_late"] == one.rows["1004"]["days_late"] == "0",
          "a group has the latest of its members", one)
    check(one.work("1007") == "eve" and one.rows["1007"]["days_late"] == "1"
          and "days_late as the roster says" in one.rows["1007"]["remarks"],
          "days late that the roster says count, after UNTIL, too", one)
    one = Class(top, head + people.format("", "", "")).collect(files, "--due", DUE, "--until", "2")
    check(one.work() == "ann" and one.rows["1003"]["days_late"] == "2" and one.work("1007") is None,
          "empty cells change nothing", one)
    late = zipped(("foxeve_LATE_7_1_bloom.c", "eve"))
    one = Class(top, head + people.format("", "", "0")).collect(late, "--due", DUE)
    check(one.status == 0 and one.rows["1007"]["days_late"] == "0", "they answer what Canvas does not say",
          one)
    one = Class(top, head + people.format(due[:-6], "", "")).collect(files, "--due", DUE)
    check(f"due {due}, as" in one.rows["1001"]["remarks"], "without a zone, it is in that of DUE", one)
    for wrong, said in ((("soon", "", ""), "roster.csv:2: due is soon; write the date"),
                        (("", "", "-1"), "roster.csv:5: days_late is -1; write a whole number")):
        one = Class(top, head + people.format(*wrong)).collect(files, "--due", DUE)
        check(one.status == 2 and said in one.said, f"{said} is refused", one)


def make_collects(top):
    one, make = Class(top), os.environ.get("MAKE", "make")
    put(one.folder, {"it's $(all) \"of\" them.zip": zipped((moodle("Ann Mason"), "ann"))})
    status, said = run(".", make, "-s", "collect", f"DOWNLOAD={one.path('it')}'s $(all) \"of\" them.zip",
                       f"ROSTER={one.path('roster.csv')}", f"OUT={one.path('out')}", "ASSIGNMENTS=bloom",
                       f"DUE={DUE}",
                       "GRACE=2", "UNTIL=3")
    check(status == 0 and one.work() == "ann" and "with 2 hours of grace" in said,
          "make collect hands all on", said)
    write("mended", one.path("out", "1001", "bloom.c"))
    for again, work in ((), "mended"), (("AGAIN=yes",), "ann"):
        run(".", make, "-s", "collect", f"DOWNLOAD={one.path('it')}'s $(all) \"of\" them.zip",
            f"ROSTER={one.path('roster.csv')}", f"OUT={one.path('out')}", "ASSIGNMENTS=bloom", *again)
        check(one.work() == work, f"make collect {' '.join(again)} gives {work}", one)
    status, said = run(".", make, "-s", "collect", "roster=x")
    check(status != 0 and "write it in capitals: ROSTER" in said, "small letters are told", said)
    status, said = run(".", make, "-s", "collect", "ASSIGNMENTS=bloom")
    check(status == 2 and "DOWNLOAD=path" in said, "what is needed is asked for", said)


def main():
    top = tempfile.mkdtemp(prefix="raykit-test-collect-")
    try:
        for claims in (moodles_folders_are_read, canvas_files_are_read, blackboards_files_are_read,
                       gradescopes_export_is_read, clones_and_mail_are_read, names_in_all_spellings_are_one,
                       nobody_is_guessed, what_was_not_collected_is_not_missing, patterns_last,
                       patterns_of_all_are_quick, a_group_has_one_submission, deadlines_are_kept,
                       the_last_upload_counts, files_are_found_under_their_names, archives_are_unpacked,
                       wicked_archives_do_no_harm, bombs_do_not_go_off, rosters_are_checked,
                       exports_are_rosters, exports_that_are_no_rosters_are_refused,
                       tables_come_back_from_spreadsheets, out_is_replaced_whole, corrections_stay,
                       students_have_deadlines_of_their_own, make_collects):
            claims(top)
    finally:
        shutil.rmtree(top, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
