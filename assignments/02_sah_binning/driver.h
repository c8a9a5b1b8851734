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
    bool splits;
} choices;

/* A node, and the candidate splits of it. */
typedef struct splits {
    uint32_t node;      /* index of the node: parents first, left before right */
    uint32_t candidate; /* index of a split, or RK_TREE_VIEW_NOT_GIVEN */
    uint32_t visited;   /* nodes */
    const rk_bvh_node *found;
    rk_bvh_reference *references; /* the node's triangles */
    uint32_t triangles, count;
    rk_sah_split list[RK_SAH_CANDIDATES_MAX];
} splits;

/* Lists the candidates of --node, as the builder saw them; false if there are none. The caller
 * frees the references, if they are not NULL, in either case. */
bool list_splits(splits *c, const rk_driver *driver, rk_error *error);

/* Does --debug name a view of a node's splits? */
bool wants_splits(const rk_driver *driver);

/* Renders and draws --debug split, bad-split or candidates. */
bool draw_splits(rk_driver *driver, rk_error *error);

/* Saves the picture, and prints the numbers of the splits drawn. */
bool save_splits(rk_driver *driver, rk_error *error);

/* Puts the tables of --splits. */
bool put_study(rk_driver *driver, rk_error *error);

#endif
