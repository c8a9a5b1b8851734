/* The base of every suite: checks that print the value they got and the value they wanted with a
 * hint, and a main that speaks TAP under `make check`.
 *
 * cmocka's own float assertions accept NaN and compare absolutely; these refuse NaN, and the caller
 * gives the tolerance, with its reason beside it. */
#ifndef RK_TESTS_TEST_H
#define RK_TESTS_TEST_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "base/sanitized.h"

/* Fails the test with the hint (a printf format and its arguments) unless true. */
#define rk_check(condition, ...)                                                                   \
    do {                                                                                           \
        if (!(condition))                                                                          \
            rk_claim_failed(__FILE__, __LINE__, __VA_ARGS__);                                      \
    } while (0)

/* 32 random bits for a test's inputs, by rk_hash. They are the same in each run, unless RAYKIT_SEED
 * is another number than 0. */
extern uint32_t rk_case_seed;
static inline uint32_t rk_case(uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    return rk_hash(a + rk_case_seed, b, c, d);
}
/* Ends the test: prints the hint, and sends it to a grader, which then need not guess it from the
 * printed lines. */
void rk_claim_failed(const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Begins what is said of a value that a known mistake gives. */
#define RK_EXAMPLE_IF "; you get this, for example, if "

/* A mistake that people make: the value that comes of it, and what is wrong, as a clause that goes
 * on after "you get this, for example, if": "the aperture is taken as the radius". */
typedef struct rk_mistake {
    double value;
    const char *said;
} rk_mistake;

typedef struct rk_vector_mistake {
    double value[3];
    const char *said;
} rk_vector_mistake;

/* Rows {value, said} for the functions below. */
#define RK_MISTAKES(...) ((const rk_mistake[]){__VA_ARGS__, {0, NULL}})
#define RK_VECTOR_MISTAKES(...) ((const rk_vector_mistake[]){__VA_ARGS__, {{0}, NULL}})

/* The three components of an rk_vec3, as numbers. */
#define RK_XYZ(v) ((const double[]){(double)(v).x, (double)(v).y, (double)(v).z})

/* Return what a wrong value says of the mistake, for the end of a message: "; it is twice the
 * wanted: ...", or "" where it says nothing. Known mistakes, which may be NULL, come before those
 * that are common everywhere. The text holds until the next call. */
const char *rk_mistake_in(double got, double want, double tolerance, const rk_mistake *known);
const char *rk_mistake_in_whole(long long got, long long want, const rk_mistake *known);
const char *rk_mistake_in_vector(const double *got, const double *want, double tolerance,
                                 const rk_vector_mistake *known);

/* The same for a value that is not within the tolerance of the wanted one. `what` describes it, and
 * is left out where it is only "got"; so is a tolerance of 0. The hint and the mistakes may be
 * NULL.
 */
void rk_claim_of_value_failed(const char *file, int line, const char *what, double got, double want,
                              double tolerance, const char *hint, const rk_mistake *known);

/* |got - want| <= tolerance; NaN fails. */
#define rk_check_close(got, want, tolerance, hint)                                                 \
    do {                                                                                           \
        double got_ = (double)(got), want_ = (double)(want), tolerance_ = (double)(tolerance);     \
        if (!(fabs(got_ - want_) <= tolerance_))                                                   \
            rk_claim_of_value_failed(__FILE__, __LINE__, #got, got_, want_, tolerance_, hint,      \
                                     NULL);                                                        \
    } while (0)

/* The same for loops and helpers, where the expression says little: a printf format and its
 * arguments describe the compared value instead. */
#define rk_check_near(got, want, tolerance, ...)                                                   \
    rk_check_near_or(got, want, tolerance, NULL, __VA_ARGS__)

/* The same with the suite's own table of likely mistakes, RK_MISTAKES(...). */
#define rk_check_near_or(got, want, tolerance, known, ...)                                         \
    do {                                                                                           \
        double got_ = (double)(got), want_ = (double)(want), tolerance_ = (double)(tolerance);     \
        if (!(fabs(got_ - want_) <= tolerance_)) {                                                 \
            char where_[1000];                                                                     \
            snprintf(where_, sizeof where_, __VA_ARGS__);                                          \
            rk_claim_of_value_failed(__FILE__, __LINE__, where_, got_, want_, tolerance_, NULL,    \
                                     known);                                                       \
        }                                                                                          \
    } while (0)

/* Equal integers, up to 64 bits. */
#define rk_check_equal(got, want, hint)                                                            \
    do {                                                                                           \
        long long got_ = (long long)(got), want_ = (long long)(want);                              \
        rk_check(got_ == want_, "%s: got %lld, want %lld: %s%s", #got, got_, want_, hint,          \
                 rk_mistake_in_whole(got_, want_, NULL));                                          \
    } while (0)

/* The call succeeds, or the test fails with the error's text. */
#define rk_check_ok(call, error) rk_check(call, "%s", (error).text)

/* The error is one line that contains `part`. */
#define rk_check_error_names(error, part)                                                          \
    rk_check(strstr((error).text, part) != NULL, "the error should name \"%s\", but says: %s",     \
             part, (error).text)

/* The number of allocations so far, and of those not yet freed, where they can be counted; by all
 * threads. */
extern _Atomic size_t rk_allocations, rk_allocations_kept;
extern const bool rk_allocations_are_counted;

/* The allocations that still succeed, SIZE_MAX for all; after them either all fail, or one. */
extern _Atomic size_t rk_allocations_left;
extern _Atomic bool rk_one_allocation_fails;

/* malloc and related functions that fail as told, for programs whose own ones may not be wrapped.
 */
void *rk_scarce_malloc(size_t size);
void *rk_scarce_calloc(size_t count, size_t size);
void *rk_scarce_realloc(void *old, size_t size);
void *rk_scarce_aligned_alloc(size_t alignment, size_t size);

/* A copy of an argument that is constant, in memory that can only be read: where it is written,
 * even if it is put back, the test fails and names it. Others, such as threads, read it at the same
 * time. Release all copies with rk_read_only_free. */
const void *rk_read_only(const void *value, size_t size, const char *name);
void rk_read_only_free(void);

/* sigaction for SIGSEGV and SIGBUS that provoked faults reach, also beside the address sanitizer.
 */
struct sigaction;
void rk_handle_fault(int signal, const struct sigaction *now, struct sigaction *before);

typedef struct rk_suite {
    const char *name;
    const struct CMUnitTest *tests;
    size_t count;
    CMFixtureFunction set_up, tear_down; /* may be NULL */
} rk_suite;

/* argv may hold --list, --only TEST, or a pattern of test names with * and ?. Returns the number of
 * failed tests; under TAP, where the lines carry the verdict, anything but 0 means a crash or a
 * leak. */
int rk_suite_main(const rk_suite *suite, int argc, char **argv);

/* Ends a suite's file: `tests` is its array of cmocka_unit_test. */
#define RK_SUITE(name, tests) RK_SUITE_IN(name, tests, NULL, NULL)

/* The same, with a set-up before the first test and a tear-down after the last (cmocka's
 * CMFixtureFunction: 0 is success). */
#define RK_SUITE_IN(name, tests, set_up, tear_down)                                                \
    int main(int argc, char **argv)                                                                \
    {                                                                                              \
        const rk_suite suite = {name, tests, sizeof tests / sizeof tests[0], set_up, tear_down};   \
        return rk_suite_main(&suite, argc, argv);                                                  \
    }

#endif
