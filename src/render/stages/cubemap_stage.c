/* Paths that hit nothing end in the environment: its radiance, or the grey of the background, times
 * their throughput. */
#include "render/stages/cubemap_stage.h"

static rk_vec3 radiance_from(const rk_rendering *r, rk_vec3 direction, rk_counters *counters)
{
    float grey = r->scene->background;
    if (!r->plan.cubemap)
        return rk_vec(grey, grey, grey);
    counters->environment_lookups++;
    return rk_cubemap_at(&r->scene->environment, direction, r->options->environment_filter);
}

rk_vec3 rk_environment_radiance(const rk_rendering *r, const rk_path_batch *paths, uint32_t i,
                                float fraction, rk_counters *counters)
{
    rk_vec3 colour = radiance_from(r, rk_batch_ray(&paths->rays, i).direction, counters);
    return rk_mul(rk_scale(paths->path[i].throughput, fraction), colour);
}

void rk_cubemap_stage(const rk_rendering *r, const rk_path_batch *paths, const rk_hit_batch *hits,
                      rk_film *film, rk_counters *counters)
{
    for (uint32_t i = 0; i < paths->rays.count; i++)
        if (hits->triangle[i] == RK_MISS)
            rk_film_add(film, paths->pixel[i], rk_environment_radiance(r, paths, i, 1, counters));
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_cubemap_filter_names, rk_cubemap_filter, RK_CUBEMAP_SEAMLESS, "nearest", "bilinear",
         "seamless");

static const rk_option rows[] = {
    {"environment-filter",
     RK_CHOICE(rk_render_options, environment_filter, rk_cubemap_filter_names),
     "interpolation between the texels of --environment", .initial = RK_CUBEMAP_SEAMLESS,
     .of_scene = true},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)options;
    return scene->environment.side > 0;
}

const rk_feature rk_cubemap_feature = {
    .stem = "cubemap", .options = rows, .takes = "--environment", .wanted = wanted};
