/* Ray groups: rays from one point of nearly the same direction, such as the reflections of a rough
 * mirror. The triangles that any of them may hit are found once for all (after Reshetov, Soupikov,
 * Hurley, "Multi-level ray tracing algorithm", SIGGRAPH 2005); not installed. */
#ifndef RK_ACCEL_RAY_GROUP_H
#define RK_ACCEL_RAY_GROUP_H

#include "accel/batch.h"
#include "base/counters.h"
#include "scene/bvh.h"

/* The same hits as rk_bvh_closest's, faster if consecutive rays of the batch have the same origin;
 * directions are unit vectors. */
void rk_ray_group_closest(const rk_bvh *bvh, const rk_ray_batch *rays, rk_hit_batch *hits,
                          rk_counters *counters);

#endif
