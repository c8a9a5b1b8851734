/* The names of an enumeration; the compiler checks their number. */
#ifndef RK_BASE_NAMES_H
#define RK_BASE_NAMES_H

#include <stdint.h>

/* The names of an enumeration's values, which count from 0 on: in options, tables and messages. */
typedef struct rk_names {
    const char *type; /* "rk_sampler_kind" */
    uint32_t count;
    const char *const *items; /* count */
} rk_names;

/* Defines `variable` as the names of `type` from 0 to `last`; the compiler refuses a wrong number
 * of names. */
#define RK_NAMES(variable, type, last, ...)                                                        \
    static const char *const variable##_items[] = {__VA_ARGS__};                                   \
    _Static_assert(sizeof variable##_items / sizeof *variable##_items == (last) + 1,               \
                   "each " #type " has one name");                                                 \
    const rk_names variable = {#type, (last) + 1, variable##_items}

#endif
