/* Declarations that the files of this driver share. */
#ifndef RK_02_SAH_BINNING_DRIVER_H
#define RK_02_SAH_BINNING_DRIVER_H

#include "driver/driver_main.h"
#include "driver/tree_view.h"
#include "features/sah_binning.h"

typedef struct choices {
    rk_tree_view tree;
    uint32_t node; /* whose splits are drawn: 0 is the root, parents first, left before right */
    uint32_t candidate; /* index of a split, or RK_TREE_VIEW_NOT_GIVEN */
} choices;

/* Does --debug name a view of a node's splits? */
bool wants_splits(const rk_driver *driver);

/* Renders and draws --debug split, bad-split or candidates. */
bool draw_splits(rk_driver *driver, rk_error *error);

/* Saves the picture, and prints the numbers of the splits drawn. */
bool save_splits(rk_driver *driver, rk_error *error);

#endif
