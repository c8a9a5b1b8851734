/* Draws the figures and measures the tables of ambient_occlusion: ambient light with both maps and
 * all samplers, the ambient visibility A alone, the rays of one pixel, and errors against closed
 * forms. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with light from all directions (--ambient), darker where it is occluded.\n"
    "--debug visibility shows the unoccluded fraction of that light, on white surfaces.\n"
    "--debug rays shows the rays of --pixel from beside the camera: unoccluded blue, "
    "occluded orange.\n"
    "--convergence writes a table: error of each map and sampler against samples and time.\n"
    "--closed-forms writes a table: estimates below a disk, a sphere and beside a wall.\n"
    "--on-floor puts an exact sphere on an endless floor: the visibility is known exactly in every "
    "pixel.";

static bool prepare(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return !c->on_floor || put_on_floor(driver, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_ambient_occlusion_options *ambient = &driver->render.ambient_occlusion;
    char label[160], distance[32] = "", pixel[32] = "";
    if (rk_driver_debug(driver, "rays"))
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    if (ambient->distance < 1000)
        snprintf(distance, sizeof distance, "_within%g", (double)ambient->distance);
    snprintf(label, sizeof label, "%s%s%g_%u_%s_%s%s%s", driver->debug ? driver->debug : "",
             driver->debug ? "_" : "", (double)ambient->intensity, ambient->samples,
             rk_ambient_map_names.items[ambient->map], rk_sampler_name(ambient->sampling), distance,
             pixel);
    if (!rk_driver_save(driver, label, error))
        return false;
    if (rk_driver_debug(driver, "rays") && !driver->quiet)
        printf("pixel %u,%u: %u ambient rays, %u unoccluded\n", driver->pixel.x, driver->pixel.y,
               c->traced, c->unoccluded);
    return true;
}

/* The number of samples is part of the metrics' names. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_ambient_occlusion_options *ambient = &driver->render.ambient_occlusion;
    uint32_t samples = ambient->intensity > 0 ? ambient->samples : 0;
    double rays = (double)driver->counters.shadow_rays / (double)driver->counters.primary_rays;
    char render[32], shadow[32];
    snprintf(render, sizeof render, "render_%u", samples);
    snprintf(shadow, sizeof shadow, "shadow_rays_%u", samples);
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, shadow, "1", rk_timing_once(rays), error);
}

static const rk_option options[] = {
    RK_SIDE_VIEW_OPTIONS(choices, viewer),
    {"on-floor", RK_FIELD(choices, on_floor), NULL,
     "instead of the scene, an exact sphere on an endless floor, seen from above",
     .of_scene = true},
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "write a table: error and time of each map, sampler and number of samples; with "
     "--on-floor the error against the closed form"},
    {"closed-forms", RK_FIELD(choices, closed_forms), NULL,
     "write a table: closed forms and estimates by both maps"},
    {"most", RK_FIELD(choices, most), "N", "largest number of samples for --convergence", 1, 4096,
     256},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture for --convergence", 1, 16384, 4096},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

static void set_defaults(rk_driver *driver)
{
    choices *c = driver->choices;
    c->viewer.yaw = 20; /* past the green wall */
    c->viewer.pitch = 25;
    driver->drawn_x = 45; /* the floor of the Cornell box, in front of the blocks */
    driver->drawn_y = 86;
    driver->render.shadows = true;
    driver->render.ambient_occlusion.intensity = 0.5f;
    driver->render.ambient_occlusion.samples = 64;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "ambient_occlusion",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"visibility", draw_visibility, false},
                                    {"rays", draw_rays, false},
                                    {0}},
        .studies = (rk_driver_study[]){{&c.convergence, put_convergence, false},
                                       {&c.closed_forms, put_closed_forms, true},
                                       {0}},
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
