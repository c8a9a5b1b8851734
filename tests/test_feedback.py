#!/usr/bin/env python3
"""The zip of reports that goes back to students, read as Moodle and Canvas read it. Speaks TAP, for make
check; runs in a build folder.

The readers follow Moodle's mod/assign/feedback/file/importziplib.php (is_valid_filename_for_import) and
Canvas's app/models/abstract_assignment.rb (infer_comment_context_from_filename)."""

import json
import os
import re
import shutil
import sys
import tempfile
import zipfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import downloads  # noqa: E402
from grading.collect_write import HEADING  # noqa: E402
from test_collect import DUE, Class, at, moodle  # noqa: E402
from tap import check, finish, run, start, write  # noqa: E402

COLLECTED = ",".join(HEADING) + """
1001,1001,Ann Mason,amason@uni.edu,,,0,,bloom,Ann Mason_71_assignsubmission_file_
1002,1002,"Müller, Jörg",jm@uni.edu,,,2,,bloom,Jörg Müller_72_assignsubmission_file
1003,1003,Kim Lou,klou@uni.edu,A,,1,,bloom,A-Kim_Lou_73_assignsubmission_file_bloom.c
1003,1004,Tom Jarvis,tj@uni.edu,A,,1,,bloom,
,1005,Zoë Berg,zg@uni.edu,,,,missing,bloom,
1006,1006,Ungraded One,u1@uni.edu,,,0,,bloom,Ungraded One_76_assignsubmission_onlinetext_
,1007,Eve Fox,ef@uni.edu,,,,not collected: w.7z: 7z archives,bloom,Eve Fox_77_assignsubmission_file_
"""
CANVAS = COLLECTED.replace("Ann Mason_71_assignsubmission_file_", "masonann_55_901_bloom.c").replace(
    "Jörg Müller_72_assignsubmission_file", "müllerjörg_LATE_56_902_bloom-1.c").replace(
    "A-Kim_Lou_73_assignsubmission_file_bloom.c", "loukim_57_text.html")
RESULTS = """name,bloom,total,maximum,not graded
1001,91,91,100,
1002,55,55,100,
1003,45,45,100,
1006,,,100,unpack w.zip
"""
TWO = """name,bloom,shading,total,maximum,not graded
1001,91,9,100,200,
1002,55,44,99,200,
1003,45,0,45,200,
1006,,,,200,unpack w.zip
"""


class Course:
    """A folder with results and a table of who handed in what, of which a zip is made."""

    def __init__(self, top, collected=COLLECTED, results=RESULTS, ending=".json"):
        self.folder = tempfile.mkdtemp(dir=top)
        write(results, self.folder, "results", "class.csv")
        write(collected, self.folder, "collected.csv")
        for line in results.splitlines()[1:]:
            name = line.split(",")[0]
            text = f"FAIL  bloom of {name}: größer\n"
            write(json.dumps({"output": text}) if ending == ".json" else text, self.folder, "results",
                  name + ending)
        self.status, self.said, self.files = None, "", None

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def zip(self, *options, out="feedback.zip", stems=()):
        self.status, self.said = run(
            self.folder, sys.executable, "-B", os.path.join(SOURCE, "tools", "feedback.py"), *stems,
            "--source", SOURCE, "--results", self.path("results"), "--roster", self.path("collected.csv"),
            "--out", self.path(out), *options)
        self.files = None
        if zipfile.is_zipfile(self.path(out)):
            with zipfile.ZipFile(self.path(out)) as archive:
                self.files = {name: archive.read(name).decode() for name in archive.namelist()}
        return self

    def of(self, who):
        """Returns the one text whose name says so, or ""."""
        found = [text for name, text in (self.files or {}).items() if who in name]
        return found[0] if len(found) == 1 else ""

    def __str__(self):
        return f"{self.status}\n{self.said}\n{self.files}"


def moodle_reads(files, participants, plugins=("assignsubmission_file", "assignsubmission_onlinetext")):
    """Returns a dictionary from participants' numbers to the files that each gets."""
    got = {}
    for path in files:
        parts = path.split("/")
        if parts[-1][0] in ".~":
            continue
        while parts:
            info = parts.pop(0).split("_", 4)
            if len(info) < 4 or not info[1].isdecimal() or int(info[1]) not in participants \
                    or "_".join(info[2:4]) not in plugins:
                continue
            name = "/".join([*info[4:], *parts])
            got.setdefault(int(info[1]), []).append(os.path.basename(name))
            break
    return got


def canvas_reads(files, submissions):
    """The same of Canvas: `submissions` are pairs of a user and the number of a file that is of this user's
    submission."""
    got = {}
    for path in files:
        name = os.path.basename(path)
        numbers = [part for part in name.split("_") if part != "LATE" and re.fullmatch(r"\d+", part)][:2]
        if len(numbers) == 2 and tuple(map(int, numbers)) in submissions and not re.match("link|[.]_", name):
            got.setdefault(int(numbers[0]), []).append(name)
    return got


def moodle_takes_it(top):
    one = Course(top).zip()
    check(moodle_reads(one.files or [], range(70, 80))
          == {number: ["feedback_bloom.txt"] for number in (71, 72, 73, 76)},
          "Moodle finds each participant's file, by the number of the download's name", one)
    check("Jörg Müller_72_assignsubmission_file_/feedback_bloom.txt" in (one.files or []),
          "the folders are named as those of the download", one)
    check("größer" in one.of("_72_") and "FAIL  bloom of 1002" in one.of("_72_"),
          "each has the report on its student's work", one)
    check(one.status == 1 and "no name from Moodle is known for Tom Jarvis (1004); give" in one.said
          and "TEMPLATE" in one.said and "delivered" in one.said,
          "students without a name in Moodle's form are listed, with where to find it", one)
    check("1 of 7 students handed in nothing, and gets no file" in one.said
          and "Eve Fox (1007): not collected: w.7z: 7z archives" in one.said and "Eve" not in str(one.files),
          "so is who handed in nothing, and whose work was not collected", one)
    check("4 of 7 students get a file" in one.said, "and how many get a file", one)
    one = Course(top, COLLECTED.replace("_72_", "_71_")).zip()
    check(one.status == 1 and list(moodle_reads(one.files or [], range(70, 80))) == [73, 76]
          and "Ann Mason (1001) and Müller, Jörg (1002) have the same number, 71" in one.said,
          "of two with one number none gets the other's report", one)


WORKSHEET = """Identifier,"Full name","Email address",Status,Grade,"Last modified (grade)"
"Participant 74","Tom Jarvis",tj@uni.edu,x,,-
"Participant 99","Kim Lou",klou@uni.edu,x,,-
"Participant 75","Zoë Berg",zg@uni.edu,x,,-
"Participant 12","A Stranger",as@uni.edu,x,,-
"""


def the_worksheet_has_other_numbers(top):
    one = Course(top)
    write(WORKSHEET, one.path("worksheet.csv"))
    one.zip("--template", one.path("worksheet.csv"))
    check(sorted(moodle_reads(one.files or [], range(100))) == [71, 72, 73, 74, 76]
          and one.of("_74_").startswith("Feedback for Tom Jarvis (1004)") and "no name" not in one.said
          and "Stranger" not in one.said,
          "students without a name from the download get Moodle's number from the worksheet", one)
    write(WORKSHEET.replace("Participant 74", "Someone"), one.path("worksheet.csv"))
    one.zip("--template", one.path("worksheet.csv"))
    check(one.status == 1 and "is known for Tom Jarvis (1004)" in one.said,
          "what is no number is not taken", one)
    for form, template, said in (("canvas", WORKSHEET, "only FORMAT=moodle takes one"),
                                 ("moodle", CANVAS, "there is no column \"Identifier\"")):
        write(template, one.path("worksheet.csv"))
        one.zip("--format", form, "--template", one.path("worksheet.csv"), out="other.zip")
        check(one.status == 2 and said in one.said and one.files is None,
              f"a TEMPLATE is refused: {said}", one)


def canvas_takes_it(top):
    one = Course(top, CANVAS).zip("--format", "canvas")
    check(canvas_reads(one.files or [], [(55, 901), (56, 902)])
          == {55: ["masonann_55_901_feedback_bloom.txt"], 56: ["müllerjörg_56_902_feedback_bloom.txt"]},
          "Canvas finds each user's submission, by the numbers of the download's name", one)
    check(one.status == 1 and "known for Kim Lou (1003), Tom Jarvis (1004), Ungraded One (1006);" in one.said
          and "Canvas shows each file under the name of what was handed in" in one.said,
          "who handed in no file there is said, and how Canvas shows the files", one)


def others_take_a_folder_for_each(top):
    one = Course(top).zip("--format", "plain")
    names = [f"{name}/feedback_bloom.txt" for name in (1001, 1002, 1003, 1004, 1006)]
    check(sorted(one.files or []) == names and "no name" not in one.said,
          "FORMAT=plain has a folder for each, called by the id", one)


def penalties_are_shown(top):
    one = Course(top).zip("--penalty", "10", "--format", "plain")
    check("bloom: 91 of 100 points, in time.\n" in one.of("1001/"), "who was in time reads that", one)
    check("bloom: 55 of 100 points. 2 days late, at 10 percent for each day, cost 11 points: 44 count.\n"
          in one.of("1002/"), "who was late reads the points, the penalty and what counts", one)
    check("45 of 100 points. 1 day late, at 10 percent for each day, costs 4 points: 41 count."
          in one.of("1004/") and one.of("1004/").startswith("Feedback for Tom Jarvis (1004)\n"),
          "a group's members have the group's report, and their own days", one)
    check("bloom: no points yet; the reason is below.\n" in one.of("1006/"),
          "points that nobody knows are not made up", one)
    book = os.path.join(SOURCE, "tools", "grade_book.py")
    run(one.folder, sys.executable, "-B", book, "--source", SOURCE, "--results", one.path("results"),
        "--roster", one.path("collected.csv"), "--format", "csv", "--out", one.path("g.csv"), "--penalty",
        "10")
    with open(one.path("g.csv"), encoding="utf-8") as file:
        book = file.read()
    check("bloom graded,bloom penalty,bloom," in book and ",1002,55,11,44,100,2," in book
          and ",1003,45,4,41,100,1," in book, "the plain grade book has the same three numbers", book)
    one.zip("--format", "plain")
    check("bloom: 55 of 100 points.\n" in one.of("1002/") and "late" not in one.of("1002/"),
          "without PENALTY nothing is said of days", one)
    one = Course(top, COLLECTED.replace(",,2,,", ",,?,,")).zip("--penalty", "10", "--format", "plain")
    check("55 of 100 points. How many days late this was is not known yet, so neither is what counts."
          in one.of("1002/") and "days_late is ?" in one.said and one.status == 1,
          "unknown days are said to be unknown", one)
    two = Course(top, COLLECTED.replace(",bloom,", ",bloom shading,"), TWO)
    two.zip("--penalty", "10", "--format", "plain")
    text = two.of("1002/feedback.txt")
    late = "2 days late, at 10 percent for each day, cost"
    check(f"bloom: 55 of 100 points. {late} 11 points: 44 count." in text
          and f"shading: 44 of 100 points. {late} 9 points: 35 count." in text
          and "In all, 79 of 200 points count.\n" in text,
          "of several assignments each, and the sum", two)


def reports_of_all_kinds(top):
    one = Course(top, ending=".txt").zip("--format", "plain")
    check("FAIL  bloom of 1002: größer" in one.of("1002/"), "reports as text are taken as they are", one)
    one = Course(top, ending=".xml").zip()
    check(one.status == 2 and one.files is None and "FORMAT=text" in one.said and "1001.xml" in one.said,
          "reports for programs are refused, with the remedy", one)
    one = Course(top)
    write("{", one.path("results", "1001.json"))
    os.unlink(one.path("results", "1002.json"))
    one.zip()
    check(one.status == 1 and "Ann Mason (1001): " in one.said and "1001.json cannot be read" in one.said
          and "Müller, Jörg (1002): there is no report" in one.said
          and sorted(moodle_reads(one.files or [], range(70, 80))) == [73, 76],
          "reports that are lost or damaged are said", one)


def what_is_wrong_is_told(top):
    one = Course(top)
    write("mine", one.path("taken.zip"))
    for options, said in ((("--out", one.path("x.tar")), "should end in .zip"),
                          (("--out", ""), "OUT=feedback"),
                          (("--out", one.path("no", "x.zip")), "there is no folder"),
                          (("--out", one.path("taken.zip")), "choose another name"),
                          (("--format", "excel"), "choose one of canvas, moodle, plain"),
                          (("--penalty", "5%"), "such as PENALTY=10"),
                          (("--results", one.path("none")), "make grade-class writes it"),
                          (("--results", ""), "RESULTS=results"), (("--roster", ""), "make collect"),
                          (("--roster", one.path("results", "class.csv")), "is not a collected.csv")):
        one.zip(*options)
        check(one.status == 2 and said in one.said and one.files is None,
              f"{' '.join(map(os.path.basename, options))} is refused: {said}", one)
    with open(one.path("taken.zip"), "rb") as file:
        check(file.read() == b"mine", "a file that is there is not replaced")
    put = downloads.zipped(("Ann Mason_71_assignsubmission_file_/bloom.c", "ann"))
    with open(one.path("moodle.zip"), "wb") as file:
        file.write(put)
    one.zip(out="moodle.zip")
    with open(one.path("moodle.zip"), "rb") as file:
        check(one.status == 2 and file.read() == put, "nor is a download", one)
    one.zip()
    one.zip("--penalty", "10")
    check("44 count" in one.of("_72_"), "what this command wrote is", one)
    old = "\n".join(",".join(line.split(",")[:-1]) for line in COLLECTED.splitlines()) + "\n"
    one = Course(top, old).zip()
    check(one.status == 2 and "no column delivered" in one.said and "make collect" in one.said
          and one.files is None, "a table of an older make collect is told", one)


def collect_keeps_the_names(top):
    def delivered(one):
        return [one.rows[name]["delivered"] for name in ("1001", "1002", "1003", "1004", "1005")]

    one = Class(top).collect(downloads.zipped(
        (moodle("Ann Mason"), "ann"), (moodle("Kim Lou", 7), "kim", at(4, 12)),
        (moodle("Tom Jarvis", 8), "tom", at(5, 12)), (moodle("Jörg Müller", 9, "x.pdf"), "%PDF")))
    people = ("Ann Mason",), ("Jörg Müller", 9), ("Kim Lou", 7), ("Tom Jarvis", 8)
    names = [moodle(*who, file="")[:-1] for who in people]
    check(delivered(one) == [*names, ""],
          "make collect keeps the name under which each student's own work came, in a group, too", one)
    one = Class(top).collect(downloads.zipped(
        ("masonann_55_901_bloom.c", "old"), ("masonann_55_905_bloom-1.c", "new"),
        ("loukim_LATE_57_907_bloom.c", "kim"), ("loukim_LATE_57_909_own.h", "own")), "--due", DUE)
    check(delivered(one) == ["masonann_55_905_bloom-1.c", "", "loukim_LATE_57_909_own.h", "", ""],
          "of several the platform's last", one)
    table = one.path("out", "collected.csv")
    with open(table, encoding="utf-8") as file:
        text = file.read()
    write(text.replace("masonann_55_905_bloom-1.c\n", "masonann_55_999_bloom.c\n"), table)
    one.collect(downloads.zipped(("masonann_55_905_bloom-1.c", "new")), "--due", DUE)
    check(delivered(one)[0] == "masonann_55_999_bloom.c" and "delivered was corrected by hand" in one.said,
          "a name that was corrected by hand stays", one)


def make_writes_it(top):
    one, make = Course(top), os.environ.get("MAKE", "make")
    words = [f"RESULTS={one.path('results')}", f"ROSTER={one.path('collected.csv')}",
             f"OUT={one.path('it is.zip')}", "ASSIGNMENTS=bloom"]
    status, said = run(".", make, "-s", "feedback", *words, "PENALTY=10", "FORMAT=plain")
    check(status != 0 and "Error 1" in said and "5 of 7 students get a file" in said,
          "make feedback hands all on", said)
    status, said = run(".", make, "-s", "feedback", *words, "PENALITY=10")
    check(status and "make feedback: it takes no PENALITY, but RESULTS ROSTER TEMPLATE PENALTY" in said,
          "and takes no variable that it does not know", said)


def the_way_there_and_back(top):
    """From Moodle's download to Moodle's upload."""
    one = Class(top).collect(downloads.zipped((moodle("Ann Mason", 71), "ann"),
                                              (moodle("Kim Lou", 73), "kim")))
    course = Course(top, "", RESULTS)
    shutil.copy(one.path("out", "collected.csv"), course.path("collected.csv"))
    course.zip()
    check(moodle_reads(course.files or [], [71, 73]) == dict.fromkeys([71, 73], ["feedback_bloom.txt"]),
          "what make collect wrote leads back to Moodle's participants", course)


def main():
    top = tempfile.mkdtemp(prefix="raykit-test-feedback-")
    try:
        for claims in (moodle_takes_it, the_worksheet_has_other_numbers, canvas_takes_it,
                       others_take_a_folder_for_each, penalties_are_shown, reports_of_all_kinds,
                       what_is_wrong_is_told, collect_keeps_the_names, make_writes_it,
                       the_way_there_and_back):
            claims(top)
    finally:
        shutil.rmtree(top, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
