/* Which features of a picture are still to be written, for notes. */
#ifndef RK_DRIVER_UNSOLVED_H
#define RK_DRIVER_UNSOLVED_H

#include "driver/driver.h"

/* Is the feature's unit still the starter? */
bool rk_is_starter(const char *stem);

/* A phrase about a picture's units: "shading and bloom are still the starters", or empty. */
typedef struct rk_unsolved {
    char text[512];
} rk_unsolved;

/* `plan`: of the picture. */
rk_unsolved rk_unsolved_features_of(const rk_plan *plan);

/* The same of the driver's picture, and of the tree that it is a view of. */
rk_unsolved rk_driver_unsolved(const rk_driver *driver);

/* "units: mine (bvh_median), others: the kit's", with those units that the driver's picture uses;
 * empty if all of the driver's units are the kit's. */
rk_unsolved rk_driver_units(const rk_driver *driver);

/* Prints the starters of the driver's picture, unless --quiet. */
void rk_driver_note_unsolved(const rk_driver *driver);

#endif
