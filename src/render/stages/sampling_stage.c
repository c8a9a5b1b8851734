/* The descriptor alone (render/feature.h): each stage draws its samples by features/sampling.h, so
 * the renderer has nothing to decide. */
#include "render/feature.h"

static bool draws_points(rk_sampler_kind kind)
{
    return kind == RK_SAMPLER_SOBOL || kind == RK_SAMPLER_ZSOBOL;
}

static bool is_joint(const rk_feature *feature, rk_sampler_kind kind, const rk_scene *scene,
                     const rk_render_options *options)
{
    return draws_points(kind) && feature->wanted(scene, options);
}

/* Does the picture draw samples of joint dimensions? */
static bool wanted(const rk_scene *scene, const rk_render_options *o)
{
    return (o->samples > 1 && draws_points(o->sampling)) ||
           is_joint(&rk_depth_of_field_feature, o->lens_sampling, scene, o) ||
           is_joint(&rk_parallelogram_light_feature, o->light.sampling, scene, o) ||
           is_joint(&rk_glossy_reflection_feature, o->glossy.sampling, scene, o) ||
           ((o->motion.sampling == RK_TIME_SOBOL || o->motion.sampling == RK_TIME_ZSOBOL) &&
            rk_motion_blur_feature.wanted(scene, o));
}

const rk_feature rk_sampling_feature = {.stem = "sampling", .wanted = wanted};
