/* The debug views: samples on the lights, and the shadow rays to them from the point that a pixel
 * sees. */
#include "driver.h"

#include "accel/trace_one.h"

typedef struct drawing {
    rk_overlay overlay;
    const rk_driver *driver;
    rk_surface surface; /* what the pixel sees */
} drawing;

/* Finds the surface at the pixel's centre. */
static bool find_surface(drawing *d, rk_error *error)
{
    const rk_pixel pixel = d->driver->pixel;
    rk_ray ray = rk_view_ray(&d->overlay.view, (float)pixel.x + 0.5f, (float)pixel.y + 0.5f);
    return rk_trace_one_surface(&d->surface, &d->driver->accel, &ray) ||
           rk_fail(error,
                   "--debug %s: the pixel %u,%u sees no surface; choose one that does by "
                   "--pixel X,Y",
                   d->driver->debug, pixel.x, pixel.y);
}

static void draw_outline(drawing *d, const rk_light *light)
{
    const rk_vec3 white = {1, 1, 1};
    rk_vec3 corner[4] = {light->position, light->position, light->position, light->position};
    for (int k = 1; k < 4 && light->kind != RK_LIGHT_POINT; k++) {
        corner[k] = rk_madd(corner[k], light->edge01, k < 3);
        corner[k] =
            rk_madd(corner[k], light->edge02, k > 1 && light->kind == RK_LIGHT_PARALLELOGRAM);
    }
    for (int k = 0; k < 4; k++)
        rk_overlay_line(&d->overlay, corner[k], corner[(k + 1) % 4], white, 2.5f);
}

static void draw_shadow_ray(drawing *d, rk_vec3 end)
{
    rk_vec3 start = rk_surface_spawn_to_light(&d->surface, rk_sub(end, d->surface.point));
    rk_ray ray = {start, rk_sub(end, start), 1};
    bool occluded = rk_trace_one(&d->driver->accel, &ray).triangle != RK_MISS;
    rk_overlay_shadow_ray(&d->overlay, start, end, occluded);
}

/* The samples that the renderer takes for the pixel's first ray. */
static void draw_light(drawing *d, uint32_t index)
{
    const rk_driver *driver = d->driver;
    const rk_render_options *options = &driver->render;
    const rk_light *light = &driver->scene.lights[index];
    uint32_t pixel = driver->pixel.y * options->width + driver->pixel.x;
    uint32_t count = light->kind == RK_LIGHT_POINT ? 1 : options->light.samples;
    const rk_sampler sampler =
        rk_render_sampler(options, options->light.sampling, options->samples * count);
    draw_outline(d, light);
    for (uint32_t i = 0; i < count; i++) {
        rk_vec2 xi = rk_joint_2d(&sampler, pixel, i, RK_DIMENSION_LIGHT + 2 * index);
        rk_light_sample sample = rk_light_sample_at(light, options->light.falloff,
                                                    options->light.domain, d->surface.point, xi);
        if (rk_driver_debug(driver, "rays"))
            draw_shadow_ray(d, sample.position);
        /* Colours without their weights: the brightest channel is 1. */
        float most = rk_max(sample.colour.x, rk_max(sample.colour.y, sample.colour.z));
        rk_overlay_point(&d->overlay, sample.position,
                         most > 0 ? rk_scale(sample.colour, 1 / most) : sample.colour, 3);
    }
}

bool draw_view(rk_driver *driver, rk_error *error)
{
    drawing d = {.driver = driver};
    rk_driver_draw_pixel(driver);
    if (!rk_driver_render(driver, error) ||
        !rk_overlay_init(&d.overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    bool ok = find_surface(&d, error);
    for (size_t i = 0; ok && i < driver->image.width * driver->image.height; i++)
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.4f); /* to the background */
    for (uint32_t i = 0; ok && i < driver->scene.light_count; i++)
        draw_light(&d, i);
    rk_overlay_free(&d.overlay);
    return ok;
}
