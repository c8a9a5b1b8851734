/* Options in words: for option_row.c, options.c and options_help.c; not installed. */
#ifndef RK_BASE_OPTIONS_WORDS_H
#define RK_BASE_OPTIONS_WORDS_H

#include "base/options.h"

typedef struct rk_phrase {
    char text[160];
} rk_phrase;

/* A row and its field. */
typedef struct rk_bound_option {
    const rk_option *row;
    void *value;
} rk_bound_option;

/* "1 to 64", "0 or more", "up to 5", or "" if every number is accepted. */
rk_phrase rk_option_range(const rk_option *option);

/* "a whole number, 1 to 64", for error messages. */
rk_phrase rk_option_takes(const rk_option *option);

/* "uniform|stratified". */
rk_phrase rk_names_list(const rk_names *names);

/* Prints --help of `count` options to standard output. */
void rk_options_print_help(const char *program, const char *summary, const rk_bound_option *options,
                           size_t count);

#endif
