#!/usr/bin/env python3
"""What git hosts run: the very commands of the workflows, in a clone of a pack, and in an instructor's
repository beside those of students. Speaks TAP, for make check-workflows; runs in a build folder."""

import csv
import os
import re
import shutil
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import handout  # noqa: E402
from grading import bubblewrap, build  # noqa: E402
from grading.assignments import ToolError, read_features, read_points  # noqa: E402
from grading.starters import starter_of  # noqa: E402
from tap import check, finish, read, run, start, write  # noqa: E402

STEM = "normals"
FEATURE = read_features(SOURCE)[STEM]
RIGHT, STARTER = read(FEATURE.reference), starter_of(FEATURE.reference)
WORKFLOWS = os.path.join(SOURCE, "tools", "workflows")
MAKE = os.environ.get("MAKE", "make")
# One suite stands for all that make check builds and runs.
ONE_SUITE = f"MAKEFLAGS=check_PROGRAMS=tests/test_{STEM} TESTS=tests/test_{STEM}"
MEMBER = ["-c", "user.name=A", "-c", "user.email=a@b"]


def commands_of(*path):
    """Returns the commands of a workflow, which are a line each."""
    text = read(*path)
    begin = r"^ +- run: (.*)$" if "runs-on:" in text else r"^    - (.*)$"
    return re.findall(begin, text, re.MULTILINE)


def host(folder, home, commands, *settings):
    """Runs commands as a host does, each in a shell of its own, all of them; returns their statuses and what
    was said. Nothing is installed."""
    environment = [f"HOME={home}", "GIT_CONFIG_NOSYSTEM=1", *settings]
    done, told = [], ""
    for command in commands:
        command = command.replace("--student", "--student --no-install")
        status, said = run(folder, "env", *environment, "sh", "-e", "-c", command)
        done.append(status)
        told += f"$ {command}\n{said}[{status}]\n"
    return done, told


def repository(folder, name):
    """Returns a bare repository, as a host has it, and a clone."""
    bare, clone = os.path.join(folder, name + ".git"), os.path.join(folder, name)
    run(folder, "git", "init", "-q", "--bare", "--initial-branch=main", bare)
    run(folder, "git", "clone", "-q", bare, clone)
    run(clone, "git", "checkout", "-q", "-b", "main")
    return bare, clone


def push(clone, date="2026-10-05T12:00:00 +0200"):
    run(clone, "git", "add", "-A")
    run(clone, "env", f"GIT_COMMITTER_DATE={date}", "git", *MEMBER, "commit", "-q", "-m", "Work")
    status, said = run(clone, "git", "push", "-q", "origin", "main")
    check(status == 0, f"{os.path.basename(clone)} is pushed", said)


def they_are_yaml():
    try:
        import yaml
    except ImportError:
        print("# there is no python3-yaml, so nobody else has read the workflows")
        return
    for name in ("check.yml", "grade.yml", "site.yml", "check.gitlab-ci.yml"):
        found = yaml.safe_load(read(WORKFLOWS, name))
        job = (found.get("jobs") or found)[name.partition(".")[0]]
        commands = job.get("script") or [step["run"] for step in job["steps"] if "run" in step]
        check(commands == commands_of(WORKFLOWS, name), f"{name} is YAML, with commands of a line each",
              commands)


def a_pack_is_checked_by_its_host(folder):
    """Returns a clone of the pack's repository."""
    bare, clone = repository(folder, "pack")
    pack = os.path.join(folder, "handed out")
    handout.make_handout(SOURCE, [STEM], folder=pack, book=False, later="all")
    shutil.copytree(pack, clone, dirs_exist_ok=True, symlinks=True)
    found = os.listdir(os.path.join(pack, ".github", "workflows"))
    check(found == ["raykit.yml"] and not os.path.exists(os.path.join(pack, "tools", "workflows")),
          "a pack has the workflow for students, and no other", found)
    push(clone)
    there = os.path.join(folder, "runner")
    run(folder, "git", "clone", "-q", bare, there)
    status, said = host(there, folder, commands_of(there, ".github", "workflows", "raykit.yml"), ONE_SUITE)
    check(status[0] == 0 and all(status[1:]) and "0 of 100 points" in said,
          "with the starter all but the setting up is red, and the first claim is told", said)
    write(RIGHT, clone, "workbook", STEM + ".c")
    push(clone)
    run(there, "git", "pull", "-q")
    for name in (os.path.join(".github", "workflows", "raykit.yml"), ".gitlab-ci.yml"):
        status, said = host(there, folder, commands_of(there, name), ONE_SUITE)
        check(not any(status) and "100 of 100 points" in said and "ok    normals" in said,
              f"with the solution all is green ({name})", said)
    cases = ElementTree.parse(os.path.join(there, "grade.xml")).getroot().findall("testsuite/testcase")
    check(len(cases) >= len(read_points(FEATURE)), "grade.xml has a case for each claim", len(cases))
    os.unlink(os.path.join(clone, ".gitlab-ci.yml"))
    status, said = run(there, MAKE, "-s", "tell-edited")
    check(status == 0 and not said, "a workflow that was removed is no edit of the kit", said)
    return clone


def a_class_is_graded_in_private(folder, pack):
    """Students' repositories: a whole pack, a unit alone, a starter, and one that cannot be cloned."""
    units = {"ann": None, "ben": RIGHT.replace("0.5f +", "", 1), "cem": STARTER}
    lines = []
    for name, text in units.items():
        bare, clone = repository(folder, name)
        if text is None:
            shutil.copytree(pack, clone, dirs_exist_ok=True, ignore=shutil.ignore_patterns(".git"))
        else:
            write(text, clone, STEM + ".c")
        push(clone, f"2026-10-0{6 if name == 'cem' else 5}T12:00:00 +0200")
        lines.append(f"{name} {bare}\n")
    bare, own = repository(folder, "grades")
    status, said = run(".", MAKE, "-s", "grading-kit", f"ASSIGNMENTS={STEM}", f"OUT={own}/kit.tar.gz")
    check(status == 0, "the grading kit is made", said)
    write("".join(lines) + f"dan {folder}/nowhere.git\n", own, "repositories.txt")
    write("id,name,email\n" + "".join(f"{name},{name},{name}@uni.edu\n" for name in [*units, "dan"]), own,
          "roster.csv")
    push(own)
    commands = commands_of(WORKFLOWS, "grade.yml")
    installs = [command for command in commands if command.startswith("apt-get")]
    check(len(installs) == 1, "one command installs what the others need", commands)
    values = re.findall(r"^  ([A-Z]+): \"?([^\"\n]*)\"?$", read(WORKFLOWS, "grade.yml"), re.MULTILINE)
    tables = []
    for attempt in ("first", "second"):
        there = os.path.join(folder, f"{attempt} night")
        run(folder, "git", "clone", "-q", bare, there)
        status, said = host(there, os.path.join(folder, "home"),
                            [line for line in commands if line not in installs],
                            *(f"{name}={value}" for name, value in values), "TOKEN=secret")
        check(not any(status) and "nothing of dan" in said, f"the {attempt} night's commands end well", said)
        _, text = run(own, "git", "--git-dir", bare, "show", "main:results/class.csv")
        tables.append(text)
        check(said.count("unchanged") == (0 if attempt == "first" else 3),
              "what has not changed is not graded again" if attempt != "first" else "each is graded", said)
    points = {row["name"]: row["total"] for row in csv.DictReader(tables[0].splitlines())}
    check(set(points) == set(units) and points["ann"] == "100" and points["cem"] == "0"
          and 0 < int(points["ben"]) < 100 and tables[0] == tables[1],
          "the table is in the instructor's repository", tables)
    _, text = run(own, "git", "--git-dir", bare, "show", "main:results/collected.csv")
    late = {row["id"]: row["days_late"] for row in csv.DictReader(text.splitlines())}
    check(late == {"ann": "0", "ben": "0", "cem": "1", "dan": ""}, "with who is late, and who is missing",
          text)
    for name in units:
        names = run(folder, "git", "--git-dir", name + ".git", "ls-tree", "--name-only", "main")[1].split()
        check(names and not {"kit.tar.gz", "raykit-grading", "results", "roster.csv"} & set(names),
              f"nothing of it is in {name}'s repository", names)


def the_site_s_commands_exist():
    """They take half an hour and a network, so no more than that."""
    usage = run(SOURCE, "./bootstrap", "--help")[1]
    for command in commands_of(WORKFLOWS, "site.yml"):
        name, *words = command.split()
        if name == "./bootstrap":
            check(all(word in usage for word in words), f"bootstrap has {' '.join(words)}", usage)
        elif name == "make":
            target = words[-1] if not words[-1].startswith("-") else "all"
            status, said = run(".", MAKE, "-n", target)
            check(status == 0 or "is missing" in said, f"make has {target}", said)


def main():
    folder = tempfile.mkdtemp(prefix="raykit-test-workflows-")
    try:
        they_are_yaml()
        the_site_s_commands_exist()
        os.mkdir(os.path.join(folder, "home"))
        pack = a_pack_is_checked_by_its_host(folder)
        try:
            bubblewrap.find(build.Toolchain("."))
        except ToolError as error:
            print(f"# no class is graded: {error}")
        else:
            a_class_is_graded_in_private(folder, pack)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
