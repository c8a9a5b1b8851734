/* Draws the figures and measures the tables of parallelogram_light: hard and soft shadows, the
 * shadow rays of one pixel, the samples on the light, and how fast each method gets exact. */
#include "driver.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene with lights that have an extent.\n"
    "--debug rays draws the shadow rays of --pixel: green pass, red are blocked.\n"
    "--debug samples draws the samples on the light in its colours.\n"
    "--convergence puts the error of each method against time into a table; with --falloff "
    "physical into another one.";

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

/* --- What is saved --------------------------------------------------------------------------- */

/* Names the picture by all that it depends on here. */
static bool save(rk_driver *driver, const choices *c, rk_error *error)
{
    static const char *const kinds[] = {"", "point_", "segment_", "parallelogram_"};
    const rk_light_options *light = &driver->render.light;
    char label[128], pixel[32] = "";
    if (driver->debug)
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    snprintf(label, sizeof label, "%s%s%s%s%u_%s%s%s%s%s", driver->debug ? driver->debug : "",
             driver->debug ? "_" : "", kinds[c->light], c->coloured ? "coloured_" : "",
             light->samples, rk_sampler_name(light->sampling),
             light->domain == RK_LIGHT_DOMAIN_SOLID_ANGLE ? "_solid-angle" : "",
             light->falloff == RK_FALLOFF_PHYSICAL ? "_physical" : "", light->ratio ? "_ratio" : "",
             pixel);
    return rk_driver_save(driver, label, error);
}

/* The render, and what a pixel asked for; under names of their own where nothing may be settled. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    double pixels = (double)driver->counters.primary_rays;
    rk_timing samples = rk_timing_once((double)driver->counters.light_samples / pixels);
    rk_timing rays = rk_timing_once((double)driver->counters.shadow_rays / pixels);
    if (driver->render.light.early_out == 0)
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
    set_lights(&driver, &c);
    rk_error error = {""};
    bool ok = rk_driver_build(&driver, &error);
    if (ok && c.convergence)
        ok = put_study(&driver, &c, &error);
    else if (ok && driver.debug)
        ok = draw_view(&driver, &c, &error) && save(&driver, &c, &error);
    else if (ok)
        ok = rk_driver_render(&driver, &error) &&
             (driver.timing ? put_rows(&driver, &error) : save(&driver, &c, &error));
    return rk_driver_finish(&driver, ok, &error);
}
