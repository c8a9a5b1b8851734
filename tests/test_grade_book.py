#!/usr/bin/env python3
"""The files for grade books, each read back by a reader that its documentation describes. Speaks TAP, for
make check; runs in a build folder.

The readers follow Canvas's lib/gradebook_importer.rb, Moodle's
mod/assign/feedback/offline/importgradeslib.php and Blackboard's help "Uploading External Grade Center
Items"."""

import csv
import io
import os
import re
import shutil
import sys
import tempfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from tap import check, finish, read, run, start, write  # noqa: E402
from grading import book_points  # noqa: E402
from grading.collect_write import HEADING  # noqa: E402

COLLECTED = ",".join(HEADING) + """
1001,1001,Ann Mason,amason@uni.edu,,2026-10-05 22:00:00 +0200,0,by the archive's time
1002,1002,"Müller, Jörg",jm@uni.edu,,2026-10-07 22:00:00 +0200,2,
1003,1003,Kim Lou,klou@uni.edu,A,2026-10-06 01:00:00 +0200,1,
1003,1004,Tom Jarvis,tj@uni.edu,A,2026-10-06 01:00:00 +0200,1,
,1005,'=HYPERLINK(1),zg@uni.edu,,,,missing
1006,1006,Ungraded One,u1@uni.edu,,2026-10-05 22:00:00 +0200,0,
"""
ONE = """name,status,bloom,total,maximum,reason
1001,graded,91,91,100,x
1002,graded,55,55,100,
1003,graded,0,0,100,
1006,not graded,,,100,the disk is full
"""
TWO = """name,bloom,shading,total,maximum
1001,91,9,100,200
1002,55,100,155,200
1003,0,,,200
1006,,,,200
"""
CANVAS = """Student,ID,SIS User ID,SIS Login ID,Section,\
Essay (11),Homework 6: Bloom (4711),Shading (12),Final Score
    Points Possible,,,,,10,100.0,100,(read only)
   ,,,,,Manual Posting,,,
"Mason, Ann",55,1001,amason,S1,7,,,70
"Müller, Jörg",56,1002,jm,S1,6,30,,
"Lou, Kim",57,1003,klou,S1,5,99,,
"Jarvis, Tom",58,,tj@uni.edu,S1,,,,
"HYPERLINK(1), =",59,1005,zg,S1,4,EX,,
"One, Ungraded",60,1006,u1,S1,3,88,,
"Student, Test",61,,,S1,,,,
"""
MOODLE = """Identifier,"Full name","Email address",Status,Grade,"Maximum Grade","Grade can be changed",\
"Last modified (submission)","Last modified (grade)","Feedback comments"
"Participant 1","Ann Mason",amason@uni.edu,"Submitted for grading",,100.00,Yes,"Monday, 5 October 2026",-,
"Participant 2","Jörg Müller",jm@uni.edu,"Submitted for grading",3.00,100.00,Yes,x,"Tuesday","So, so"
"Participant 3","Kim Lou",klou@uni.edu,x,,100.00,Yes,x,-,
"Participant 4","Tom Jarvis",,x,,100.00,Yes,x,-,
"Participant 5","=HYPERLINK(1)",zg@uni.edu,"No submission",,100.00,Yes,-,-,
"Participant 6","Ungraded One",u1@uni.edu,x,88.00,100.00,Yes,x,-,
"""
BLACKBOARD = [
    ["Last Name", "First Name", "Username", "Student ID", "Last Access", "Total [Total Pts: 300 Score] |1",
     "Homework: Bloom [Total Pts: 100 Score] |4711", "Notes [Total Pts: 10 Text] |9"],
    ["Mason", "Ann", "amason", "", "2026", "", "", ""], ["Müller", "Jörg", "x2", "1002", "", "", "3", ""],
    ["Lou", "Kim", "klou", "", "", "", "", ""], ["Jarvis", "Tom", "tj", "", "", "", "", ""],
    ["HYPERLINK(1)", "=", "zg", "1005", "", "", "", ""], ["One", "Ungraded", "u1", "", "", "", "88", ""]]


class Course:
    """A folder with results, a roster and a template, where grades are written."""

    def __init__(self, top, results=ONE, collected=COLLECTED):
        self.folder = tempfile.mkdtemp(dir=top)
        write(results, self.folder, "results", "class.csv")
        write(collected, self.folder, "collected.csv")
        self.status, self.said, self.data = None, "", None

    def path(self, name):
        return os.path.join(self.folder, name)

    def book(self, form, *options, template="", stems=(), encoding="utf-8"):
        """Writes a template if there is one, and the book; keeps its bytes."""
        if template:
            with open(self.path("template.csv"), "wb") as file:
                file.write(template.encode(encoding))
            options = ("--template", self.path("template.csv"), *options)
        out = self.path("out.csv")
        if os.path.exists(out):
            os.unlink(out)
        command = [sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_book.py"), *stems]
        self.status, self.said = run(
            self.folder, *command, "--source", SOURCE, "--results", self.path("results"), "--roster",
            self.path("collected.csv"), "--format", form, "--out", out, *options)
        self.data = None
        if os.path.exists(out):
            with open(out, "rb") as file:
                self.data = file.read()
        return self

    def __str__(self):
        return f"{self.status}\n{self.said}\n{(self.data or b'no file').decode('utf-8', 'replace')}"


def rows_of(data, delimiter=","):
    return list(csv.reader(io.StringIO(data, newline=""), delimiter=delimiter, strict=True))


def canvas_reads(data, template=CANVAS):
    """What changes by an import, by student's number and column: as the importer finds columns and compares
    scores. An empty cell takes a score away."""
    rows, before = rows_of(data.decode("utf-8")), rows_of(template)
    heading = rows[0]
    assert "Student" in heading[0] and "ID" in heading[1] and heading[2:4] == ["SIS User ID", "SIS Login ID"]
    assert "Section" in heading[4] and "Points Possible" in rows[1][0]
    old = {row[1]: dict(zip(before[0], row)) for row in before[3:]}
    changes = {}
    for row in rows[2:]:
        if not any(cell.strip() and not re.fullmatch("Manual Posting.*", cell.strip()) for cell in row):
            continue
        for name, cell in list(zip(heading, row))[5:]:
            assert re.fullmatch(r".+ \(\d+\)", name), name
            if cell.strip() != old[row[1]][name].strip():
                changes[row[1], name] = cell
    return changes


def moodle_reads(data, maximum=100):
    """The grades that the offline importer takes: by identifier; an empty one, or one out of range, is
    skipped."""
    rows = rows_of(data.decode("utf-8"))
    where = {name: rows[0].index(name) for name in ("Identifier", "Grade", "Last modified (grade)")}
    grades = {}
    for row in rows[1:]:
        assert len(row) == len(rows[0]) and row[where["Identifier"]].startswith("Participant ")
        grade = row[where["Grade"]]
        if grade and 0 <= float(grade) <= maximum:
            grades[int(row[where["Identifier"]][len("Participant "):])] = float(grade)
    return grades


def blackboard_reads(data):
    """Scores by user name and the column's number; the encoding is told by a mark, the separator by the
    header."""
    text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    delimiter = "\t" if "\t" in text.partition("\n")[0] else ","
    assert all(re.fullmatch(rf'"[^"]*"({delimiter}"[^"]*")*', line) for line in text.splitlines())
    rows = rows_of(text, delimiter)
    user = rows[0].index("Username")
    return {(row[user], re.search(r"\|(\d+)$", name)[1]): cell for row in rows[1:]
            for name, cell in zip(rows[0], row) if re.search(r"\|\d+$", name)}


# --- Forms --------------------------------------------------------------------------------------


def canvas_imports_it(top):
    one = Course(top).book("canvas", template=CANVAS)
    name = "Homework 6: Bloom (4711)"
    check(canvas_reads(one.data) == {("55", name): "91", ("56", name): "55", ("57", name): "0",
                                     ("58", name): "0"},
          "Canvas imports the points, and nothing else changes", one)
    check(read(one.path("out.csv")).splitlines()[0] == "Student,ID,SIS User ID,SIS Login ID,Section," + name,
          "only columns that say who, and the assignment's, are written", one)
    check(one.status == 1 and "Ungraded One (1006): bloom could not be graded" in one.said
          and "1 of 6 students handed in nothing, and have no grade" in one.said,
          "who was not graded is listed, and keeps the export's cell", one)
    one.book("canvas", "--missing", "0", template=CANVAS)
    check("59" not in [student for student, _ in canvas_reads(one.data)], "an excused student stays excused",
          one)
    one.book("canvas", "--missing", "0", template=CANVAS.replace("EX", ""))
    check(canvas_reads(one.data, CANVAS.replace("EX", ""))["59", name] == "0", "MISSING=0 gives 0", one)
    check('"HYPERLINK(1), ="' in read(one.path("out.csv")), "names are the export's", one)
    two = Course(top, TWO).book("canvas", template=CANVAS)
    changes = canvas_reads(two.data)
    check(changes["55", name] == "91" and changes["55", "Shading (12)"] == "9"
          and ("57", "Shading (12)") not in changes,
          "each assignment has its column", two)
    two.book("canvas", "--column", "Essay (11)", template=CANVAS.replace(",10,100.0", ",200,100.0"))
    check(canvas_reads(two.data)["56", "Essay (11)"] == "155", "COLUMN takes the sum", two)
    one.book("canvas", template=CANVAS.replace("Final Score", "Bloom so far (13)"))
    check(one.status == 1 and name in one.data.decode(), "a column that can only be read is left out", one)
    semicolons = CANVAS.replace('"Mason, Ann"', "Mason").replace(",", ";")
    one.book("canvas", template="\ufeff" + semicolons)
    check(";91\n" in one.data.decode(), "an export with semicolons is read and written", one)
    for template, said in ((CANVAS.replace("Homework 6: Bloom", "Week 6"), "no columns of"),
                           (CANVAS.replace("Shading (12)", "Bloom again (12)"), "2 columns of"),
                           (CANVAS.replace("100.0", "50"), "has 50 points, but bloom 100"),
                           (CANVAS.replace("Section", "Class"), "there is no Student, ID and Section"),
                           ("", "give the file that Canvas exports")):
        one.book("canvas", template=template)
        check(one.status == 2 and said in one.said and one.data is None, f"a template is refused: {said}",
              one)


def rows_and_students_are_told(top):
    one = Course(top)
    more = CANVAS + '"Stranger, A",70,9,q,S1,,7,,\n"Mason, Ann",71,,amason,S2,,,,\n'
    one.book("canvas", template=more.replace('"Jarvis, Tom",58,,tj@uni.edu,S1,,,,\n', ""))
    check("no student on the roster matches the row Stranger, A, 70, 9; it stays as it is" in one.said,
          "a stranger's row is listed", one)
    check("Tom Jarvis (1004) has no row in" in one.said and one.status == 1,
          "a student without a row is listed", one)
    check(one.said.count("and another fit Ann Mason (1001)") == 2 and "91" not in one.data.decode(),
          "two rows that fit one student are listed, and not filled in", one)
    check("Test" not in one.said, "Canvas's test student is nobody's trouble", one)
    one.book("canvas", template=CANVAS.replace("1002,jm", "1002,amason"))
    check("fits Ann Mason (1001) and Müller, Jörg (1002)" in one.said,
          "a row that contradicts itself is listed", one)
    one.book("canvas", template=CANVAS.replace("1001,amason", ","))
    check("by the name alone: Ann Mason (1001)" in one.said, "who was found by the name alone is said", one)
    one = Course(top, ONE + "2222,graded,5,5,100,\n",
                 COLLECTED + "7777,7777,New One,n@uni.edu,,,0,\n").book("csv")
    check("no student on the roster matches 2222 in" in one.said, "a result of nobody's is listed",
          one)
    check("New One (7777): the submission 7777 has no row in" in one.said and one.status == 1,
          "so is a submission without a result", one)


def other_points_are_not_replaced_in_silence(top):
    one = Course(top).book("moodle", template=MOODLE)
    told = "Müller, Jörg (1002): 3.00, graded 55"
    check(told in one.said and "KEEP=yes would keep them" in one.said and one.said.count(", graded ") == 1,
          "points of the template that become others are listed", one)
    one.book("moodle", "--keep", template=MOODLE)
    check(told in one.said and moodle_reads(one.data) == {1: 91, 2: 3, 3: 0, 4: 0, 6: 88},
          "KEEP=yes keeps what is there, and says so", one)
    one.book("moodle", "--keep", template=MOODLE.replace("3.00", "55,0").replace(",55,0,", ',"55,0",'))
    check("KEEP" not in one.said, "the same points are no others", one)


def who_is_not_collected_is_not_missing(top):
    one = Course(top, ONE, COLLECTED.replace(",,,,missing", ",,,,not collected: the group G1 has nobody"))
    one.book("csv", "--missing", "0")
    check("=HYPERLINK(1) (1005): not collected: the group G1 has nobody" in one.said
          and one.status == 1 and ",100,,not collected" in one.data.decode(),
          "whose work was not collected gets no 0", one)
    two = Course(top, TWO,
                 COLLECTED.replace("by the archive's time", "not collected: bloom.c: which counts?"))
    rows = {row["id"]: row for row in csv.DictReader(io.StringIO(two.book("csv").data.decode()))}
    check((rows["1001"]["bloom"], rows["1001"]["shading"], rows["1001"]["note"]) == ("", "9", "not collected")
          and "not collected: bloom.c: which counts?" in two.said, "nor for a unit that was left out", two)
    one = Course(top, ONE, COLLECTED.replace("by the archive's time", "too late,shading"))
    one.book("csv")
    check(one.status == 2 and "collected for shading, and the results are of bloom" in one.said,
          "another assignment's table is refused", one)
    one = Course(top).book("moodle", "--missing", "0",
                           template=MOODLE.replace("No submission", "Submitted for grading - Late"))
    check("=HYPERLINK(1) (1005) submitted something" in one.said and 5 not in moodle_reads(one.data),
          "nor does one whose work the platform has", one)


def moodle_imports_it(top):
    one = Course(top).book("moodle", template=MOODLE)
    check(moodle_reads(one.data) == {1: 91, 2: 55, 3: 0, 4: 0, 6: 88}, "Moodle imports the points", one)
    before, after = rows_of(MOODLE), rows_of(one.data.decode())
    check([row[:4] + row[5:] for row in before] == [row[:4] + row[5:] for row in after],
          "all else of the worksheet stays, in its order", one)
    one.book("moodle", "--missing", "0", template=MOODLE)
    check(moodle_reads(one.data)[5] == 0, "MISSING=0 gives 0 there, too", one)
    two = Course(top, TWO).book("moodle",
                                template=MOODLE.replace("100.00", "200,00").replace(",200,00", ',"200,00"'))
    check(moodle_reads(two.data, 200) == {1: 100, 2: 155, 6: 88},
          "of several assignments the sum is the grade", two)
    two.book("moodle", template=MOODLE)
    check(two.status == 2 and "has 100.00 points, but total 200" in two.said,
          "a grade out of range is refused", two)
    one.book("moodle", template=MOODLE.replace("Identifier", "Kennung"))
    check(one.status == 2 and "set Moodle's language to English" in one.said, "a worksheet in German is told",
          one)
    one.book("moodle")
    check(rows_of(one.data.decode())[:2] == [["ID number", "Email address", "bloom"],
                                             ["1001", "amason@uni.edu", "91"]]
          and ["1006", "u1@uni.edu", ""] in rows_of(one.data.decode()),
          "without a worksheet a plain list is written", one)


def blackboard_imports_it(top):
    expected = {("amason", "4711"): "91", ("x2", "4711"): "55", ("klou", "4711"): "0", ("tj", "4711"): "0",
                ("zg", "4711"): "", ("u1", "4711"): "88"}
    for how, encoding, delimiter in (("UTF-16 with tabs", "utf-16", "\t"),
                                     ("UTF-8 with commas", "utf-8-sig", ",")):
        stream = io.StringIO()
        csv.writer(stream, delimiter=delimiter, quoting=csv.QUOTE_ALL).writerows(BLACKBOARD)
        one = Course(top).book("blackboard", template=stream.getvalue(), encoding=encoding)
        check(blackboard_reads(one.data) == expected, f"Blackboard imports the points, in {how}", one)
        check(one.data.startswith(b"\xff\xfe" if encoding == "utf-16" else b"\xef\xbb\xbf"),
              "in the encoding of its download", one)
    one.book("blackboard")
    check(one.status == 2 and "Work Offline, Download" in one.said, "without a download it is asked for", one)


def a_table_is_safe(top):
    one = Course(top).book("csv", "--penalty", "10")
    rows = {row["id"]: row for row in csv.DictReader(io.StringIO(one.data.decode()))}
    check(rows["1005"]["name"] == "'=HYPERLINK(1)", "no cell of the plain table is a formula", one)
    check([rows[name]["bloom"] for name in sorted(rows)] == ["91", "44", "0", "0", "", ""],
          "points have the penalty; who was not graded, or is missing, has an empty cell", one)
    check([rows[name]["note"] for name in ("1001", "1005", "1006")] == ["", "missing", "not graded"],
          "and why it is empty", one)
    check([rows["1002"][name] for name in ("bloom graded", "bloom penalty", "bloom")] == ["55", "11", "44"],
          "with a penalty, it shows what was graded, the penalty, and what counts", one)
    two = Course(top, TWO).book("csv", "--penalty", "10")
    rows = {row["id"]: row for row in csv.DictReader(io.StringIO(two.data.decode()))}
    check([rows["1002"][name] for name in ("total graded", "total penalty", "total")] == ["155", "31", "124"]
          and rows["1003"]["total penalty"] == "" and rows["1003"]["bloom penalty"] == "0",
          "of several assignments the sum, too, where all parts are known", two)
    two.book("csv")
    check("graded" not in two.data.decode().splitlines()[0], "without one, what was graded counts", two)
    one.book("csv", "--missing", "0", template=MOODLE)
    check(one.status == 2 and "TEMPLATE: FORMAT=csv takes none" in one.said, "it has no template", one)


# --- Points -------------------------------------------------------------------------------------


def penalties_are_exact(top):
    for points, percent, days, left in ((100, "10", 1, 90), (55, "10", 2, 44), (45, "10", 1, 41),
                                        (44, "10", 1, 40),
                                        (100, "10", 11, 0), (7, "2.5", 3, 6), (100, "33.333", 3, 0),
                                        (0, "10", 1, 0),
                                        (90, "50", 1, 45), (1, "50", 1, 1), (100, "", 9, 100)):
        got = book_points.with_penalty(points, book_points.penalty_of(percent), days)
        check(got == left, f"{points} points less {percent or 0} % for {days} days are {left}", got)
    for penalty in ("-5", "ten", "101", "5%"):
        one = Course(top).book("csv", "--penalty=" + penalty)
        check(one.status == 2 and "such as PENALTY=10" in one.said and one.data is None,
              f"{penalty} is no penalty", one)
    one = Course(top, ONE, COLLECTED.replace(",2,", ",?,")).book("csv", "--penalty", "10")
    check(one.status == 1 and "Müller, Jörg (1002): days_late is ?" in one.said
          and '"Müller, Jörg",jm@uni.edu,,1002,55,,,100,?,days late unknown' in one.data.decode(),
          "unknown days are asked for, not guessed", one)
    check("10 percent for each day were taken from 2 students" in one.said, "how many are late is said", one)
    one = Course(top, ONE, re.sub(r",[012],", ",,", COLLECTED)).book("csv", "--penalty", "10")
    check(one.status == 2 and "does not say how late anybody was; give make collect DUE=" in one.said,
          "a penalty without a deadline is refused", one)
    one = Course(top, ONE, COLLECTED.replace(",2,", ",?,"))
    one.book("csv")
    check('1002,55,100,?,' in one.data.decode(), "and do not matter without a penalty", one)


def what_is_wrong_is_told(top):
    one = Course(top)
    for options, said in ((("--missing", "50"), "MISSING=50"),
                          (("--out", one.path("collected.csv")), "made from"),
                          (("--results", one.path("none")), "make grade-class writes it"),
                          (("--roster", one.path("results/class.csv")), "is not a collected.csv"),
                          (("--format", "excel"), "choose one of blackboard, canvas, csv, moodle"),
                          (("--column", "x"), "has no columns to choose from"),
                          (("--out", one.path("no/where.csv")), "there is no folder")):
        one.book("csv", *options)
        check(one.status == 2 and said in one.said and one.data is None
              and read(one.path("collected.csv")) == COLLECTED,
              f"{options[0][2:]} is refused: {said}", one)
    one.book("csv", stems=("shading",))
    check(one.status == 2 and "class.csv:1: there is no column of shading" in one.said,
          "an assignment that was not "
          "graded is named", one)
    one = Course(top, ONE.replace("91,91", "9l,91")).book("csv")
    check(one.status == 2 and "class.csv:2: 9l in column bloom" in one.said,
          "what is no number is named by its line", one)


def misspelt_variables_are_told():
    make = os.environ.get("MAKE", "make").split()
    for target, wrong, right in (("grade-book", "PENALITY", "PENALTY"), ("collect", "UNTILL", "UNTIL"),
                                 ("class-page", "ROOSTER", "RESULTS"), ("grade-class", "HOST", "HOSTS")):
        status, said = run(".", *make, "-s", target, f"{wrong}=10", "OUT=/nowhere/else")
        check(status and f"make {target}: it takes no {wrong}, but " in said and right in said,
              f"make {target} takes no {wrong}", said)


def main():
    top = tempfile.mkdtemp(prefix="raykit-test-book-")
    try:
        for claims in (canvas_imports_it, rows_and_students_are_told,
                       other_points_are_not_replaced_in_silence, who_is_not_collected_is_not_missing,
                       moodle_imports_it,
                       blackboard_imports_it,
                       a_table_is_safe, penalties_are_exact, what_is_wrong_is_told):
            claims(top)
        misspelt_variables_are_told()
    finally:
        shutil.rmtree(top, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
