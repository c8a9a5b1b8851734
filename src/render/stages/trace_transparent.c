/* Ray by ray, because each keeps a list of its crossings. A shadow ray stops at the first opaque
 * one. */
#include "render/stages/trace_transparent.h"

#include "render/stages/motion_blur_stage.h"

/* Crossings with moving objects, after those with static surfaces, which may end the ray early. */
static rk_ray_time gather_moving(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                                 uint32_t pixel, bool from_camera, rk_crossings_wanted wanted,
                                 rk_crossing_list *list)
{
    rk_ray_time when = {NAN, 0};
    if (!r->plan.motion_blur) {
        rk_crossings_gather_at_rest(r->accel, ray, wanted, list, pass->counters);
        return when;
    }
    float t_max = rk_transparency_end(list, ray->t_max);
    when = rk_motion_blur_ray_time(r, pass, pixel, from_camera, ray, t_max);
    rk_crossings_gather_moving(r->accel, ray, &when, wanted, list, pass->counters);
    return when;
}

rk_ray_time rk_trace_crossings(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_path_batch *paths, uint32_t i, rk_crossing_list *list)
{
    const rk_path *path = &paths->path[i];
    rk_ray ray = rk_batch_ray(&paths->rays, i);
    const rk_crossings_wanted wanted = {.cutouts_only = !r->options->transparency};
    rk_transparency_start(list, path->bounces_left + 1u);
    rk_crossings_gather_static(r->accel, &ray, wanted, list, pass->counters);
    const rk_ray_time when =
        gather_moving(r, pass, &ray, paths->pixel[i],
                      rk_path_is_from_camera(path, r->options->max_depth), wanted, list);
    pass->counters->crossings += list->count;
    return when;
}

rk_vec3 rk_trace_transmittance(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                               uint32_t pixel, rk_crossing_list *list)
{
    const rk_crossings_wanted wanted = {true, !r->options->transparency};
    rk_transparency_start(list, RK_CROSSINGS_MAX);
    rk_crossings_gather_static(r->accel, ray, wanted, list, pass->counters);
    if (!rk_crossings_are_opaque(list))
        gather_moving(r, pass, ray, pixel, false, wanted, list);
    pass->counters->crossings += list->count;
    return rk_crossings_transmittance(list, ray, r->options->glass);
}
