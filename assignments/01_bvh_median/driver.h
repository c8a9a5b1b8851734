/* Declarations that the files of this driver share. */
#ifndef RK_01_BVH_MEDIAN_DRIVER_H
#define RK_01_BVH_MEDIAN_DRIVER_H

#include "driver/driver_main.h"
#include "driver/tree_view.h"

typedef struct choices {
    rk_tree_view tree;
    uint32_t steps; /* drawn by --debug traversal */
} choices;

/* Renders, draws the steps of --debug traversal over the picture, and prints all of them. */
bool draw_traversal(rk_driver *driver, rk_error *error);
bool save_traversal(rk_driver *driver, rk_error *error);

#endif
