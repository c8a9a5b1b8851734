/* Static surfaces, times, moving objects: in this order, because a ray that a wall ends needs no
 * time for what is behind it. */
#include "render/stages/trace_stage.h"

#include "accel/query/trace.h"
#include "accel/query/trace_moving.h"
#include "render/ray_record.h"
#include "render/stages/motion_blur_stage.h"

void rk_trace_closest(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                      rk_hit_batch *hits, rk_ray_times *times)
{
    rk_accel_closest_static(r->accel, &paths->rays, hits, pass->counters);
    if (r->plan.motion_blur) {
        rk_motion_blur_stage(r, pass, &paths->rays, paths->pixel,
                             rk_path_is_from_camera(paths->path, r->options->max_depth), hits->t,
                             times);
        rk_accel_closest_moving(r->accel, &paths->rays, times, hits, pass->counters);
    } else {
        rk_accel_closest_at_rest(r->accel, &paths->rays, hits, pass->counters);
    }
    if (r->record)
        rk_ray_record_paths(r, pass, paths, hits);
}
