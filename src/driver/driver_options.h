/* The options of all drivers; not installed. */
#ifndef RK_DRIVER_DRIVER_OPTIONS_H
#define RK_DRIVER_DRIVER_OPTIONS_H

#include "driver/driver_main.h"

/* Sets the spec's own options to the defaults of their rows, and the common ones to the spec's
 * defaults. */
void rk_driver_set_defaults(rk_driver *driver, const rk_driver_spec *spec);

/* Reads the command line, and checks that its options go together. */
rk_options_result rk_driver_read_options(rk_driver *driver, const rk_driver_spec *spec, int argc,
                                         char **argv, rk_error *error);

#endif
