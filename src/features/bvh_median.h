/* Bounding volume hierarchy, split at the median: builds the tree, then finds the closest hit of a
 * ray, or whether it is occluded. */
#ifndef RK_FEATURES_BVH_MEDIAN_H
#define RK_FEATURES_BVH_MEDIAN_H

#include "base/counters.h"
#include "features/watertight.h"
#include "scene/bvh.h"

/* How a builder splits a node over the `count` triangles from `begin` on, in an order that the
 * builder keeps: fills in the node's box, moves the left child's triangles to the front, and
 * returns their number; 0 makes the node a leaf. Up to `depth_left` levels may follow below it, of
 * RK_BVH_LEVELS_MAX in all; if none may, it is a leaf, whatever is returned. */
typedef uint32_t (*rk_bvh_split)(void *builder, uint32_t begin, uint32_t count, uint32_t depth_left,
                                 rk_box *box);

/* Fills in the nodes of a tree that has its triangle_count and memory (rk_bvh_init): the root, then
 * the children that `split` makes of each node, siblings side by side, pairs from node 2 on. */
void rk_bvh_build_nodes(rk_bvh *bvh, rk_bvh_split split, void *builder);

/* Builds the tree over a valid mesh (rk_mesh_validate): each node is split on the longest axis of
 * its box, the ceil(N / 2) triangles with the lowest centroids to the left (of equal ones those
 * with the smaller indices; -0 is lower than 0), until RK_BVH_LEAF_TARGET or fewer remain. O(N
 * log^2 N) time at most, 31 levels at most; the stack that it takes does not grow with the mesh. A
 * mesh without triangles gives a tree without nodes. False, with an empty tree, if memory runs out.
 * Release with rk_bvh_free. */
bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error);

/* Returns the closest hit at 0 < t <= ray->t_max; at equal t the smallest triangle index. On a miss
 * hit.triangle is RK_MISS. Visits the nearer child first, and no box that begins behind the nearest
 * hit so far, and tests each triangle of a leaf once. Adds the box and triangle tests to the
 * counters. */
rk_hit rk_bvh_closest(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters);

/* Does the ray hit anything at 0 < t <= ray->t_max? Visits the nearer child first, and stops at the
 * first hit found. Counts likewise. */
bool rk_bvh_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters);

#endif
