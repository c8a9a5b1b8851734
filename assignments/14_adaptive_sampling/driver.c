/* Draws the figures and measures the tables of adaptive_sampling: pictures of a wanted error, their
 * numbers of samples per pixel, and the samples that they save. */
#include "driver.h"

#include "features/shading.h"
#include "render/stages/adaptive_sampling_stage.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with as many samples as an error needs (--error), where the picture is "
    "noisy.\n"
    "--show samples shows the number of samples per pixel, from blue (4) to orange (the most "
    "that a pixel of the picture takes), by its logarithm.\n"
    "--efficiency writes a table: samples for the same error, evenly, adaptively, and the fewest.";

static rk_vec3 colour_of_samples(float fraction)
{
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    return rk_gradient_at(&gradient, 2 * fraction - 1);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const rk_adaptive_sampling_options *o = &driver->render.adaptive_sampling;
    char label[64] = "even";
    if (o->error > 0 && o->shown == RK_ADAPTIVE_SAMPLES) {
        driver->scale =
            rk_driver_scale_of("samples per pixel", RK_ADAPTIVE_BLOCKS,
                               (double)driver->counters.most_samples, colour_of_samples);
        driver->scale.logarithmic = true;
    }
    if (o->error > 0)
        snprintf(label, sizeof label, "%s_%g", rk_adaptive_shown_names.items[o->shown],
                 (double)o->error);
    return rk_driver_save(driver, label, error);
}

/* The wanted error is part of the metrics' names. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_counters *counters = &driver->counters;
    const double pixels = (double)driver->render.width * driver->render.height;
    const double wanted = (double)driver->render.adaptive_sampling.error;
    char render[32], samples[32], kept[32], estimated[32];
    snprintf(render, sizeof render, "render_%g", wanted);
    snprintf(samples, sizeof samples, "samples_%g", wanted);
    snprintf(kept, sizeof kept, "kept_samples_%g", wanted);
    snprintf(estimated, sizeof estimated, "estimated_error_%g", wanted);
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, samples, "1",
                         rk_timing_once((double)counters->taken_samples / pixels), error) &&
           rk_driver_row(driver, kept, "1", rk_timing_once((double)counters->kept_samples / pixels),
                         error) &&
           rk_driver_row(driver, estimated, "%", rk_timing_once(100 * counters->estimated_error),
                         error) &&
           rk_driver_count_rows(driver, error);
}

static const rk_option options[] = {
    {"efficiency", RK_FIELD(choices, efficiency), NULL,
     "write a table: samples for errors of 2 % and 1 %, evenly, adaptively, and by the best "
     "allocation"},
    {"effect", RK_FIELD(choices, effect), "NAME", "name of the rows of --efficiency",
     .initial_text = "light"},
    {"seeds", RK_FIELD(choices, seeds), "N", "pictures for each number of samples of --efficiency",
     2, 64, 8},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture for --efficiency", 64, 16384, 2048},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->render.shadows = true;
    driver->render.light.samples = 1; /* per sample of the pixel */
    driver->render.adaptive_sampling.error = 0.01f;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "adaptive_sampling",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .studies = (rk_driver_study[]){{&c.efficiency, put_efficiency, false}, {0}},
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
