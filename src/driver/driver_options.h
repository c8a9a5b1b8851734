/* The options of all drivers: reading them, the command line for captions, options without effect;
 * not installed. */
#ifndef RK_DRIVER_DRIVER_OPTIONS_H
#define RK_DRIVER_DRIVER_OPTIONS_H

#include "driver/driver_main.h"
#include "render/feature_list.h"

/* Sets the spec's own options to the defaults of their rows, and the common ones to the spec's
 * defaults. */
void rk_driver_set_defaults(rk_driver *driver, const rk_driver_spec *spec);

/* Reads the command line, and checks that its options go together. */
rk_options_result rk_driver_read_options(rk_driver *driver, const rk_driver_spec *spec, int argc,
                                         char **argv, rk_error *error);

/* All options of a driver, in the order of --help. */
typedef struct rk_driver_tables {
    rk_option_table tables[4 + RK_FEATURE_COUNT];
    size_t count;
} rk_driver_tables;

/* Fills in driver->parameters: the command line from the program's bare name on, files without
 * their folders, options in their present spelling. */
void rk_driver_note_command(rk_driver *driver, const rk_driver_tables *all);

/* Prints a note to standard error for each feature that the picture needs neither with the command
 * line nor without, although options of it are given, and for --max-depth without bounces; the
 * first of them is named as it was typed. Silent by --quiet and --timing. */
void rk_driver_note_unused(const rk_driver *driver);

#endif
