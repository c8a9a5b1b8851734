/* Rays from one point that go nearly the same way, such as those of a rough mirror: which triangles
 * any of them may intersect is found once for all (after Reshetov, Soupikov, Hurley,
 * "Multi-level ray tracing algorithm", SIGGRAPH 2005). */
#ifndef RK_ACCEL_RAY_GROUP_H
#define RK_ACCEL_RAY_GROUP_H

#include "accel/batch.h"
#include "base/counters.h"
#include "scene/bvh.h"

/* The same hits as rk_bvh_closest's, sooner where rays that follow each other in the batch start
 * from the same point; directions are unit vectors. */
void rk_ray_group_closest(const rk_bvh *bvh, const rk_ray_batch *rays, rk_hit_batch *hits,
                          rk_counters *counters);

#endif
