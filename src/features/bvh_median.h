/* Bounding volume hierarchy, split by the median: build the tree, then ask it what a ray meets. */
#ifndef RK_FEATURES_BVH_MEDIAN_H
#define RK_FEATURES_BVH_MEDIAN_H

#include "base/counters.h"
#include "scene/bvh.h"

/* How a builder cuts a node over the `count` triangles from `begin` on, in an order that it keeps:
 * fills in the node's box, moves the triangles of the left part to the front, and returns how many
 * they are; 0 makes the node a leaf. There may be `depth_left` levels of nodes below it. */
typedef uint32_t (*rk_bvh_split)(void *builder, uint32_t begin, uint32_t count, uint32_t depth_left,
                                 rk_box *box);

/* Fills in the nodes of a tree whose triangle_count and memory are there (rk_bvh_init): the root,
 * then what `cut` makes of each node, the children of one side by side, pairs from node 2 on. */
void rk_bvh_build_nodes(rk_bvh *bvh, rk_bvh_split cut, void *builder);

/* Builds the tree over a valid mesh (rk_mesh_validate): each node is cut on the longest axis of
 * its box, the half ceil(N / 2) of its triangles with the lowest centroids to the left, until
 * RK_BVH_LEAF_TARGET or fewer remain. O(N log N) time, at most 31 levels. A mesh without triangles
 * gives a tree without nodes. False when memory is short. Release with rk_bvh_free. */
bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error);

/* Returns the nearest hit at 0 < t <= ray->t_max; among equals the smallest triangle index. On a
 * miss hit.triangle is RK_MISS. Counts box and triangle tests. */
rk_hit rk_bvh_closest(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters);

/* Does anything lie at 0 < t <= ray->t_max? Stops at the first triangle found. */
bool rk_bvh_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters);

#endif
