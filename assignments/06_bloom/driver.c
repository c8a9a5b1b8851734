/* Draws the figures and measures the tables of bloom: a scene with bloom, its bright pixels, the
 * bloom alone, the time it takes, and the errors of cheaper filters. */
#include "driver.h"

#include "post/bloom_stage.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene with bloom around bright pixels (--bloom-threshold and others).\n"
    "--debug threshold shows bright pixels in red, --debug mask the bloom alone.\n"
    "--errors puts time and error of each --bloom-method into a table.\n"
    "--histogram puts how many pixels are how bright, and how many at or above the threshold, into "
    "the tables bloom_histogram and bloom_bright.\n"
    "--halo puts how many pixels the bloom reaches, and how bright it is, into the table "
    "bloom_halo.";

/* The renderer adds no bloom where copies of its picture get it. */
static bool prepare(rk_driver *driver, rk_error *error)
{
    (void)error;
    const choices *c = driver->choices;
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->light_count; i++)
        for (int k = 0; k < 4; k++)
            scene->lights[i].colours[k] = rk_scale(scene->lights[i].colours[k], c->light);
    return true;
}

static bool choose(rk_driver *driver, rk_error *error)
{
    (void)error;
    choices *c = driver->choices;
    c->bloom = driver->render.bloom;
    driver->render.bloom.on =
        c->bloom.on && !driver->debug && !driver->timing && !c->errors && !c->histogram && !c->halo;
    return true;
}

bool bloom_copy(rk_driver *driver, const rk_bloom_options *options, rk_image *copy, rk_timing *ms,
                rk_error *error)
{
    double milliseconds[RK_RUNS_MAX];
    bool ok = true;
    for (uint32_t run = 0; ok && run < driver->runs; run++) {
        driver->counters.bloom_taps = 0;
        memcpy(copy->pixels, driver->image.pixels, pixels_of(copy) * sizeof *copy->pixels);
        double start = rk_clock_wall();
        ok = rk_bloom_stage(copy, options, driver->pool, &driver->counters, error);
        milliseconds[run] = 1e3 * (rk_clock_wall() - start);
    }
    if (ok)
        *ms = rk_timing_of(milliseconds, driver->runs);
    return ok;
}

/* The picture as it is, all of it dark, and all of it bright. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_bloom_options *options = &c->bloom;
    const char *const names[] = {"as_is", "dark", "all"};
    const float thresholds[] = {options->threshold, 1e6f, -1e6f};
    rk_image copy;
    if (!rk_image_init(&copy, driver->image.width, driver->image.height, error))
        return false;
    bool ok = rk_driver_row(driver, "render", "ms", driver->render_ms, error);
    for (int i = 0; ok && i < 3; i++) {
        char metric[64], taps[72];
        rk_timing ms;
        rk_bloom_options now = *options;
        now.threshold = thresholds[i];
        snprintf(metric, sizeof metric, "%s_r%u_%s", names[i], now.radius,
                 rk_bloom_method_names.items[now.method]);
        snprintf(taps, sizeof taps, "%s_taps", metric);
        ok = bloom_copy(driver, &now, &copy, &ms, error) &&
             rk_driver_row(driver, metric, "ms", ms, error) &&
             rk_driver_row(driver, taps, "1", rk_timing_once(taps_of(driver)), error);
    }
    rk_image_free(&copy);
    return ok;
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_bloom_options *options = &c->bloom;
    char label[96];
    snprintf(label, sizeof label, "%s_%g_r%u_%s_%s", driver->debug ? driver->debug : "glow",
             (double)options->threshold, options->radius,
             rk_bloom_border_names.items[options->border],
             rk_bloom_method_names.items[options->method]);
    return rk_driver_save(driver, rk_bloom_wanted(options) || driver->debug ? label : "without",
                          error);
}

static const rk_option options[] = {
    {"light", RK_FIELD(choices, light), "F", "multiplies the colours of the scene's lights", 0, 1e6,
     1, .of_scene = true},
    {"errors", RK_FIELD(choices, errors), NULL,
     "put time and error of each method into DIR/tables/bloom_errors.csv instead of drawing"},
    {"histogram", RK_FIELD(choices, histogram), NULL,
     "put the numbers of pixels by luminance into tables instead of drawing"},
    {"halo", RK_FIELD(choices, halo), NULL,
     "put width and brightness of the bloom alone into a table instead of drawing"},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "teapot";
    driver->render.bloom.on = true;
    driver->render.shading.model = RK_SHADING_BLINN_PHONG;
    driver->render.shadows = true;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "bloom",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views =
            (rk_driver_view[]){{"threshold", draw_view, false}, {"mask", draw_view, false}, {0}},
        .studies = (rk_driver_study[]){{&c.errors, put_study, false},
                                       {&c.histogram, put_histogram, false},
                                       {&c.halo, put_halo, false},
                                       {0}},
        .choose = choose,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
