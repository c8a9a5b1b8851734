/* Rows of numbers that a live figure or a plot draws, such as the points of a curve. */
#ifndef RK_DRIVER_NUMBER_ROW_H
#define RK_DRIVER_NUMBER_ROW_H

#include "driver/driver.h"

/* Puts a row into OUT/tables/NAME.csv: the scene, then a number for each of `columns`, which are
 * separated by spaces. A row with the same scene and the same first `keys` numbers is replaced.
 * Nine digits tell all floats apart. */
bool rk_driver_number_row(const rk_driver *driver, const char *name, const char *columns,
                          size_t keys, const double *numbers, rk_error *error);

#endif
