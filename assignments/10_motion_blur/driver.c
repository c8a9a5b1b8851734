/* Draws the figures and measures the tables of motion blur: a scene on the move, one of its times,
 * the path with the boxes that are swept, and the error against the number of samples. */
#include "render/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene while it moves, by --time-samples rays a pixel; a mesh moves as a whole.\n"
    "--isolate K shows one of the times, also before the first or behind the last.\n"
    "--debug path draws the path, each of the times on it, and what is swept.\n"
    "--convergence puts errors against many more samples into a table.";

static const char *const sampling_names[] = {"equidistant", "stratified", "low-discrepancy"};
enum { sampling_count = sizeof sampling_names / sizeof sampling_names[0] };

typedef struct choices {
    uint32_t reference; /* samples of what --convergence compares with */
    bool convergence, still;
} choices;

static bool check(const rk_driver *driver, const choices *c, rk_error *error)
{
    if (c->still && driver->debug)
        return rk_fail(error, "--debug path draws how things move, and with --still nothing does: "
                              "choose one of them");
    if (c->still && c->convergence)
        return rk_fail(error, "--convergence measures blur, and with --still there is none: choose "
                              "one of them");
    return true;
}

/* --- The path --------------------------------------------------------------------------------- */

static float isolated_or(const rk_motion_options *motion, float x)
{
    return isnan(motion->isolate)
               ? x
               : rk_shutter_equidistant(&motion->shutter, motion->isolate, motion->samples);
}

static void draw_path(rk_overlay *overlay, const rk_motion_options *motion, const rk_box *rest,
                      const rk_motion *path)
{
    const rk_vec3 orange = rk_vec(1, 0.55f, 0.1f), blue = rk_vec(0.3f, 0.6f, 1);
    const rk_vec3 white = rk_vec(1, 1, 1);
    rk_vec3 centre = rk_scale(rk_add(rest->corner[0], rest->corner[1]), 0.5f);
    float open = motion->shutter.open, close = motion->shutter.close;
    float from = rk_min(open, isolated_or(motion, open));
    float to = rk_max(close, isolated_or(motion, close));
    const int steps = 200;
    rk_vec3 last = rk_add(centre, rk_motion_offset(path, from));
    for (int i = 1; i <= steps; i++) {
        float x = from + (to - from) * ((float)i / (float)steps);
        rk_vec3 next = rk_add(centre, rk_motion_offset(path, x));
        rk_overlay_line(overlay, last, next, x <= close && x > open ? orange : white, 2);
        last = next;
    }
    rk_box swept = rk_motion_sweep(path, &motion->shutter, rest);
    rk_overlay_wireframe(overlay, &swept, orange, 2.5f);
    for (uint32_t k = 1; k <= motion->samples && motion->samples <= 100; k++) {
        float x = rk_shutter_equidistant(&motion->shutter, (float)k, motion->samples);
        rk_overlay_point(overlay, rk_add(centre, rk_motion_offset(path, x)), orange, 3.5f);
    }
    if (isnan(motion->isolate))
        return;
    const rk_shutter then = {isolated_or(motion, 0), isolated_or(motion, 0)};
    swept = rk_motion_sweep(path, &then, rest);
    rk_overlay_wireframe(overlay, &swept, blue, 2.5f);
    rk_overlay_point(overlay, rk_add(centre, rk_motion_offset(path, then.open)), blue, 6);
}

/* Nothing hides the path: most of it is inside of what moves. */
static bool draw_paths(rk_driver *driver, rk_error *error)
{
    rk_overlay overlay;
    if (!rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++) {
        overlay.depth[i] = INFINITY;
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.6f);
    }
    for (uint32_t i = 0; i < driver->scene.moving_count; i++)
        draw_path(&overlay, &driver->render.motion, &driver->accel.moving[i].nodes[0].box,
                  &driver->scene.moving[i].motion);
    rk_overlay_free(&overlay);
    return true;
}

/* --- Tables ----------------------------------------------------------------------------------- */

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_motion_options *motion = &driver->render.motion;
    char metric[64], share[64];
    bool blurred = driver->scene.moving_count > 0 && motion->samples > 0;
    snprintf(metric, sizeof metric, blurred ? "render_%s_%u" : "render_still",
             sampling_names[motion->sampling], motion->samples);
    snprintf(share, sizeof share, blurred ? "times_per_pixel_%u" : "times_per_pixel_still",
             motion->samples);
    double pixels = (double)driver->render.width * (double)driver->render.height;
    return rk_driver_row(driver, metric, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, share, "1",
                         rk_timing_once((double)driver->counters.time_samples / pixels), error);
}

static bool put_errors(rk_driver *driver, const rk_image *truth, const char *name, rk_error *error)
{
    for (int sampling = 0; sampling < sampling_count; sampling++)
        for (uint32_t samples = 1; samples <= 256; samples *= 2) {
            driver->render.motion.sampling = (rk_time_sampling)sampling;
            driver->render.motion.samples = samples;
            if (!rk_convergence_row_of(driver, "motion_blur_convergence", sampling_names[sampling],
                                       samples, truth, name, error))
                return false;
        }
    return true;
}

/* The truth: equidistant times, so many that their error is far below the others'. */
static bool put_convergence(rk_driver *driver, const choices *c, rk_error *error)
{
    char name[64];
    snprintf(name, sizeof name, "%u equidistant times", c->reference);
    driver->render.motion.sampling = RK_TIME_EQUIDISTANT;
    driver->render.motion.samples = c->reference;
    rk_image truth = {0};
    bool ok =
        rk_convergence_reference(driver, &truth, error) && put_errors(driver, &truth, name, error);
    rk_image_free(&truth);
    return ok;
}

/* --- The driver ------------------------------------------------------------------------------- */

static bool save(rk_driver *driver, rk_error *error)
{
    const rk_motion_options *motion = &driver->render.motion;
    char label[96];
    if (driver->scene.moving_count == 0)
        snprintf(label, sizeof label, "still");
    else if (!isnan(motion->isolate))
        snprintf(label, sizeof label, "%s%g_of_%u", driver->debug ? "path_" : "isolated_",
                 (double)motion->isolate, motion->samples);
    else
        snprintf(label, sizeof label, "%s%s_%u", driver->debug ? "path_" : "",
                 sampling_names[motion->sampling], motion->samples);
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c = {.reference = 2048};
    rk_driver driver = rk_driver_default("motion_blur", summary);
    const rk_option options[] = {
        {"path-a", RK_OPTION_FLOAT, &driver.motion.a, "A",
         "a mesh moves to (x, A x^3 + B x^2 + C x, 0)", -1e3, 1e3},
        {"path-b", RK_OPTION_FLOAT, &driver.motion.b, "B", "of that path", -1e3, 1e3},
        {"path-c", RK_OPTION_FLOAT, &driver.motion.c, "C", "of that path", -1e3, 1e3},
        {"still", RK_OPTION_FLAG, &c.still, NULL, "nothing moves, to compare with", 0, 0},
        {"convergence", RK_OPTION_FLAG, &c.convergence, NULL,
         "put errors into DIR/tables/motion_blur_convergence.csv instead of drawing", 0, 0},
        {"reference", RK_OPTION_UINT, &c.reference, "N", "samples that errors are measured against",
         1, 65536},
        {0},
    };
    const char *const views[] = {"path", NULL};
    driver.scene_name = "moving";
    driver.move = true;
    driver.render.motion.samples = 20;
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = check(&driver, &c, &error);
    if (c.still)
        driver.scene.moving_count = 0;
    ok = ok && rk_driver_build(&driver, &error);
    if (ok && c.convergence)
        return rk_driver_finish(&driver, put_convergence(&driver, &c, &error), &error);
    ok = ok && rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        return rk_driver_finish(&driver, put_rows(&driver, &error), &error);
    if (ok && driver.debug)
        ok = draw_paths(&driver, &error);
    return rk_driver_finish(&driver, ok && save(&driver, &error), &error);
}
