/* An option is one row: its name, the field that it sets, its range and default, its help. The row
 * serves the default (rk_options_set_defaults), the command line and --help (base/options.h), and
 * the check of values that a program set itself (rk_options_check). */
#ifndef RK_BASE_OPTION_ROW_H
#define RK_BASE_OPTION_ROW_H

#include "base/error.h"
#include "base/names.h"

typedef enum rk_option_kind {
    RK_OPTION_FLAG,   /* bool: --name sets it */
    RK_OPTION_UINT,   /* uint32_t in [low, high] */
    RK_OPTION_FLOAT,  /* float in [low, high]; NaN is refused; as a default it means "not given" */
    RK_OPTION_TEXT,   /* const char *, pointing into argv */
    RK_OPTION_LIST,   /* rk_text_list: --name may be repeated */
    RK_OPTION_PIXEL,  /* rk_pixel: X,Y */
    RK_OPTION_CHOICE, /* an enumeration from 0 on, by its names */
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
    const char *name; /* without dashes; NULL ends a table of rows */
    /* These four by RK_FIELD or RK_CHOICE. */
    const char *field; /* "light.samples", for messages to programs */
    size_t offset;     /* of the field in the struct that the table is for */
    rk_option_kind kind;
    const rk_names *names; /* of a choice */
    const char *argument;  /* its name in --help: FILE, N; NULL for flags and choices */
    const char *help;      /* with the unit; a newline starts a further line; several spaces after
                              a name in a list are kept */
    double low, high;      /* for numbers; both inclusive */
    double initial;        /* the default of numbers, choices and flags; NaN or a whole number above
                              `high` stands for "not given" */
    const char *initial_text; /* the default of texts; NULL: none */
    const char *alias;        /* an older spelling, still read but not listed; NULL: none */
    const char *views; /* the values of --debug with which it goes, "node" or "split bad-split";
                          NULL: with all, and without --debug */
    bool of_scene; /* scene or tree depend on it: live figures make these anew when it changes */
} rk_option;

/* clang-format off */
/* A row's field; its type determines the kind. */
#define RK_FIELD(type, member)                                                                     \
    .field = #member, .offset = offsetof(type, member),                                            \
    .kind = _Generic(((type *)0)->member,                                                          \
                     bool: RK_OPTION_FLAG,                                                         \
                     uint32_t: RK_OPTION_UINT,                                                     \
                     float: RK_OPTION_FLOAT,                                                       \
                     const char *: RK_OPTION_TEXT,                                                 \
                     rk_text_list: RK_OPTION_LIST,                                                 \
                     rk_pixel: RK_OPTION_PIXEL),                                                   \
    .names = NULL

/* A field that holds one of an enumeration's values; the help comes next. */
#define RK_CHOICE(type, member, of_names)                                                          \
    .field = #member, .offset = offsetof(type, member),                                            \
    .kind = _Generic(((type *)0)->member, uint32_t: RK_OPTION_CHOICE),                             \
    .names = &(of_names), .argument = NULL
/* clang-format on */

/* Sets the fields of all rows, ended by a NULL name, to their defaults; other fields stay. */
void rk_options_set_defaults(const rk_option *rows, void *values);

/* Is each field in its range, or its default? False with an error that names the first that is
 * not. */
bool rk_options_check(const rk_option *rows, const void *values, rk_error *error);

#endif
