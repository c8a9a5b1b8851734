/* Command-line options from a table: parsed by getopt_long, checked against their ranges, listed
 * by --help with their defaults. */
#ifndef RK_BASE_OPTIONS_H
#define RK_BASE_OPTIONS_H

#include "base/error.h"

typedef enum rk_option_kind {
    RK_OPTION_FLAG,   /* bool: --name sets it */
    RK_OPTION_UINT,   /* uint32_t in [low, high] */
    RK_OPTION_FLOAT,  /* float in [low, high]; NaN is refused, but as a default means: not given */
    RK_OPTION_TEXT,   /* const char *, pointing into argv */
    RK_OPTION_LIST,   /* rk_text_list: --name may come again */
    RK_OPTION_PIXEL,  /* rk_pixel: X,Y */
    RK_OPTION_CHOICE, /* an enumeration from 0 on; `argument` has its names: "off|lambert|phong" */
} rk_option_kind;

enum { RK_TEXT_LIST_MAX = 64 };

typedef struct rk_text_list {
    size_t count;
    const char *items[RK_TEXT_LIST_MAX];
} rk_text_list;

typedef struct rk_pixel {
    bool given;
    unsigned x, y;
} rk_pixel;

typedef struct rk_option {
    const char *name; /* without dashes; NULL ends a table */
    rk_option_kind kind;
    void *value; /* where the default stands and the given value goes; NaN or a whole number
                    above `high` stands for "not given" */
    const char *argument; /* its name in --help: FILE, N, or a choice's names; NULL for flags */
    const char *help;     /* what it is, with its unit; a newline starts a further line; several
                             spaces after a name in a list are kept */
    double low, high;     /* for numbers; both inclusive */
} rk_option;

typedef enum rk_options_result {
    RK_OPTIONS_OK,
    RK_OPTIONS_DONE, /* --help or --version was printed: exit with success */
    RK_OPTIONS_BAD,  /* the error names the option, its range, and --help: exit with failure */
} rk_options_result;

/* Reads argv by the tables (common ones and the program's own), each ended by a NULL name. */
rk_options_result rk_options_parse(int argc, char **argv, const char *summary,
                                   const rk_option *const *tables, size_t table_count,
                                   rk_error *error);

#endif
