/* The debug view: the path of one pixel's ray through glass, and the shadow rays from its end. */
#include "driver.h"

typedef struct drawing {
    const rk_driver *driver;
    rk_overlay overlay;
    rk_counters counters; /* not read */
} drawing;

static rk_vec3 along(const rk_ray *ray, float t)
{
    return rk_madd(ray->origin, ray->direction, t);
}

/* The colour seen along the rest of a view ray, from t on: surfaces in their own colours, as if
 * fully lit, blended with those behind them. */
static rk_vec3 colour_behind(drawing *d, const rk_ray *ray, float t, uint32_t limit)
{
    rk_ray rest = {along(ray, t), ray->direction, INFINITY};
    rk_crossing_list list;
    float weights[RK_CROSSINGS_MAX], transmittance;
    rk_crossings_gather(&d->driver->accel, &rest, limit, &list, &d->counters);
    rk_transparency_weights(list.crossings, list.count, weights, &transmittance);
    rk_vec3 colour = rk_vec(0, 0, 0);
    for (uint32_t k = 0; k < list.count; k++)
        colour = rk_madd(colour, list.crossings[k].kd, weights[k]);
    return colour;
}

/* The light's transmittance along a shadow ray from t to 1. */
static rk_vec3 colour_of_light(drawing *d, const rk_ray *ray, float t)
{
    rk_ray rest = {along(ray, t), rk_scale(ray->direction, 1 - t), 1};
    return rk_crossings_transmit(&d->driver->accel, &rest, d->driver->render.glass, &d->counters);
}

/* Each interval between crossings in the colour of the light that travels there. */
static void draw_view_ray(drawing *d, const rk_ray *ray, const rk_crossing_list *list)
{
    float from = 0;
    for (uint32_t k = 0; k < list->count; k++) {
        const rk_crossing *crossing = &list->crossings[k];
        rk_vec3 colour = colour_behind(d, ray, (from + crossing->t) / 2, list->limit - k);
        rk_overlay_line(&d->overlay, along(ray, from), along(ray, crossing->t), colour, 5);
        from = crossing->t;
    }
    for (uint32_t k = 0; k < list->count; k++)
        rk_overlay_point(&d->overlay, along(ray, list->crossings[k].t), list->crossings[k].kd, 6);
    rk_overlay_point(&d->overlay, ray->origin, rk_vec(1, 1, 1), 8);
}

static void draw_shadow_ray(drawing *d, const rk_surface *surface, rk_vec3 light)
{
    rk_vec3 start = rk_surface_spawn_to_light(surface, rk_sub(light, surface->point));
    rk_ray ray = {start, rk_sub(light, start), 1};
    rk_crossing_list list;
    rk_crossings_gather(&d->driver->accel, &ray, RK_CROSSINGS_MAX, &list, &d->counters);
    for (uint32_t k = 0; k <= list.count; k++) {
        float from = k ? list.crossings[k - 1].t : 0;
        float to = k < list.count ? list.crossings[k].t : 1;
        rk_overlay_line(&d->overlay, along(&ray, from), along(&ray, to),
                        colour_of_light(d, &ray, (from + to) / 2), 3);
    }
    rk_overlay_point(&d->overlay, light, rk_vec(1, 1, 1), 8);
}

static void draw_rays(drawing *d, const rk_ray *ray)
{
    const rk_scene *scene = &d->driver->scene;
    rk_crossing_list list;
    rk_crossings_gather(&d->driver->accel, ray, d->driver->render.max_depth + 1, &list,
                        &d->counters);
    draw_view_ray(d, ray, &list);
    if (list.count == 0 || !d->driver->render.shadows)
        return;
    rk_hit last = rk_crossing_hit(&list.crossings[list.count - 1]);
    rk_surface surface;
    rk_scene_surface(&surface, scene, ray, &last);
    for (uint32_t i = 0; i < scene->light_count; i++)
        draw_shadow_ray(d, &surface,
                        rk_light_sample_at(&scene->lights[i], RK_FALLOFF_NONE, RK_LIGHT_DOMAIN_AREA,
                                           surface.point, (rk_vec2){0.5f, 0.5f})
                            .position);
}

/* The ray is the camera's, the picture is drawn from beside it. Nothing hides the ray, not even
 * walls. */
bool draw_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_ray ray = rk_side_view_ray(driver);
    drawing d = {.driver = driver};
    if (!rk_side_view_render(&c->viewer, driver, &d.overlay, error))
        return false;
    draw_rays(&d, &ray);
    rk_overlay_free(&d.overlay);
    return true;
}
