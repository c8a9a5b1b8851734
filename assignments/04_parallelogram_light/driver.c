/* Draws the figures and measures the tables of parallelogram_light: hard and soft shadows, the
 * shadow rays of one pixel, the samples on the light, and how fast each method gets exact. */
#include "render/convergence.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene with lights that have an extent.\n"
    "--debug rays draws the shadow rays of --pixel: green pass, red are blocked.\n"
    "--debug samples draws the samples on the light in its colours.\n"
    "--convergence puts the error of each method against time into a table; with --falloff "
    "physical into another one.";

typedef struct choices {
    uint32_t light; /* 0: as the scene has it; or 1 + rk_light_kind */
    bool coloured, convergence;
    float brightness;
    uint32_t most, reference; /* samples */
} choices;

/* --- The lights ------------------------------------------------------------------------------ */

/* A point stands in the middle of the light, a segment between the middles of two sides. */
static void shrink(rk_light *light, rk_light_kind kind)
{
    light->position = rk_madd(light->position, light->edge02, 0.5f);
    if (kind == RK_LIGHT_POINT)
        light->position = rk_madd(light->position, light->edge01, 0.5f);
    light->kind = kind;
}

static void set_lights(rk_driver *driver, const choices *c)
{
    const rk_vec3 corners[4] = {{1, 0.1f, 0.1f}, {0.1f, 1, 0.1f}, {0.2f, 0.2f, 1}, {1, 0.9f, 0.1f}};
    for (uint32_t i = 0; i < driver->scene.light_count; i++) {
        rk_light *light = &driver->scene.lights[i];
        if (c->light && light->kind == RK_LIGHT_PARALLELOGRAM)
            shrink(light, (rk_light_kind)(c->light - 1));
        if (c->coloured)
            memcpy(light->colours, corners, sizeof corners);
        for (int k = 0; k < 4; k++)
            light->colours[k] = rk_scale(light->colours[k], c->brightness);
    }
}

/* --- Debug views ----------------------------------------------------------------------------- */

/* Names a picture by all that it depends on here. */
typedef struct label {
    char text[128];
} label;

static label label_of(const rk_driver *driver, const choices *c)
{
    static const char *const kinds[] = {"", "point_", "segment_", "parallelogram_"};
    static const char *const samplings[] = {"uniform", "stratified", "low-discrepancy"};
    const rk_light_options *light = &driver->render.light;
    char pixel[32] = "";
    label made;
    if (driver->debug)
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    snprintf(made.text, sizeof made.text, "%s%s%s%s%u_%s%s%s%s%s",
             driver->debug ? driver->debug : "", driver->debug ? "_" : "", kinds[c->light],
             c->coloured ? "coloured_" : "", light->samples, samplings[light->sampling],
             light->map == RK_LIGHT_MAP_SOLID_ANGLE ? "_solid-angle" : "",
             light->falloff == RK_FALLOFF_PHYSICAL ? "_physical" : "", light->ratio ? "_ratio" : "",
             pixel);
    return made;
}

typedef struct drawing {
    rk_overlay overlay;
    const rk_driver *driver;
    rk_surface surface; /* what the pixel sees */
} drawing;

/* The surface behind the pixel's centre. */
static bool look(drawing *d, rk_pixel pixel, rk_error *error)
{
    const rk_driver *driver = d->driver;
    rk_ray ray = rk_view_ray(&d->overlay.view, (float)pixel.x + 0.5f, (float)pixel.y + 0.5f);
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_batch_push(&rays, &ray);
    rk_accel_closest(&driver->accel, &rays, &hits, &counters);
    rk_hit hit = rk_batch_hit(&hits, 0);
    if (hit.triangle == RK_MISS)
        return rk_fail(error,
                       "--debug %s: nothing is seen at the pixel %u,%u; choose one on a surface by "
                       "--pixel X,Y",
                       driver->debug, pixel.x, pixel.y);
    rk_scene_surface(&d->surface, &driver->scene, &ray, &hit);
    return true;
}

static bool is_blocked(const drawing *d, rk_vec3 start, rk_vec3 end)
{
    rk_ray ray = {start, rk_sub(end, start), 1};
    rk_ray_batch rays = {.count = 0};
    rk_any_batch blocked;
    rk_counters counters = {0};
    rk_batch_push(&rays, &ray);
    rk_accel_any(&d->driver->accel, &rays, &blocked, &counters);
    return blocked.found[0];
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
        rk_overlay_line(&d->overlay, corner[k], corner[(k + 1) % 4], white, 1.5f);
}

/* The samples that the renderer takes for the pixel's first ray. */
static void draw_light(drawing *d, uint32_t index, uint32_t pixel)
{
    const rk_render_options *options = &d->driver->render;
    const rk_light *light = &d->driver->scene.lights[index];
    uint32_t count = light->kind == RK_LIGHT_POINT ? 1 : options->light.samples;
    const rk_sampler sampler = {options->light.sampling, options->seed, options->samples * count};
    draw_outline(d, light);
    for (uint32_t i = 0; i < count; i++) {
        rk_vec2 xi = rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_LIGHT + 2 * index);
        rk_light_sample sample = rk_light_sample_at(light, options->light.falloff,
                                                    options->light.map, d->surface.point, xi);
        if (rk_driver_debug(d->driver, "rays")) {
            rk_vec3 start =
                rk_surface_leave(&d->surface, rk_sub(sample.position, d->surface.point));
            rk_vec3 colour = is_blocked(d, start, sample.position) ? rk_vec(1, 0.05f, 0.05f)
                                                                   : rk_vec(0.05f, 0.8f, 0.1f);
            rk_overlay_line(&d->overlay, start, sample.position, colour, 1);
        }
        /* Colours without their weights: the brightest channel is 1. */
        float most = rk_max(sample.colour.x, rk_max(sample.colour.y, sample.colour.z));
        rk_overlay_point(&d->overlay, sample.position,
                         most > 0 ? rk_scale(sample.colour, 1 / most) : sample.colour, 3);
    }
}

static bool draw(rk_driver *driver, const choices *c, rk_error *error)
{
    const rk_pixel pixel = driver->pixel;
    drawing d = {.driver = driver};
    if (!rk_overlay_init(&d.overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    bool ok = look(&d, pixel, error);
    for (size_t i = 0; ok && i < driver->image.width * driver->image.height; i++)
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.4f); /* steps back */
    for (uint32_t i = 0; ok && i < driver->scene.light_count; i++)
        draw_light(&d, i, pixel.y * driver->render.width + pixel.x);
    rk_overlay_free(&d.overlay);
    return ok && rk_driver_save(driver, label_of(driver, c).text, error);
}

/* --- Error against time ---------------------------------------------------------------------- */

typedef struct method {
    const char *name;
    rk_sampler_kind sampling;
    rk_light_map map;
    bool ratio;
    uint32_t settle;
} method;

/* The last two are others only with physical falloff, and have no rows without. */
static const method methods[] = {
    {"uniform", RK_SAMPLER_UNIFORM, RK_LIGHT_MAP_AREA, false, 0},
    {"stratified", RK_SAMPLER_STRATIFIED, RK_LIGHT_MAP_AREA, false, 0},
    {"low discrepancy", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_MAP_AREA, false, 0},
    {"settled", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_MAP_AREA, false, RK_LIGHT_ROUND},
    {"solid angle", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_MAP_SOLID_ANGLE, false, 0},
    {"ratio", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_MAP_AREA, true, 0},
};

/* The least noisy of all; its bias falls with 1 / samples. */
static const method best = {"", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_MAP_SOLID_ANGLE, true, 0};

static void choose(rk_driver *driver, const method *m, uint32_t samples)
{
    rk_light_options *light = &driver->render.light;
    light->sampling = m->sampling;
    light->map = m->map;
    light->ratio = m->ratio;
    light->settle = m->settle;
    light->samples = samples;
}

static bool converge(rk_driver *driver, const choices *c, rk_error *error)
{
    bool physical = driver->render.light.falloff == RK_FALLOFF_PHYSICAL;
    size_t count = sizeof methods / sizeof *methods - (physical ? 0 : 2);
    char name[64], truth[32];
    rk_image reference;
    snprintf(name, sizeof name, "%s_convergence%s", driver->feature, physical ? "_physical" : "");
    snprintf(truth, sizeof truth, "%u samples", c->reference);
    choose(driver, &best, c->reference);
    if (!rk_convergence_reference(driver, &reference, error))
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++)
        for (uint32_t samples = 1; ok && samples <= c->most; samples *= 4) {
            choose(driver, &methods[i], samples);
            ok = rk_convergence_row_of(driver, name, methods[i].name, samples, &reference, truth,
                                       error);
        }
    rk_image_free(&reference);
    return ok;
}

/* --- Timings --------------------------------------------------------------------------------- */

/* The render, and what a pixel asked for; under names of their own where nothing may be settled. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    double pixels = (double)driver->counters.primary_rays;
    rk_timing samples = rk_timing_once((double)driver->counters.light_samples / pixels);
    rk_timing rays = rk_timing_once((double)driver->counters.shadow_rays / pixels);
    if (driver->render.light.settle == 0)
        return rk_driver_row(driver, "render_all_traced", "ms", driver->render_ms, error) &&
               rk_driver_row(driver, "shadow_rays_all_traced", "1", rays, error);
    return rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_row(driver, "light_samples", "1", samples, error) &&
           rk_driver_row(driver, "shadow_rays", "1", rays, error);
}

int main(int argc, char **argv)
{
    choices c = {.brightness = 1, .most = 64, .reference = 2048};
    const rk_option options[] = {
        {"light", RK_OPTION_CHOICE, &c.light, "own|point|segment|parallelogram",
         "shrink the scene's parallelograms to their middle, or to a line through it", 0, 0},
        {"coloured", RK_OPTION_FLAG, &c.coloured, NULL,
         "the lights' corners shine red, green, blue and yellow", 0, 0},
        {"brightness", RK_OPTION_FLOAT, &c.brightness, "F", "multiplies the lights' colours", 0,
         1e6},
        {"convergence", RK_OPTION_FLAG, &c.convergence, NULL,
         "put the error and time of each method and number of samples into a table", 0, 0},
        {"most", RK_OPTION_UINT, &c.most, "N", "samples that --convergence goes up to", 1, 4096},
        {"reference", RK_OPTION_UINT, &c.reference, "N",
         "samples of the picture that --convergence compares with", 1, 16384},
        {0},
    };
    const char *const views[] = {"rays", "samples", NULL};
    rk_driver driver = rk_driver_default("parallelogram_light", summary);
    driver.scene_name = "cornell-light";
    driver.drawn_x = 86; /* in the Cornell box, a place on the floor that sees a part of the lamp */
    driver.drawn_y = 88;
    driver.render.shadows = true;
    driver.render.light.sampling = RK_SAMPLER_LOW_DISCREPANCY; /* settling wants even prefixes */
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    if (driver.debug)
        rk_driver_draw_pixel(&driver);
    set_lights(&driver, &c);
    bool ok = rk_driver_build(&driver, &error);
    if (ok && c.convergence)
        ok = converge(&driver, &c, &error);
    else
        ok = ok && rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        ok = put_rows(&driver, &error);
    else if (ok && driver.debug)
        ok = draw(&driver, &c, &error);
    else if (ok && !c.convergence)
        ok = rk_driver_save(&driver, label_of(&driver, &c).text, &error);
    return rk_driver_finish(&driver, ok, &error);
}
