/* A tree for drawing before bvh_median and sah_binning can build and traverse one: leaves of
 * neighbouring triangles in the mesh's order, joined in pairs from the leaves up. Slower to
 * traverse than theirs, and never built where theirs find triangles; not installed. */
#ifndef RK_ACCEL_STAND_IN_TREE_H
#define RK_ACCEL_STAND_IN_TREE_H

#include "accel/accel.h"
#include "accel/packet.h"
#include "features/bvh_median.h"

/* Can the structure's trees be used for pictures? False if rays from outside towards triangles hit
 * nothing, or if a tree is one leaf with more triangles than a leaf may have. */
bool rk_accel_finds_triangles(const rk_accel *accel);

/* Builds the structure of the same scene from stand-in trees. Release with rk_accel_free. */
bool rk_accel_build_stand_in(rk_accel *accel, const rk_scene *scene, rk_error *error);

/* rk_bvh_closest and rk_bvh_occluded; in a stand-in tree, a packet of the same ray twice. */
static inline rk_hit rk_tree_closest(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{
    if (!bvh->is_stand_in)
        return rk_bvh_closest(bvh, ray, counters);
    const rk_ray rays[2] = {*ray, *ray};
    rk_hit hits[2];
    rk_packet_closest(bvh, rays, 2, hits, counters);
    return hits[0];
}

static inline bool rk_tree_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{
    if (!bvh->is_stand_in)
        return rk_bvh_occluded(bvh, ray, counters);
    const rk_ray rays[2] = {*ray, *ray};
    bool occluded[2];
    rk_packet_occluded(bvh, rays, 2, occluded, counters);
    return occluded[0];
}

#endif
