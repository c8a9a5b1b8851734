#include "render/plan.h"

rk_render_options rk_render_options_default(void)
{
    return (rk_render_options){.width = 800, .height = 800, .samples = 1};
}

bool rk_light_shines(const rk_light *light)
{
    return light->colour.x > 0 || light->colour.y > 0 || light->colour.z > 0;
}

rk_plan rk_plan_of(const rk_scene *scene, const rk_render_options *options)
{
    bool lights = false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        lights |= rk_light_shines(&scene->lights[i]);
    bool rays = (scene->mesh.triangle_count > 0 || scene->sphere_count > 0) && lights;
    return (rk_plan){
        .rays = rays,
        .pixel_samples = rays && options->samples > 1,
        .lights = lights,
        .shadow_rays = rays && options->shadows,
    };
}
