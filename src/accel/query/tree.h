/* One tree of an acceleration structure, and how its kind is traversed; not installed. */
#ifndef RK_ACCEL_QUERY_TREE_H
#define RK_ACCEL_QUERY_TREE_H

#include "accel/accel.h"
#include "accel/batch.h"
#include "accel/kernel/wide_kernel.h"

typedef struct rk_tree {
    const rk_bvh *bvh;
    const rk_wide_bvh *wide;
    const rk_wide_kernel *kernel; /* NULL: the binary tree is traced, by features/bvh_median.h */
} rk_tree;

/* The tree over the static triangles, and the one over an object at rest. */
static inline rk_tree rk_accel_static_tree(const rk_accel *accel)
{
    return (rk_tree){&accel->bvh, &accel->wide, accel->kernel};
}

static inline rk_tree rk_accel_moving_tree(const rk_accel *accel, uint32_t object)
{
    return (rk_tree){&accel->moving[object], &accel->wide_moving[object], accel->kernel};
}

/* The closest hits, or occlusion, entry for entry. */
void rk_tree_closest(const rk_tree *tree, const rk_ray_batch *rays, rk_hit_batch *hits,
                     rk_counters *counters);
void rk_tree_occluded(const rk_tree *tree, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                      rk_counters *counters);

/* Shows the triangles of the leaves that a ray enters to a visitor, leaves that come first first,
 * more or less. Counts boxes; the visitor counts triangles. */
void rk_tree_visit_leaves(const rk_tree *tree, const rk_ray *ray, rk_leaf_visitor *visitor,
                          rk_counters *counters);

/* Can the structure's trees be used for pictures? False if rays from outside towards triangles hit
 * nothing, or if a binary tree is one leaf with more triangles than a leaf may have: what starters
 * build. */
bool rk_accel_finds_triangles(const rk_accel *accel);

#endif
