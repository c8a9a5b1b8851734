/* Draws the figures and measures the tables of bloom: a scene that glows, what of it glows, the
 * glow alone, how long it takes, and how far cheaper filters are from it. */
#include "driver.h"

#include "post/bloom_stage.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene and lets what is bright glow (--bloom-threshold and others).\n"
    "--debug threshold shows what glows in red, --debug mask the glow alone.\n"
    "--errors puts time and error of each --bloom-method into a table.";

static const char *const border_names[] = {"zero", "clamp", "renormalize"};

/* The renderer makes no glow where copies of its picture are to glow. */
static void prepare(rk_driver *driver, choices *c)
{
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->light_count; i++)
        for (int k = 0; k < 4; k++)
            scene->lights[i].colours[k] = rk_scale(scene->lights[i].colours[k], c->light);
    c->bloom = driver->render.bloom;
    driver->render.bloom.on = c->bloom.on && !driver->debug && !driver->timing && !c->errors;
}

bool glow_copy(rk_driver *driver, const rk_bloom_options *options, rk_image *copy, rk_timing *ms,
               rk_error *error)
{
    double milliseconds[RK_RUNS_MAX];
    bool ok = true;
    for (uint32_t run = 0; ok && run < driver->runs; run++) {
        memcpy(copy->pixels, driver->image.pixels, pixels_of(copy) * sizeof *copy->pixels);
        double start = rk_clock_wall();
        ok = rk_bloom_stage(copy, options, driver->pool, &driver->counters, error);
        milliseconds[run] = 1e3 * (rk_clock_wall() - start);
    }
    if (ok)
        *ms = rk_timing_of(milliseconds, driver->runs);
    return ok;
}

/* A picture as it is, a dark one, and one that glows everywhere. */
static bool put_rows(rk_driver *driver, const choices *c, rk_error *error)
{
    const rk_bloom_options *options = &c->bloom;
    const char *const names[] = {"as_is", "dark", "all"};
    const float thresholds[] = {options->threshold, 1e6f, -1e6f};
    rk_image copy;
    if (!rk_image_init(&copy, driver->image.width, driver->image.height, error))
        return false;
    bool ok = rk_driver_row(driver, "render", "ms", driver->render_ms, error);
    for (int i = 0; ok && i < 3; i++) {
        char metric[64];
        rk_timing ms;
        rk_bloom_options now = *options;
        now.threshold = thresholds[i];
        snprintf(metric, sizeof metric, "%s_r%u_%s", names[i], now.radius,
                 method_names[now.method]);
        ok = glow_copy(driver, &now, &copy, &ms, error) &&
             rk_driver_row(driver, metric, "ms", ms, error);
    }
    rk_image_free(&copy);
    return ok;
}

static bool save(rk_driver *driver, const choices *c, rk_error *error)
{
    const rk_bloom_options *options = &c->bloom;
    char label[96];
    snprintf(label, sizeof label, "%s_%g_r%u_%s_%s", driver->debug ? driver->debug : "glow",
             (double)options->threshold, options->radius, border_names[options->border],
             method_names[options->method]);
    return rk_driver_save(driver, rk_bloom_wanted(options) || driver->debug ? label : "without",
                          error);
}

int main(int argc, char **argv)
{
    choices c = {.light = 1};
    const rk_option options[] = {
        {"light", RK_OPTION_FLOAT, &c.light, "F", "lights are F times as bright as the scene's", 0,
         1e6},
        {"errors", RK_OPTION_FLAG, &c.errors, NULL,
         "put time and error of each method into DIR/tables/bloom_errors.csv instead of drawing", 0,
         0},
        {0},
    };
    const char *const views[] = {"threshold", "mask", NULL};
    rk_driver driver = rk_driver_default("bloom", summary);
    driver.scene_name = "teapot";
    driver.render.bloom.on = true;
    driver.render.shading.model = RK_SHADING_BLINN_PHONG;
    driver.render.shadows = true;
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    prepare(&driver, &c);
    bool ok = rk_driver_build(&driver, &error);
    if (ok && c.errors)
        ok = put_study(&driver, &c, &error);
    else if (ok && driver.debug)
        ok = draw_view(&driver, &c, &error) && save(&driver, &c, &error);
    else if (ok)
        ok = rk_driver_render(&driver, &error) &&
             (driver.timing ? put_rows(&driver, &c, &error) : save(&driver, &c, &error));
    return rk_driver_finish(&driver, ok, &error);
}
