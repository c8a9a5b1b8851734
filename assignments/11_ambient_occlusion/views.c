/* The debug views: the ambient visibility alone, and a pixel's rays from beside the camera. */
#include "driver.h"

#include "accel/trace_one.h"

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

/* Traces a camera ray; returns its shading point and the renderer's samples there. */
static bool trace_pixel(const rk_driver *driver, const rk_ray *ray, rk_shading_point *point,
                        rk_ambient_samples *samples, rk_error *error)
{
    const rk_rendering r = {.options = &driver->render};
    const rk_sample_pass pass = {.tile = {driver->pixel.x, driver->pixel.y, 1, 1},
                                 .samples = driver->render.samples};
    *point = (rk_shading_point){.path = rk_path_start(0, driver->render.max_depth)};
    if (!rk_trace_one_surface(&point->surface, &driver->accel, ray))
        return rk_fail(error,
                       "--debug %s: there is no surface at pixel %u,%u; choose another one by "
                       "--pixel X,Y",
                       driver->debug, driver->pixel.x, driver->pixel.y);
    rk_ambient_samples_start(samples, &r, &pass, point);
    return true;
}

/* An occluded ray ends at its hit; an unoccluded one is drawn for a short distance. */
static void draw_ray(const rk_driver *driver, rk_overlay *overlay, const rk_ray *ray)
{
    const float shown = 0.6f;
    rk_hit hit = rk_trace_one(&driver->accel, ray);
    bool unoccluded = hit.triangle == RK_MISS;
    float t = unoccluded ? rk_min(shown / rk_length(ray->direction), 1) : hit.t;
    rk_vec3 end = rk_madd(ray->origin, ray->direction, t);
    rk_overlay_shadow_ray(overlay, ray->origin, end, !unoccluded);
}

bool draw_rays(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_overlay overlay;
    rk_shading_point point;
    rk_ambient_samples samples;
    rk_ray ray = rk_side_view_ray(driver);
    if (!trace_pixel(driver, &ray, &point, &samples, error) ||
        !rk_side_view_render(&c->viewer, driver, &overlay, error))
        return false;
    for (uint32_t i = 0; i < samples.count; i++) {
        rk_ray sample;
        float weight;
        if (rk_ambient_ray(&samples, i, &sample, &weight))
            draw_ray(driver, &overlay, &sample);
    }
    rk_vec3 tip = rk_madd(point.surface.point, point.surface.normal, 0.3f);
    rk_overlay_line(&overlay, ray.origin, point.surface.point, white, 1.5f);
    rk_overlay_line(&overlay, point.surface.point, tip, purple, 3);
    rk_overlay_free(&overlay);
    return true;
}
