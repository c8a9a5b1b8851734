/* What the files of this driver share. */
#ifndef RK_02_SAH_BINNING_DRIVER_H
#define RK_02_SAH_BINNING_DRIVER_H

#include "driver/tree_view.h"

typedef struct choices {
    rk_tree_view tree;
    uint32_t node;      /* whose cuts are drawn: 0 is the root, parents first, left before right */
    uint32_t candidate; /* of them, or RK_TREE_VIEW_NOT_GIVEN */
} choices;

/* Does --debug name a view of a node's cuts? */
bool wants_cuts(const rk_driver *driver);

/* Renders, draws driver->debug and saves it; of cuts it tells the numbers, too. */
bool draw_view(rk_driver *driver, const choices *c, rk_error *error);

#endif
