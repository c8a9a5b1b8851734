"""How platforms want to be given a file for each student, in one zip: each by the name of what the student
has handed in there, which make collect keeps in the column delivered.

Sources: Moodle, mod/assign/feedback/file/importziplib.php (is_valid_filename_for_import: some part of a
file's path is NAME_NUMBER_TYPE_PLUGIN, or goes on with another underscore; NUMBER is the participant's, of
this assignment alone, and the type and plugin have to exist; names that begin with . or ~ are left out, and
the NAME, which has no underscore, is not looked at). Canvas, app/models/abstract_assignment.rb
(infer_comment_context_from_filename: the first two parts between underscores that are digits are the user and
a file of that user's submission; generate_comments_from_files makes a comment of it, with the file under the
name of the one handed in, for all of a group).
"""

import re

from grading.collect_names import read_name

_MOODLE = re.compile(r"(?P<name>.+?)_(?P<number>\d+)_(?P<plugin>assignsubmission_[a-z]+)(?:_.*)?")
_NAMELESS = "student"


class _NoUnits:
    """For read_name, which looks for a unit's name only where no platform's form fits."""

    @staticmethod
    def before(_text):
        return None


class Form:
    """A platform: `place(delivered, student, file)` returns a key of whose the file is, and its path in the
    zip, or None if the name that was delivered does not say it. `needs` says what is then to be done."""

    def __init__(self, title, place, needs="", remark=""):
        self.title, self.place, self.needs, self.remark = title, place, needs, remark


def _moodle(delivered, _student, file):
    found = _MOODLE.fullmatch(delivered)
    if not found:
        return None
    name = re.sub(r"[_/\\]", " ", found["name"]).strip(" .") or _NAMELESS
    return found["number"], f"{name}_{found['number']}_{found['plugin']}_/{file}"


def _canvas(delivered, _student, file):
    reading = read_name(delivered, _NoUnits)
    if reading.form != "Canvas" or not reading.rest:
        return None
    name = re.sub(r"[_/\\]", " ", reading.names[0]).strip(" .")
    name = _NAMELESS if name.isdecimal() or not name else name
    return reading.ids[0], f"{name}_{reading.ids[0]}_{reading.serial}_{file}"


def _plain(_delivered, student, file):
    return student.id, f"{student.id}/{file}"


FORMS = {
    "moodle": Form(
        "Moodle", _moodle, "give Moodle's grading worksheet as TEMPLATE=worksheet.csv, or write "
        "NAME_NUMBER_assignsubmission_file_ into the column delivered of {roster}"),
    "canvas": Form(
        "Canvas", _canvas, "attach the report in SpeedGrader, unless Canvas knows the group: all members see "
        "what one is given",
        "Canvas shows each file under the name of what was handed in"),
    "plain": Form("", _plain),
}
