#include "render/stages/trace_stage.h"

#include "accel/trace.h"
#include "accel/trace_moving.h"
#include "render/stages/motion_blur_stage.h"

/* Reflections of a rough mirror follow each other in the batch, from the same point. */
static void closest_static(const rk_rendering *r, const rk_path_batch *paths, rk_hit_batch *hits,
                           rk_counters *counters)
{
    if (!paths->path[0].split)
        rk_accel_closest_static(r->accel, &paths->rays, hits, counters);
    else
        rk_accel_closest_static_grouped(r->accel, &paths->rays, hits, counters);
}

void rk_trace_closest(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                      rk_hit_batch *hits, rk_ray_times *times)
{
    closest_static(r, paths, hits, pass->counters);
    if (!r->plan.motion_blur) {
        rk_accel_closest_at_rest(r->accel, &paths->rays, hits, pass->counters);
        return;
    }
    rk_motion_blur_stage(r, pass, &paths->rays, paths->pixel,
                         rk_path_is_from_camera(paths->path, r->options->max_depth), hits->t,
                         times);
    rk_accel_closest_moving(r->accel, &paths->rays, times, hits, pass->counters);
}
