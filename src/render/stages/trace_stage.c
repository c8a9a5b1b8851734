#include "render/stages/trace_stage.h"

#include "accel/trace.h"
#include "accel/trace_moving.h"
#include "render/stages/motion_blur_stage.h"

static bool is_from_camera(const rk_rendering *r, const rk_path *path)
{
    return path->bounces_left == r->options->max_depth;
}

/* Rays that a rough mirror has split follow each other from the same point. */
static void closest_still(const rk_rendering *r, const rk_path_batch *paths, rk_hit_batch *hits,
                          rk_counters *counters)
{
    if (paths->path[0].split)
        rk_accel_closest_still_grouped(r->accel, &paths->rays, hits, counters);
    else
        rk_accel_closest_still(r->accel, &paths->rays, hits, counters);
}

void rk_trace_closest(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                      rk_hit_batch *hits, rk_ray_times *times)
{
    closest_still(r, paths, hits, pass->counters);
    if (!r->plan.motion_blur) {
        rk_accel_closest_at_rest(r->accel, &paths->rays, hits, pass->counters);
        return;
    }
    rk_motion_blur_stage(r, pass, &paths->rays, paths->pixel, is_from_camera(r, paths->path),
                         hits->t, times);
    rk_accel_closest_moving(r->accel, &paths->rays, times, hits, pass->counters);
}

void rk_trace_occlusion(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                        const uint16_t *pixels, rk_occlusion_batch *answers)
{
    if (!r->plan.motion_blur) {
        rk_accel_occluded(r->accel, rays, answers, pass->counters);
        return;
    }
    float t_max[RK_BATCH_MAX];
    rk_ray_times times;
    rk_accel_occluded_still(r->accel, rays, answers, pass->counters);
    for (uint32_t i = 0; i < rays->count; i++)
        t_max[i] = answers->occluded[i] ? 0 : rays->t_max[i];
    rk_motion_blur_stage(r, pass, rays, pixels, false, t_max, &times);
    rk_accel_occluded_moving(r->accel, rays, &times, answers, pass->counters);
}

/* What moves, behind what stands still. */
static rk_ray_time gather_moving(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                                 uint32_t pixel, bool from_camera, bool until_opaque,
                                 rk_crossing_list *list)
{
    rk_ray_time when = {NAN, 0};
    if (!r->plan.motion_blur) {
        rk_crossings_gather_at_rest(r->accel, ray, until_opaque, list, pass->counters);
        return when;
    }
    float t_max = rk_transparency_end(list, ray->t_max);
    when = rk_motion_blur_ray_time(r, pass, pixel, from_camera, ray, t_max);
    rk_crossings_gather_moving(r->accel, ray, &when, until_opaque, list, pass->counters);
    return when;
}

rk_ray_time rk_trace_crossings(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_path_batch *paths, uint32_t i, rk_crossing_list *list)
{
    const rk_path *path = &paths->path[i];
    rk_ray ray = rk_batch_ray(&paths->rays, i);
    rk_transparency_start(list, path->bounces_left + 1u);
    rk_crossings_gather_still(r->accel, &ray, false, list, pass->counters);
    return gather_moving(r, pass, &ray, paths->pixel[i], is_from_camera(r, path), false, list);
}

rk_vec3 rk_trace_transmittance(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                               uint32_t pixel)
{
    rk_crossing_list list;
    rk_transparency_start(&list, RK_CROSSINGS_MAX);
    rk_crossings_gather_still(r->accel, ray, true, &list, pass->counters);
    if (!rk_crossings_are_opaque(&list))
        gather_moving(r, pass, ray, pixel, false, true, &list);
    return rk_crossings_transmittance(&list, ray, r->options->glass);
}
