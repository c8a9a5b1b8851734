#!/usr/bin/env python3
"""Proves that suites distinguish right work from wrong: `make check-suites`.

For each feature of assignments/features.tsv:
- the reference passes every test of its suite;
- the starter compiles without a warning, runs safely under the address, undefined behaviour and
  leak sanitizers, fails every test that carries points, and passes every other one;
- points.tsv lists every test, those that carry no points with 0, so that students hear when one
  that held no longer does;
- points.tsv lists the tests that carry points in the order of the steps of the assignment's handout.md,
  and names for each a section that the handout names for its step or an earlier one;
- after each of these steps, with the reference in its gaps and in those of earlier ones, the tests of all
  these steps pass; those of the next step fail, but for those that points.tsv says are green already;
- the unit reads as its chapter (tools/grading/reading_order.py);
- reference and starter keep the rules for units (tools/grading/unit_rules.py);
- each mutant, a known mistake in tests/mutants/STEM.mutants, fails the tests that it names, and the first
  claim that fails says what the mutant says that it should.
  tools/grading/mutants.py says how mutants are written.

This is mutation testing (DeMillo, Lipton, Sayward, "Hints on test data selection", 1978) with
mistakes that people made, not random ones.

RAYKIT_VERDICTS names a folder in which killed mutants are noted by the digest of all that decides it, so
that later runs need not kill them again; FRESH=1 kills all of them anew (tools/grading/verdict_store.py).
MUTANTS=4 tries so many of each feature's mutants, spread over its file: a quick look, no proof.

Prints a line for each feature and each fault; the exit status is 0 if there is none. The build
tells by RAYKIT_COMPILE and RAYKIT_LINK how it compiles and links, and by RAYKIT_LIBS with what.
"""

import argparse
import concurrent.futures
import csv
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import threading

sys.dont_write_bytecode = True  # the source folder may be read-only, and stays clean
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from grading import assignments
from grading import reading_order
from grading import starters
from grading import unit_rules
from grading import verdict_store
from grading.mutants import MutantError, mutate, read_mutants
from grading.processor_time import limited

FEWEST_MUTANTS = 8
SECONDS = 20  # of processor time for one test: a slow one takes half a second, with sanitizers ten times that
PATIENCE = 10  # times as long by the clock, for one that waits
# A mutant's time is its compiler's: no warnings, no debugging information.
QUICKLY = ["-w", "-g0"]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]

# A sanitizer's report has a status of its own, and cmocka's handlers do not turn a crash into an
# ordinary failed test.
REPORTED = 86
SANITIZER_ENVIRONMENT = {
    "ASAN_OPTIONS": f"exitcode={REPORTED}:handle_segv=2:handle_sigbus=2:handle_sigfpe=2:"
    "handle_sigill=2",
    "UBSAN_OPTIONS": f"exitcode={REPORTED}:print_stacktrace=1",
    "LSAN_OPTIONS": f"exitcode={REPORTED}",
}


class Fault(Exception):
    """A fault, in one sentence with its remedy."""


class Progress:
    """One line that counts finished jobs, on a terminal only."""

    def __init__(self):
        self.started, self.finished, self.lock = 0, 0, threading.Lock()

    def add(self, started, finished):
        with self.lock:
            self.started += started
            self.finished += finished
            if sys.stderr.isatty():
                print(f"\r{self.finished} of {self.started} ", end="", file=sys.stderr, flush=True)

    def clear(self):
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def read_table(path):
    """Returns the rows of a tab-separated file with a header line, as dictionaries."""
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def includes_of(text):
    """Returns a unit's preprocessor lines, on which it depends which files it includes."""
    return re.findall(r"^\s*#.*$", text, re.MULTILINE)


def spread(items, most):
    """Returns at most so many of the items, in even distances; all of them for 0."""
    count = min(most or len(items), len(items))
    return [items[i * len(items) // count] for i in range(count)]


def _with_points(rows):
    return [row["test"] for row in rows if row["points"] != "0"]


# --- Building and running ---------------------------------------------------------------------


class Builder:
    """Compiles and links as the build does, into a temporary folder."""

    def __init__(self, folder, store):
        self.folder, self.store = folder, store
        self.compiler = shlex.split(os.environ["RAYKIT_COMPILE"])
        self.linker = shlex.split(os.environ["RAYKIT_LINK"])
        self.libraries = shlex.split(os.environ["RAYKIT_LIBS"])

    def run(self, command, what):
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != 0:
            raise Fault(f"{what} does not compile or link:\n{done.stdout.rstrip()}")

    def compile(self, source, name, flags, what):
        """Returns the object NAME.o."""
        target = self.folder / f"{name}.o"
        self.run([*self.compiler, *flags, "-c", "-o", str(target), str(source)], what)
        return target

    def compile_base_sanitized(self, root):
        """Returns objects of what features call, and of what counts allocations in them, so that a
        sanitizer sees into it too."""
        sources = sorted([*(root / "src/base").glob("*.c"), *(root / "src/scene").glob("*.c"),
                          root / "tests/count_allocations.c"])
        return [self.compile(source, f"{source.parent.name}-{source.stem}-sanitized", SANITIZE,
                             source) for source in sources]

    def link(self, objects, name, flags, what):
        """Returns the program NAME."""
        target = self.folder / name
        self.run([*self.linker, *flags, "-o", str(target), *map(str, objects), *self.libraries],
                 what)
        return target

    def inputs(self, root):
        """Returns the digest of what decides every feature's verdicts."""
        digest = verdict_store.Digest()
        for path in [*sorted((root / "tools" / "grading").glob("*.py")), root / "tools" / "check_suites.py"]:
            digest.add_file(path.name, path)
        for command in (self.compiler, QUICKLY, self.linker, self.libraries):
            digest.add("command", "\0".join(command).replace(str(root), ".").replace(os.getcwd(), "."))
        verdict_store.add_machine(digest)
        verdict_store.add_compiler(digest, self.compiler[0])
        for library in self.libraries:
            if library.endswith(".a"):
                verdict_store.add_archive(digest, library)
        return digest


def list_tests(program):
    return subprocess.run([program, "--list"], stdout=subprocess.PIPE, text=True,
                          check=True).stdout.split()


def run_test(program, test, environment=None):
    """Returns the exit status of one test, 0 for passed, and its output. Out of time: 124."""
    try:
        done = subprocess.run(limited([program, "--only", test], SECONDS), stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace",
                              env={**os.environ, **(environment or {})}, timeout=PATIENCE * SECONDS,
                              check=False)
    except subprocess.TimeoutExpired:
        return 124, f"no verdict after {PATIENCE * SECONDS} s"
    if done.returncode == -signal.SIGXCPU:
        return 124, f"no verdict after {SECONDS} s of processor time"
    return done.returncode, done.stdout.strip()


# --- A feature --------------------------------------------------------------------------------


class Feature:
    """A row of features.tsv, and its files in the tree."""

    def __init__(self, row, root, builder, progress):
        self.stem, self.root, self.builder, self.progress = row["stem"], root, builder, progress
        self.source = root / "src" / "features" / f"{self.stem}.c"
        self.points = root / "assignments" / row["folder"] / "points.tsv"
        self.mutants_file = root / "tests" / "mutants" / f"{self.stem}.mutants"
        self.needs = f"{row['needs']} {row['uses']}".split()  # here all are the kit's
        self.faults, self.notes = [], []
        self.most = 0  # mutants; 0: all

    def prepare(self):
        """Builds the objects common to all programs, and the reference; finds the tests' names."""
        self.common = self.compile_common("", [])
        self.reference = self.program(self.source, "reference", f"{self.stem}'s reference",
                                      ["-w"])
        self.check_rules("reference")
        self.tests = list_tests(self.reference)
        self.inputs = self.find_inputs() if self.builder.store.folder else None

    def find_inputs(self):
        """Returns the digest of what decides this feature's verdicts but the unit's text."""
        digest = self.builder.inputs(self.root)
        sources = [self.root / "tests" / f"test_{self.stem}.c", self.source]
        sources += [self.root / "src" / "features" / f"{stem}.c" for stem in self.needs]
        for source in sources:
            verdict_store.add_includes(digest, self.builder.compiler, source, self.root)
        verdict_store.add_shared_libraries(digest, self.reference)
        return digest

    def verdict_of(self, mutant, text):
        """Returns the digest of what decides whether this mutant is killed; None where it includes other
        files."""
        if not self.inputs or includes_of(text) != includes_of(self.source.read_text(encoding="utf-8")):
            return None
        digest = self.inputs.copy()
        digest.add("unit", text)
        digest.add("fails", " ".join(mutant.fails))
        if mutant.says:
            digest.add("says", mutant.says)
            digest.add_file("points", self.points)
        return digest

    def compile_common(self, suffix, flags):
        sources = [self.root / "tests" / f"test_{self.stem}.c"]
        sources += [self.root / "src" / "features" / f"{stem}.c" for stem in self.needs]
        return [self.builder.compile(source, f"{self.stem}-{source.stem}{suffix}", flags, source)
                for source in sources]

    def program(self, source, name, what, flags, link_flags=(), common=None):
        name = f"{self.stem}-{name}"
        unit = self.builder.compile(source, name, flags, what)
        return self.builder.link([unit, *(common or self.common)], name, link_flags, what)

    def scored(self, starter):
        """Returns the tests that carry points; without a table those that the starter fails."""
        if not self.points.exists():
            self.notes.append(f"there is no {self.points.relative_to(self.root)}; so every test "
                              "that the starter fails counts as scored")
            return [test for test in self.tests if starter[test] != 0]
        name = self.points.relative_to(self.root)
        rows = read_table(self.points)
        listed = [row.get("test") for row in rows]
        for test in dict.fromkeys(listed):
            if test not in self.tests:
                self.faults.append(f"{name}: the suite has no test {test}; correct its name")
            if listed.count(test) > 1:
                self.faults.append(f"{name}: {test} has two lines; remove one")
        for test in self.tests:
            if test not in listed:
                self.faults.append(f"{name}: {test} has no line; "
                                   "give it one, with 0 points if the starter passes it")
        return [test for test in _with_points(rows) if test in self.tests]

    # --- jobs: each may raise a Fault

    def check_handout(self):
        """The handout's steps are those of the table used for grading, which lists them in order."""
        handout = self.points.with_name("handout.md")
        if not self.points.exists() or not handout.exists():
            return
        rows = re.findall(r"^\| (\d+) \|(.*)$", handout.read_text(encoding="utf-8"), re.MULTILINE)
        told = [int(number) for number, cells in rows if "{tests}" in cells]
        numbers = [int(number) for number, cells in rows]
        feature = assignments.read_features(str(self.root))[self.stem]
        looks = [look.step for look in assignments.read_looks(feature)]
        tests = [test for test in assignments.read_points(feature) if test.points]
        steps = list(dict.fromkeys(test.step for test in tests))
        handout, points = (path.relative_to(self.root) for path in (handout, self.points))
        faults = [f"{points}: {after.name} of step {after.step} stands below {before.name} of step "
                  f"{before.step}; order them by steps"
                  for before, after in zip(tests, tests[1:]) if after.step < before.step]
        faults += [f"{handout}: no step {step} with {{tests}}, which {points} names"
                   for step in steps if step not in told]
        faults += [f"{handout}: step {step} has {{tests}}, but none in {points}"
                   for step in told if step not in steps]
        faults += [f"{points}: {test.name} is green since step {test.green_since}, which is not before step "
                   f"{test.step}" for test in tests if test.green_since >= test.step]
        named = {int(number): {section.strip() for section in cells.split("|")[1].split(",")}
                 for number, cells in rows}

        def named_until(step):
            return set().union(*(named[number] for number in named if number <= step))

        faults += [f"{points}: {test.name} of step {test.step} names the section {test.section}, "
                   f"which {handout} names for no step up to that one"
                   for test in tests if test.section[1:] not in named_until(test.step)]
        faults += [f"{handout}: step {number} has no {{look}}"
                   for number, cells in rows if "{look}" not in cells]
        if looks[-1:] != numbers[-1:]:
            faults.append(f"{handout}: look.tsv beside it ends with step {looks[-1]}; "
                          "the last thing to do in an assignment is to draw its picture")
        if faults:
            raise Fault("\n".join(faults))

    def check_order(self):
        faults = reading_order.find_faults(self.root, self.stem, self.points.parent.name)
        if faults:
            raise Fault("\n".join(faults))

    def check_reference(self, test):
        status, said = run_test(self.reference, test)
        if status != 0:
            raise Fault(f"the reference fails {test}; one of them is wrong:\n{said}")

    def check_rules(self, whose):
        """The rules for students' units hold for the reference and the starter, too."""
        objdump = os.environ["RAYKIT_OBJDUMP"]

        def look_at(name):
            return unit_rules.Object(objdump, self.builder.folder / f"{self.stem}-{name}.o")

        obj, kit = look_at(whose), set(unit_rules.pure_names(objdump, "librkbase.a"))
        for stem in self.needs:
            kit |= {name for *_, name in look_at(stem).symbols}
        faults = [unit_rules.fault_in_object(obj, False), unit_rules.fault_in_names(obj, kit)]
        faults += [f"keeps `{name}` from call to call; make it local, or const"
                   for name in unit_rules.kept_data(obj)]
        self.faults += [f"the {whose} {fault}" for fault in faults if fault]

    def check_starter(self):
        text = self.builder.folder / f"{self.stem}-starter.c"
        text.write_text(starters.starter_of(self.source), encoding="utf-8")
        plain = self.program(text, "starter", "the starter", ["-Werror"])
        self.check_rules("starter")
        status = {test: run_test(plain, test)[0] for test in self.tests}
        scored = self.scored(status)
        lucky = [test for test in scored if status[test] == 0]
        if lucky:
            self.faults.append(f"the starter passes tests that carry points: {' '.join(lucky)}; sharpen "
                               "these tests, or give them 0 in points.tsv")
        worthless = [test for test in self.tests if test not in scored and status[test] != 0]
        if worthless:
            self.faults.append(f"the starter fails tests that carry no points: {' '.join(worthless)}; "
                               "give these tests some in points.tsv")
        self.check_safety(text, status)

    def check_safety(self, text, status):
        """A test that fails leaves its meshes behind, so leaks count in those that pass."""
        common = self.compile_common("-sanitized", SANITIZE) + self.sanitized_base.result()
        program = self.program(text, "starter-sanitized", "the starter with sanitizers", SANITIZE,
                               SANITIZE, common)
        for test in self.tests:
            environment = dict(SANITIZER_ENVIRONMENT)
            environment["ASAN_OPTIONS"] += f":detect_leaks={0 if status[test] else 1}"
            got, said = run_test(program, test, environment)
            if got not in (0, 1) or (got == 0) != (status[test] == 0):
                self.faults.append(f"the starter does not run {test} safely (status {got} with "
                                   f"sanitizers, {status[test]} without):\n{said}")

    def unit_of_step(self, step, decides):
        """Returns the program of the unit as it is after a step, see solved_until()."""
        name = f"step-{step}-{decides.__name__}"
        text = self.builder.folder / f"{self.stem}-{name}.c"
        text.write_text(starters.solved_until(self.source, step, decides), encoding="utf-8")
        return self.program(text, name, f"{self.stem}'s reference up to step {step}", QUICKLY)

    def check_step(self, step):
        """Each test is green after its step, and no sooner than points.tsv says."""
        verdict = self.verdict_of_step(step)
        if verdict and self.builder.store.has(verdict):
            return
        reached = [test for test in self.listed if test.points and (test.green_since or test.step) <= step]
        following = [test for test in self.listed if test.step == step + 1 and not test.green_since]
        most, least = self.unit_of_step(step, min), self.unit_of_step(step, max)
        faults = [f"{test.name} of step {test.step} fails after step {step}, though it should be green since "
                  f"step {test.green_since or test.step}; correct the step"
                  for test in reached if run_test(most, test.name)[0] != 0]
        faults += [f"{test.name} of step {test.step} passes after step {step}; say since when it is green"
                   for test in following if run_test(least, test.name)[0] == 0]
        if faults:
            raise Fault("\n".join(f"{self.points.relative_to(self.root)}: {fault}" for fault in faults))
        if verdict:
            self.builder.store.keep(verdict)

    def verdict_of_step(self, step):
        """Returns the digest of what decides whether the tests of a step are green when they should be."""
        if not self.inputs:
            return None
        digest = self.inputs.copy()
        digest.add("step", str(step))
        digest.add_file("unit", self.source)
        digest.add_file("points", self.points)
        return digest

    def check_mutant(self, mutant):
        for test in mutant.fails:
            if test not in self.tests:
                raise Fault(f"{mutant.file}:{mutant.fails_line}: the suite has no test {test}; "
                            "correct its name")
        unit = mutate(mutant, self.source.read_text(encoding="utf-8"), self.source.relative_to(self.root))
        verdict = self.verdict_of(mutant, unit)
        if verdict and self.builder.store.has(verdict):
            return
        text = self.builder.folder / f"{self.stem}-{mutant.name}.c"
        text.write_text(unit, encoding="utf-8")
        name = f"{mutant.file}:{mutant.line}: {mutant.name}"
        program = self.program(text, mutant.name, f"the mutant {name}", QUICKLY)
        survived = [test for test in mutant.fails if run_test(program, test)[0] == 0]
        if survived:
            raise Fault(f"{name} survives {' '.join(survived)}; "
                        "sharpen the test, or name another that fails for a good reason")
        if mutant.says:
            self.check_message(program, mutant, name)
        if verdict:
            self.builder.store.keep(verdict)

    def check_message(self, program, mutant, name):
        """What a student reads first names the mistake."""
        order = [row["test"] for row in read_table(self.points)]
        test, said = next((test, said) for test in order
                          for status, said in [run_test(program, test)] if status != 0)
        if mutant.says not in " ".join(said.split()):
            raise Fault(f"{name}: {test}, which fails first, should say \"{mutant.says}\", but says:\n{said}")

    def read_mutants(self):
        """Returns the feature's mutants; none if one of them is not written as it should be."""
        name = self.mutants_file.relative_to(self.root)
        try:
            mutants = read_mutants(self.mutants_file, name)
        except MutantError as fault:
            self.faults.append(str(fault))
            return []
        except FileNotFoundError:
            mutants = []
        if len(mutants) < FEWEST_MUTANTS:
            self.faults.append(f"{name} has {len(mutants)} mutants; "
                               f"a suite is tried with {FEWEST_MUTANTS} at least")
        return mutants

    def jobs(self):
        """Returns the functions that check this feature, in any order and at once."""
        self.known = self.read_mutants()
        self.mutants, self.listed = spread(self.known, self.most), []
        if self.points.exists():
            self.listed = assignments.read_points(assignments.read_features(str(self.root))[self.stem])
        jobs = [self.check_starter, self.check_handout, self.check_order]
        jobs += [lambda mutant=mutant: self.check_mutant(mutant) for mutant in self.mutants]
        jobs += [lambda step=step: self.check_step(step)
                 for step in range(1, max((test.step for test in self.listed), default=0))]
        jobs += [lambda test=test: self.check_reference(test) for test in self.tests]
        self.progress.add(len(jobs), 0)
        return jobs

    def run(self, job):
        """Returns whether the job found nothing wrong."""
        try:
            job()
            return True
        except (Fault, MutantError, OSError, starters.RegionError) as fault:
            self.faults.append(str(fault))
            return False
        finally:
            self.progress.add(0, 1)

    def report(self):
        for line in self.notes + self.faults:
            print(f"{self.stem}: {line}")
        verdict = f"faults: {len(self.faults)}" if self.faults else "ok"
        left = len(self.known) - len(self.mutants)
        print(f"{self.stem}: {len(self.tests)} tests, {self.killed} of {len(self.mutants)} mutants "
              f"killed{f', {left} not tried' if left else ''}: {verdict}")


def check(features, progress):
    """Checks all features on all processors."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        base = None
        for feature in features:
            feature.prepare()
            base = base or pool.submit(feature.builder.compile_base_sanitized, feature.root)
            feature.sanitized_base = base
            jobs = feature.jobs()
            feature.results = [pool.submit(feature.run, job) for job in jobs]
    progress.clear()
    for feature in features:
        sound = [result.result() for result in feature.results]
        feature.killed = sum(sound[3 : 3 + len(feature.mutants)])
        feature.report()


def main():
    parser = argparse.ArgumentParser(
        prog="make check-suites", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__)
    parser.add_argument("stems", nargs="*", metavar="STEM", help="only these features")
    parser.add_argument("--mutants", type=int, default=0, metavar="N", help="of each feature; all without it")
    arguments = parser.parse_args()
    stems = arguments.stems
    root = pathlib.Path(__file__).resolve().parent.parent
    rows = read_table(root / "assignments" / "features.tsv")
    known = [row["stem"] for row in rows]
    unknown = [stem for stem in stems if stem not in known]
    if unknown or "RAYKIT_COMPILE" not in os.environ:
        print(f"check_suites: there is no feature \"{unknown[0]}\"; choose of: {' '.join(known)}"
              if unknown else "check_suites: start it by make check-suites, which knows the "
              "compiler", file=sys.stderr)
        return 2
    progress = Progress()
    with tempfile.TemporaryDirectory(prefix="check-suites-") as folder:
        store = verdict_store.Store(os.environ.get("RAYKIT_VERDICTS", ""), bool(os.environ.get("FRESH")))
        builder = Builder(pathlib.Path(folder), store)
        features = [Feature(row, root, builder, progress) for row in rows
                    if not stems or row["stem"] in stems]
        for feature in features:
            feature.most = arguments.mutants
        try:
            check(features, progress)
        except Fault as fault:
            progress.clear()
            print(f"check_suites: {fault}", file=sys.stderr)
            return 1
    killed = sum(feature.killed for feature in features)
    faults = sum(len(feature.faults) for feature in features)
    known = f", {store.found} of them by the store" if store.found else ""
    print(f"{killed} mutants killed{known}" + (f"; faults: {faults}" if faults else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
