/* A batch of one ray, so that a debug view sees what the renderer sees. */
#include "accel/query/trace_one.h"

#include "accel/query/crossings.h"
#include "accel/query/trace.h"

/* Past what a picture cuts out, as the renderer goes. */
static rk_hit first_crossing(const rk_accel *accel, const rk_ray *ray)
{
    const rk_crossings_wanted wanted = {.cutouts_only = true};
    rk_counters counters = {0};
    rk_crossing_list list;
    rk_transparency_start(&list, 1);
    rk_crossings_gather_static(accel, ray, wanted, &list, &counters);
    rk_crossings_gather_at_rest(accel, ray, wanted, &list, &counters);
    return list.count ? rk_crossing_hit(&list.crossings[0]) : (rk_hit){.triangle = RK_MISS};
}

rk_hit rk_trace_one(const rk_accel *accel, const rk_ray *ray)
{
    if (accel->has_cutouts)
        return first_crossing(accel, ray);
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
