/* Draws the figures and measures the tables of sampling: points in two of their dimensions, errors
 * of a picture, and how fast they fall with each kind of samples. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with the same kind of samples for all effects (--kind).\n"
    "--debug points draws points in two of their dimensions, --debug order pixels in Z order.\n"
    "--debug error shows the error of a picture with --samples N, four times as large: grey is 0.\n"
    "--convergence writes tables: the error of each kind of samples, and how fast it falls;\n"
    "--blurred the error of few samples after a blur, --spectrum its power by frequency;\n"
    "--pairs how well points are distributed in each pair of dimensions.";

RK_NAMES(effect_names, effect, EFFECT_AMBIENT, "pixel", "lens", "light", "mirror", "penumbra",
         "ambient");
RK_NAMES(point_kind_names, point_kind, POINTS_SAMPLES, "sequence", "directions", "owen", "samples");

static const rk_option options[] = {
    {"kind", RK_CHOICE(choices, kind, rk_sampler_names), "distribution of all samples",
     .initial = RK_SAMPLER_SOBOL},
    {"effect", RK_CHOICE(choices, effect, effect_names),
     "what is sampled together with the position in the pixel; penumbra and ambient: the light, "
     "and "
     "ambient light, from its centre"},
    {"points-of", RK_CHOICE(choices, of, point_kind_names),
     "which points --debug points draws: of the sequence by the table or by rk_sobol_directions, "
     "scrambled by rk_owen_scramble, or the samples of --pixel",
     .initial = POINTS_SAMPLES},
    {"points", RK_FIELD(choices, points), "N", "number of points", 1, 65536, 64},
    {"x", RK_FIELD(choices, x), "D", "the joint dimension along x", 0, RK_SOBOL_DIMENSIONS - 1, 0},
    {"y", RK_FIELD(choices, y), "D", "and along y", 0, RK_SOBOL_DIMENSIONS - 1, 1},
    {"permuted", RK_FIELD(choices, permuted), NULL, "--debug order shows permuted digits"},
    {"blur", RK_FIELD(choices, blur), "S",
     "blur --debug error by a Gaussian filter of this standard deviation, pixels", 0, 16, 0},
    {"gain", RK_FIELD(choices, gain), "G", "--debug error shows errors so many times as large", 0,
     1000, 4},
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "write tables: error of each kind and number of samples, and slopes"},
    {"blurred", RK_FIELD(choices, blurred), NULL,
     "write a table: errors of few samples, in single pixels and after a blur"},
    {"spectrum", RK_FIELD(choices, spectrum), NULL,
     "write a table: the power of the error by frequency"},
    {"pairs", RK_FIELD(choices, pairs), NULL,
     "write a table: the share of squares without any of --points, by pair of dimensions"},
    {"most", RK_FIELD(choices, most), "N", "largest number of samples for --convergence", 8, 4096,
     128},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture for the tables and --debug error", 1, 65536, 2048},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

void set_samples(rk_driver *driver, rk_sampler_kind kind, uint32_t samples)
{
    const choices *c = driver->choices;
    rk_render_options *o = &driver->render;
    const bool from_centre = c->effect >= EFFECT_PENUMBRA;
    o->sampling = o->lens_sampling = o->light.sampling = o->glossy.sampling = kind;
    o->ambient_occlusion.sampling = kind;
    o->ambient_occlusion.intensity = c->effect == EFFECT_AMBIENT ? 1 : 0;
    o->samples = from_centre ? 1 : samples;
    o->lens_samples = c->effect == EFFECT_LENS ? samples : 0;
    o->light.samples = o->ambient_occlusion.samples = from_centre ? samples : 1;
    o->glossy.samples = c->effect == EFFECT_MIRROR;
    o->reflections = c->effect == EFFECT_MIRROR;
    o->shadows = c->effect != EFFECT_PIXEL;
}

static bool choose(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    const bool is_scene = !driver->debug || rk_driver_debug(driver, "error");
    if (!is_scene && driver->pixel.given)
        return rk_fail(error,
                       "--debug %s shows no scene, so there is no pixel to explain: leave it or "
                       "--pixel out",
                       driver->debug);
    c->samples = driver->render.samples;
    set_samples(driver, c->kind, c->samples);
    return true;
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    char label[160], blur[32] = "";
    if (rk_driver_debug(driver, "error") && c->blur > 0)
        snprintf(blur, sizeof blur, "_blurred_%g", (double)c->blur);
    if (rk_driver_debug(driver, "points"))
        snprintf(label, sizeof label, "points_%s%s_%u_of_%u_and_%u",
                 c->of == POINTS_SAMPLES ? rk_sampler_name(c->kind) : "",
                 point_kind_names.items[c->of], c->points, c->x, c->y);
    else if (rk_driver_debug(driver, "order"))
        snprintf(label, sizeof label, "order%s", c->permuted ? "_permuted" : "");
    else
        snprintf(label, sizeof label, "%s%s_%s_%u%s", driver->debug ? "error_" : "",
                 effect_names.items[c->effect], rk_sampler_name(c->kind), c->samples, blur);
    return rk_driver_save(driver, label, error);
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    char render[64], rays[64];
    const choices *c = driver->choices;
    const double pixels = (double)driver->render.width * driver->render.height;
    snprintf(render, sizeof render, "render_%s", rk_sampler_name(c->kind));
    snprintf(rays, sizeof rays, "rays_%s", rk_sampler_name(c->kind));
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, rays, "1",
                         rk_timing_once((double)rk_counters_rays(&driver->counters) / pixels),
                         error);
}

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "cornell-light";
    driver->render.samples = 16;
    driver->render.lens.focal_distance = 2.5f;
    driver->render.lens.aperture = 150;
    driver->render.glossy.radius = 0.1f;
    driver->render.light.early_out = 0;
    driver->render.light.visibility = RK_LIGHT_RAYS; /* of all samples: they are compared */
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "sampling",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"points", draw_points, true},
                                    {"order", draw_order, true},
                                    {"error", draw_error, false},
                                    {0}},
        .studies = (rk_driver_study[]){{&c.convergence, put_convergence, false},
                                       {&c.blurred, put_blurred, false},
                                       {&c.spectrum, put_spectrum, false},
                                       {&c.pairs, put_pairs, true},
                                       {0}},
        .choose = choose,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
