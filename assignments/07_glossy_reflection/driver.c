/* Draws the figures and measures the tables of glossy_reflection: rough mirrors with few and many
 * samples, the rays of one pixel, their points in the disk, and the effect of the weights where
 * directions lead into the surface. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with rough mirrors (--glossy samples in a disk of --glossy-radius).\n"
    "--debug rays shows the reflected rays of --pixel from beside the camera.\n"
    "--debug dots shows the samples in the disk; with --pixel, discarded ones are grey.\n"
    "--convergence puts the error and time of each map and sampler into a table.\n"
    "--policies puts the light that remains with each kind of weights into a table.";

/* Remembers --pixel, which drawing resets. */
static bool choose(rk_driver *driver, rk_error *error)
{
    (void)error;
    choices *c = driver->choices;
    c->of_pixel = rk_driver_debug(driver, "rays") || driver->pixel.given;
    return true;
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_glossy_options *glossy = &driver->render.glossy;
    char label[128], pixel[32] = "", radius[32] = "";
    if (driver->debug && c->of_pixel)
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    if (glossy->radius >= 0)
        snprintf(radius, sizeof radius, "_radius%g", (double)glossy->radius);
    snprintf(label, sizeof label, "%s%s%u_%s_%s%s%s%s", driver->debug ? driver->debug : "",
             driver->debug ? "_" : "", glossy->samples, rk_disk_map_names.items[glossy->map],
             rk_sampler_name(glossy->sampling), radius,
             glossy->weights == RK_GLOSSY_CLASSIC ? "_classic" : "", pixel);
    return rk_driver_save(driver, label, error);
}

/* With the number of samples in their names. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    double rays = (double)driver->counters.reflected_rays / (double)driver->counters.primary_rays;
    char render[32], reflected[32];
    snprintf(render, sizeof render, "render_%u", driver->render.glossy.samples);
    snprintf(reflected, sizeof reflected, "reflected_rays_%u", driver->render.glossy.samples);
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, reflected, "1", rk_timing_once(rays), error);
}

static const rk_option options[] = {
    RK_SIDE_VIEW_OPTIONS(choices, viewer),
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "put the error and time of each map, sampler and number of samples into a table"},
    {"policies", RK_FIELD(choices, policies), NULL,
     "put the light of grazing reflections with each kind of weights into a table"},
    {"most", RK_FIELD(choices, most), "N", "largest number of samples in --convergence", 1, 4096,
     256},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture of --convergence", 1, 16384, 4096},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->drawn_x = 36; /* the mirror of the Cornell box */
    driver->drawn_y = 56;
    driver->render.reflections = true;
    driver->render.glossy.samples = 64;
    driver->render.glossy.radius = 0.1f; /* the box's own mirror is too shiny to look rough */
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "glossy_reflection",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"rays", draw_rays, false}, {"dots", draw_dots, false}, {0}},
        .studies = (rk_driver_study[]){{&c.convergence, put_convergence, false},
                                       {&c.policies, put_policies, false},
                                       {0}},
        .choose = choose,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
