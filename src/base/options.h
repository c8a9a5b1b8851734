/* Command-line options from tables: parsed by getopt_long, checked against their ranges, listed
 * by --help with their defaults. */
#ifndef RK_BASE_OPTIONS_H
#define RK_BASE_OPTIONS_H

#include "base/option_row.h"

/* Rows, and the struct whose fields they name: its present values are the defaults. */
typedef struct rk_option_table {
    const rk_option *rows; /* ended by a NULL name */
    void *values;
} rk_option_table;

typedef enum rk_options_result {
    RK_OPTIONS_OK,
    RK_OPTIONS_DONE, /* --help or --version was printed: exit with success */
    RK_OPTIONS_BAD,  /* the error names the option, its range, and --help: exit with failure */
} rk_options_result;

/* Reads argv by the tables. */
rk_options_result rk_options_parse(int argc, char **argv, const char *summary,
                                   const rk_option_table *tables, size_t table_count,
                                   rk_error *error);

/* Returns the row whose name or alias the argument, --name or --name=value, spells out; NULL if
 * there is none. */
const rk_option *rk_options_find(const rk_option_table *tables, size_t table_count,
                                 const char *argument);

#endif
