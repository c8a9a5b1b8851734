/* What options.c and options_help.c share; not installed. */
#ifndef RK_BASE_OPTIONS_WORDS_H
#define RK_BASE_OPTIONS_WORDS_H

#include "base/options.h"

#include <stddef.h>
#include <stdint.h>

typedef struct rk_phrase {
    char text[160];
} rk_phrase;

/* "1 to 64", "0 or more", "up to 5", or "" when every number will do. */
rk_phrase rk_option_range(const rk_option *option);

/* "a whole number, 1 to 64": what a complaint says. */
rk_phrase rk_option_takes(const rk_option *option);

/* The name of a choice's value, as long as *length says. */
const char *rk_option_choice_name(const rk_option *option, uint32_t value, size_t *length);

/* Prints --help of `count` options to standard output. */
void rk_options_print_help(const char *program, const char *summary,
                           const rk_option *const *options, size_t count);

#endif
