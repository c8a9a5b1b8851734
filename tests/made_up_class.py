"""A made-up class of any size that hands in normals.c on Moodle: right, unfinished, wrong, broken, cheating,
empty, missing, late, twice and in groups, under names of all kinds. Who asks gets the download, the roster,
and what has to come of each student's work. The same size is the same class."""

import collections
import csv
import datetime
import os
import random
import unicodedata

import disguise
import downloads
from by_address import by_address
from grading.assignments import DEDUCTION, read_features, read_points
from grading.mutants import mutate, read_mutants
from grading.starters import read_regions, starter_of

STEM = "normals"
DUE, GRACE = "2026-10-05 23:59 +0200", 2
_DEADLINE = datetime.datetime(2026, 10, 6, 0, 0)  # the first minute that is late, without the grace

# Students of a hundred; what is left is right.
_SHARES = {"own work": 14, "copy": 4, "first step": 6, "second step": 6, "known mistake": 20,
           "does not compile": 5, "crash": 4, "endless loop": 5, "cheat": 6, "starter": 6, "empty": 2,
           "missing": 4, "no unit": 2}
KINDS = [*_SHARES, "right"]
_FIRST = ("Ann Jörg Zoë Łukasz Øyvind José Anaïs Nguyễn Jean-Luc Æsa Иван Θάλεια محمد 李 Kim Tom Ada Seán "
          "Şule Ilse Bo Çağla Ngozi Mária Aino Đức Ravi Noor Yuki Þóra").split()
_LAST = ("Mason|Müller-Lüdenscheid|van der Berg|O'Neil|d’Arc|Özdemir|Kowalczyk|Sørensen|García López|Ångström"
         "|Петров|Παπαδάκης|الأحمد|小明|Lou|Jarvis|Béla|Ó Súilleabháin|Þorsteinsdóttir|Nkrumah|de la Cruz"
         "|Smith, Jr.|$(reboot)|%s%n|=SUM(1)|Näf|Đặng|Straße|Wu & Sons|Çelik").split("|")

# `text` is what counts of the work, in bytes, or None; `points` what it earns, None for less than all;
# `fails` names claims that fail, `says` stands in the reason; `like` is the text that it copies.
Work = collections.namedtuple("Work", "kind text points fails says like", defaults=((), "", None))
# `team` is the id of the submission that counts for a student, or ""; `days` is how many days late it is.
Member = collections.namedtuple("Member", "id name email group pattern team days work")


class _Kit:
    """The unit, its starter, its mistakes and its points."""

    def __init__(self, source):
        self.feature = read_features(source)[STEM]
        with open(self.feature.reference, encoding="utf-8") as file:
            self.reference = file.read()
        self.starter = starter_of(self.feature.reference)
        self.tests = read_points(self.feature)
        path = os.path.join(source, "tests", "mutants", STEM + ".mutants")
        self.mutants = read_mutants(path, path)

    def until(self, steps):
        """Returns the unit with these steps solved, of which it has a region each."""
        text, step = [], 1
        for kind, line in read_regions(self.feature.reference):
            if kind == "common" or kind == ("solution" if step in steps else "starter"):
                text.append(line)
            step += line.strip() == "end */"
        return "".join(text)

    def claims(self, steps):
        return [test.name for test in self.tests if test.step in steps]

    def free(self):
        """Names the claims without points, which are about colours."""
        return [test.name for test in self.tests if test.points == 0]

    def points(self, fails):
        """Returns the points of a unit that fails just these claims."""
        got = sum(test.points for test in self.tests if test.name not in fails)
        return max(0, got - DEDUCTION * sum(test.points == 0 and test.name in fails for test in self.tests))


# --- What is handed in ---------------------------------------------------------------------------


def _dressed(text, rng):
    """As editors and systems save it."""
    return rng.choice([
        lambda: text.encode(), lambda: text.encode(), lambda: text.replace("\n", "\r\n").encode(),
        lambda: b"\xef\xbb\xbf" + text.encode(), lambda: text.rstrip("\n").encode(),
        lambda: b"/* von J\xf6rg, in Latin-1 */\n" + text.encode(),
        lambda: f"// 小明 {rng.random()} 🙂\n{text}".encode(), lambda: text.replace("    ", "\t").encode()])()


def _number(rng):
    return f"{rng.randrange(3, 9999) / 8}f"


def _idea(rng):
    """An experiment that somebody has left in the file, with numbers that nobody else has."""
    def vector(depth):
        if depth == 0:
            return f"rk_vec({_number(rng)}, {rng.choice('abc')}.{rng.choice('xyz')}, {_number(rng)})"
        return f"{rng.choice(['rk_cross', 'rk_sub', 'rk_add', 'rk_min3'])}({vector(depth - 1)}, {vector(0)})"

    lines = [f"    sum {rng.choice('+-')}= rk_dot({vector(1)}, {vector(0)}) * {_number(rng)};\n"
             for _ in range(8)]
    return (f"static float idea_{rng.randrange(10 ** 6)}(rk_vec3 a, rk_vec3 b, rk_vec3 c)\n{{\n"
            f"    float sum = {_number(rng)};\n{''.join(lines)}    return sum;\n}}\n")


def _own_work(rng):
    """A right unit in somebody's own words."""
    colour = rng.choice(["return rk_scale(rk_add(n, rk_vec(1, 1, 1)), 0.5f);",
                         "rk_vec3 grey = rk_vec(0.5f, 0.5f, 0.5f);\n    return rk_madd(grey, n, 0.5f);",
                         "return rk_vec((1 + n.x) / 2, (1 + n.y) / 2, (1 + n.z) / 2);"])
    normal = rng.choice(["rk_vec3 u = rk_sub(b, a), v = rk_sub(c, a);\n"
                         "    return rk_normalize(rk_cross(u, v));",
                         "rk_vec3 ab = rk_sub(b, a);\n    rk_vec3 ca = rk_sub(a, c);\n"
                         "    return rk_normalize(rk_cross(ca, ab));"])
    odd = [f"float odd = {_number(rng)};\n    (void)odd;\n" for _ in range(2)]
    return (f'#include "features/normals.h"\n\nrk_vec3 rk_normals_colour(rk_vec3 n)\n{{\n    {odd[0]}'
            f"    {colour}\n}}\n\n{_idea(rng)}\n"
            "rk_vec3 rk_normals_of_triangle(rk_vec3 a, rk_vec3 b, rk_vec3 c)\n"
            f"{{\n    {odd[1]}    {normal}\n}}\n")


def _beginning(kit, steps, begin, before=""):
    """Returns the right unit whose functions of these steps begin so."""
    text = kit.reference.replace('normals.h"\n', 'normals.h"\n' + before, 1)
    for step, name in enumerate(("rk_normals_colour", "rk_normals_of_triangle"), 1):
        at = text.index("{\n", text.index(f"rk_vec3 {name}(")) + 2
        text = text[:at] + (f"    {begin}\n" if step in steps else "") + text[at:]
    return text


def _stopped(kit, kind, rng, begins, says):
    """A unit in which one function, or both, comes to no end."""
    steps = rng.choice([(1,), (2,), (1, 2)])
    fails = kit.claims(steps) + (kit.free() if 1 in steps else [])
    return Work(kind, _dressed(_beginning(kit, steps, rng.choice(begins)), rng), kit.points(fails),
                tuple(fails), says)


def _cheat(kit, number, rng):
    printed = "".join(f'    puts("ok {k} - {test.name}");\n' for k, test in enumerate(kit.tests, 1))
    says_ok = kit.starter.replace('normals.h"\n', 'normals.h"\n#include <stdio.h>\n', 1).replace(
        "    //", printed + "    //", 1)
    library = "#include <stdio.h>\n#include <stdlib.h>\n#include <unistd.h>\n"
    reads = ('char line[99];\n    FILE *suite = fopen("../tests/test_normals.c", "r");\n'
             "    while (suite && fgets(line, sizeof line, suite))\n        puts(line);\n    exit(0);")
    none = kit.points(kit.claims((1, 2)))
    text, points, says = [
        (says_ok, none, ""),
        (_beginning(kit, (1, 2), printed.strip() + " exit(0);", library), 0, "exit"),
        (_beginning(kit, (1, 2), "_exit(0);", library + by_address("_exit")), 0, "middle of the test"),
        (_beginning(kit, (1, 2), reads, library), 0, "fopen"),
        (_beginning(kit, (1, 2), reads, library + by_address("fopen", "fgets", "exit")), 0,
         "middle of the test"),
        (_beginning(kit, (), "", "__attribute__((constructor)) static void early(void) { for (;;) { } }\n"),
         0, "constructor"),
        ('#include "features/normals.c"\n', 0, "includes"),
    ][number % 7]
    return Work("cheat", _dressed(text, rng), points, tuple(kit.claims((1, 2))), says)


def _work(kit, kind, number, rng, originals):
    """Returns the number-th Work of a kind; `originals` are texts that nobody has copied yet."""
    if kind == "right":
        text = kit.reference if number == 0 else disguise.copy_of(kit.reference, rng.randrange(10 ** 6))
        return Work(kind, _dressed(text, rng), kit.points(()))
    if kind == "own work":
        originals.append(_own_work(rng))
        return Work(kind, _dressed(originals[-1], rng), kit.points(()), like=originals[-1])
    if kind == "copy":
        original = originals.pop(0)
        text = original if number == 0 else disguise.copy_of(original, number)
        return Work(kind, _dressed(text, rng), kit.points(()), like=original)
    if kind in ("first step", "second step"):
        steps = (1,) if kind == "first step" else (2,)
        fails = kit.claims({1, 2}.difference(steps))
        return Work(kind, _dressed(kit.until(steps), rng), kit.points(fails), tuple(fails))
    if kind == "known mistake":
        mutant = kit.mutants[number % len(kit.mutants)]
        return Work(kind, _dressed(mutate(mutant, kit.reference, STEM), rng), None, tuple(mutant.fails))
    if kind == "does not compile":
        text = [kit.reference.replace(";", "", 1), '#include "mine.h"\n' + kit.reference,
                kit.reference.rstrip()[:-1], kit.reference.replace("rk_cross(", "rk_cross_of_two("),
                kit.reference.encode("utf-16"), b"%PDF-1.7\n" + rng.randbytes(3000)][number % 6]
        return Work(kind, text if isinstance(text, bytes) else text.encode(), 0)
    if kind == "crash":
        return _stopped(kit, kind, rng, ["volatile int *volatile none = 0; *none = 1;",
                                         "volatile float few[2] = {0}; volatile int k = 99; few[k] = 1;"], "")
    if kind == "endless loop":
        return _stopped(kit, kind, rng, ["for (volatile int k = 0; k < 2; k = 0) { }"], "endless loop")
    if kind == "cheat":
        return _cheat(kit, number, rng)
    if kind == "starter":
        return Work(kind, kit.starter.encode(), 0, tuple(kit.claims((1, 2))))
    if kind == "empty":
        return Work(kind, b"" if number % 2 == 0 else b"/* later */\n", 0)
    return Work(kind, None, None)  # missing, or no unit


# --- Who hands it in -----------------------------------------------------------------------------


def _kinds(size, rng):
    """Returns the kinds of so many works, each kind at least once if there is room."""
    kinds = [kind for kind, share in _SHARES.items() for _ in range(max(1, round(share * size / 100)))]
    del kinds[size:]
    kinds += ["right"] * (size - len(kinds))
    rng.shuffle(kinds)
    return sorted(kinds, key=lambda kind: kind == "copy")  # of what was written before


def _teams(size, rng):
    """Returns lists of numbers of students: most work alone, a third in groups of two or three."""
    teams, number = [], 0
    while number < size:
        count = min(rng.choice([1] * 12 + [2, 3]), size - number)
        teams.append(list(range(number, number + count)))
        number += count
    return teams


def _people(size, rng):
    """Returns (id, name, e-mail, pattern), some of the same name, whom patterns tell apart."""
    names = [f"{first} {last}" for first in _FIRST for last in _LAST]
    rng.shuffle(names)
    people = []
    for number in range(size):
        name = names[number % len(names)]
        if number % 100 == 99:
            name = people[number - 1][1]
        many = size > len(names) or number % 100 in (98, 99)
        identity = [f"{1001 + number}", f"u{number}", f"s-{number}.x", f"{number:07}"][number % 4]
        pattern = f"*_{500000 + number}_*" if many else ""
        people.append((identity, name, f"login{number}@uni.example", pattern))
    return people


def _time(days, rng):
    """Returns the date and time of a zip for what comes so many days late, on even seconds."""
    if not days and rng.random() < 0.1:
        return (_DEADLINE + datetime.timedelta(minutes=rng.randrange(2, 60 * GRACE - 2))).timetuple()[:6]
    late = datetime.timedelta(hours=GRACE) if days else datetime.timedelta(0)
    begin = _DEADLINE + late + datetime.timedelta(days=days - 1)
    return (begin + datetime.timedelta(minutes=rng.randrange(2, 24 * 60 - 2))).timetuple()[:6]


class _Zip:
    """Moodle's download: a folder for each student, or a file that begins with the folder's name."""

    def __init__(self, rng):
        self.files, self._rng = [], rng

    def add(self, student, group, number, data, when, name="normals.c"):
        rng = self._rng
        shown = unicodedata.normalize(rng.choice(["NFC", "NFD"]), student)
        shown = f"{group}-{shown}" if group and rng.random() < 0.5 else shown
        folder = f"{shown}_{500000 + number}_assignsubmission_file_"
        if name == "normals.c" and rng.random() < 0.3:
            name = rng.choice(["Normals.C", "normals (1).c", "normals.c.txt", "work/normals.c",
                               "my work.zip"])
        if name.endswith(".zip"):
            data = downloads.zipped(("normals/normals.c", data))
        self.files.append((f"{folder}/{name}", data, when))

    def add_alone(self, student, number, data, when, again):
        """A file without a folder: one of several."""
        self.files.append((f"{student}_{500000 + number}_assignsubmission_file_normals{again}.c", data, when))


def _deliver(archive, team, people, group, work, days, kit, rng):
    """Adds what a team hands in; at times twice, or by several members."""
    number = rng.choice(team)
    name, when = people[number][1], _time(days, rng)
    if work.kind == "no unit":
        archive.add(name, group, number, b"%PDF-1.7\n", when, "report.pdf")
    elif rng.random() < 0.9:
        archive.add(name, group, number, work.text, when)
    elif days:
        archive.add_alone(name, number, kit.starter.encode(), _time(days + 1, rng), " (1)")
        archive.add_alone(name, number, work.text, _time(days + 2, rng), " (2)")
        return days + 2
    else:  # twice: an older one that does not count, or a newer one that is late
        archive.add_alone(name, number, work.text, when, "")
        other = (2026, 9, 30, 12, 0, 0) if rng.random() < 0.5 else _time(1, rng)
        archive.add_alone(name, number, kit.starter.encode(), other, " (1)")
    return days


def _write_roster(members, path):
    with open(path, "w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["id", "name", "email", "group", "pattern"])
        rows.writerows([member.id, member.name, member.email, member.group, member.pattern]
                       for member in members)


def make(source, folder, size):
    """Writes moodle.zip and roster.csv of a class into the folder; returns its Members, in the roster's
    order."""
    rng, kit, members = random.Random(f"class of {size}"), _Kit(source), []
    people, teams, archive, originals = _people(size, rng), _teams(size, rng), _Zip(rng), []
    counts = collections.Counter()
    for team, kind in zip(teams, _kinds(len(teams), rng)):
        work = _work(kit, kind, counts[kind], rng, originals)
        counts[kind] += 1
        group = f"Group {team[0]}" if len(team) > 1 else ""
        days = rng.choice([0] * 9 + [1, 2, 3])
        if kind != "missing":
            days = _deliver(archive, team, people, group, work, days, kit, rng)
        whose = people[team[0]][0] if work.text is not None else ""
        for number in team:
            identity, name, email, pattern = people[number]
            members.append(Member(identity, name, email, group, pattern, whose, days, work))
    rng.shuffle(archive.files)
    with open(os.path.join(folder, "moodle.zip"), "wb") as file:
        file.write(downloads.zipped(*archive.files))
    _write_roster(members, os.path.join(folder, "roster.csv"))
    return members
