/* Draws the figures and measures the tables of parallelogram_light: hard and soft shadows, the
 * shadow rays of one pixel, the samples on the light, and how fast each method converges. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene with lights that have an extent.\n"
    "--debug rays draws the shadow rays of --pixel: unoccluded blue, occluded orange.\n"
    "--debug samples draws the samples on the light in their colours.\n"
    "--convergence puts each method's error and time into the table "
    "parallelogram_light_convergence, with --falloff physical into "
    "parallelogram_light_convergence_physical.\n"
    "--sharpness puts the error of highlights by their shininess, with and without directions of "
    "the lobe, into the table parallelogram_light_sharpness.\n"
    "--early-outs puts the error and the shadow rays of several early outs into the table "
    "parallelogram_light_early_outs.\n"
    "--growth draws a picture with 1, 2, 4 samples and so on, up to --most, and puts their errors "
    "into the table parallelogram_light_growth.";

RK_NAMES(light_names, choice of light, 1 + RK_LIGHT_PARALLELOGRAM, "own", "point", "segment",
         "parallelogram");

static const rk_option options[] = {
    {"light", RK_CHOICE(choices, light, light_names),
     "shrink the scene's parallelograms to their middle, or to a line through it",
     .of_scene = true},
    {"lights", RK_FIELD(choices, lights), "N",
     "cut the scene's only light into N strips, each with its share of the light; 0: leave it "
     "whole",
     0, RK_LIGHTS_MAX, 0, .of_scene = true},
    {"coloured", RK_FIELD(choices, coloured), NULL,
     "gives the lights' corners the colours red, green, blue and yellow", .of_scene = true},
    {"brightness", RK_FIELD(choices, brightness), "F", "multiplies the lights' colours", 0, 1e6, 1,
     .of_scene = true},
    {"lamp-x", RK_FIELD(choices, lamp_x), "X", "moves the scene's lights by X along the x axis",
     -1e3, 1e3, 0, .of_scene = true},
    {"lamp-z", RK_FIELD(choices, lamp_z), "Z", "and by Z along the z axis", -1e3, 1e3, 0,
     .of_scene = true},
    {"lamp-size", RK_FIELD(choices, lamp_size), "F", "multiplies the sides of the scene's lights",
     1e-3, 1e3, 1, .of_scene = true},
    {"convergence", RK_FIELD(choices, convergence), NULL,
     "put the error and time of each method and number of samples into a table"},
    {"sharpness", RK_FIELD(choices, sharpness), NULL,
     "put the error of highlights by shininess into a table; kd is black"},
    {"early-outs", RK_FIELD(choices, early_outs), NULL,
     "put error and shadow rays of several early outs into a table"},
    {"growth", RK_FIELD(choices, growth), NULL,
     "draw a picture with each number of samples up to --most, and put their errors into a table"},
    {"most", RK_FIELD(choices, most), "N",
     "largest number of samples in --convergence and --growth", 1, 4096, 64},
    {"reference", RK_FIELD(choices, reference), "N",
     "samples of the reference picture of these tables", 1, 16384, 2048},
    RK_CONVERGENCE_SEEDS(choices),
    {0},
};

/* --- The lights ------------------------------------------------------------------------------ */

/* A point is put in the middle of the light, a segment between the middles of two sides. */
static void shrink(rk_light *light, rk_light_kind kind)
{
    light->position = rk_madd(light->position, light->edge02, 0.5f);
    if (kind == RK_LIGHT_POINT)
        light->position = rk_madd(light->position, light->edge01, 0.5f);
    light->kind = kind;
}

static void colour(rk_light *light, const choices *c)
{
    const rk_vec3 corners[4] = {{1, 0.1f, 0.1f}, {0.1f, 1, 0.1f}, {0.2f, 0.2f, 1}, {1, 0.9f, 0.1f}};
    if (c->coloured)
        memcpy(light->colours, corners, sizeof corners);
    for (int k = 0; k < 4; k++)
        light->colours[k] = rk_scale(light->colours[k], c->brightness);
}

/* The middle moves; the sides grow or shrink about it. */
static void place(rk_light *light, const choices *c)
{
    const rk_vec3 move = {c->lamp_x, 0, c->lamp_z};
    const rk_vec3 across = rk_add(light->edge01, light->edge02);
    const float inwards = light->kind == RK_LIGHT_POINT ? 0 : 0.5f * (1 - c->lamp_size);
    light->position = rk_madd(rk_add(light->position, move), across, inwards);
    light->edge01 = rk_scale(light->edge01, c->lamp_size);
    light->edge02 = rk_scale(light->edge02, c->lamp_size);
}

/* From `begin` to `end` along the first edge, with `share` of the colours there. */
static rk_light strip_of(const rk_light *whole, float begin, float end, float share)
{
    rk_light strip = *whole;
    strip.position = rk_madd(whole->position, whole->edge01, begin);
    strip.edge01 = rk_scale(whole->edge01, end - begin);
    for (int k = 0; k < 4; k++) {
        const rk_vec3 *side = &whole->colours[k & 2];
        const rk_vec3 here = rk_mix(side[0], side[1], k & 1 ? end : begin);
        strip.colours[k] = rk_scale(here, share);
    }
    return strip;
}

/* Physical lights with an extent emit by its size; others have the same colour at any size. */
static bool cut(rk_driver *driver, const choices *c, rk_error *error)
{
    rk_scene *scene = &driver->scene;
    const rk_light whole = scene->lights[0];
    if (scene->light_count != 1 || whole.kind == RK_LIGHT_POINT)
        return rk_fail(error, "--lights cuts a light with an extent, the only one of its scene: "
                              "choose another scene, such as cornell-light");
    const bool by_size =
        driver->render.light.falloff == RK_FALLOFF_PHYSICAL && c->light != 1 + RK_LIGHT_POINT;
    const float count = (float)c->lights;
    for (uint32_t i = 0; i < c->lights; i++)
        scene->lights[i] =
            strip_of(&whole, (float)i / count, (float)(i + 1) / count, by_size ? 1 : 1 / count);
    scene->light_count = c->lights;
    return true;
}

static bool set_lights(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->light_count; i++)
        colour(&scene->lights[i], c);
    for (uint32_t i = 0; i < scene->light_count; i++)
        place(&scene->lights[i], c);
    if (c->lights && !cut(driver, c, error))
        return false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (c->light && scene->lights[i].kind == RK_LIGHT_PARALLELOGRAM)
            shrink(&scene->lights[i], (rk_light_kind)(c->light - 1));
    return true;
}

/* --- Saving ---------------------------------------------------------------------------------- */

/* Names the picture by every option of this driver that changes it. */
/* Where the renderer needs no ray, the picture has none; this says why. */
static void print_rays(const rk_driver *driver)
{
    const choices *c = driver->choices;
    const rk_pixel pixel = driver->pixel;
    if (driver->quiet || !rk_driver_debug(driver, "rays"))
        return;
    if (c->traced > 0)
        printf("pixel %u,%u: %u shadow rays, %u unoccluded: a fraction of %.3g\n", pixel.x, pixel.y,
               c->traced, c->unoccluded, (double)c->unoccluded / c->traced);
    else
        printf("pixel %u,%u: no shadow rays: it faces away from the light, or nothing is between "
               "them; --light-visibility rays traces them there, too\n",
               pixel.x, pixel.y);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_light_options *light = &driver->render.light;
    char label[160], pixel[32] = "", lights[32] = "";
    if (c->lights)
        snprintf(lights, sizeof lights, "lights%u_", c->lights);
    if (driver->debug)
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    snprintf(label, sizeof label, "%s%s%s%s%s%s%u_%s%s%s%s%s%s%s",
             driver->debug ? driver->debug : "", driver->debug ? "_" : "",
             c->light ? light_names.items[c->light] : "", c->light ? "_" : "", lights,
             c->coloured ? "coloured_" : "", light->samples, rk_sampler_name(light->sampling),
             light->domain == RK_LIGHT_DOMAIN_SOLID_ANGLE ? "_solid-angle" : "",
             light->falloff == RK_FALLOFF_PHYSICAL ? "_physical" : "", light->ratio ? "_ratio" : "",
             light->highlights == RK_HIGHLIGHT_LIGHT ? "_by-light" : "",
             light->visibility == RK_LIGHT_RAYS ? "_rays" : "", pixel);
    if (!rk_driver_save(driver, label, error))
        return false;
    print_rays(driver);
    return true;
}

/* The render, with samples and shadow rays per pixel; under names of its own for each way to decide
 * which rays are traced. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_light_options *light = &driver->render.light;
    const char *way = light->visibility == RK_LIGHT_PYRAMIDS ? "_pyramids"
                      : light->early_out == 0                ? "_all_traced"
                                                             : "_early_out";
    const double pixels = (double)driver->counters.primary_rays;
    char render[32], samples[32], rays[32];
    snprintf(render, sizeof render, "render%s", way);
    snprintf(samples, sizeof samples, "light_samples%s", way);
    snprintf(rays, sizeof rays, "shadow_rays%s", way);
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, samples, "1",
                         rk_timing_once((double)driver->counters.light_samples / pixels), error) &&
           rk_driver_row(driver, rays, "1",
                         rk_timing_once((double)driver->counters.shadow_rays / pixels), error);
}

/* --- Main ------------------------------------------------------------------------------------ */

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "cornell-light";
    driver->drawn_x = 86; /* in the Cornell box, a point of the floor that sees part of the lamp */
    driver->drawn_y = 88;
    driver->render.shadows = true;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "parallelogram_light",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"rays", draw_view, false}, {"samples", draw_view, false}, {0}},
        .studies = (rk_driver_study[]){{&c.convergence, put_study, false},
                                       {&c.sharpness, put_sharpness, false},
                                       {&c.early_outs, put_early_outs, false},
                                       {&c.growth, put_growth, false},
                                       {0}},
        .prepare = set_lights,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
