/* rk_render_check of render/plan.h: errors before the first ray, instead of a black or a lost
 * picture. */
#include "render/options.h"
#include "render/stages/adaptive_sampling_stage.h"
#include "render/time_passes.h"

/* --- The scene -------------------------------------------------------------------------------- */

static bool is_finite(rk_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Rays that are not numbers would be tested against everything. */
static bool check_camera(const rk_scene *scene, rk_error *error)
{
    const rk_camera *camera = &scene->camera;
    if (!(camera->fov > 0 && camera->fov < 180))
        return rk_fail(error,
                       "%s: the camera's field of view is %g degrees: it is above 0 and below 180",
                       scene->name, (double)camera->fov);
    return (is_finite(camera->look_at) && is_finite(camera->rotation) &&
            isfinite(camera->distance)) ||
           rk_fail(error, "%s: the camera's look_at, rotation or distance is not a finite number",
                   scene->name);
}

static bool check_light(const rk_scene *scene, uint32_t i, rk_error *error)
{
    const rk_light *light = &scene->lights[i];
    if (light->kind > RK_LIGHT_PARALLELOGRAM)
        return rk_fail(error, "%s: light %u has the kind %u, which is not in rk_light_kind",
                       scene->name, i, light->kind);
    /* Members that a kind does not have are not read. */
    const uint32_t corners = light->kind == RK_LIGHT_POINT     ? 1
                             : light->kind == RK_LIGHT_SEGMENT ? 2
                                                               : 4;
    bool finite = is_finite(light->position) && (corners < 2 || is_finite(light->edge01)) &&
                  (corners < 4 || is_finite(light->edge02));
    for (uint32_t corner = 0; corner < corners; corner++)
        finite = finite && is_finite(light->colours[corner]);
    return finite || rk_fail(error,
                             "%s: light %u has a position, an edge or a colour that is not a "
                             "finite number",
                             scene->name, i);
}

static bool check_scene(const rk_scene *scene, rk_error *error)
{
    if (!check_camera(scene, error))
        return false;
    if (scene->light_count > RK_LIGHTS_MAX || scene->sphere_count > RK_SPHERES_MAX)
        return rk_fail(error, "%s: %u lights and %u spheres: a scene has at most %d and %d",
                       scene->name, scene->light_count, scene->sphere_count, RK_LIGHTS_MAX,
                       RK_SPHERES_MAX);
    if (!(scene->background >= 0 && isfinite(scene->background)))
        return rk_fail(error, "%s: the background is %g: it is a finite number from 0 up",
                       scene->name, (double)scene->background);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (!check_light(scene, i, error))
            return false;
    return true;
}

/* --- Samples ---------------------------------------------------------------------------------- */

/* Stops multiplying above the limit, so that the product fits 64 bits. */
static uint64_t multiply(uint64_t samples, uint32_t by)
{
    return samples > RK_SAMPLES_MAX ? samples : samples * by;
}

/* Per pixel, in the dimension that takes the most. */
static uint64_t most_samples(const rk_scene *scene, const rk_render_options *options,
                             const rk_plan *plan)
{
    uint32_t own = options->samples > 0 ? options->samples : 1; /* its row refuses 0 */
    if (plan->depth_of_field && options->lens_samples > own)
        own = options->lens_samples;
    uint64_t samples = multiply(own, rk_time_passes(plan, options, own));
    uint32_t at_a_point = 1;
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (!rk_features[i]->samples || !rk_plan_has(plan, i))
            continue;
        uint32_t taken = rk_features[i]->samples(scene, options);
        if (rk_features[i]->splits)
            samples = multiply(samples, taken);
        else if (taken > at_a_point)
            at_a_point = taken;
    }
    return multiply(samples, at_a_point);
}

static bool check_samples(const rk_scene *scene, const rk_render_options *options, rk_error *error)
{
    const rk_render_options adapted = rk_adaptive_sampling_options_of(options);
    const rk_plan plan = rk_plan_of(scene, &adapted);
    return most_samples(scene, &adapted, &plan) <= RK_SAMPLES_MAX ||
           rk_fail(
               error,
               "a pixel takes at most %d samples, and here it would take more: the product of its "
               "own (or those of the lens or in time, if they are more), those of rough mirrors, "
               "and the most that a light or another feature takes per point; reduce one of them",
               RK_SAMPLES_MAX);
}

bool rk_render_check(const rk_scene *scene, const rk_render_options *options, rk_error *error)
{
    return check_scene(scene, error) && check_samples(scene, options, error) &&
           rk_render_options_check(options, error);
}
