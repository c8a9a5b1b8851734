/* What rk_render refuses before the first ray, so that no picture is black, or lost, for it. */
#include "post/bloom_stage.h"
#include "render/tile.h"

/* --- Enumerations ----------------------------------------------------------------------------- */

typedef struct choice {
    const char *field, *type;
    uint32_t value, last;
} choice;

static bool check_choices(const rk_render_options *o, rk_error *error)
{
    const choice choices[] = {
        {"sampling", "rk_sampler_kind", o->sampling, RK_SAMPLER_LOW_DISCREPANCY},
        {"shading.model", "rk_shading_model", o->shading.model, RK_SHADING_GRADIENT},
        {"glass", "rk_glass_model", o->glass, RK_GLASS_BEER_LAMBERT},
        {"light.sampling", "rk_sampler_kind", o->light.sampling, RK_SAMPLER_LOW_DISCREPANCY},
        {"light.domain", "rk_light_domain", o->light.domain, RK_LIGHT_DOMAIN_SOLID_ANGLE},
        {"light.falloff", "rk_light_falloff", o->light.falloff, RK_FALLOFF_PHYSICAL},
        {"environment_filter", "rk_cubemap_filter", o->environment_filter, RK_CUBEMAP_SEAMLESS},
        {"lens.focal", "rk_focal_surface", o->lens.focal, RK_FOCAL_SPHERE},
        {"lens_sampling", "rk_sampler_kind", o->lens_sampling, RK_SAMPLER_LOW_DISCREPANCY},
        {"motion.sampling", "rk_time_sampling", o->motion.sampling, RK_TIME_LOW_DISCREPANCY},
        {"glossy.weights", "rk_glossy_weights", o->glossy.weights, RK_GLOSSY_RENORMALIZED},
        {"glossy.map", "rk_disk_map", o->glossy.map, RK_DISK_CONCENTRIC},
        {"glossy.sampling", "rk_sampler_kind", o->glossy.sampling, RK_SAMPLER_LOW_DISCREPANCY},
    };
    for (size_t i = 0; i < sizeof choices / sizeof *choices; i++)
        if (choices[i].value > choices[i].last)
            return rk_fail(error, "the option %s is %u, but %s goes from 0 to %u", choices[i].field,
                           choices[i].value, choices[i].type, choices[i].last);
    return true;
}

/* --- Numbers ---------------------------------------------------------------------------------- */

static bool check_numbers(const rk_render_options *options, rk_error *error)
{
    if (options->width < 1 || options->height < 1 || options->samples < 1)
        return rk_fail(error, "a picture has at least one pixel, and a pixel at least one sample");
    if (options->max_depth > RK_MAX_DEPTH || options->light.samples < 1)
        return rk_fail(error, "rays go on at most %d times, and a light gets at least one sample",
                       RK_MAX_DEPTH);
    if (options->shading.gradient.count > RK_GRADIENT_STOPS_MAX)
        return rk_fail(error, "a gradient has at most %d stops, not %u", RK_GRADIENT_STOPS_MAX,
                       options->shading.gradient.count);
    if (!(options->lens.focal_distance > 0 && options->lens.aperture >= 0))
        return rk_fail(error,
                       "a lens is focused at a distance above 0, and no smaller than a point");
    if (!(options->motion.shutter.open <= options->motion.shutter.close))
        return rk_fail(error, "the shutter opens at x = %g, behind x = %g, where it closes",
                       (double)options->motion.shutter.open, (double)options->motion.shutter.close);
    return true;
}

/* --- The scene -------------------------------------------------------------------------------- */

static bool check_scene(const rk_scene *scene, rk_error *error)
{
    if (!(scene->camera.fov > 0 && scene->camera.fov < 180))
        return rk_fail(error,
                       "%s: the camera's field of view is %g degrees: it is above 0 and below 180",
                       scene->name, (double)scene->camera.fov);
    if (scene->light_count > RK_LIGHTS_MAX || scene->sphere_count > RK_SPHERES_MAX)
        return rk_fail(error, "%s: %u lights and %u spheres: a scene has at most %d and %d",
                       scene->name, scene->light_count, scene->sphere_count, RK_LIGHTS_MAX,
                       RK_SPHERES_MAX);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind > RK_LIGHT_PARALLELOGRAM)
            return rk_fail(error, "%s: light %u is of the kind %u, which is none of rk_light_kind",
                           scene->name, i, scene->lights[i].kind);
    return true;
}

/* --- Samples ---------------------------------------------------------------------------------- */

static bool has_wide_light(const rk_scene *scene)
{
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind != RK_LIGHT_POINT)
            return true;
    return false;
}

/* Stays beyond the limit once it is, without going beyond 64 bits. */
static uint64_t multiply(uint64_t samples, uint32_t by)
{
    return samples > RK_SAMPLES_MAX ? samples : samples * by;
}

/* Of a pixel, in the dimension that takes the most. */
static uint64_t most_samples(const rk_scene *scene, const rk_render_options *options,
                             const rk_plan *plan)
{
    uint32_t own = options->samples;
    if (plan->lens && options->lens_samples > own)
        own = options->lens_samples;
    uint64_t samples = multiply(own, rk_time_passes(plan, options, own));
    if (plan->glossy)
        samples = multiply(samples, options->glossy.samples);
    if (plan->rays && has_wide_light(scene))
        samples = multiply(samples, options->light.samples);
    return samples;
}

static bool check_samples(const rk_scene *scene, const rk_render_options *options, rk_error *error)
{
    const rk_plan plan = rk_plan_of(scene, options);
    return most_samples(scene, options, &plan) <= RK_SAMPLES_MAX ||
           rk_fail(error,
                   "a pixel takes at most %d samples, but its own, or those on the lens or in time "
                   "where they are more, times those of rough mirrors and of lights are more: ask "
                   "for fewer",
                   RK_SAMPLES_MAX);
}

bool rk_render_check(const rk_scene *scene, const rk_render_options *options, rk_error *error)
{
    return check_choices(options, error) && check_numbers(options, error) &&
           rk_bloom_check(&options->bloom, error) && check_scene(scene, error) &&
           check_samples(scene, options, error);
}
