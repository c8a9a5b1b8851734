/* The renderer's options as a table for the command line; not installed. */
#ifndef RK_RENDER_OPTIONS_H
#define RK_RENDER_OPTIONS_H

#include "base/options.h"
#include "render/plan.h"

typedef struct rk_option_table {
    rk_option options[48]; /* ended by a NULL name */
} rk_option_table;

/* A table that reads into `options`, whose present values are the defaults. */
rk_option_table rk_render_option_table(rk_render_options *options);

/* Do the options go together? False with an error that names those that do not. */
bool rk_render_options_check(const rk_render_options *options, rk_error *error);

#endif
