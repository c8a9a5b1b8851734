#include "render/plan.h"

#include "post/bloom_stage.h"

rk_render_options rk_render_options_default(void)
{
    return (rk_render_options){
        .width = 800,
        .height = 800,
        .samples = 1,
        .sampling = RK_SAMPLER_STRATIFIED,
        .shading = {.model = RK_SHADING_LAMBERT, .gradient = rk_gradient_cool_to_warm()},
        .glass = RK_GLASS_ORDERED,
        .max_depth = 6,
        .light = {.samples = 16,
                  .sampling = RK_SAMPLER_LOW_DISCREPANCY,
                  .early_out = RK_LIGHT_EARLY_OUT},
        .bloom = rk_bloom_options_default(),
        .environment_filter = RK_CUBEMAP_SEAMLESS,
        .lens = rk_lens_default(),
        .lens_sampling = RK_SAMPLER_LOW_DISCREPANCY,
        .motion = {.shutter = rk_shutter_default(), .sampling = RK_TIME_STRATIFIED, .isolate = NAN},
        .glossy = {.radius = NAN,
                   .weights = RK_GLOSSY_RENORMALIZED,
                   .map = RK_DISK_CONCENTRIC,
                   .sampling = RK_SAMPLER_LOW_DISCREPANCY},
    };
}

static bool reflects(const rk_material *material)
{
    return material->ks.x > 0 || material->ks.y > 0 || material->ks.z > 0;
}

static bool lets_through(const rk_material *material)
{
    return material->alpha < 1;
}

static bool is_textured(const rk_material *material)
{
    return material->kd_texture != NULL;
}

static bool any_material(const rk_scene *scene, bool (*holds)(const rk_material *material))
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        if (holds(&scene->mesh.materials[i]))
            return true;
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        if (holds(&scene->sphere_materials[i]))
            return true;
    return false;
}

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options)
{
    bool lights = false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        lights |= rk_light_emits(&scene->lights[i]);
    bool environment = scene->environment.side > 0;
    bool anything = scene->mesh.triangle_count > 0 || scene->sphere_count > 0;
    bool rays = (anything && lights) || environment;
    const rk_motion_options *motion = &options->motion;
    bool moves = rays && motion->samples > 0 && scene->moving_count > 0;
    bool reflections =
        rays && options->reflections && options->max_depth > 0 && any_material(scene, reflects);
    return (rk_plan){
        .rays = rays,
        .pixel_samples = rays && options->samples > 1,
        .lights = lights,
        .shadow_rays = anything && lights && options->shadows,
        .textures = any_material(scene, is_textured),
        .viewer = reflections || ((options->shading.model == RK_SHADING_PHONG ||
                                   options->shading.model == RK_SHADING_BLINN_PHONG) &&
                                  any_material(scene, reflects)),
        .reflections = reflections,
        .glossy = reflections && options->glossy.samples > 0 && options->glossy.radius != 0,
        .transparency = rays && options->transparency && any_material(scene, lets_through),
        .bloom = rays && rk_bloom_wanted(&options->bloom),
        .environment = environment,
        .lens = rays && options->lens_samples > 0 && options->lens.aperture > 0,
        .motion = moves,
        .time_samples =
            moves && isnan(motion->isolate) && motion->shutter.open < motion->shutter.close,
    };
}
