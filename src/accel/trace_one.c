/* A batch of one ray, so that a debug view sees what the renderer sees. */
#include "accel/trace_one.h"

#include "accel/trace.h"

rk_hit rk_trace_one(const rk_accel *accel, const rk_ray *ray)
{
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_batch_push(&rays, ray);
    rk_accel_closest(accel, &rays, &hits, &counters);
    return rk_batch_hit(&hits, 0);
}

bool rk_trace_one_surface(rk_surface *surface, const rk_accel *accel, const rk_ray *ray)
{
    rk_hit hit = rk_trace_one(accel, ray);
    if (hit.triangle == RK_MISS)
        return false;
    rk_scene_surface(surface, accel->scene, ray, &hit);
    return true;
}
