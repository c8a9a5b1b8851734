/* Declarations that the files of this driver share. */
#ifndef RK_15_WIDE_BVH_DRIVER_H
#define RK_15_WIDE_BVH_DRIVER_H

#include "accel/batch.h"
#include "driver/driver_main.h"

typedef struct choices {
    uint32_t node;  /* whose children are drawn: 0 is the root, parents before their children */
    uint32_t level; /* 0 is the root */
    uint32_t most;  /* visits that have the brightest colour */
    bool steps, occupancy;
    /* found by draw_visits: per ray */
    double mean_visits;
    uint32_t most_visits;
} choices;

/* The tree that was built, whether rays find triangles in it or not; without nodes if its kind is
 * binary. */
const rk_wide_bvh *wide_tree(const rk_driver *driver);

/* A place of a node that has no child. */
bool is_vacant(const rk_wide_node *node, uint32_t place);

/* What a tree is made of; a leaf's triangles are tested four at once in every tree. */
typedef struct tree_shape {
    double nodes, children, blocks, bytes;
    double steps; /* expected of a ray that hits the root: nodes visited and blocks tested */
    double children_of[RK_WIDE_CHILDREN + 1]; /* nodes by their number of children */
    double triangles_of[RK_WIDE_BLOCK + 1];   /* blocks by their number of triangles */
} tree_shape;

tree_shape shape_of_binary(const rk_bvh *bvh);
tree_shape shape_of_wide(const rk_wide_bvh *wide);

/* Do --debug and --occupancy have a wide tree to show, with this node and this level? */
bool check_view(rk_driver *driver, rk_error *error);

/* Render, and draw over the picture: --debug node, level and blocks; --debug visits. */
bool draw_tree(rk_driver *driver, rk_error *error);
bool draw_visits(rk_driver *driver, rk_error *error);

/* Saves the picture, and prints what its view shows. */
bool save_view(rk_driver *driver, rk_error *error);

/* The rays of --steps. Which sixteen pixels of a tile are neighbours in its batch: a row of them,
 * or a square. */
enum { PRIMARY, SHADOW, DIFFUSE, WORKLOADS };
enum { ROWS, SQUARES, ORDERS };

typedef struct ray_set {
    uint32_t batches;
    double rays;
    rk_ray_batch *batch;             /* one for each tile */
    uint32_t (*pixel)[RK_BATCH_MAX]; /* of each ray */
} ray_set;

/* One ray through the centre of each pixel; from its hit one to the first light, and one in a
 * random direction, distributed by the cosine. Release with free_rays, also if memory is short. */
bool make_rays(ray_set sets[WORKLOADS], const rk_driver *driver, int order, const rk_accel *accel,
               rk_error *error);
void free_rays(ray_set sets[WORKLOADS]);

/* The tables of --steps and --occupancy. */
bool put_steps(rk_driver *driver, rk_error *error);
bool put_occupancy(rk_driver *driver, rk_error *error);

#endif
