/* The renderer's options as tables: its own rows, and those of each feature; not installed. */
#ifndef RK_RENDER_OPTIONS_H
#define RK_RENDER_OPTIONS_H

#include "render/feature_list.h"

typedef struct rk_render_option_tables {
    rk_option_table tables[1 + RK_FEATURE_COUNT];
    size_t count;
} rk_render_option_tables;

extern const rk_names rk_shading_model_names;

/* Tables that read into `options`, whose present values are the defaults in --help. */
rk_render_option_tables rk_render_options_tables(rk_render_options *options);

/* Is each option in its range, and does each feature accept them? */
bool rk_render_options_check(const rk_render_options *options, rk_error *error);

/* Do the options of a command line go together? False with an error that names those that do not.
 */
bool rk_render_options_check_command(const rk_render_options *options, rk_error *error);

#endif
