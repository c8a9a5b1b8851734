#!/usr/bin/env python3
"""Units in a process of their own: the same verdicts as beside their suite, and nothing to earn but by right
answers. Speaks TAP, for make check-judge; runs in a build folder."""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from unittest import mock

SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), ".."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from by_address import by_address  # noqa: E402
from tap import check, finish, read, start  # noqa: E402
from grading import build, bubblewrap, judged, sandbox  # noqa: E402
from grading.assignments import KEEPS_NOTHING, read_features  # noqa: E402
from grading.starters import starter_of  # noqa: E402
import grade  # noqa: E402
import judge_calls  # noqa: E402

FEATURES = read_features(SOURCE)
APART = [stem for stem in FEATURES
         if os.path.exists(os.path.join(SOURCE, "tests", "judge", stem + ".calls"))]
FIRST_AHEAD = int(re.search(r"DIRECT_FIRST = (\d+)", read(SOURCE, "tests", "judge", "judge.c"))[1])
CALLED = "rk_vec3 rk_normals_colour(rk_vec3 n)\n{\n"  # by every second claim of normals


def text_of(stem):
    with open(FEATURES[stem].reference, encoding="utf-8") as file:
        return file.read()


class Grader:
    """Grades texts of units in the sandbox, apart from their suites or not."""

    def __init__(self, folder):
        self._folder = folder

    def verdicts(self, stem, text, apart, only=None, enclosed=True):
        """Returns passed and reason of each claim by its name, of all or only some, and the points."""
        toolchain = build.Toolchain(".")
        toolchain.sandbox = bubblewrap.find(toolchain)[0] if enclosed else None
        toolchain.judges = apart
        path = os.path.join(tempfile.mkdtemp(dir=self._folder), stem + ".c")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        suites = grade.prepare_suites(FEATURES, [FEATURES[stem]], path, False, None)
        suites[0].tests = [test for test in suites[0].tests if only is None or test.name in only]
        suites[0].take(grade._grade_here(toolchain, FEATURES, suites, path, 0)[0])
        return ({test.name: (suites[0].verdicts[test.name].passed, suites[0].verdicts[test.name].reason)
                 for test in suites[0].tests}, suites[0].points())


def every_suite_can_be_judged_apart_or_says_why():
    toolchain, count, worth = build.Toolchain("."), 0, 0
    for stem in APART:
        check(judged.is_possible(toolchain, stem), f"{stem} has a judge", "make judges-ready makes it")
        points = {test.name: test.points for test in grade.read_points(FEATURES[stem])}
        together = judged.claims_together(toolchain, stem)
        unknown = [name for name in together if name not in points]
        check(not unknown, f"{stem}: what its judge leaves out are claims", str(unknown))
        count, worth = count + len(together), worth + sum(points.get(name, 0) for name in together)
    told = f"{count} claims, worth {worth} of {100 * len(FEATURES):,} points"
    check(told in read(SOURCE, "docs", "tools.md")
          and f"of {count} claims" in read(SOURCE, "docs", "teaching.md"),
          "the texts say how many claims are not judged apart", told)


def _traced(stem, test, folder, disturbed, seed=""):
    """Returns count and hash of the requests of each function that the test asks."""
    path = os.path.join(folder, "trace")
    environment = {**os.environ, "RAYKIT_TRACE": path, "RAYKIT_DISTURB": str(disturbed), "RAYKIT_SEED": seed}
    ended = subprocess.run([f"impl/judge/{stem}-trace", "--only", test], env=environment, check=False,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if not os.path.exists(path):
        return None, ended.returncode
    with open(path, encoding="ascii") as file:
        lines = [line.split() for line in file]
    os.remove(path)
    return {int(function): (int(count), hash_) for function, count, hash_ in lines}, 0


def requests_tell_no_answers(folder):
    """What is published ahead is the same if the answers are others: those that its line does not name."""
    for stem in APART:
        headers = judge_calls.headers_of(SOURCE, stem)
        differ = []
        for test in (test.name for test in grade.read_points(FEATURES[stem])):
            if test in judged.claims_together(build.Toolchain("."), stem):
                continue
            right, _ = _traced(stem, test, folder, 0)
            ahead = {function: headers.after(function) for function, (_, claims) in headers.ahead.items()
                     if function in right and test not in claims}
            if sum(count for count, _ in right.values()) < FIRST_AHEAD:
                continue
            for after in set(ahead.values()):
                other, status = _traced(stem, test, folder, ~after & (1 << 64) - 1)
                differ += [(test, headers.functions[function][1], status) for function in ahead
                           if ahead[function] == after and (other or {}).get(function) != right[function]]
        check(not differ, f"{stem}: no answer can be read in a request that is published ahead", str(differ))


def another_seed_asks_other_things(folder):
    for stem in APART:
        together = judged.claims_together(build.Toolchain("."), stem)
        tests = [test.name for test in grade.read_points(FEATURES[stem]) if test.name not in together]
        others = (test for test in tests
                  if _traced(stem, test, folder, 0) != _traced(stem, test, folder, 0, "7"))
        check(next(others, None), f"{stem}: SEED=7 draws other random cases")


def units_without_functions_earn_nothing(grader):
    for stem in APART:
        verdicts, points = grader.verdicts(stem, "typedef int nothing;\n", True)
        check(points == 0 and all("your file does not define" in reason for _, reason in verdicts.values()),
              f"{stem}: a file without functions earns nothing", f"{points} {verdicts}")
    weak = text_of("watertight").replace("\nrk_hit rk_watertight_intersect(",
                                         "\n__attribute__((weak)) rk_hit rk_watertight_intersect(")
    verdicts, points = grader.verdicts("watertight", weak, True)
    check(points == 0 and all("rk_watertight_intersect as weak" in reason for _, reason in verdicts.values()),
          "neither does one whose definitions give way to the kit's", f"{points} {verdicts}")


def right_units_pass_apart(grader):
    for stem in APART:
        verdicts, points = grader.verdicts(stem, text_of(stem), True)
        failed = {name: reason for name, (passed, reason) in verdicts.items() if not passed}
        check(not failed and points == 100, f"the right {stem} has 100 points", str(failed))


# Of each kind of call one: values, arrays, structures that are changed.
WRONG = {
    "normals": ("rk_normals_colour", "return", "n = (rk_vec3){n.y, n.x, n.z};\n    return"),
    "transparency": ("rk_transparency_weights", "transmitted *= 1 - crossings[k].alpha;",
                     "transmitted *= k < 3 ? 1 - crossings[k].alpha : 0.999f;"),
    "depth_of_field": ("rk_lens_ray", "0.5f * diameter_of(lens)", "diameter_of(lens)"),
}


def starters_and_mistakes_get_the_same_verdicts(grader):
    for stem, (function, old, new) in WRONG.items():
        text = text_of(stem)
        at = text.index(old, text.index(f" {function}("))
        wrong = text[:at] + new + text[at + len(old):]
        for what, unit in (("starter", starter_of(FEATURES[stem].reference)), ("mistake", wrong)):
            apart, together = (grader.verdicts(stem, unit, where) for where in (True, False))
            differ = {name: (apart[0][name], together[0][name]) for name in apart[0]
                      if apart[0][name] != together[0][name]}
            check(not differ and apart[1] == together[1] < 100,
                  f"{stem}: a {what} has the same verdicts, reasons and points",
                  f"{differ} {apart[1]} {together[1]}")


def a_judge_speculates_until_an_answer_is_another_one(grader):
    """A claim with 884,736 calls in some 8 laps, of which the first 200 are made one by one."""
    claim, text = "normalized_highlights_never_reflect_more_light_than_arrives", text_of("shading")
    begin = re.search(r"rk_vec3 rk_shade\([^)]*\)\n\{\n", text)[0]
    names = ", ".join(re.findall(r"(\w+)(?=[,)])", begin))
    text = text.replace(begin, "static " + begin.replace("rk_shade", "shade"))
    for nth, what in ((100, "before"), (1000, "in the first lap of"), (123456, "in the second lap of"),
                      (884736, "at the end of")):
        for change, passes in (("colour.x = NAN", False), ("colour.x = nextafterf(colour.x, 2)", True)):
            unit = (f"{text}\nstatic int calls;\n{begin}    rk_vec3 colour = shade({names});\n"
                    f"    if (++calls == {nth})\n        {change};\n    return colour;\n}}\n")
            passed, reason = grader.verdicts("shading", unit, True, [claim])[0][claim]
            check(passed == passes and "compile" not in reason,
                  f"an answer {what} a speculation that is {'rounded otherwise' if passes else 'wrong'} "
                  f"{'passes' if passes else 'fails'}", reason)


# Each begins a function of the starter, which goes on as it is. FIND gets the addresses of both memories, as
# an attacker may read them: from the system's list.
FIND = """
static unsigned char *memory_of(const char *what)
{
    static char text[1 << 16];
    int file = open("/proc/self/maps", 0);
    long size = 0, more;
    while ((more = read(file, text + size, sizeof text - 1 - size)) > 0)
        size += more;
    text[size] = 0;
    char *found = strstr(text, what);
    while (found > text && found[-1] != '\\n')
        found--;
    return (unsigned char *)strtoul(found, NULL, 16);
}
"""
ATTACKS = {
    "ends with success": ("_exit(0);", "", ["_exit"]),
    "says that all is answered":
        ("*(unsigned *)memory_of(\"memfd:answers\") = 1u << 30;", FIND, ["open", "read"]),
    "makes the requests writable":
        ("mprotect(memory_of(\"memfd:requests\"), 4096, 3);\n"
         "    *(unsigned *)memory_of(\"memfd:requests\") = 1;", FIND, ["open", "read", "mprotect"]),
    "opens the requests again":
        ("for (int i = 3; i < 64; i++) {\n"
         "        char name[] = \"/proc/self/fd/00\";\n"
         "        name[14] += i / 10;\n        name[15] += i % 10;\n"
         "        unsigned *at = mmap(NULL, 4096, 3, 1, open(name + 0, 2), 0);\n"
         "        if (at != (void *)-1)\n            at[2] = 1;\n    }", "", ["open", "mmap"]),
    "answers with a verdict":
        ("for (int i = 3; i < 64; i++)\n        write(i, \"0246802468\", 10);", "", ["write"]),
    "asks a child for the wanted value": ("if (fork() == 0)\n        _exit(0);", "", ["fork", "_exit"]),
    "ends its parents": ("kill(getppid(), 9);\n    kill(1, 9);\n    kill(-1, 9);", "", ["kill", "getppid"]),
    "fills its stack with returns":
        ("volatile long *at = (volatile long *)__builtin_frame_address(0);\n"
         "    for (int i = 1; i < 3; i++)\n        at[i] += 5;", "", []),
}
DECLARED = """
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
int open(const char *, int, ...); ssize_t read(int, void *, size_t); ssize_t write(int, const void *, size_t);
int mprotect(void *, size_t, int); void *mmap(void *, size_t, int, int, int, long); pid_t fork(void);
pid_t getppid(void); pid_t getpid(void); int kill(pid_t, int); void _exit(int);
"""


def forgeries_earn_no_more_than_their_code(grader):
    starter = starter_of(FEATURES["normals"].reference)
    honest = grader.verdicts("normals", starter, True)[1]
    first = starter.index("#include")
    for what, (statement, before, names) in ATTACKS.items():
        at = starter.index(CALLED) + len(CALLED)
        unit = (starter[:first] + DECLARED + by_address(*names) + before + starter[first:at] + "    "
                + statement + "\n" + starter[at:])
        verdicts, points = grader.verdicts("normals", unit, True)
        check("compile" not in str(verdicts), f"a unit that {what} is run", str(verdicts))
        check(points <= honest, f"a unit that {what} earns nothing by it",
              f"{points} points, {honest} without it: {verdicts}")


# In each call of the function, the system's calls by their numbers: 35 is nanosleep, 202 futex.
SLEEPERS = {
    "sleeps": "syscall(35, (long[]){60, 0}, NULL);",
    "sleeps a little in each call":
        "for (int i = 0; i < 200; i++)\n        syscall(35, (long[]){0, 5000000}, NULL);",
    "waits for what never comes":
        "int word = 0;\n    syscall(202, &word, 0, 0, NULL, NULL, 0);",
    "takes short naps":
        "int word = 0;\n    for (int i = 0; i < 200; i++)\n        "
        "syscall(202, &word, 0, 0, (long[]){0, 5000000}, NULL, 0);",
    "stops itself": "kill(getpid(), 19);",
}


def sleepers_are_not_waited_for(grader):
    right = text_of("normals")
    at, first = right.index(CALLED) + len(CALLED), right.index("#include")
    before = DECLARED + "long syscall(long, ...);\n" + by_address("syscall", "kill", "getpid")
    for what, statement in SLEEPERS.items():
        unit = right[:first] + before + right[first:at] + "    " + statement + "\n" + right[at:]
        began = time.monotonic()
        with mock.patch.dict(os.environ, RAYKIT_TEST_SECONDS="2"):
            verdicts, _ = grader.verdicts("normals", unit, True, "each_axis_has_a_colour_of_its_own")
        passed, reason = verdicts["each_axis_has_a_colour_of_its_own"]
        took = time.monotonic() - began
        print(f"# {took:.1f}")
        check(took < 20 and "compile" not in reason and (not passed or "syscall(35" in statement),
              f"a unit that {what} holds nobody up", f"{took:.0f} s, {reason}")


def after_one_loop_single_calls_are_not_waited_for(grader):
    """Only where one call does not end: who works slowly through many of them has all the time of a claim."""
    right, seconds = text_of("normals"), 2
    at = right.index(CALLED) + len(CALLED)
    tests = ["each_axis_has_a_colour_of_its_own", "opposite_normals_have_complementary_colours"]
    units = {"loops": "for (volatile int k = 0; k < 2; k = 0) { }",
             "is slow": "for (volatile int k = 0; k < 5000000; k++) { }"}
    found = {}
    for what, statement in units.items():
        with mock.patch.dict(os.environ, RAYKIT_TEST_SECONDS=str(seconds)), \
                mock.patch.object(grade.Suite, "hung", lambda _: 1):
            found[what] = grader.verdicts("normals", right[:at] + statement + right[at:], True, tests)[0]
    check(all("within 0.2 s in one call" in reason for _, reason in found["loops"].values()),
          "after one endless loop a single call gets less time", str(found["loops"]))
    check(all("within 2 seconds" in reason or passed for passed, reason in found["is slow"].values()),
          "who works slowly through many calls does not", str(found["is slow"]))


def what_one_call_leaves_another_does_not_find(grader):
    right, claim = text_of("normals"), "each_axis_has_a_colour_of_its_own"
    at, first = right.index(CALLED) + len(CALLED), right.index("#include")

    def verdicts_of(statement, before):
        text = right[:first] + before + right[first:at] + "    " + statement + "\n" + right[at:]
        return grader.verdicts("normals", text, True)[0]

    said = verdicts_of("errno++;\n    if (errno > 1)\n        return n;", "#include <errno.h>\n")
    check(said[claim][0], "errno is 0 at each call", str(said[claim]))
    hidden = verdicts_of("if (!*optarg)\n        *optarg = malloc(16);",
                         DECLARED + "#include <unistd.h>\n" + by_address("optarg"))
    check(hidden[claim][0] and "leaks memory" in hidden["all_memory_is_freed"][1],
          "memory that only the C library's data point to is not freed", str(hidden))
    left = verdicts_of("if (!*optarg) {\n        *optarg = malloc(16);\n"
                       "        __cxa_atexit((void (*)(void *))_exit, 0, 0);\n    }",
                       DECLARED + "#include <unistd.h>\nint __cxa_atexit(void (*)(void *), void *, void *);\n"
                       + by_address("optarg", "__cxa_atexit", "_exit"))
    check("leaks memory" in left["all_memory_is_freed"][1], "also where a handler of exit() would end first",
          str(left))
    printed = verdicts_of('printf("%g\\n", (double)n.x);\n    fprintf(stderr, "%g\\n", (double)n.y);',
                          "#include <stdio.h>\n")
    check(printed["all_memory_is_freed"][0], "but what the C library prints from is no leak", str(printed))


def a_tree_that_is_too_large_is_told(grader):
    begin = "bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)\n{\n"
    text = text_of("bvh_median").replace(begin, begin.replace("rk_bvh_build_median", "build").replace(
        "bool", "static bool"))
    text += f"\n{begin}    bool is_built = build(bvh, mesh, error);\n"
    text += "    bvh->node_count = 1u << 30;\n    return is_built;\n}\n"
    said = grader.verdicts("bvh_median", text, True)[0]
    check(any("values were allocated, want at most" in reason for _, reason in said.values()),
          "a unit that says that it has made too many nodes is told so", str(said))


def constant_structures_cannot_be_written_to(grader):
    """Also those whose pointers are set in the unit's process."""
    claim, text, begin = "all_lines_are_summed", text_of("bloom"), "uint32_t used = 0, taps = 0;\n"
    write = "    *(volatile uint32_t *)(uintptr_t)&filter->reach = filter->reach;\n"
    passed, reason = grader.verdicts("bloom", text.replace(begin, begin + write), True, [claim])[0][claim]
    check(not passed and "a write to the caller's data, which is constant" in reason,
          "a constant structure cannot be written to", reason)


def it_ends_with_its_grader():
    """Though nobody has answered it."""
    asked, answered = judged._shared_memory("requests"), judged._shared_memory("answers")
    alive, held = os.pipe()
    begin = ("RAYKIT_JUDGE=%d,%d,%d,$$ impl/judge/normals-judge --only each_axis_has_a_colour_of_its_own "
             ">/dev/null & echo $!; read line" % (asked, answered, alive))
    grader = subprocess.Popen(["/bin/sh", "-c", begin], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE, pass_fds=(asked, answered, alive))
    pid = int(grader.stdout.readline())
    while not judged.fcntl.fcntl(asked, judged._GET_SEALS) & judged._SEAL_FUTURE_WRITE:
        time.sleep(0.01)
    grader.kill()
    grader.communicate()
    ended = os.waitpid(pid, 0)[1]  # of a subreaper (sandbox.prepare)
    check(os.WTERMSIG(ended) == signal.SIGKILL, "a judge ends with its grader", str(ended))
    for descriptor in (asked, answered, alive, held):
        os.close(descriptor)


# In each call of the function, where `calls` counts those of a process.
HIDDEN = {
    "has a loop in its tenth call": "if (++calls == 10)\n        for (volatile int k = 0; k < 2; k = 0) { }",
    "answers wrongly after its tenth call": "if (++calls > 10)\n        return n;",
    "leaks in its tenth call": "if (++calls == 10)\n        lost = malloc(16), lost = NULL;",
    "crashes in its tenth call": "if (++calls == 10)\n        return *(volatile rk_vec3 *)(uintptr_t)calls;",
    "ends the program in its tenth call": "if (++calls == 10)\n        _exit(0);",
    "prints in its tenth call": 'if (++calls == 10)\n        puts("ten");',
}


def claims_of_a_step_share_a_process(grader):
    """Where all of them hold; otherwise each is judged by itself, with the verdict that it would have had."""
    right, asked, run = text_of("normals"), [], judged.run
    points = grade.read_points(FEATURES["normals"])

    def noted(toolchain, stem, names, *rest, **options):
        asked.append(names)
        return run(toolchain, stem, names, *rest, **options)

    with mock.patch.object(judged, "run", noted):
        verdicts, _ = grader.verdicts("normals", right, True)
        steps = len({test.step for test in points})
        check(all(passed for passed, _ in verdicts.values()) and len(asked) == steps
              and sorted(sum(asked, [])) == sorted(test.name for test in points),
              "a right unit has a process for each step", f"{asked} {verdicts}")
        asked.clear()
        grader.verdicts("normals", starter_of(FEATURES["normals"].reference), True)
        check(all([test.name] in asked for test in points if test.step), "a starter has one for each claim",
              str(asked))
    before = ("#include <stdio.h>\n#include <stdlib.h>\n#include <unistd.h>\n#include <stdint.h>\n"
              + by_address("_exit") + "static int calls;\nstatic void *volatile lost;\n")
    at, first = right.index(CALLED) + len(CALLED), right.index("#include")
    for what, statement in HIDDEN.items():
        unit = right[:first] + before + right[first:at] + "    " + statement + "\n" + right[at:]
        with mock.patch.dict(os.environ, RAYKIT_TEST_SECONDS="2"):
            said = grader.verdicts("normals", unit, True)
            with mock.patch.object(grade, "hold_together", lambda *_: False):
                alone = grader.verdicts("normals", unit, True)
        failed = [name for name, (passed, _) in alone[0].items() if not passed and name != KEEPS_NOTHING.name]
        check("compile" not in str(said) and said == alone and bool(failed) != what.startswith("prints"),
              f"a unit that {what} has the verdicts of single processes", f"{said}\n{alone}")


def its_cost_is_measured():
    ended = subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "tools", "bench_grade.py"), "normals",
                            "--rounds", "1"], capture_output=True, text=True, check=False)
    rows = [line.split() for line in ended.stdout.splitlines()[1:]]
    fine = [row for row in rows if all(float(number) > 0 for number in row[1:])]
    check([row[0] for row in fine] == ["normals", "all"], "bench-grade measures both ways to grade",
          ended.stdout + ended.stderr)


def what_cannot_be_compared_is_told():
    tool = os.path.join(SOURCE, "tests", "test_same_verdicts.py")
    for more, told in (({"EVERY": "many"}, "EVERY=many: give a whole number from 1 on"),
                       ({"STEMS": "normal"}, 'there is no feature "normal"; choose one of: normals')):
        environment = dict(os.environ, **{f"RAYKIT_{name}": text for name, text in more.items()})
        ended = subprocess.run([sys.executable, "-B", tool], env=environment, capture_output=True, text=True,
                               check=False)
        check(ended.returncode == 1 and ended.stderr.startswith(told) and ended.stderr.count("\n") == 1,
              f"check-same-verdicts says in a line: {told}", ended.stderr)


def main():
    if not judged.is_possible(build.Toolchain("."), "normals"):
        check(False, "there are judges", "make judges-ready")
        return finish()
    sandbox.prepare()
    folder = tempfile.mkdtemp(prefix="raykit-judge-")
    try:
        every_suite_can_be_judged_apart_or_says_why()
        it_ends_with_its_grader()
        requests_tell_no_answers(folder)
        another_seed_asks_other_things(folder)
        grader = Grader(folder)
        a_judge_speculates_until_an_answer_is_another_one(grader)
        its_cost_is_measured()
        claims_of_a_step_share_a_process(grader)
        what_cannot_be_compared_is_told()
        units_without_functions_earn_nothing(grader)
        right_units_pass_apart(grader)
        starters_and_mistakes_get_the_same_verdicts(grader)
        forgeries_earn_no_more_than_their_code(grader)
        sleepers_are_not_waited_for(grader)
        after_one_loop_single_calls_are_not_waited_for(grader)
        what_one_call_leaves_another_does_not_find(grader)
        a_tree_that_is_too_large_is_told(grader)
        constant_structures_cannot_be_written_to(grader)
    finally:
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
