/* The debug view: the path of one pixel's ray through glass, and the shadow rays from where it
 * crosses a surface, as the renderer traces them. */
#include "driver.h"

typedef struct drawing {
    rk_driver *driver;
    rk_overlay overlay;
} drawing;

static rk_vec3 along(const rk_ray *ray, float t)
{
    return rk_madd(ray->origin, ray->direction, t);
}

/* The colour seen along a view ray from before these crossings on: surfaces in their own colours,
 * as if fully lit, blended with those behind them. */
static rk_vec3 colour_seen(const rk_crossing *crossings, uint32_t count)
{
    float weights[RK_CROSSINGS_MAX], transmittance;
    rk_vec3 colour = rk_vec(0, 0, 0);
    rk_transparency_weights(crossings, count, weights, &transmittance);
    for (uint32_t k = 0; k < count; k++)
        colour = rk_madd(colour, crossings[k].kd, weights[k]);
    return colour;
}

/* The light's transmittance along the rest of a shadow ray, from t to 1; the crossings behind t. */
static rk_vec3 colour_of_light(const drawing *d, const rk_ray *ray, float t,
                               const rk_crossing *crossings, uint32_t count)
{
    rk_crossing rest[RK_CROSSINGS_MAX];
    for (uint32_t k = 0; k < count; k++) {
        rest[k] = crossings[k];
        rest[k].t = (crossings[k].t - t) / (1 - t);
    }
    return rk_transparency_transmit(d->driver->render.glass, rest, count,
                                    (1 - t) * rk_length(ray->direction));
}

/* Each interval between crossings in the colour of the light that travels there. */
static void draw_view_ray(drawing *d, const rk_ray *ray, const rk_crossing *crossings,
                          uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        rk_overlay_line(&d->overlay, along(ray, k ? crossings[k - 1].t : 0),
                        along(ray, crossings[k].t), colour_seen(&crossings[k], count - k), 5);
    for (uint32_t k = 0; k < count; k++)
        rk_overlay_point(&d->overlay, along(ray, crossings[k].t), crossings[k].kd, 6);
    rk_overlay_point(&d->overlay, ray->origin, rk_vec(1, 1, 1), 8);
}

static void draw_shadow_ray(drawing *d, const rk_ray *ray, const rk_crossing *crossings,
                            uint32_t count)
{
    enum { parts = 16 }; /* a block absorbs more and more */
    for (uint32_t k = 0; k <= count; k++) {
        const float from = k ? crossings[k - 1].t : 0, to = k < count ? crossings[k].t : 1;
        for (int i = 0; i < parts; i++) {
            const float part = (to - from) / parts, t = from + part * (float)i;
            rk_overlay_line(&d->overlay, along(ray, t), along(ray, t + part),
                            colour_of_light(d, ray, t + part / 2, &crossings[k], count - k), 3);
        }
    }
}

/* Of the pixel's first sample, before any reflection. */
static void draw_rays(drawing *d)
{
    const rk_ray_record *record = &d->driver->record;
    choices *c = d->driver->choices;
    c->crossed = c->traced = c->unoccluded = 0;
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *it = &record->rays[i];
        const rk_crossing *crossings = &record->crossings[it->first_crossing];
        if (it->kind != RK_RAY_SHADOW || it->bounce > 0 || it->sample > 0)
            continue;
        if (it->occluded)
            rk_overlay_shadow_ray(&d->overlay, it->ray.origin, along(&it->ray, 1), true);
        else
            draw_shadow_ray(d, &it->ray, crossings, it->crossing_count);
        rk_overlay_point(&d->overlay, along(&it->ray, 1), rk_vec(1, 1, 1), 5);
        c->traced++;
        c->unoccluded += !it->occluded;
    }
    c->crossed = record->rays[0].crossing_count;
    draw_view_ray(d, &record->rays[0].ray, record->crossings, c->crossed);
}

/* Ambient light has shadow rays, too, which are not drawn. */
static bool record_rays(rk_driver *driver, rk_error *error)
{
    rk_render_options options = driver->render;
    options.ambient_occlusion.intensity = 0;
    return rk_driver_record_surface(driver, &driver->scene, &options, error);
}

/* The rays are the camera's, the picture is drawn from beside it. Nothing hides them, not even
 * walls. */
bool draw_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    drawing d = {.driver = driver};
    rk_driver_draw_pixel(driver);
    if (!record_rays(driver, error) || !rk_side_view_render(&c->viewer, driver, &d.overlay, error))
        return false;
    draw_rays(&d);
    rk_overlay_free(&d.overlay);
    return true;
}
