/* Draws the figures and measures the tables of motion blur: a moving scene, one of its times, the
 * path with the swept boxes, and the error by the number of samples. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a moving scene with --time-samples rays per pixel; a mesh moves as a whole.\n"
    "--single-time K shows one of the times, also before the first or after the last.\n"
    "--debug path draws the path, equidistant times on it, and the swept box.\n"
    "--convergence puts errors against many more samples into a table.\n"
    "--positions puts where each object is by time, and while the shutter is open, into the tables "
    "motion_blur_path and motion_blur_shutter.";

static bool choose(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    if (c->still && driver->debug)
        return rk_fail(error,
                       "--debug path draws paths, and with --still nothing moves: choose one "
                       "of them");
    if (c->still && c->positions)
        return rk_fail(error, "--positions lists paths, and with --still nothing moves: choose one "
                              "of them");
    if (c->still && c->convergence)
        return rk_fail(error, "--convergence measures blur, and with --still there is none: choose "
                              "one of them");
    return true;
}

static bool prepare(rk_driver *driver, rk_error *error)
{
    (void)error;
    const choices *c = driver->choices;
    if (c->still)
        driver->scene.moving_count = 0;
    return true;
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_motion_options *motion = &driver->render.motion;
    char metric[64], times[64], rays[64];
    bool blurred = driver->scene.moving_count > 0 && motion->samples > 0;
    snprintf(metric, sizeof metric, blurred ? "render_%s_%u" : "render_still",
             rk_time_sampling_names.items[motion->sampling], motion->samples);
    snprintf(times, sizeof times, blurred ? "times_per_pixel_%u" : "times_per_pixel_still",
             motion->samples);
    snprintf(rays, sizeof rays, blurred ? "rays_per_pixel_%u" : "rays_per_pixel_still",
             motion->samples);
    double pixels = (double)driver->render.width * (double)driver->render.height;
    double traced = (double)rk_counters_rays(&driver->counters);
    return rk_driver_row(driver, metric, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, rays, "1", rk_timing_once(traced / pixels), error) &&
           rk_driver_row(driver, times, "1",
                         rk_timing_once((double)driver->counters.time_samples / pixels), error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const rk_motion_options *motion = &driver->render.motion;
    const rk_shutter usual = rk_render_options_default().motion.shutter,
                     *shutter = &motion->shutter;
    char label[128], open[32] = "";
    if (shutter->open != usual.open || shutter->close != usual.close)
        snprintf(open, sizeof open, "_%g_to_%g", (double)shutter->open, (double)shutter->close);
    if (driver->scene.moving_count == 0)
        snprintf(label, sizeof label, "still");
    else if (!isnan(motion->single_time))
        snprintf(label, sizeof label, "%s%g_of_%u%s", driver->debug ? "path_" : "single_",
                 (double)motion->single_time, motion->samples, open);
    else
        snprintf(label, sizeof label, "%s%s_%u%s", driver->debug ? "path_" : "",
                 rk_time_sampling_names.items[motion->sampling], motion->samples, open);
    return rk_driver_save(driver, label, error);
}

static const rk_option driver_options[] = {
    {"path-a", RK_FIELD(rk_driver, motion.a), "A", "a mesh moves to (x, A x^3 + B x^2 + C x, 0)",
     -1e3, 1e3, .of_scene = true},
    {"path-b", RK_FIELD(rk_driver, motion.b), "B", "of this path", -1e3, 1e3, .of_scene = true},
    {"path-c", RK_FIELD(rk_driver, motion.c), "C", "of this path", -1e3, 1e3, .of_scene = true},
    {0},
};

static const rk_option options[] = {
    {"still", RK_FIELD(choices, still), NULL, "keeps everything at rest, for comparison",
     .of_scene = true},
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "put errors into DIR/tables/motion_blur_convergence.csv instead of drawing"},
    {"positions", RK_FIELD(choices, positions), NULL,
     "put the positions of moving objects by time into tables instead of drawing"},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture of --convergence", 1, 65536, 2048},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "moving";
    driver->move = true;
    driver->render.motion.samples = 20;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "motion_blur",
        .summary = summary,
        .options = options,
        .choices = &c,
        .driver_options = driver_options,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"path", draw_view, false}, {0}},
        .studies = (rk_driver_study[]){{&c.convergence, put_study, false},
                                       {&c.positions, put_positions, true},
                                       {0}},
        .choose = choose,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
