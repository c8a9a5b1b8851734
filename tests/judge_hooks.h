/* What tests/suite.c calls where a judge is linked with it; elsewhere these are NULL. */
#ifndef RK_TESTS_JUDGE_HOOKS_H
#define RK_TESTS_JUDGE_HOOKS_H

#include <stdbool.h>
#include <stddef.h>

/* Before any call of the unit: maps the memory that the environment's RAYKIT_JUDGE names, for this
 * test. */
void rk_judge_connect(const char *test) __attribute__((weak));

/* A predictor's work ends with the test's function, or with a failed claim. Returns whether the
 * test goes on though a claim failed. */
bool rk_judge_end_of_test(void) __attribute__((weak));

/* Before memory is freed, or moved. */
void rk_judge_forget(const void *memory) __attribute__((weak));

/* Tells the unit's process that no more calls will come. */
void rk_judge_disconnect(void) __attribute__((weak));

/* Returns whether all claims hold, and the seconds of each: one after the other with the same
 * process of the unit, each in a fork of this one, where none finds what another one left. Ends
 * with the first that does not hold. */
bool rk_judge_all_hold(bool (*holds)(void *claim), void *claims[], double seconds[], size_t count)
    __attribute__((weak));

#endif
