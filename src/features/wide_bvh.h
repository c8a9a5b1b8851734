/* A tree of eight children per node and four triangles per block, made from a binary one: a ray
 * takes a third of the steps, each of which tests eight boxes or four triangles at once. */
#ifndef RK_FEATURES_WIDE_BVH_H
#define RK_FEATURES_WIDE_BVH_H

#include "base/counters.h"
#include "features/watertight.h"
#include "scene/bvh.h"
#include "scene/wide_tree.h"

/* Makes the tree from a valid binary one, which is only read. Subtrees of at most RK_WIDE_BLOCK
 * triangles become one leaf. Of all choices of nodes and leaves, the tree is one with the least
 * expected cost, which is a node's area for each node, and a leaf's times its blocks for each leaf.
 * False, with an empty tree, if memory runs out, or if there are more blocks than
 * RK_WIDE_BLOCK_BITS can count. Release with rk_wide_bvh_free. */
bool rk_wide_bvh_build(rk_wide_bvh *wide, const rk_bvh *bvh, rk_error *error);

/* Returns the closest hit at 0 < t <= ray->t_max; at equal t the smallest triangle index. On a miss
 * hit.triangle is RK_MISS. The same hit to the bit as rk_bvh_closest's. A visit to a node counts
 * eight box tests, one to a block four triangle tests. */
rk_hit rk_wide_bvh_closest(const rk_wide_bvh *wide, const rk_ray *ray, rk_counters *counters);

/* Does the ray hit anything at 0 < t <= ray->t_max? Stops at the first hit found. Counts
 * likewise. */
bool rk_wide_bvh_occluded(const rk_wide_bvh *wide, const rk_ray *ray, rk_counters *counters);

#endif
