/* The command line for captions; not installed. */
#ifndef RK_DRIVER_DRIVER_COMMAND_H
#define RK_DRIVER_DRIVER_COMMAND_H

#include "driver/driver.h"
#include "render/feature_list.h"

/* All options of a driver, in the order of --help. */
typedef struct rk_driver_tables {
    rk_option_table tables[4 + RK_FEATURE_COUNT];
    size_t count;
} rk_driver_tables;

/* Fills in driver->parameters: the command line from the program's bare name on, files without
 * their folders, options in their present spelling. */
void rk_driver_note_command(rk_driver *driver, const rk_driver_tables *all);

#endif
