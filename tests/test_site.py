#!/usr/bin/env python3
"""The suites in a page: compiled and run as WebAssembly, by a clang that is WebAssembly itself, they pass
with the kit's units, and say of starters and of known mistakes what the native suites say under sanitizers.
Speaks TAP, for make check-site; runs in a build folder that has site/. RAYKIT_MUTANTS is how many mistakes
of each suite are made, "all" or a number; FEATURES names the suites."""

import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(os.environ.get("srcdir", ".")).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "tools"))

import check_suites  # noqa: E402
from grading.mutants import mutate  # noqa: E402
from grading.processor_time import limited  # noqa: E402
from grading.starters import starter_of  # noqa: E402
from grading.verdict_store import Store  # noqa: E402
from tap import check, finish, start  # noqa: E402

_SECRET = b"0" * 64  # asks for no decoy


def checked(units, first=False, seconds=60):
    """Returns what tools/site/claims.mjs says of units, (stem, file), in their order."""
    command = [os.environ["RAYKIT_NODE"], SOURCE / "tools/site/claims.mjs", "--site", "site", "--json",
               "--seconds", str(seconds), *(["--first"] if first else []),
               *(f"{stem}={file}" for stem, file in units)]
    answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    results = [json.loads(line) for line in answer.stdout.splitlines()]
    if len(results) != len(units):
        sys.exit(f"tools/site/claims.mjs ended after {len(results)} of {len(units)} units; it says above why")
    return results


def attested(program, test):
    """Returns a native claim's verdict and message; of a crash, and of what sanitizers report, "fault"."""
    ours, theirs = socket.socketpair()
    ours.send(_SECRET)
    environment = dict(os.environ, **check_suites.SANITIZER_ENVIRONMENT, RAYKIT_ATTEST=str(theirs.fileno()))
    environment["ASAN_OPTIONS"] += ":detect_leaks=0"
    with ours, theirs:
        done = subprocess.run(limited([program, "--only", test], check_suites.SECONDS), env=environment,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              pass_fds=[theirs.fileno()], text=True, errors="replace", check=False)
        theirs.close()
        said = b"".join(iter(lambda: ours.recv(4096), b"")).decode(errors="replace")
    if done.returncode == 0:
        return "passed", ""
    place, _, message = said.partition("\n")
    is_told = done.returncode == 1 and place and message != "failed"
    return ("failed", message) if is_told else ("fault", done.stdout)


# What C does not define, as the first function of `normals`, with what is told of it.
_FAULTS = {
    "float *volatile p = malloc(12); p[0] = n.x; float y = p[3]; free(p); return rk_vec(y, 0, 0);":
        "reads 4 bytes of memory that is not its own: 12 bytes after the beginning of a block of 12 bytes",
    "float *volatile p = malloc(12); p[-1] = n.x; free(p); return n;":
        "writes 4 bytes of memory that is not its own: 4 bytes before a block of 12 bytes",
    "float *volatile p = malloc(12); p[0] = n.x; free(p); return rk_vec(p[0], 0, 0);":
        "reads 4 bytes of memory that is not its own: in a block of 12 bytes that is freed already",
    "float *volatile p = malloc(12); p[0] = n.x; free(p); free(p); return n;":
        "free is called for memory that is freed already, or that malloc did not return",
    "const float *volatile p = NULL; return rk_vec(*p, n.x, 0);": "a pointer that is NULL is used",
    "float p[5] = {n.x}; float *volatile q = p; q[5] = 1; return rk_vec(p[2], 0, 0);":
        "writes 4 bytes of memory that is not its own: beside a variable",
    "float p[3] = {n.x, n.y, n.z}; volatile int i = 3; return rk_vec(p[i], 0, 0);":
        "an index is outside of its array",
    "volatile int big = 0x7fffffff; return rk_vec((float)(big + 1), 0, 0);":
        "the sum of two integers is beyond their type's range",
    "volatile int none = 0; return rk_vec((float)(1 / none), 0, 0);":
        "an integer is divided by 0, or the quotient is beyond its type's range",
    "volatile float p[64]; p[0] = n.x; rk_vec3 m = rk_normals_colour(n); return rk_vec(p[0], m.y, 0);":
        "the stack is used up",
    "volatile float none = n.x; while (none < 9) ; return n;": "no verdict after 2 s",
}


def check_faults(folder):
    reference = (SOURCE / "src/features/normals.c").read_text(encoding="utf-8")
    rest = reference[reference.index("rk_vec3 rk_normals_of_triangle"):]
    files = []
    for number, body in enumerate(_FAULTS):
        files.append(os.path.join(folder, f"fault-{number}.c"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write('#include "features/normals.h"\n#include <stdlib.h>\n'
                       f"rk_vec3 rk_normals_colour(rk_vec3 n)\n{{\n    {body}\n}}\n{rest}")
    results = checked([("normals", file) for file in files], first=True, seconds=2)
    for (body, said), result in zip(_FAULTS.items(), results):
        first = next(iter(result["verdicts"]), {})
        place = "" if "while" in body else "normals.c:5"
        check(said in first.get("message", "") and place == first.get("place"), f"a page tells: {said}",
              [body, result["said"], first])


class Suite(check_suites.Feature):
    """A suite, native with sanitizers."""

    def prepare(self):
        self.common = self.compile_common("", check_suites.SANITIZE) + [self.counting]

    def first(self, unit, name, claims):
        """Returns the first claim that a unit does not pass, with its verdict and its message."""
        program = self.program(unit, name, name, ["-w", *check_suites.SANITIZE], check_suites.SANITIZE)
        for claim in claims:
            verdict, message = attested(program, claim)
            if verdict != "passed":
                return claim, verdict, message
        return "", "passed", ""


def first_of(result):
    """The same in the page."""
    for verdict in result["verdicts"]:
        if verdict["verdict"] != "passed":
            return verdict["claim"], verdict["verdict"], verdict["message"]
    return "", "passed" if result["verdicts"] else result["said"], ""


def same(native, page):
    """Faults have other words: a page has no addresses."""
    return native[:2] == page[:2] and (native[1] == "fault" or native[2] == page[2])


def mistakes_of(suite, wanted):
    """Returns the mutants that are made, spread over all of them."""
    mutants = suite.read_mutants()
    count = len(mutants) if wanted == "all" else min(int(wanted), len(mutants))
    return [mutants[i * len(mutants) // count] for i in range(count)]


def check_suite(suite, claims, wanted):
    units = {"starter": starter_of(suite.source)}
    for mutant in mistakes_of(suite, wanted):
        units[mutant.name] = mutate(mutant, suite.source.read_text(encoding="utf-8"), suite.source.name)
    files = {name: suite.builder.folder / f"{suite.stem}-{name}.c" for name in units}
    for name, text in units.items():
        files[name].write_text(text, encoding="utf-8")
    suite.prepare()
    differ = []
    for name, result in zip(files, checked([(suite.stem, file) for file in files.values()], first=True)):
        native, page = suite.first(files[name], name, claims), first_of(result)
        if not same(native, page):
            differ += [f"{name}: natively {native}", f"    in the page {page}"]
    check(not differ, f"{suite.stem}: the starter and {len(units) - 1} known mistakes fail the same claim "
          "first, with the same message", differ)


def main():
    if not os.environ.get("RAYKIT_SITE"):
        print("1..0 # SKIP @yowasp/clang or node is missing: ./bootstrap --site")
        return 0
    with open(os.environ["RAYKIT_SITE"], encoding="utf-8") as file:
        suites = json.load(file)
    rows = check_suites.read_table(SOURCE / "assignments" / "features.tsv")
    wanted = os.environ.get("FEATURES", "").split() or list(suites)
    for stem in wanted:
        result, = checked([(stem, SOURCE / "src/features" / f"{stem}.c")])
        broken = [verdict for verdict in result["verdicts"] if verdict["verdict"] != "passed"]
        count = len(suites[stem])
        check(len(result["verdicts"]) == count and not broken and not result["said"],
              f"{stem}: the kit's unit compiles without a warning and passes all {count} claims in a page",
              [result["said"], *broken])
    with tempfile.TemporaryDirectory(prefix="raykit-site-") as folder:
        check_faults(folder)
        builder = check_suites.Builder(pathlib.Path(folder), Store("", False))
        counting = builder.compile(SOURCE / "tests/count_allocations.c", "counting", check_suites.SANITIZE,
                                   "what counts allocations")
        for row in rows:
            if row["stem"] in wanted:
                suite = Suite(row, SOURCE, builder, None)
                suite.counting = counting
                check_suite(suite, [claim["name"] for claim in suites[row["stem"]]],
                            os.environ.get("RAYKIT_MUTANTS") or "2")
    return finish()


start(main)
