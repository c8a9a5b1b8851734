#!/usr/bin/env python3
"""Rules for units, tried on honest and on dishonest units of bvh_median: each dishonest one gets no point
that it did not earn. Speaks TAP, for make check; runs in a build folder."""

import csv
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from by_address import by_address  # noqa: E402
from tap import check, finish, run, start  # noqa: E402
from grading import (build, c_source, private_copy, results, sandbox, unit_rules,  # noqa: E402
                     volatile_constants)
from grading.assignments import (  # noqa: E402
    DEDUCTION, FREES_ALL, KEEPS_NOTHING, ScoredTest, Unit, read_features, read_points,
)
from grading.starters import is_handed_out, starter_of  # noqa: E402
import grade  # noqa: E402

FEATURE = read_features(SOURCE)["bvh_median"]
SOLVED = not is_handed_out(FEATURE.reference)
with open(FEATURE.reference, encoding="utf-8") as source_file:
    RIGHT = source_file.read() if SOLVED else starter_of(FEATURE.reference)
BUILD = "bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)\n{\n"
ALL = [KEEPS_NOTHING, *read_points(FEATURE), FREES_ALL]
EMPTY = ScoredTest("no_triangles_give_a_tree_without_nodes", 0, "#difficult-meshes")

REFUSED_EARLY = "runs before or after the tests"
HEADERS = "".join(f"#include <{name}.h>\n" for name in "assert errno math stdio stdlib string unistd".split())


def unit(statement="", before=""):
    """The right unit whose build begins with this statement."""
    at = RIGHT.rindex(BUILD) + len(BUILD)
    first = RIGHT.index("#include")
    return RIGHT[:first] + HEADERS + before + RIGHT[first:at] + statement + "\n" + RIGHT[at:]


class Grader:
    """Makes suites in a folder, and grades them together."""

    def __init__(self, toolchain, folder):
        self.toolchain, self.folder, self.waiting = toolchain, folder, []

    def add(self, text, tests=(EMPTY,), beside=()):
        """Returns a suite over a unit with this text, beside files given as (path, text)."""
        place = tempfile.mkdtemp(dir=self.folder)
        path = os.path.join(place, "bvh_median.c")
        for name, words in [("bvh_median.c", text), *beside]:
            os.makedirs(os.path.dirname(os.path.join(place, name)), exist_ok=True)
            with open(os.path.join(place, name), "wb") as file:
                file.write(words if isinstance(words, bytes) else words.encode())
        suite = grade.Suite(FEATURE, Unit(FEATURE, path, "mine/bvh_median.c", False), list(tests))
        suite.folder = place
        self.waiting.append(suite)
        return suite

    def grade(self, decoys=grade.DECOYS):
        grade.grade(self.toolchain, self.waiting, {}, seconds=60, decoys=decoys)
        self.waiting = []


# --- Refused ------------------------------------------------------------------------------------

# claim: (unit, part of the reason)
REFUSED = {
    "exit": (unit("exit(0);"), "uses exit (line "),
    "exit, with what to do instead": (unit("exit(0);"), "return false"),
    "rand, with what to do instead": (unit("if (rand() < 0) return false;"), "rk_hash"),
    "signal, which the headers rename": (
        unit("signal(SIGSEGV, SIG_IGN);", "#include <signal.h>\n"), "uses signal (line "
    ),
    "setjmp, which the headers rename": (
        unit("if (setjmp(place)) return false;", "#include <setjmp.h>\nstatic jmp_buf place;\n"),
        "uses setjmp (line "
    ),
    "fork": (unit("fork();"), "uses fork"),
    "a function that is called at exit": (unit("atexit(abort);"), "uses atexit"),
    "a shell": (unit('if (system("true")) return false;'), "uses system"),
    "files": (unit('if (fopen("/etc/passwd", "r")) return false;'), "uses fopen (line "),
    "mprotect": (unit("mprotect((void *)4096, 4096, 7);", "#include <sys/mman.h>\n"), "uses mprotect"),
    "dlopen": (unit('dlopen("x.so", RTLD_NOW);', "#include <dlfcn.h>\n"), "uses dlopen"),
    "threads": (
        unit("pthread_t thread;\n    pthread_create(&thread, NULL, run, NULL);",
             "#include <pthread.h>\nstatic void *run(void *nothing)\n{\n    return nothing;\n}\n"),
        "uses pthread_create",
    ),
    "the environment": (unit("if (environ) return false;", "extern char **environ;\n"), "uses environ"),
    "the kit's clock": (
        unit("if (rk_clock_wall() < 0) return false;", '#include "base/table.h"\n'), "uses rk_clock_wall"
    ),
    "the kit's files": (unit('rk_file_abort(NULL);', '#include "base/file.h"\n'), "uses rk_file_abort"),
    "the suite's own functions": (
        unit('rk_claim_failed("x", 1, "y");',
             "void rk_claim_failed(const char *file, int line, const char *format, ...);\n"),
        "uses rk_claim_failed",
    ),
    "another name for exit": (unit("leave(0);", 'void leave(int status) __asm__("exit");\n'), "uses exit"),
    "a switch of the leak sanitizer": (
        unit("__lsan_disable();", "void __lsan_disable(void);\n"), "uses __lsan_disable"
    ),
    "a switch of the leak sanitizer under another name": (
        unit("off();", 'void off(void) __asm__("__ls" "an_disable");\n'), "uses __lsan_disable"
    ),
    "the address sanitizer's functions": (
        unit("__asan_set_shadow_00(0, 1);",
             "void __asan_set_shadow_00(unsigned long address, unsigned long size);\n"),
        "uses __asan_set_shadow_00",
    ),
    "the sanitizer's attribute": (
        unit("", '#define OFF(x) x##sanitize("address")\n__attribute__((OFF(no_))) int odd(void);\n'
             "int odd(void)\n{\n    return 1;\n}\n"),
        "uses the attribute no_sanitize",
    ),
    "inline assembly": (unit('__asm__ volatile("syscall");'), "uses inline assembly"),
    "inline assembly that looks like a name": (unit('if (bvh) __asm__("syscall");'), "uses inline assembly"),
    "assembly beside functions": (unit("", '__asm__(".incbin \\"/etc/passwd\\"");\n'),
                                  "uses inline assembly"),
    "assembly within a name": (
        unit("", 'extern int odd __asm__("x\\n.incbin \\"/etc/passwd\\"\\n");\n'), "uses inline assembly"
    ),
    "assembly within a section's name": (
        unit("", '__attribute__((section(".text\\n.incbin \\"/etc/passwd\\"\\n#"))) int odd(void);\n'),
        "uses the attribute section",
    ),
    "a section's name in parentheses": (
        unit("", '__attribute__((section((".text")))) int odd(void);\n'), "uses the attribute section (line "
    ),
    "a section's name in brackets that are written otherwise": (
        unit("", '<:<:gnu::section(".text"):>:> int odd(void);\n'), "uses the attribute section"
    ),
    "a section within an attribute that is allowed": (
        unit("", "__attribute__((aligned(sizeof(struct { int x; } __attribute__((section(\"a\")))))))\n"
             "extern int odd;\n"), "uses the attribute section"
    ),
    "an alias": (unit("", 'int odd(void) __attribute__((alias(("rk_bvh_closest"))));\n'),
                 "uses the attribute alias"),
    "a function that is chosen while loading": (
        unit("", '__attribute__((target_clones("avx2", "default"))) int odd(void);\n'
             "int odd(void)\n{\n    return 1;\n}\n"), "chosen while the program is loaded"
    ),
    "a pragma that places": (unit("", "#pragma weak rk_bvh_closest\n"), "uses #pragma weak"),
    "a constructor": (
        unit("", "__attribute__((constructor)) static void early(void)\n{\n    abort();\n}\n"), REFUSED_EARLY
    ),
    "a destructor": (
        unit("", "__attribute__((destructor)) static void late(void)\n{\n    abort();\n}\n"), REFUSED_EARLY
    ),
}

# The same by the compiler alone: what an object tells if its source was not looked at.
OBJECTS = {
    "code": ("int f(int x)\n{\n    return x;\n}\n", ""),
    "constants, also of addresses": (
        'const char *const names[] = {"a", "b"};\nstatic const double table[] = {1, 2};\n'
        "double at(int i)\n{\n    return table[i];\n}\n", ""),
    **{f"an entry in {section}": (
        "static void early(void)\n{\n}\n"
        f'__attribute__((section("{section}"), used)) static void (*entry)(void) = early;\n', REFUSED_EARLY
    ) for section in (".init_array", ".fini_array", ".preinit_array", ".ctors", ".dtors",
                      ".init_array.00099")},
    **{f"a number in {section}": (
        f'__attribute__((section("{section}"), used)) static unsigned long entry = 4096;\n', REFUSED_EARLY
    ) for section in (".init_array", ".fini_array.5")},
    "code in .init": ('__attribute__((section(".init"))) void early(void)\n{\n}\n', REFUSED_EARLY),
    "a function chosen while loading": (
        "static int plain(void)\n{\n    return 1;\n}\n"
        "static int (*choose(void))(void)\n{\n    return plain;\n}\n"
        'int chosen(void) __attribute__((ifunc("choose")));\n', "chosen while the program is loaded"
    ),
    "a section of another name": (
        '__attribute__((section("mine"), used)) static const int odd = 1;\n', "has a section mine"
    ),
    "code among constants": (
        '__attribute__((section(".rodata.x,\\"ax\\",@progbits #"))) int odd(void)\n{\n    return 1;\n}\n',
        "has a section .rodata.x",
    ),
}


def what_reaches_around_the_suite_is_refused(grader):
    cases = {claim: (grader.add(case[0]), case[1]) for claim, case in REFUSED.items()}
    grader.grade()
    for claim, (suite, part) in cases.items():
        check(part in suite.problem and suite.points() == 0, f"{claim}: refused by name",
              suite.problem or results.text([suite], ""))


def objects_are_looked_at(toolchain, folder):
    path = os.path.join(folder, "object")
    for claim, (text, part) in OBJECTS.items():
        with open(path + ".c", "w", encoding="utf-8") as file:
            file.write(text)
        for flags in ([], toolchain.sanitize) if toolchain.finds_leaks() else ([],):
            subprocess.run([*toolchain.compiler, *flags, "-w", "-c", path + ".c", "-o", path + ".o"],
                           check=True)
            found = unit_rules.Object(toolchain.tools["objdump"], path + ".o")
            fault = unit_rules.fault_in_object(found, bool(flags))
            check(part in fault and bool(part) == bool(fault) and not unit_rules.kept_data(found),
                  f"{claim}: {'refused' if part else 'allowed'}{', with sanitizers' if flags else ''}",
                  f"{fault} {unit_rules.kept_data(found)}")


# --- Allowed ------------------------------------------------------------------------------------

HONEST = {
    "printing": unit('printf("%u\\n", mesh->triangle_count);\n    fprintf(stderr, "x");\n    puts("y");\n'
                     "    fflush(stdout);"),
    "assert": unit("assert(mesh != NULL);"),
    "errno and strings": unit('errno = 0;\n    char text[9];\n    strcpy(text, "a");\n'
                              "    if (strtol(text, NULL, 10) && errno) return false;\n"
                              "    if (strerror_r(2, text, sizeof text) == 3) return false;"),
    "all of math.h": unit("volatile double x = 2;\n    x = lgamma(x) + tgamma(x) + fma(x, x, x) + erf(x);\n"
                          "    x = remquo(x, x, &(int){0});"),
    "the less known of math.h, and complex.h": unit(
        "volatile double x = j0(2) + y1(2) + lgamma_r(3, &(int){0});\n    double complex z = cexp(I * x);\n"
        "    x = cabs(z) + carg(z) + creal(csqrt(z));",
        "#include <complex.h>\ndouble lgamma_r(double, int *);\n"
    ),
    "ctype.h": unit("volatile int c = 'a';\n    if (!isalpha(toupper(c)) || isdigit(c)) return false;",
                    "#include <ctype.h>\n"),
    "the less known of string.h, and numbers in text": unit(
        'char text[] = "1 2", *word = strtok(text, " ");\n    int number;\n'
        '    if (!word || sscanf(word, "%d", &number) != 1) return false;'
    ),
    "functions called as attributes are": unit(
        'if (section("x") + alias("y") > 5) return false;',
        "static int section(const char *name)\n{\n    return name[0] == 'z';\n}\n"
        "static int alias(const char *name)\n{\n    return name[0] == 'z';\n}\n"),
    "a variable called nearly as an attribute is": unit("volatile int no_sanitized_input = 1;\n"
                                                        "    if (!no_sanitized_input) return false;"),
    "attributes that say something": unit(
        "", "[[maybe_unused]] __attribute__((const, noinline, aligned(16))) static int odd(int x)\n"
        "{\n    return x;\n}\n"),
    "pragmas that say something": unit("", "#pragma omp declare simd\nstatic int odd(int x);\n"
                                       "#pragma region folded by editors\n#pragma endregion\n#pragma mark -\n"
                                       "#pragma warning(disable: 4996)\n#pragma message(\"seen\")\n"
                                       "#pragma GCC diagnostic push\n#pragma GCC diagnostic pop\n"
                                       "static int odd(int x)\n{\n    return x;\n}\n"),
    "what a second look at the source would see": unit(
        "", '#if __has_include("../../bvh_median.included")\n#error the source was read again\n#endif\n'),
    "wide arithmetic": unit("volatile unsigned __int128 x = 5;\n    x = x / (x - 1);"),
    "intrinsics": unit("", "#if defined(__SSE__)\n#include <immintrin.h>\n#endif\n"),
    "the kit's own functions": unit("if (rk_sample_1d(&(rk_sampler){0}, 1, 2, 3) > 2) return false;",
                                    '#include "base/sampler.h"\n'),
    "constant tables": unit("if (names[0][0] != table[1]) return false;",
                            "static const char *const names[] = {\"a\"};\n"
                            "static const int table[] = {1, 'a'};\n"),
    "constants that are volatile": unit(
        "static volatile const short odd = 7, more[] = {1, 2};\n"
        "    if (odd + last + more[1] == 1) return false;",
        "static const volatile int last = 5;\nconst volatile static float none;\n"),
    "the version that a revision system writes": unit(
        "", '#ident "$Id: bvh_median.c,v 1.2 2026/11/29 ann Exp $"\n%:sccs "1"\n'),
    "a version that would be assembly": unit("", '#ident "1\\"\\n.incbin \\"/etc/passwd\\"\\n#"\n'),
    "a main and helpers without static": unit("", "int main(void);\nint main(void)\n{\n    return 1;\n}\n"),
}


def honest_code_is_not_refused(grader):
    suites = {claim: grader.add(text, (KEEPS_NOTHING, EMPTY)) for claim, text in HONEST.items()}
    grader.grade()
    for claim, suite in suites.items():
        check(not suite.problem and suite.verdicts[KEEPS_NOTHING.name].passed, f"{claim}: allowed",
              results.text([suite], ""))


def long_texts_take_little(grader):
    """A pass over a text of a megabyte that is quadratic takes half an hour, and a linear one a second or
    two."""
    million = 1 << 20
    parts = {"blank lines": "\n", "comments that do not end": "//\\\n/*",
             "attributes that do not end": "__attribute__((", "brackets": "[[", "quotes": "'", "braces": "{",
             "directives": "#\\\n", "assembly": "asm(",
             "declarations": "static const volatile int x[", "words": "static const volatile "}
    for name, part in parts.items():
        text = part * (million // len(part))
        began = time.process_time()
        unit_rules.fault_in_source(text)
        unit_rules.fault_in_assembly(text)
        volatile_constants.names_in(text)
        list(c_source.functions_of(c_source.tokens_of(text)))
        list(private_copy._headers_beside(SOURCE, text.encode()))
        took = time.process_time() - began
        check(took < 60, f"a megabyte of {name} is read at once", f"{took:.0f} s of processor time")
    longest = grader.add(unit("", "\n" * (million - len(unit()) - 1)), (KEEPS_NOTHING, EMPTY))
    longer = grader.add(unit("", "\n" * million), (KEEPS_NOTHING, EMPTY))
    grader.grade()
    check(not longest.problem, "a unit of 1 MB is read", longest.problem)
    check("larger than 1 MB" in longer.problem, "a larger one is refused, with the limit", longer.problem)


def reasons_fit(grader):
    cases = {
        "a missing #include": ("_Bool lone(void);\n_Bool lone(void)\n{\n"
                               "    return rk_mesh_validate(0, \"\", 0);\n}\n",
                               (), '#include "scene/mesh.h" declares it'),
        "a missing brace": (unit("if (mesh) {"), (),
                            "; a } is missing in rk_bvh_build_median, which begins in line "),
        "text in UTF-16": (unit().encode("utf-16"), (), "is text in UTF-16; save it in UTF-8"),
        "text in UTF-16 without a mark": (unit().encode("utf-16-le"), (),
                                          "is text in UTF-16; save it in UTF-8"),
        **{f"text in {name}": (unit().encode(name), (), "is text in UTF-32; save it in UTF-8")
           for name in ("utf-32", "utf-32-le", "utf-32-be")},
        "text in UTF-32 that begins with a mark": ("\ufeff".encode("utf-32-be"), (), "is text in UTF-32"),
        "text in UTF-16 of the other order": (unit().encode("utf-16-be"), (), "is text in UTF-16"),
        "an archive": (gzip.compress(unit().encode()), (), "is an archive (gzip); unpack it"),
        "a program": (b"\x7fELF\2\1\1\0", (), "is a compiled program; hand in the text that it was made of"),
        "a header that hides the kit's": (
            unit(), [("features/bvh_median.h", "#error old\n")], "which hides the kit's; remove it"
        ),
        "a helper that is declared only": (
            unit("helper();", "void helper(void);\n"), (),
            "your file uses helper (line 13), which nothing defines"
        ),
    }
    suites = {claim: grader.add(text, beside=beside) for claim, (text, beside, _) in cases.items()}
    own = grader.add(unit("", '#include "own.h"\n'), beside=[("own.h", "enum { own = 1 };\n")])
    with_zero = grader.add(b"/\0" + unit().encode()[2:])
    grader.grade()
    for claim, suite in suites.items():
        check(cases[claim][2] in suite.problem, f"{claim} is called so", suite.problem)
    check("UTF" not in with_zero.problem, "a byte 0 at the beginning makes no UTF-16", with_zero.problem)
    told = suites["a missing brace"].verdicts[EMPTY.name].details
    check(told.count("error: ") == 1, "where a brace is missing, one error is shown of many", told)
    check(not own.problem, "a header of the student's own is used", own.problem)


# --- Claims of the grader's own -----------------------------------------------------------------

def no_constant_is_written(grader):
    suite = grader.add(unit("*(int *)(uintptr_t)&odd += 1;", "static const volatile int odd = 5;\n"))
    grader.grade()
    check(not suite.verdicts[EMPTY.name].passed and not suite.problem, "a unit that writes to one crashes",
          results.text([suite], ""))


def what_is_kept_is_named(grader):
    count, keep = "static int calls;\n    calls += 1;\n    if (calls > 1 << 20) return false;", "last = mesh;"
    cases = {
        "a static variable": (count, "", "`calls`"),
        "one that is called as the sanitizer's are": (
            "asan_calls += 1;\n    if (asan_calls > 1 << 20) return false;", "static int asan_calls;\n",
            "`asan_calls`"),
        "a variable beside the functions": (keep, "static const void *volatile last;\n", "`last`"),
        "a variable of each thread": (keep, "static _Thread_local const void *volatile last;\n", "`last`"),
        "a volatile one beside a constant that is": (
            "if (odd[0]) last = mesh;", "static const volatile int odd[] = {1}, *volatile last;\n", "`last`"),
        "one called as a constant is": (
            "{ static int odd; odd += 1; if (odd > 1 << 20) return false; }",
            "static const volatile int odd = 1;\nint reads_odd(void);\nint reads_odd(void)\n{\n"
            "    return odd;\n}\n", "`odd`"),
        "one that has a value": ("seed *= 3;", "static volatile unsigned seed = 7;\n", "`seed`"),
    }
    suites = {claim: grader.add(unit(statement, before), ALL)
              for claim, (statement, before, _) in cases.items()}
    grader.grade()
    for claim, suite in suites.items():
        verdict = suite.verdicts[KEEPS_NOTHING.name]
        text = results.text([suite], "")
        check(not verdict.passed and f"keeps {cases[claim][2]} from call to call" in verdict.reason
              and f"first: {KEEPS_NOTHING.name}" in text, f"{claim} is named, first of all", verdict.reason)
        check(suite.points() == (100 - DEDUCTION if SOLVED else 0) and "100 of 100 points" not in text,
              f"{claim} costs {DEDUCTION} points", text)


LEAK = "void *volatile lost = malloc(100);\n    lost = NULL;\n    "
# What used to hide a leak.
HIDING = {
    "a leak": ("", ""),
    "a leak beside memory that is freed": ("void *volatile freed = malloc(100);\n    free(freed);", ""),
    "a leak behind the leak sanitizer's own words": (
        'fputs("LeakSanitizer has encountered a fatal error\\n", stderr);', ""
    ),
    "a leak before an end without checks": (
        "on_exit(late, NULL);", "int on_exit(void (*function)(int, void *), void *argument);\n"
        + by_address("on_exit", "_exit") + "static void late(int status, void *argument)\n"
        "{\n    (void)status, (void)argument;\n    _exit(0);\n}\n"
    ),
}


def a_leak_is_a_claim_of_its_own(grader):
    suites = {claim: grader.add(unit(LEAK + statement, before), ALL)
              for claim, (statement, before) in HIDING.items()}
    alone = grader.add(unit(LEAK), (EMPTY,))
    grader.grade()
    check(not alone.passed() and "leaks memory" in alone.verdicts[EMPTY.name].reason,
          "a test that is asked for alone tells its leak", alone.verdicts[EMPTY.name].reason)
    for claim, suite in suites.items():
        verdict, text = suite.verdicts[FREES_ALL.name], results.text([suite], "")
        check(not verdict.passed and "leaks memory: " in verdict.reason
              and "mine/bvh_median.c:" in verdict.place,
              f"{claim} is found, with its line", f"{verdict.reason}\n{verdict.place}\n{text}")
        # Nothing may be kept where memory runs out, either, which held with the starter.
        broken = {FREES_ALL.name, "where_memory_runs_out_nothing_is_kept"}
        check(not SOLVED or {test.name for test in suite.tests
                             if not suite.verdicts[test.name].passed} == broken,
              f"{claim} fails no claim that carries points", text)
        check(suite.points() == (100 - 2 * DEDUCTION if SOLVED else 0), f"{claim} costs what these two cost",
              text)


def what_held_and_breaks_costs_points(grader):
    """The right unit fails a claim without points, and nothing else."""
    suite = grader.add(unit("if (mesh->triangle_count == 0) return false;"), ALL)
    starter = grader.add(starter_of(FEATURE.reference), ALL)
    grader.grade()
    broken = [test for test in ALL if not suite.verdicts[test.name].passed]
    text = results.text([suite], "")
    check(EMPTY.name in [test.name for test in broken] and suite.points() == sum(
        test.points for test in ALL if test not in broken) - DEDUCTION * sum(test.points == 0
                                                                             for test in broken)
        if SOLVED else suite.points() == 0, "a claim without points that breaks costs points", text)
    check("FAIL" in text and "100 of 100" not in text and f"costs {DEDUCTION}" in text,
          "and the report says so", text)
    check(starter.points() == 0 and all(starter.verdicts[test.name].passed
                                        for test in (KEEPS_NOTHING, FREES_ALL)),
          "the starter keeps the grader's claims, and nobody has fewer than 0 points",
          results.text([starter], ""))
    common = os.path.join(SOURCE, "assignments/handout_common.md")  # a pack has it in each handout
    handout = os.path.join(os.path.dirname(FEATURE.points_table), "handout.md")
    with open(common if os.path.exists(common) else handout, encoding="utf-8") as file:
        words = file.read()
    check(all(part in words for part in (f"costs {DEDUCTION} points", KEEPS_NOTHING.name, FREES_ALL.name)),
          "and every handout says so")
    report = json.loads(results.gradescope([suite, starter], "mine"))
    check(report["score"] == suite.points() + starter.points() == sum(test["score"]
                                                                      for test in report["tests"]),
          "Gradescope's score is the sum of its tests', deductions included", report)
    check(report["output_format"] == "text", "Gradescope shows the report as it is")
    root = ElementTree.fromstring(results.junit([suite, starter], "mine"))
    totals = {name: sum(int(each.get(name)) for each in root) for name in ("tests", "failures", "errors")}
    check(all(int(root.get(name)) == total for name, total in totals.items())
          and totals["tests"] == 2 * len(ALL),
          "JUnit has totals", root.attrib)


# --- The verdict within the process -------------------------------------------------------------

def thieves(toolchain, folder):
    """Returns units that reach the suite's data by distance, as one finds it in one's own build."""
    steal = """char *witness = (char *)(uintptr_t)rk_bvh_build_median + (WITNESSL);
    write(*(int *)(void *)witness, witness + 4, 48);
    _exit(0);"""
    patch = """char *code = (char *)(uintptr_t)rk_bvh_build_median + (FAILEDL);
    mprotect((void *)((uintptr_t)code & ~(uintptr_t)4095), 8192, 7);
    swab("\\xc3\\xc3\\xc3\\xc3", code, 2);"""
    cases = {
        "who sends the secret": (steal, by_address("write", "_exit")),
        "who disables what fails a claim": (patch,
                                            "#include <sys/mman.h>\n" + by_address("mprotect", "swab")),
    }
    for claim, (statement, before) in cases.items():
        text = unit(statement, before)
        distances = {"WITNESS": 0x123456, "FAILED": 0x123456}
        for _ in range(2):  # the first program tells the distances
            with_distances = text
            for name, value in distances.items():
                with_distances = with_distances.replace(name + "L", f"{value}L")
            distances = distances_in(toolchain, folder, with_distances)
        yield claim, with_distances


def distances_in(toolchain, folder, text):
    place = tempfile.mkdtemp(dir=folder)
    path = os.path.join(place, "bvh_median.c")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    thief = Unit(FEATURE, path, "bvh_median.c", False)
    linked, _ = build.compile_unit(toolchain, thief, place, toolchain.of_units)
    build.keep_interface(toolchain, FEATURE, linked)
    program = build.link_suite(toolchain, [thief], [linked], place, toolchain.sanitize)
    said = subprocess.run([toolchain.tools["nm"], program], capture_output=True, text=True, check=True).stdout
    places = {name: int(value, 16) for value, name in re.findall(r"^(\w+) \w (\w+)$", said, re.MULTILINE)}
    return {"WITNESS": places["witness"] - places["rk_bvh_build_median"],
            "FAILED": places["rk_claim_failed"] - places["rk_bvh_build_median"]}


def verdicts_are_not_taken(grader, folder):
    scored = [test for test in ALL if test.points]
    suites = {claim: grader.add(text, scored) for claim, text in thieves(grader.toolchain, folder)}
    grader.grade(decoys=len(scored))  # a few, by chance, may be claims that do not call what steals
    for claim, suite in suites.items():
        check(suite.points() == 0 and "attests a claim that cannot hold" in suite.problem,
              f"{claim} is found by decoys, and gets 0", results.text([suite], ""))
    name = ("static int reads_its_name(const char *place)\n{\n    char text[4096];\n"
            "    FILE *file = fopen(place, \"r\");\n"
            "    size_t size = fread(text, 1, sizeof text, file);\n    fclose(file);\n"
            f"    return memmem(text, size, \"{EMPTY.name[3:]}\", {len(EMPTY.name) - 3}) != NULL;\n}}\n")
    reader = grader.add(unit("if (reads_its_name(\"/proc/self/cmdline\") || "
                             "reads_its_name(\"/proc/self/environ\")) abort();",
                             "void *memmem(const void *text, size_t size, "
                             "const void *part, size_t part_size);\n"
                             + by_address("fopen", "fread", "fclose") + name))
    liar = grader.add(unit("for (int file = 3; file < 64; file++)\n"
                           "        dprintf(file, \"tests/x.c:1\\n%03000d\", 1);\n    _exit(1);",
                           by_address("dprintf", "_exit")))
    grader.grade()
    check(reader.passed(), "neither command nor environment tells which test runs",
          results.text([reader], ""))
    reason = liar.verdicts[EMPTY.name].reason
    check(not liar.passed() and len(reason) < 600, "a unit that writes its own reason has little room",
          len(reason))


def a_class_is_told(folder):
    """What the instructor's table says."""
    copy = re.sub(r"/\*.*?\*/", "", RIGHT, flags=re.DOTALL).replace("    ", "\t")
    for name, text in {"=HYPERLINK(1)": unit("exit(0);"), "copy": copy}.items():
        os.makedirs(os.path.join(folder, "class", name))
        with open(os.path.join(folder, "class", name, "bvh_median.c"), "w", encoding="utf-8") as file:
            file.write(text)
    out = os.path.join(folder, "results")
    _, said = run(".", sys.executable, "-B", os.path.join(SOURCE, "tools", "grade_class.py"), "bvh_median",
                  "--submissions", os.path.join(folder, "class"), "--out", out)
    with open(os.path.join(out, "class.csv"), encoding="utf-8", newline="") as file:
        rows = {row[0]: row for row in csv.reader(file)}
    check("'=HYPERLINK(1)" in rows and "=HYPERLINK(1)" not in rows, "no cell of class.csv is a formula", rows)
    check(not SOLVED or "the same text as the reference" in " ".join(rows["copy"]),
          "a copy of the reference is told", said)


def main():
    sandbox.prepare()
    toolchain = build.Toolchain(".")
    folder = tempfile.mkdtemp(prefix="raykit-test-rules-")
    grader = Grader(toolchain, folder)
    try:
        what_reaches_around_the_suite_is_refused(grader)
        objects_are_looked_at(toolchain, folder)
        honest_code_is_not_refused(grader)
        long_texts_take_little(grader)
        reasons_fit(grader)
        no_constant_is_written(grader)
        what_is_kept_is_named(grader)
        if toolchain.finds_leaks():
            a_leak_is_a_claim_of_its_own(grader)
        what_held_and_breaks_costs_points(grader)
        verdicts_are_not_taken(grader, folder)
        a_class_is_told(folder)
    finally:
        sandbox.end_strays()
        shutil.rmtree(folder, ignore_errors=True)
    return finish()


if __name__ == "__main__":
    start(main)
