/* Errors: a function that can fail for a reason outside the program returns false and leaves one
 * sentence that names the thing, the place and the remedy. */
#ifndef RK_BASE_ERROR_H
#define RK_BASE_ERROR_H

#include <stdbool.h>
#include <stddef.h>

typedef struct rk_error {
    char text[1024]; /* one line without a newline; "" while all is well */
} rk_error;

/* Writes the sentence, truncated to fit, with control characters as \x1b, and returns false, so
 * that callers can `return rk_fail(...)`. `error` may be NULL if the caller needs no reason. */
bool rk_fail(rk_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Returns `count` zeroed elements of `size` bytes, aligned to a cache line (64 bytes), or NULL with
 * an error that names `what` when memory is short or the product overflows. Release with free().
 * Zero elements give a valid pointer. */
void *rk_allocate(size_t count, size_t size, const char *what, rk_error *error);

/* The same without the zeroes, for big arrays that are filled at once. */
void *rk_allocate_unset(size_t count, size_t size, const char *what, rk_error *error);

#endif
