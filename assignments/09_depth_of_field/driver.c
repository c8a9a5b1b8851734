/* Draws the figures and measures the tables of depth of field: a scene through a lens, its focal
 * surface and rays, seen from the side, and errors against the closed form. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene through a lens (--focal-distance, --aperture, --lens-samples).\n"
    "--debug focus shows the focal surface, --debug rays the lens rays of --pixel, both from the "
    "side.\n"
    "--debug blurred marks the pixels that take lens samples.\n"
    "--convergence puts the errors of a blurred edge into a table.\n"
    "--circles puts the circles of confusion by distance, and those of the picture's middle "
    "column, "
    "into the tables depth_of_field_circles and depth_of_field_column.";

static bool choose(rk_driver *driver, rk_error *error)
{
    if (rk_driver_debug(driver, "focus") && driver->pixel.given)
        return rk_fail(error, "--debug focus shows no pixel: --pixel goes without --debug, or with "
                              "--debug rays or blurred");
    if (driver->debug && (driver->render.lens_samples == 0 || !(driver->render.lens.aperture > 0)))
        return rk_fail(error, "--debug %s goes with a lens: --lens-samples and --aperture above 0",
                       driver->debug);
    return true;
}

/* A pixel in focus has rays through the middle of the lens alone. */
static void print_rays(const rk_driver *driver)
{
    const choices *c = driver->choices;
    if (driver->quiet || !rk_driver_debug(driver, "rays"))
        return;
    printf("pixel %u,%u: %u camera ray%s%s\n", driver->pixel.x, driver->pixel.y, c->rays,
           c->rays == 1 ? "" : "s",
           c->rays == driver->render.samples
               ? ": it is in focus, and takes none of the lens samples drawn"
               : "");
}

static bool save(rk_driver *driver, rk_error *error)
{
    const rk_render_options *o = &driver->render;
    char label[128] = "pinhole", pixel[32] = "";
    if (rk_driver_debug(driver, "rays"))
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    if (o->lens_samples > 0)
        snprintf(label, sizeof label, "%s%s%s_%g_%g_%u%s", driver->debug ? driver->debug : "",
                 driver->debug ? "_" : "", rk_focal_surface_names.items[o->lens.focal],
                 (double)o->lens.focal_distance, (double)o->lens.aperture, o->lens_samples, pixel);
    if (!rk_driver_save(driver, label, error))
        return false;
    print_rays(driver);
    return true;
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_render_options *o = &driver->render;
    double pixels = (double)o->width * o->height;
    char metric[64] = "render_pinhole";
    if (o->lens_samples > 0)
        snprintf(metric, sizeof metric, "render_%g_%g", (double)o->lens.focal_distance,
                 (double)o->lens.aperture);
    if (!rk_driver_row(driver, metric, "ms", driver->render_ms, error))
        return false;
    if (o->lens_samples == 0)
        return true;
    snprintf(metric, sizeof metric, "blurred_%g_%g", (double)o->lens.focal_distance,
             (double)o->lens.aperture);
    double blurred = (double)driver->counters.lens_samples /
                     (o->lens_samples > o->samples ? o->lens_samples : o->samples);
    return rk_driver_row(driver, metric, "%", rk_timing_once(100 * blurred / pixels), error);
}

static const rk_option options[] = {
    {"viewer-yaw", RK_FIELD(choices, viewer_yaw), "DEG",
     "turn of the camera about y for the view from the side, degrees", -360, 360, 75},
    {"viewer-pitch", RK_FIELD(choices, viewer_pitch), "DEG", "its turn about x, degrees", -360, 360,
     -5},
    {"viewer-far", RK_FIELD(choices, viewer_far), "F",
     "its distance, in multiples of the camera's own", 0.01, 100, 1.8},
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "put errors into DIR/tables/depth_of_field_convergence.csv instead of drawing a picture"},
    {"circles", RK_FIELD(choices, circles), NULL,
     "put circles of confusion by distance into tables instead of drawing a picture"},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "statue:87130";
    driver->render.lens_samples = 15;
}

int main(int argc, char **argv)
{
    static const rk_driver_view views[] = {
        {"focus", draw_from_the_side, false},
        {"rays", draw_from_the_side, false},
        {"blurred", draw_blurred, false},
        {0},
    };
    choices c;
    const rk_driver_spec spec = {
        .feature = "depth_of_field",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = views,
        .studies = (rk_driver_study[]){{&c.convergence, put_study, true},
                                       {&c.circles, put_circles, false},
                                       {0}},
        .choose = choose,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
