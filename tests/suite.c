/* The main of every suite. Runs all tests, those that match a pattern, or exactly one; the last
 * form can attest its verdict to the calling program, so that printing "ok" proves nothing. */
#define _DEFAULT_SOURCE /* for MAP_ANONYMOUS */
#include "judge_hooks.h"
#include "test.h"

#include <fnmatch.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

typedef struct attestation {
    int file; /* descriptor to write to, or -1 */
    char nonce[65];
} attestation;

/* The one test of --only, and where its verdict is attested. */
static const struct CMUnitTest *only;
static attestation witness = {.file = -1};
static bool a_claim_was_told;

/* Of the leak sanitizer, where the program is linked with it: whether memory is lost. */
int __lsan_do_recoverable_leak_check(void) __attribute__((weak));

/* RAYKIT_ATTEST names a descriptor: a secret of up to 64 characters is read from it, once, and
 * either the secret, followed by "leaks" if memory was lost, or the failed claim is written back.
 */
static void take_attestation(void)
{
    char *value = getenv("RAYKIT_ATTEST");
    if (!value)
        return;
    int file = atoi(value);
    ssize_t size = read(file, witness.nonce, sizeof witness.nonce - 1);
    if (size > 0)
        witness.file = file;
    memset(value, 'x', strlen(value));
    unsetenv("RAYKIT_ATTEST");
}

/* A secret whose first digit is odd asks for a decoy: a claim of the grader's own that never holds.
 * Code that sends the secret in place of the suite knows this no better than the suite's reader. */
static bool is_decoy(void)
{
    return witness.file >= 0 && witness.nonce[0] % 2 != 0;
}

/* A failing test does not return from its function. */
static void run_and_attest(void **state)
{
    size_t kept = rk_allocations_kept;
    only->test_func(state);
    if (rk_judge_end_of_test)
        rk_judge_end_of_test();
    rk_check(!is_decoy(), "a claim that never holds");
    if (witness.file < 0)
        return;
    /* A search takes longer than most claims, and finds nothing where all memory was freed. */
    bool all_is_freed = rk_allocations_are_counted && rk_allocations_kept == kept;
    bool leaks = !all_is_freed && __lsan_do_recoverable_leak_check &&
                 __lsan_do_recoverable_leak_check() != 0;
    if (dprintf(witness.file, "%s%s", witness.nonce, leaks ? "leaks" : "") < 0)
        fail_msg("the verdict could not be attested");
}

void rk_claim_failed(const char *file, int line, const char *format, ...)
{
    if (rk_judge_end_of_test && rk_judge_end_of_test())
        return;
    char message[2000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    print_error("%s\n", message);
    a_claim_was_told = true;
    if (witness.file >= 0)
        dprintf(witness.file, "%s:%d\n%s", file, line, message);
    _fail(file, line);
}

void rk_claim_of_value_failed(const char *file, int line, const char *what, double got, double want,
                              double tolerance, const char *hint, const rk_mistake *known)
{
    bool is_named = strcmp(what, "got") != 0;
    char within[40] = "";
    if (tolerance != 0)
        snprintf(within, sizeof within, " within %.3g", tolerance);
    rk_claim_failed(file, line, "%s%sgot %.9g, want %.9g%s%s%s%s", is_named ? what : "",
                    is_named ? ": " : "", got, want, within, hint ? ": " : "", hint ? hint : "",
                    rk_mistake_in(got, want, tolerance, known));
}

static struct {
    char *start;
    size_t size;
    const char *name;
} read_only[8];
static int read_only_count;
static struct sigaction before_read_only[2];
static const int faults[2] = {SIGSEGV, SIGBUS};

/* glibc's own name: graded, the address sanitizer ignores sigaction (handle_segv=2), so that
 * crashes are its to report; faults that a test provokes are the suite's. */
extern int __sigaction(int, const struct sigaction *, struct sigaction *) __attribute__((weak));

void rk_handle_fault(int signal, const struct sigaction *now, struct sigaction *before)
{
    if (__sigaction)
        __sigaction(signal, now, before);
    else
        sigaction(signal, now, before);
}

/* cmocka's own handler leaves the test in the same way. */
static void tell_of_a_write(int signal, siginfo_t *info, void *context)
{
    (void)context;
    for (int i = 0; i < read_only_count; i++)
        if ((char *)info->si_addr >= read_only[i].start &&
            (char *)info->si_addr < read_only[i].start + read_only[i].size)
            rk_claim_failed(
                __FILE__, __LINE__,
                "a write to the caller's %s, which is constant: other threads read it at "
                "the same time, so putting it back is too late",
                read_only[i].name);
    rk_handle_fault(signal, &before_read_only[signal == faults[1]],
                    NULL); /* the fault comes again */
}

const void *rk_read_only(const void *value, size_t size, const char *name)
{
    rk_check(read_only_count < (int)(sizeof read_only / sizeof *read_only), "too many copies");
    char *start = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    rk_check(start != MAP_FAILED, "no memory for %zu bytes", size);
    memcpy(start, value, size);
    rk_check(mprotect(start, size, PROT_READ) == 0, "%zu bytes cannot be made read-only", size);
    struct sigaction tell = {.sa_sigaction = tell_of_a_write, .sa_flags = SA_SIGINFO | SA_NODEFER};
    for (int i = 0; i < 2 && read_only_count == 0; i++)
        rk_handle_fault(faults[i], &tell, &before_read_only[i]);
    read_only[read_only_count].start = start;
    read_only[read_only_count].size = size;
    read_only[read_only_count++].name = name;
    return start;
}

void rk_read_only_free(void)
{
    for (int i = 0; i < 2 && read_only_count > 0; i++)
        rk_handle_fault(faults[i], &before_read_only[i], NULL);
    while (read_only_count > 0) {
        read_only_count--;
        if (rk_judge_forget)
            rk_judge_forget(read_only[read_only_count].start);
        munmap(read_only[read_only_count].start, read_only[read_only_count].size);
    }
}

static int list_tests(const struct CMUnitTest *tests, size_t count)
{
    for (size_t i = 0; i < count; i++)
        puts(tests[i].name);
    return 0;
}

static const struct CMUnitTest *find_test(const rk_suite *suite, const char *name)
{
    for (size_t i = 0; i < suite->count; i++)
        if (strcmp(suite->tests[i].name, name) == 0)
            return &suite->tests[i];
    fprintf(stderr, "%s: there is no test %s; --list shows them\n", suite->name, name);
    return NULL;
}

/* Runs `only`. */
static int run_it(const rk_suite *suite)
{
    struct CMUnitTest one = *only;
    one.test_func = run_and_attest;
    if (rk_judge_connect)
        rk_judge_connect(only->name);
    int failures = _cmocka_run_group_tests(suite->name, &one, 1, suite->set_up, suite->tear_down);
    if (rk_judge_disconnect)
        rk_judge_disconnect();
    return failures;
}

/* The name is blanked, so that the tested code does not read in its command which test it is. */
static int run_only(const rk_suite *suite, char *name)
{
    only = find_test(suite, name);
    if (!only)
        return 2;
    memset(name, 'x', strlen(name));
    int failures = run_it(suite);
    if (failures && witness.file >= 0 && !a_claim_was_told)
        dprintf(witness.file, ":0\nfailed");
    return failures;
}

/* --- Several, for a judge --- */

static const rk_suite *judged;

static bool holds(void *test)
{
    only = test;
    witness.file = -1; /* all of them are attested together */
    return run_it(judged) == 0;
}

/* Attests them all, with the seconds of each, or none. */
static int run_several(const rk_suite *suite, char **names, size_t count)
{
    enum { MOST = 64 };
    void *tests[MOST];
    double seconds[MOST];
    if (!rk_judge_all_hold || count > MOST) {
        fprintf(stderr, "%s: --only takes one test here, and up to %d in a judge\n", suite->name,
                MOST);
        return 2;
    }
    for (size_t i = 0; i < count; i++)
        if (!(tests[i] = (void *)(uintptr_t)find_test(suite, names[i])))
            return 2;
    judged = suite;
    if (!rk_judge_all_hold(holds, tests, seconds, count) || is_decoy() || witness.file < 0)
        return 1;
    char told[MOST * 16] = "";
    for (size_t i = 0, end = 0; i < count && end < sizeof told; i++)
        end += (size_t)snprintf(told + end, sizeof told - end, " %.3f", seconds[i]);
    return dprintf(witness.file, "%s%s", witness.nonce, told) > 0 ? 0 : 1;
}

/* RAYKIT_TIMES names a file: each claim that ran adds a line with its processor seconds, those of
 * its child processes included, its suite and its name. Claims run in their order, so their
 * fixtures know which one is meant. */
static struct {
    const rk_suite *suite;
    size_t next;
    double began;
    FILE *file;
} times;

static double seconds_of(int who)
{
    struct rusage used;
    getrusage(who, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static double processor_seconds(void)
{
    return seconds_of(RUSAGE_SELF) + seconds_of(RUSAGE_CHILDREN);
}

static int begin_time(void **state)
{
    CMFixtureFunction set_up = times.suite->tests[times.next++].setup_func;
    times.began = processor_seconds();
    return set_up ? set_up(state) : 0;
}

static int end_time(void **state)
{
    const struct CMUnitTest *test = &times.suite->tests[times.next - 1];
    int status = test->teardown_func ? test->teardown_func(state) : 0;
    fprintf(times.file, "%.3f\t%s\t%s\n", processor_seconds() - times.began, times.suite->name,
            test->name);
    return status;
}

static int run_timed(const rk_suite *suite, const char *path)
{
    struct CMUnitTest *timed = malloc(suite->count * sizeof *timed);
    times.file = fopen(path, "a");
    if (!timed || !times.file) {
        fprintf(stderr, "%s: RAYKIT_TIMES names %s, which cannot be written\n", suite->name, path);
        free(timed);
        return 2;
    }
    times.suite = suite;
    for (size_t i = 0; i < suite->count; i++) {
        timed[i] = suite->tests[i];
        timed[i].setup_func = begin_time;
        timed[i].teardown_func = end_time;
    }
    int failures =
        _cmocka_run_group_tests(suite->name, timed, suite->count, suite->set_up, suite->tear_down);
    fclose(times.file);
    free(timed);
    return failures;
}

static int run_all(const rk_suite *suite)
{
    const char *times_file = getenv("RAYKIT_TIMES");
    if (times_file && *times_file)
        return run_timed(suite, times_file);
    return _cmocka_run_group_tests(suite->name, suite->tests, suite->count, suite->set_up,
                                   suite->tear_down);
}

static int run_matching(const rk_suite *suite, const char *pattern)
{
    size_t matching = 0;
    for (size_t i = 0; i < suite->count; i++)
        matching += fnmatch(pattern, suite->tests[i].name, 0) == 0;
    if (matching == 0) {
        fprintf(stderr, "%s: no test's name matches %s; --list shows them\n", suite->name, pattern);
        return 2;
    }
    cmocka_set_test_filter(pattern);
    return _cmocka_run_group_tests(suite->name, suite->tests, suite->count, suite->set_up,
                                   suite->tear_down);
}

uint32_t rk_case_seed;

static void take_seed(void)
{
    const char *value = getenv("RAYKIT_SEED");
    uint32_t seed = value ? (uint32_t)strtoul(value, NULL, 10) : 0;
    rk_case_seed = seed ? rk_hash(seed, 0, 0, 0) : 0; /* not the cases of 0 in another order */
}

int rk_suite_main(const rk_suite *suite, int argc, char **argv)
{
    take_attestation();
    take_seed();
    if (argc == 2 && strcmp(argv[1], "--list") == 0)
        return list_tests(suite->tests, suite->count);
    if (argc == 3 && strcmp(argv[1], "--only") == 0)
        return run_only(suite, argv[2]);
    if (argc > 3 && strcmp(argv[1], "--only") == 0)
        return run_several(suite, argv + 2, (size_t)argc - 2);
    if (argc > 2 || (argc == 2 && argv[1][0] == '-')) {
        fprintf(stderr, "usage: %s [--list | --only TEST | PATTERN]\n", argv[0]);
        return 2;
    }
    int failures = argc == 2 ? run_matching(suite, argv[1]) : run_all(suite);
    const char *format = getenv("CMOCKA_MESSAGE_OUTPUT");
    bool verdicts_are_printed = format && strcmp(format, "TAP") == 0 && failures >= 0 && argc == 1;
    return verdicts_are_printed ? 0 : failures;
}
