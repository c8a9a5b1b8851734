/* Each feature is asked whether scene and options want it; what needs several answers, such as
 * shadow rays, is combined here. */
#include "render/plan.h"

#include "render/feature_list.h"
#include "render/stages/highlight_stage.h"

static bool reflects(const rk_material *material)
{
    return material->ks.x > 0 || material->ks.y > 0 || material->ks.z > 0;
}

static bool is_textured(const rk_material *material)
{
    return material->kd_texture != NULL;
}

bool rk_plan_any_material(const rk_scene *scene, bool (*holds)(const rk_material *material))
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        if (holds(&scene->mesh.materials[i]))
            return true;
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        if (holds(&scene->sphere_materials[i]))
            return true;
    return false;
}

bool rk_plan_has_light(const rk_scene *scene)
{
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (rk_light_emits(&scene->lights[i]))
            return true;
    return false;
}

bool rk_plan_reflects(const rk_scene *scene, const rk_render_options *options)
{
    return options->reflections && options->max_depth > 0 && rk_plan_any_material(scene, reflects);
}

static bool has_highlights(const rk_scene *scene, const rk_render_options *options)
{
    rk_shading_model model = options->shading.model;
    return (model == RK_SHADING_PHONG || model == RK_SHADING_BLINN_PHONG) &&
           rk_plan_any_material(scene, reflects);
}

static bool times_differ(const rk_motion_options *motion)
{
    return isnan(motion->single_time) && motion->shutter.open < motion->shutter.close;
}

static bool wants(const rk_feature *feature, const rk_scene *scene,
                  const rk_render_options *options)
{
    return feature->wanted && feature->wanted(scene, options);
}

static bool shines(const rk_scene *scene, const rk_render_options *options)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->shines && wants(rk_features[i], scene, options))
            return true;
    return false;
}

static void set_features(rk_plan *plan, const rk_scene *scene, const rk_render_options *options)
{
#define RK_FEATURE(stem) plan->stem = plan->rays && wants(&rk_##stem##_feature, scene, options);
#include "features/list.h"
#undef RK_FEATURE
}

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options)
{
    bool anything = scene->mesh.triangle_count > 0 || scene->sphere_count > 0;
    bool lights = rk_plan_has_light(scene);
    bool background = scene->environment.side > 0 || scene->background > 0;
    rk_plan plan = {.rays = (anything && (lights || shines(scene, options))) || background,
                    .background = background,
                    .lights = lights};
    set_features(&plan, scene, options);
    plan.pixel_samples = plan.rays && options->samples > 1;
    plan.shadow_rays = anything && lights && options->shadows;
    plan.varying_kd = rk_plan_any_material(scene, is_textured) || scene->mesh.colours;
    plan.reflections = plan.rays && rk_plan_reflects(scene, options);
    plan.viewer = plan.reflections || has_highlights(scene, options);
    plan.sharp_highlights = plan.parallelogram_light && rk_highlights_may_be_sharp(scene, options);
    plan.time_samples = plan.motion_blur && times_differ(&options->motion);
    return plan;
}
