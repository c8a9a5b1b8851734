/* Options without effect; not installed. */
#ifndef RK_DRIVER_DRIVER_UNUSED_H
#define RK_DRIVER_DRIVER_UNUSED_H

#include "driver/driver.h"

/* Prints a note to standard error for each feature that the picture needs neither with the command
 * line nor without, although options of it are given, and for --max-depth without bounces; the
 * first of them is named as it was typed. Silent by --quiet and --timing. */
void rk_driver_note_unused(const rk_driver *driver);

#endif
