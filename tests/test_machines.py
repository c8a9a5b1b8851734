#!/usr/bin/env python3
"""Other machines than ours: what configure and the tools say where something is missing, too old or another
program, and that lists of packages agree. With programs of a few lines in the place of real ones.
Speaks TAP, for make check-machines; runs in a build folder."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from unittest import mock

MAKE = os.environ.get("MAKE", "make")
SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from tap import check, finish, read, start, write  # noqa: E402
from grading import bubblewrap, build, verdicts  # noqa: E402
from grading.assignments import ToolError  # noqa: E402
import grade  # noqa: E402

CONFIGURED_FROM = ("Makefile.in", "GNUmakefile", "raykit.pc.in", "features.am", "configure", "build-aux",
                   "src/base/vec3.h", "src/accel/kernel/machine.h")
OLD_PYTHON = 'case $1 in --version) echo Python 3.9.18 ;; *) exit 1 ;; esac'
LATER_PYTHON = 'case $1 in --version) echo Python 3.14.1 ;; -c) ;; esac'
OLD_PANDOC = 'echo pandoc 2.9.2.1'
PLAIN_COMPILER = """case " $* " in
*" -fsanitize"*) echo "gcc: error: no such option" >&2; exit 1 ;;
esac
exec gcc "$@\""""
STRICT_SYSTEM = """case $1 in --version) echo bubblewrap 0.9.0; exit ;; esac
echo "bwrap: setting up uid map: Permission denied" >&2
exit 1"""
OTHER_PARALLEL = """echo "parallel: invalid option -- '-'" >&2
exit 1"""


def stub(folder, name, text):
    write("#!/bin/sh\n" + text + "\n", folder, name)
    os.chmod(os.path.join(folder, name), 0o755)
    return os.path.join(folder, name)


def _answer(command, folder, changed):
    """Runs a command in a folder, with a changed environment; returns its status and what it said."""
    kept = {name: value for name, value in os.environ.items()
            if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "PYTHON", "PANDOC", "CC", "CFLAGS", "srcdir")}
    answer = subprocess.run(command, cwd=folder, env={**kept, **changed}, stdin=subprocess.DEVNULL, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    return answer.returncode, answer.stdout


# --- configure's closing table --------------------------------------------------------------------


def configured(work, name, changed, *options):
    """Configures what configure needs of the kit; returns its status, the rows of its table, and what it
    said."""
    folder = os.path.join(work, name)
    for part in CONFIGURED_FROM:
        place = os.path.join(folder, part)
        os.makedirs(os.path.dirname(place), exist_ok=True)
        (shutil.copytree if os.path.isdir(os.path.join(SOURCE, part)) else shutil.copy2)(
            os.path.join(SOURCE, part), place)
    status, said = _answer(["./configure", "--quiet", "--disable-dependency-tracking", *options], folder,
                           changed)
    return status, dict(re.findall(r"^  (\w.{12})(.*)$", said, re.MULTILINE)), said


def row(rows, name):
    return rows.get(f"{name:<13}", "").strip()


def what_is_too_old_or_another_program(work):
    programs = os.path.join(work, "programs")
    for name, text in (("pandoc", OLD_PANDOC), ("plain-cc", PLAIN_COMPILER), ("bwrap", STRICT_SYSTEM),
                       ("parallel", OTHER_PARALLEL)):
        stub(programs, name, text)
    old = stub(programs, "python3", OLD_PYTHON)
    for name, version in (("assimp", "5.0.0"), ("OpenImageIO", "2.2.10")):
        write(f"Name: {name}\nDescription: too old\nVersion: {version}\n", work, "modules", f"{name}.pc")
    status, rows, said = configured(work, "old", {
        "PATH": f"{programs}:{os.environ['PATH']}", "PYTHON": old, "CC": "plain-cc",
        "PKG_CONFIG_PATH": os.path.join(work, "modules")})
    check(status == 0, "where much is too old, configure succeeds all the same", said)
    wanted = {
        "Python": "MISSING: no workbooks, no grading: Python 3.9.18 is too old, 3.10 is needed",
        "pandoc": "MISSING: no report and no book; drivers still make pictures and tables: pandoc 2.9.2.1 is "
                  "too old, 2.17 is needed",
        "Assimp": "MISSING: no mesh files; the built-in scenes still work: Assimp 5.0.0 is too old, 5.2 is "
                  "needed",
        "OpenImageIO": "MISSING: only PNG image files: OpenImageIO 2.2.10 is too old, 2.4 is needed",
        "sanitizers": "MISSING: plain-cc refuses -fsanitize: wrong memory accesses, undefined behaviour and "
                      "leaks can go unnoticed in checks and grades (libasan and libubsan)",
        "sandbox": "MISSING: nothing of others is graded, unless you say SANDBOX=no, or as root "
                   "SANDBOX=container: bubblewrap starts no sandbox here (setting up uid map: Permission "
                   "denied); docs/machines.md says what to do",
        "GNU parallel": f"MISSING: classes are graded one submission after the other: {programs}/parallel is "
                        "another "
                        "program, not GNU parallel (parallel)"}
    for name, words in wanted.items():
        check(row(rows, name) == words, f"{name}: what is lost and why has a row",
              [row(rows, name), words])
    made = read(work, "old", "Makefile")
    for name in ("PYTHON", "PANDOC", "RK_GRADE_SANITIZE"):
        check(re.search(rf"^{name} = *$", made, re.MULTILINE), f"the build treats {name} as absent")
    for name, words in (("PYTHON", "Python 3.9.18 is too old, 3.10 is needed"),
                        ("PANDOC", "pandoc 2.9.2.1 is too old, 2.17 is needed")):
        check(f"\nNO_{name} = {words}: docs/machines.md says what to do\n" in made,
              f"and can say why: {name}")
    check(said.endswith("\nNow: make check (tests), make install.\n"),
          "the last line has no command that needs what is too old", said)


def what_a_student_needs_not(work):
    programs = os.path.join(work, "student-programs")
    stub(programs, "bwrap", STRICT_SYSTEM)
    absent = {f"ac_cv_path_{name}": ""
              for name in ("PARALLEL", "PANDOC", "GNUPLOT", "CHROMIUM", "FIREFOX", "BLENDER")}
    status, rows, said = configured(work, "student", {**absent, "PATH": f"{programs}:{os.environ['PATH']}"},
                                    "--enable-student")
    for name in ("GNU parallel", "pandoc", "gnuplot", "Chromium", "Firefox", "Blender"):
        check(row(rows, name) == "not installed (a student needs none)",
              f"{name}: no student is told to miss it", row(rows, name))
    check(status == 0 and row(rows, "sandbox").startswith("MISSING: "),
          "what is there and does not serve has its reason for students, too", said)
    check(said.endswith("\nNow: make workbook DIR=mine && make start IMPL=mine.\n"),
          "a student's next command is the first one", said)
    stub(programs, "python3", OLD_PYTHON)
    _, _, said = configured(work, "no-python", {"PYTHON": f"{programs}/python3"}, "--enable-student")
    check("make workbook" not in said and "\nNow: " in said, "if there is a Python for it", said)


def the_package_of_clangs_sanitizers(work):
    for version, package in (("14.0.6", "libclang-rt-14-dev"), ("11.0.1-2", "libclang-common-11-dev")):
        programs = os.path.join(work, "clang" + version)
        says = f"[ \"$*\" != --version ] || {{ echo Debian clang version {version}; exit; }}\n"
        stub(programs, "clang-stub", says + PLAIN_COMPILER)
        changed = {"PATH": f"{programs}:{os.environ['PATH']}", "CC": "clang-stub"}
        _, rows, said = configured(work, "with" + version, changed)
        check(row(rows, "sanitizers").endswith(f"in checks and grades ({package})"),
              f"clang {version}: the package of its sanitizers is named", said)
    status, _, said = configured(work, "refused", changed, "--enable-sanitizers")
    check(status != 0 and "install libclang-common-11-dev (" in said, "as where they are asked for", said)


def make_says_what_is_missing():
    status, said = _answer([MAKE, "-s", "workbook", "DIR=mine", "PYTHON=", "NO_PYTHON=Python 3.9.2 is odd"],
                           ".", {})
    check(status != 0 and "Python 3.9.2 is odd" in said and "Traceback" not in said,
          "make says why there is no Python", said)
    for page in ("report", "book"):
        status, said = _answer([MAKE, "-s", page, "PANDOC=", "NO_PANDOC=pandoc 2.9 is odd"], ".", {})
        check(status != 0 and "pandoc 2.9 is odd" in said, f"make {page} says why there is no pandoc", said)
        changed = os.path.join(os.environ.get("srcdir", "."), "src", "base", "vec3.h")  # make's name of it
        counts = [_answer([MAKE, "-n", "-W", changed, page, *options], ".", {})[1].count(" -c ")
                  for options in ([], ["PANDOC="])]
        check(counts[0] > 0 and counts[1] == 0, "before it compiles anything", counts)


def versions_of_helpers_packages_agree():
    wanted = read(SOURCE, "configure.ac")
    for name, module, package in (("mesh", "assimp", "libassimp-dev"),
                                  ("image", "OpenImageIO", "libopenimageio-dev")):
        least = re.search(rf"\[{module} >= ([\d.]+)\]", wanted)[1]
        check(f'"{package} {least} or later"' in read(SOURCE, "src", "io", f"{name}_file.c"),
              f"who reads a {name} without its helper is told how old {package} may be")


def what_is_absent(work):
    absent = {f"ac_cv_{kind}_{name}": "" for kind, name in (
        ("path", "PANDOC"), ("path", "BWRAP"), ("path", "PARALLEL"), ("prog", "OBJCOPY"),
        ("prog", "ac_ct_OBJCOPY"))}
    status, rows, said = configured(work, "absent", absent)
    check(status == 0, "where it is absent, too", said)
    for name, words in (
            ("binutils", "MISSING: no checks of your files, no grading (binutils)"),
            ("sandbox", "MISSING: nothing of others is graded, unless you say SANDBOX=no, or as root "
                        "SANDBOX=container (bubblewrap)"),
            ("GNU parallel", "MISSING: classes are graded one submission after the other (parallel)"),
            ("pandoc", "MISSING: no report and no book; drivers still make pictures and tables (pandoc)")):
        check(row(rows, name) == words, f"{name}: what is lost without it has a row",
              [row(rows, name), words])


def other_objects(work):
    """A compiler whose programs are no ELF, as on macOS: od reads the first bytes."""
    programs = os.path.join(work, "foreign")
    stub(programs, "od", "echo ' 317 372 355 376'")
    _, rows, said = configured(work, "mach", {"PATH": f"{programs}:{os.environ['PATH']}", "CC": "gcc"})
    check(row(rows, "binutils") == "MISSING: no checks of your files, no grading: they read ELF, which gcc "
          "does not make here; docs/machines.md says what to do", "where programs are no ELF, this is said",
          said)


def a_later_python_beside_an_old_one(work):
    programs = os.path.join(work, "beside")
    stub(programs, "python3", OLD_PYTHON)
    later = stub(programs, "python3.14", LATER_PYTHON)
    _, rows, said = configured(work, "both", {"PATH": f"{programs}:{os.environ['PATH']}"})
    made = read(work, "both", "Makefile")
    check(row(rows, "Python") == "Python 3.14.1" and f"\nPYTHON = {later}\n" in made,
          "a later Python beside one that is too old is taken", said)


# --- the tools themselves -------------------------------------------------------------------------


def an_old_python_is_told():
    for name in ("launch.py", "grading/least_python.py"):
        try:
            ast.parse(read(SOURCE, "tools", name), feature_version=(3, 6))
            check(True, f"Python 3.6 can read {name}")
        except SyntaxError as error:
            check(False, f"Python 3.6 can read {name}", error)
    for arguments in (["launch.py", "grade.py"], ["grade.py"]):
        script = ("import runpy, sys; sys.version_info = (3, 9, 18); tools = sys.argv.pop(1); "
                  "sys.path.insert(0, tools); sys.argv = [tools + '/' + name for name in sys.argv[1:]]; "
                  "runpy.run_path(sys.argv[0], run_name='__main__')")
        status, said = _answer(
            [sys.executable, "-B", "-c", script, os.path.join(SOURCE, "tools"), *arguments], ".", {})
        check(status == 2 and len(said.splitlines()) == 1
              and "need Python 3.10 or later, but this is Python 3.9" in said,
              f"{' '.join(arguments)} says in one line that Python is too old", said)


def a_later_cmocka_is_not_the_unit():
    said = "TAP version 13\n1..1\nmine\nnot ok 1 - claim\n# got 1, want 2\n"  # 1.1.7, as in Debian 13
    check(verdicts.printed_lines(said) == ["mine"], "what a later cmocka prints is not told as the unit's",
          verdicts.printed_lines(said))


def what_is_not_looked_for_is_told(work):
    toolchain = build.Toolchain(".")
    check(toolchain.left_out() == [] if toolchain.sanitize else True,
          "with sanitizers a report has nothing to add")
    toolchain.sanitize = []
    submission = os.path.join(work, "submission")
    os.mkdir(submission)
    shutil.copy(os.path.join(SOURCE, "src", "features", "normals.c"), submission)
    with mock.patch.multiple(grade, _grade_apart=mock.DEFAULT, _grade_here=mock.DEFAULT), \
            mock.patch.object(build, "Toolchain", return_value=toolchain):
        told = {"of a class": grade.grade_submission(toolchain, ["normals"], submission),
                "of one's own work": grade.grade_impl(".", ["normals"], submission, own=True)[1]}
    for whose, suites in told.items():
        remarks = [remark for remark in suites[0].remarks if "without sanitizers" in remark]
        check(len(remarks) == 1 and "leaks were not looked for" in remarks[0],
              f"without them a report {whose} says what was not looked for", suites[0].remarks)


def a_compiler_of_ones_own_is_told(work):
    toolchain = build.Toolchain(".")
    toolchain.compiler = [stub(os.path.join(work, "own"), "cc", "exec gcc \"$@\"")]
    stub(os.path.join(work, "own"), "bwrap", STRICT_SYSTEM)
    try:
        with mock.patch.dict(os.environ, RAYKIT_SANDBOX="", PATH=f"{work}/own:{os.environ['PATH']}"):
            bubblewrap.find(toolchain)
        said = "no word"
    except ToolError as error:
        said = str(error)
    check(f"{work}/own/cc stands outside of the system's folders" in said,
          "a compiler that no sandbox has is named, instead of the sandbox", said)


def without_a_sandbox_the_way_out_is_ones_own(work):
    """Bubblewrap that is there need not be installed, and root is told what root may do."""
    toolchain = build.Toolchain(".")
    toolchain.compiler = ["/usr/bin/cc"]
    stub(os.path.join(work, "strict"), "bwrap", STRICT_SYSTEM)
    for there, path in ((True, f"{work}/strict:{os.environ['PATH']}"), (False, f"{work}/nothing")):
        for user in (0, 1000):
            said = "no word"
            with mock.patch.dict(os.environ, RAYKIT_SANDBOX="", PATH=path), \
                    mock.patch.object(os, "geteuid", return_value=user):
                try:
                    bubblewrap.find(toolchain)
                except ToolError as error:
                    said = str(error)
            check("there is no sandbox" in said and ("install bubblewrap" in said) != there
                  and ("docs/machines.md" in said) == there
                  and ("SANDBOX=container" in said) == (user == 0) == ("SANDBOX=no" not in said),
                  f"without a sandbox {'root' if user == 0 else 'a user'} is told a way that is open, "
                  f"bubblewrap is {'there' if there else 'absent'}", said)


# --- lists of packages ----------------------------------------------------------------------------


def asked_of_apt(work, name, options):
    """Returns the packages that bootstrap installs where none is there."""
    folder = os.path.join(work, name)
    shutil.copytree(os.path.join(work, "apt"), folder)
    shutil.copy2(os.path.join(SOURCE, "bootstrap"), folder)
    status, said = _answer(["./bootstrap", "--only-install", *options], folder,
                           {"PATH": f"{folder}/bin:{os.environ['PATH']}"})
    if status or not os.path.exists(os.path.join(folder, "asked")):
        return said
    return read(folder, "asked").split()


def lists_of_packages(work):
    programs = os.path.join(work, "apt", "bin")
    stub(programs, "dpkg-query", "exit 1")
    stub(programs, "sudo", 'exec "$@"')
    stub(programs, "apt-get", """while [ $# != 0 ]; do
    case $1 in install) shift; while [ "${1#-}" != "$1" ]; do shift; done; echo "$@" >>asked; exit ;; esac
    shift
done""")
    student, whole = (asked_of_apt(work, "apt-" + name, options)
                      for name, options in (("student", ["--student"]), ("whole", [])))
    check(isinstance(student, list) and "gcc" in student and "pandoc" not in student,
          "--student is a little list, and --only-install ends after it", student)
    check(set(student) < set(whole) and "parallel" in whole, "which is part of the whole one", whole)
    page = read(SOURCE, "docs", "machines.md")
    lines = [words.split() for words in
             re.findall(r"^    sudo apt-get install --no-install-recommends (.*)$", page, re.MULTILINE)]
    for name, packages in (("--student", student), ("the whole kit", whole)):
        check(packages in lines, f"docs/machines.md has the administrator's line of {name}",
              [packages, *lines])
    return student


def without_apt(work):
    """A machine with another package manager."""
    folder = os.path.join(work, "elsewhere")
    os.mkdir(folder)
    shutil.copy2(os.path.join(SOURCE, "bootstrap"), folder)
    programs = os.path.join(folder, "bin")
    os.mkdir(programs)
    for name in ("sh", "dirname", "sed", "cat", "env"):
        os.symlink(shutil.which(name), os.path.join(programs, name))
    status, said = _answer(["./bootstrap", "--student", "--only-install"], folder, {"PATH": programs})
    check(status == 0 and all(f"\n    {name} " in said for name in ("Fedora", "Arch", "Alpine", "Homebrew")),
          "without apt-get bootstrap has other systems' names", said)
    page = read(SOURCE, "docs", "machines.md")
    commands = re.findall(r"^    \w+ +((?:dnf|pacman|apk|brew) .*)$", said, re.MULTILINE)
    check(len(commands) == 4 and all(command in page for command in commands),
          "and docs/machines.md has the same ones", commands)


def containers(student):
    text = read(SOURCE, "Dockerfile")
    check(re.search(r"^ARG LIST=--student$", text, re.MULTILINE)
          and re.search(r"^COPY bootstrap /root/$", text, re.MULTILINE)
          and "RUN /root/bootstrap $LIST --only-install" in text, "the Dockerfile installs by bootstrap",
          text)
    words = set(re.findall(r"[\w.+-]+", re.sub(r"^#.*", "", text, flags=re.MULTILINE)))
    check(not words & set(student) and "apt-get" not in text, "and has no list of its own",
          sorted(words & set(student)))
    check(read(SOURCE, ".dockerignore").split() == ["*", "!bootstrap"], "no other file is sent to make it")
    text = read(SOURCE, ".devcontainer", "devcontainer.json")
    text = re.sub(r"^\s*//.*$", "", text, flags=re.MULTILINE)
    place = json.loads(text)["build"]
    check({key: os.path.normpath(os.path.join(SOURCE, ".devcontainer", path)) for key, path in place.items()}
          == {"dockerfile": os.path.join(SOURCE, "Dockerfile"), "context": SOURCE},
          "VS Code's container is made by the same file", place)
    check(json.loads(text)["postCreateCommand"] == "./bootstrap --student --no-install",
          "and configured when it is made")


def main():
    # Beside the build, not in /tmp, from which programs may not be allowed to start.
    with tempfile.TemporaryDirectory(dir=".") as work:
        work = os.path.abspath(work)
        what_is_too_old_or_another_program(work)
        what_is_absent(work)
        what_a_student_needs_not(work)
        the_package_of_clangs_sanitizers(work)
        make_says_what_is_missing()
        versions_of_helpers_packages_agree()
        other_objects(work)
        a_later_python_beside_an_old_one(work)
        an_old_python_is_told()
        a_later_cmocka_is_not_the_unit()
        what_is_not_looked_for_is_told(work)
        a_compiler_of_ones_own_is_told(work)
        without_a_sandbox_the_way_out_is_ones_own(work)
        containers(lists_of_packages(work))
        without_apt(work)
    return finish()


start(main)
