/* Draws the figures and measures the tables of bloom: a scene that glows, what of it glows, the
 * glow alone, how long it takes, and how far cheaper filters are from it. */
#include "render/driver.h"
#include "base/file.h"
#include "render/glow.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char summary[] =
    "Renders a scene and lets what is bright glow (--bloom-threshold and others).\n"
    "--debug threshold shows what glows in red, --debug mask the glow alone.\n"
    "--errors puts time and error of each --bloom-method into a table.";

static const char *const method_names[] = {"exact", "gaussian", "recursive", "pyramid"};
static const char *const border_names[] = {"zero", "clamp", "renormalize"};
enum { method_count = sizeof method_names / sizeof method_names[0] };

typedef struct choices {
    float light; /* times as bright as the scene's own */
    bool errors;
} choices;

static size_t pixels_of(const rk_image *image)
{
    return image->width * image->height;
}

/* Lets a copy of the picture glow, `runs` times. */
static bool glow_copy(rk_driver *driver, const rk_bloom_options *options, rk_image *copy,
                      rk_timing *ms, rk_error *error)
{
    double milliseconds[RK_RUNS_MAX];
    bool ok = true;
    for (uint32_t run = 0; ok && run < driver->runs; run++) {
        memcpy(copy->pixels, driver->image.pixels, pixels_of(copy) * sizeof *copy->pixels);
        double start = rk_clock_wall();
        ok = rk_glow(copy, options, driver->pool, &driver->counters, error);
        milliseconds[run] = 1e3 * (rk_clock_wall() - start);
    }
    if (ok)
        *ms = rk_timing_of(milliseconds, driver->runs);
    return ok;
}

/* --- Debug views ------------------------------------------------------------------------------ */

static void show_threshold(rk_image *image, float threshold)
{
    for (size_t i = 0; i < pixels_of(image); i++) {
        float dark = 0.15f * rk_bloom_luminance(image->pixels[i]);
        image->pixels[i] = rk_bloom_glows(image->pixels[i], threshold) ? rk_vec(1, 0, 0)
                                                                       : rk_vec(dark, dark, dark);
    }
}

static bool show_mask(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    rk_image with;
    rk_timing ms;
    if (!rk_image_init(&with, driver->image.width, driver->image.height, error))
        return false;
    rk_bloom_options alone = *options;
    alone.intensity = 1;
    bool ok = glow_copy(driver, &alone, &with, &ms, error);
    for (size_t i = 0; ok && i < pixels_of(&with); i++)
        driver->image.pixels[i] = rk_sub(with.pixels[i], driver->image.pixels[i]);
    rk_image_free(&with);
    return ok;
}

/* --- Tables ----------------------------------------------------------------------------------- */

/* A picture as it is, a dark one, and one that glows everywhere. */
static bool put_timings(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
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

typedef struct difference {
    double largest, rms;
} difference;

static difference difference_of(const rk_image *a, const rk_image *b)
{
    double largest = 0, squares = 0;
    for (size_t i = 0; i < pixels_of(a); i++)
        for (int axis = 0; axis < 3; axis++) {
            double d =
                fabs((double)rk_axis(a->pixels[i], axis) - (double)rk_axis(b->pixels[i], axis));
            largest = d > largest ? d : largest;
            squares += d * d;
        }
    return (difference){largest, sqrt(squares / (3 * (double)pixels_of(a)))};
}

static bool put_error(rk_driver *driver, const rk_bloom_options *options, double ms, difference d,
                      rk_error *error)
{
    static const char *const header[] = {"scene",     "radius", "method", "milliseconds",
                                         "max_error", "rmse",   NULL};
    char path[4096], cells[4][32];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/bloom_errors.csv", driver->out);
    snprintf(cells[0], sizeof cells[0], "%u", options->radius);
    snprintf(cells[1], sizeof cells[1], "%.4g", ms);
    snprintf(cells[2], sizeof cells[2], "%.3g", d.largest);
    snprintf(cells[3], sizeof cells[3], "%.3g", d.rms);
    const char *row[] = {driver->scene.name, cells[0], method_names[options->method],
                         cells[1],           cells[2], cells[3]};
    return rk_table_put(path, header, row, 6, 3, error);
}

/* Each method at several radii, against the filter itself. */
static bool put_errors(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    const uint32_t radii[] = {15, 50, 100, 250, 1000};
    rk_image exact = {0}, near = {0};
    bool ok = rk_image_init(&exact, driver->image.width, driver->image.height, error) &&
              rk_image_init(&near, driver->image.width, driver->image.height, error);
    for (size_t i = 0; ok && i < sizeof radii / sizeof *radii; i++)
        for (int method = 0; ok && method < method_count; method++) {
            rk_bloom_options now = *options;
            rk_timing ms;
            now.radius = radii[i];
            now.method = (rk_bloom_method)method;
            rk_image *result = method == RK_BLOOM_EXACT ? &exact : &near;
            ok = glow_copy(driver, &now, result, &ms, error) &&
                 put_error(driver, &now, ms.median, difference_of(result, &exact), error);
        }
    rk_image_free(&exact);
    rk_image_free(&near);
    return ok;
}

/* --- The driver ------------------------------------------------------------------------------- */

static bool save(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    char label[96];
    snprintf(label, sizeof label, "%s_%g_r%u_%s_%s", driver->debug ? driver->debug : "glow",
             (double)options->threshold, options->radius, border_names[options->border],
             method_names[options->method]);
    return rk_driver_save(driver, rk_bloom_wanted(options) || driver->debug ? label : "without",
                          error);
}

static bool draw(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    if (rk_driver_debug(driver, "threshold"))
        show_threshold(&driver->image, options->threshold);
    return (!rk_driver_debug(driver, "mask") || show_mask(driver, options, error)) &&
           save(driver, options, error);
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
    rk_scene *scene = &driver.scene;
    for (uint32_t i = 0; i < scene->light_count; i++)
        for (int k = 0; k < 4; k++)
            scene->lights[i].colours[k] = rk_scale(scene->lights[i].colours[k], c.light);
    const rk_bloom_options bloom = driver.render.bloom;
    driver.render.bloom.on = bloom.on && !driver.debug && !driver.timing && !c.errors;
    bool ok = rk_driver_build(&driver, &error) && rk_driver_render(&driver, &error);
    if (ok && c.errors)
        ok = put_errors(&driver, &bloom, &error);
    else if (ok && driver.timing)
        ok = put_timings(&driver, &bloom, &error);
    else if (ok)
        ok = draw(&driver, &bloom, &error);
    return rk_driver_finish(&driver, ok, &error);
}
