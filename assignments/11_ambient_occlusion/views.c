/* The debug views: the ambient visibility alone, and a pixel's rays from beside the camera. */
#include "driver.h"

#include "accel/query/trace_one.h"

static const rk_vec3 white = {1, 1, 1}, purple = {0.5f, 0.05f, 0.6f};

/* --- Visibility ------------------------------------------------------------------------------- */

static void make_white(rk_material *material)
{
    material->kd = white;
    material->ks = rk_vec(0, 0, 0);
    material->kd_texture = NULL;
}

void show_visibility_alone(rk_driver *driver)
{
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        make_white(&scene->mesh.materials[i]);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        make_white(&scene->sphere_materials[i]);
    scene->light_count = 0;
    driver->render.ambient_occlusion.intensity = 1;
}

bool draw_visibility(rk_driver *driver, rk_error *error)
{
    show_visibility_alone(driver);
    return rk_driver_render(driver, error);
}

/* --- Rays ------------------------------------------------------------------------------------- */

/* Without lights, all shadow rays are those of ambient light. At --ambient 0 they are drawn, too:
 * where they go does not depend on its intensity. */
static bool record_rays(rk_driver *driver, rk_error *error)
{
    rk_scene scene = driver->scene;
    rk_render_options options = driver->render;
    scene.light_count = 0;
    options.ambient_occlusion.intensity = 1;
    return rk_driver_record_surface(driver, &scene, &options, error);
}

/* An occluded ray ends at its hit; an unoccluded one is drawn for a short distance. */
static void draw_ray(const rk_driver *driver, rk_overlay *overlay, const rk_ray_record_entry *it)
{
    const float shown = 0.6f;
    const rk_ray *ray = &it->ray;
    float t = it->occluded ? rk_min(rk_trace_one(&driver->accel, ray).t, 1)
                           : rk_min(shown / rk_length(ray->direction), 1);
    rk_vec3 end = rk_madd(ray->origin, ray->direction, t);
    rk_overlay_shadow_ray(overlay, ray->origin, end, it->occluded);
}

/* Of the pixel's first sample, before any reflection. */
static void draw_all(const rk_driver *driver, rk_overlay *overlay)
{
    const rk_ray_record *record = &driver->record;
    const rk_ray_record_entry *first = &record->rays[0];
    choices *c = driver->choices;
    rk_surface surface;
    c->traced = c->unoccluded = 0;
    rk_scene_surface(&surface, &driver->scene, &first->ray, &first->hit);
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *it = &record->rays[i];
        if (it->kind != RK_RAY_SHADOW || it->bounce > 0 || it->sample > 0)
            continue;
        draw_ray(driver, overlay, it);
        c->traced++;
        c->unoccluded += !it->occluded;
    }
    rk_vec3 tip = rk_madd(surface.point, surface.normal, 0.3f);
    rk_overlay_line(overlay, first->ray.origin, surface.point, white, 1.5f);
    rk_overlay_line(overlay, surface.point, tip, purple, 3);
}

bool draw_rays(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_overlay overlay;
    rk_driver_draw_pixel(driver);
    if (!record_rays(driver, error) || !rk_side_view_render(&c->viewer, driver, &overlay, error))
        return false;
    draw_all(driver, &overlay);
    rk_overlay_free(&overlay);
    return true;
}
