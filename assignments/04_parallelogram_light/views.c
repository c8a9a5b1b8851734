/* The debug views: samples on the lights, and the shadow rays to them that the renderer traces from
 * what the pixel's first ray hits. */
#include "driver.h"

#include "render/stages/parallelogram_light_stage.h"

typedef struct drawing {
    rk_overlay overlay;
    rk_driver *driver;
    rk_shading_point point; /* what the pixel's first ray hits */
} drawing;

/* Ambient light has shadow rays, too, which are not drawn. */
static bool record(rk_driver *driver, rk_error *error)
{
    rk_render_options options = driver->render;
    options.ambient_occlusion.intensity = 0;
    return rk_driver_record_surface(driver, &driver->scene, &options, error);
}

static void find_point(drawing *d)
{
    const rk_ray_record_entry *first = d->driver->record.rays;
    d->point = (rk_shading_point){.path = rk_path_start(0, d->driver->render.max_depth)};
    rk_scene_surface(&d->point.surface, &d->driver->scene, &first->ray, &first->hit);
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

/* The colour of a sample without its weight: the brightest channel is 1. */
static void draw_sample(drawing *d, const rk_light_sample *sample)
{
    const rk_vec3 colour = sample->colour;
    const float most = rk_max(colour.x, rk_max(colour.y, colour.z));
    rk_overlay_point(&d->overlay, sample->position, most > 0 ? rk_scale(colour, 1 / most) : colour,
                     3);
}

/* The samples of one light, drawn as by its stage. */
static void draw_light(drawing *d, uint32_t index)
{
    const rk_driver *driver = d->driver;
    const rk_render_options *options = &driver->render;
    const rk_rendering r = {.options = options, .joint_runs = rk_joint_runs_of()};
    const rk_sample_pass pass = {.tile = {driver->pixel.x, driver->pixel.y, 1, 1},
                                 .samples = options->samples};
    const rk_light *light = &driver->scene.lights[index];
    uint32_t count = light->kind == RK_LIGHT_POINT ? 1 : options->light.samples;
    draw_outline(d, light);
    for (uint32_t i = 0; i < count; i++) {
        rk_vec2 xi;
        rk_light_random(&r, &pass, &d->point, index, RK_DIMENSION_LIGHT, count, i, 1, &xi);
        rk_light_sample sample = rk_light_sample_at(
            light, options->light.falloff, options->light.domain, d->point.surface.point, xi);
        draw_sample(d, &sample);
    }
}

/* Those of the pixel's first sample, before any reflection. Returns how many were traced. */
static uint32_t draw_shadow_rays(drawing *d, uint32_t *unoccluded)
{
    const rk_ray_record *record = &d->driver->record;
    uint32_t traced = 0;
    *unoccluded = 0;
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *it = &record->rays[i];
        if (it->kind != RK_RAY_SHADOW || it->bounce > 0 || it->sample > 0)
            continue;
        rk_overlay_shadow_ray(&d->overlay, it->ray.origin,
                              rk_add(it->ray.origin, it->ray.direction), it->occluded);
        *unoccluded += !it->occluded;
        traced++;
    }
    return traced;
}

static void draw_all(drawing *d)
{
    const rk_driver *driver = d->driver;
    choices *c = driver->choices;
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++)
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.4f); /* to the background */
    if (rk_driver_debug(driver, "rays"))
        c->traced = draw_shadow_rays(d, &c->unoccluded);
    for (uint32_t i = 0; i < driver->scene.light_count; i++)
        draw_light(d, i);
}

bool draw_view(rk_driver *driver, rk_error *error)
{
    drawing d = {.driver = driver};
    rk_driver_draw_pixel(driver);
    if (!record(driver, error) || !rk_driver_render_overlay(driver, &d.overlay, error))
        return false;
    find_point(&d);
    draw_all(&d);
    rk_overlay_free(&d.overlay);
    return true;
}
