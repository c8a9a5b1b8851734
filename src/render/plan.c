#include "render/plan.h"

rk_render_options rk_render_options_default(void)
{
    return (rk_render_options){.width = 800, .height = 800, .samples = 1};
}

bool rk_light_shines(const rk_light *light)
{
    const uint32_t corners = light->kind == RK_LIGHT_POINT     ? 1
                             : light->kind == RK_LIGHT_SEGMENT ? 2
                                                               : 4;
    for (uint32_t i = 0; i < corners; i++)
        if (light->colours[i].x > 0 || light->colours[i].y > 0 || light->colours[i].z > 0)
            return true;
    return false;
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
