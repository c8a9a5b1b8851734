/* For drivers of binary trees: the views of a level and of a leaf, and the table's rows. */
#ifndef RK_DRIVER_TREE_VIEW_H
#define RK_DRIVER_TREE_VIEW_H

#include "driver/driver.h"

#define RK_TREE_VIEW_NOT_GIVEN UINT32_MAX

/* Values of --level and --leaf; RK_TREE_VIEW_NOT_GIVEN until the user gives them. */
typedef struct rk_tree_view {
    uint32_t level, leaf;
} rk_tree_view;

/* The two options' rows, for a driver's own table: `view` is a rk_tree_view of struct `type`. */
#define RK_TREE_VIEW_OPTIONS(type, view)                                                           \
    {"level",                                                                                      \
     RK_FIELD(type, view.level),                                                                   \
     "N",                                                                                          \
     "level drawn by --debug level; 0 is the root; by default 4, or the deepest",                  \
     0,                                                                                            \
     RK_BVH_LEVELS_MAX - 1,                                                                        \
     RK_TREE_VIEW_NOT_GIVEN,                                                                       \
     .views = "level"},                                                                            \
    {                                                                                              \
        "leaf", RK_FIELD(type, view.leaf), "N",                                                    \
            "leaf drawn by --debug leaf, counted from the left; by default 0", 0, UINT32_MAX - 1,  \
            RK_TREE_VIEW_NOT_GIVEN, .views = "leaf"                                                \
    }

/* Chooses the level and the leaf to draw. Errors name the tree's range. */
bool rk_tree_view_choose(rk_tree_view *view, const rk_driver *driver, rk_error *error);

/* Renders, and draws --debug level or --debug leaf over the picture. */
bool rk_tree_view_draw(const rk_tree_view *view, rk_driver *driver, rk_error *error);

/* Saves that, or the plain picture without --debug. */
bool rk_tree_view_save(const rk_tree_view *view, rk_driver *driver, rk_error *error);

/* Darkens the picture, so that small drawings stand out. */
void rk_tree_view_dim(const rk_image *image);

/* Rows: build and render time, the tree's shape, tests per camera ray; with --shadows the render
 * time alone. */
bool rk_tree_view_rows(rk_driver *driver, rk_error *error);

#endif
