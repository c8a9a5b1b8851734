#!/usr/bin/env python3
"""The store of killed mutants: whatever decides a verdict changes its digest, and nothing else does; what is
known is not compiled again. A small kit with one feature takes the place of the whole. Speaks TAP, for make
check-suites."""

import os
import pathlib
import shutil
import sys
import tempfile
from unittest import mock

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

import check_suites  # noqa: E402
from grading import verdict_store  # noqa: E402
from tap import check, finish, start  # noqa: E402

UNIT = '#include "features/fog.h"\n\nint fog_at(int t)\n{\n    return t * 2 + base_of(t);\n}\n'
SUITE = """#include "features/fog.h"
#include "suite.h"
#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    if (argc == 2) { puts("doubles"); return 0; }
    if (argc != 3 || fog_at(3) == EXPECTED)
        return 0;
    puts("got 9, want 6");
    return 1;
}
"""
FILES = {"src/features/fog.c": UNIT, "src/features/fog.h": "int fog_at(int t);\nint base_of(int t);\n",
         "src/features/mist.c": "int mist;\n", "tests/test_fog.c": SUITE,
         "tests/suite.h": "#define EXPECTED 6\n",
         "tools/check_suites.py": "# the tool\n", "tools/grading/build.py": "# a part of it\n",
         "base.c": "int base_of(int t);\nint base_of(int t) { return 0 * t; }\n"}
MUTANTS = "mutant triples\nmistake: One.\nfails: doubles\nin fog_at\n- t * 2\n+ t * 3\n"
ROW = {"stem": "fog", "folder": "01_fog", "needs": "mist", "uses": ""}


def put(root, path, text):
    path = root / path
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def make_kit(root):
    for path, text in FILES.items():
        put(root, path, text)
    put(root, "cc", "#!/bin/sh\nexec gcc \"$@\"\n")
    (root / "cc").chmod(0o755)
    build_base(root)


def build_base(root):
    os.system(f"cd '{root}' && gcc -g -c base.c -o base.o && rm -f base.a && ar crD base.a base.o")


def feature_of(root, store):
    """The feature, ready for its jobs; the suite runs as in the kit."""
    environment = {"RAYKIT_COMPILE": f"{root}/cc -I{root}/src -I{root}/tests {os.environ.get('MORE', '')}",
                   "RAYKIT_LINK": "gcc", "RAYKIT_LIBS": "base.a", "RAYKIT_OBJDUMP": "objdump"}
    os.chdir(root)
    with mock.patch.dict(os.environ, environment):
        folder = root / "out"
        folder.mkdir(exist_ok=True)
        builder = check_suites.Builder(folder, store)
        feature = check_suites.Feature(ROW, root, builder, check_suites.Progress())
        with mock.patch.object(feature, "check_rules"):
            feature.prepare()
        return feature


def digest_of(root):
    feature = feature_of(root, verdict_store.Store(root / "store"))
    return feature.inputs.text()


def every_input_is_seen(root):
    first = digest_of(root)
    check(first == digest_of(root), "the same inputs have the same digest")
    for path in ("src/features/fog.c", "src/features/fog.h", "src/features/mist.c", "tests/test_fog.c",
                 "tests/suite.h",
                 "tools/check_suites.py", "tools/grading/build.py"):
        text = (root / path).read_text(encoding="utf-8")
        put(root, path, text + ("# other\n" if path.endswith(".py") else "/* other */\n"))
        check(digest_of(root) != first, f"a change of {path} is seen")
        put(root, path, text)
    put(root, "base.c", FILES["base.c"].replace("0 * t", "1 * t - t + (t > 1000)"))
    build_base(root)
    check(digest_of(root) != first, "a change of the library's code is seen")
    put(root, "base.c", FILES["base.c"])
    build_base(root)
    check(digest_of(root) == first, "what is put back has the digest that it had")
    for name, value in (("MORE", "-DMORE"), ("RAYKIT_ISA", "scalar"), ("LD_BIND_NOW", "1")):
        with mock.patch.dict(os.environ, {name: value}):
            check(digest_of(root) != first, f"{'a flag' if name == 'MORE' else name} is seen")
    put(root, "cc", "#!/bin/sh\n[ \"$1\" != --version ] || echo another\nexec gcc \"$@\"\n")
    check(digest_of(root) != first, "another compiler is seen")
    put(root, "cc", "#!/bin/sh\nexec gcc \"$@\"\n")
    return first


def verdicts_are_kept(root):
    mutant = check_suites.read_mutants(root / "fog.mutants", "fog.mutants")[0]
    store = verdict_store.Store(root / "store")
    feature = feature_of(root, store)
    feature.check_mutant(mutant)
    check(store.found == 0, "a mutant that is new is killed")
    with mock.patch.object(feature, "program", side_effect=AssertionError):
        feature.check_mutant(mutant)
    check(store.found == 1, "one that is known is not compiled again")
    fresh = feature_of(root, verdict_store.Store(root / "store", is_fresh=True))
    fresh.check_mutant(mutant)
    check(fresh.builder.store.found == 0, "unless all is wanted fresh")
    found = feature.verdict_of(mutant, UNIT), feature.verdict_of(mutant._replace(fails=["doubles"] * 2), UNIT)
    check(found[0].text() != found[1].text(), "another list of claims is another question")
    more = feature.verdict_of(mutant, UNIT + "#include \"other.h\"\n")
    check(more is None, "nothing is kept of one that includes more")
    put(root, "tests/suite.h", "#define EXPECTED 9\n")
    blunt = feature_of(root, store)
    for _ in range(2):
        try:
            blunt.check_mutant(mutant)
            check(False, "a survivor is told each time")
        except check_suites.Fault as fault:
            check("survives" in str(fault), "a survivor is told each time", fault)


def some_mutants_are_spread():
    check(check_suites.spread(list(range(10)), 4) == [0, 2, 5, 7],
          "a quick look takes mutants from the whole file")
    check(check_suites.spread([1, 2], 4) == [1, 2] == check_suites.spread([1, 2], 0)
          and not check_suites.spread([], 4),
          "and all where there are no more, or no number is said")


def messages_are_compared(root):
    put(root, "tests/suite.h", FILES["tests/suite.h"])
    put(root, "assignments/01_fog/points.tsv", "test\tpoints\ndoubles\t100\n")
    mutant = check_suites.read_mutants(root / "fog.mutants", "fog.mutants")[0]
    store = verdict_store.Store(root / "store", is_fresh=True)
    feature_of(root, store).check_mutant(mutant._replace(says="got 9"))
    check(True, "a mutant whose first message says what it should is killed")
    feature = feature_of(root, store)
    try:
        feature.check_mutant(mutant._replace(says="half the wanted"))
        check(False, "another message is told")
    except check_suites.Fault as fault:
        check("should say \"half the wanted\", but says:\ngot 9" in str(fault),
              "another message is told", fault)
    found = [feature.verdict_of(mutant._replace(says=says), UNIT).text() for says in (None, "got 9", "half")]
    check(len(set(found)) == 3, "another message is another question", found)


def main():
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder).resolve() / "kit-1"
        make_kit(root)
        first = every_input_is_seen(root)
        put(root, "fog.mutants", MUTANTS)
        verdicts_are_kept(root)
        some_mutants_are_spread()
        messages_are_compared(root)
        moved = root.with_name("kit-2")
        os.chdir(here)
        shutil.rmtree(root)
        make_kit(moved)
        check(digest_of(moved) == first, "the folder's name decides nothing")
        os.chdir(here)
    return finish()


if __name__ == "__main__":
    start(main)
