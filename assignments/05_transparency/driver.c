/* Draws the figures and measures the tables of transparency: a scene with glass, the path of one
 * pixel's ray through it, and the light through a few surfaces by the three models of shadows. */
#include "driver.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with glass (--transparency; --shadows are coloured by --glass).\n"
    "--debug rays shows the path of the ray of --pixel from beside the camera.\n"
    "--models puts the light through a few panes and blocks into a table.";

static void set_material(rk_material *material, const choices *c)
{
    if (!isnan(c->alpha))
        material->alpha = c->alpha;
    if (!isnan(c->absorption)) /* the colour's complement is absorbed */
        material->absorption = rk_scale(rk_sub(rk_vec(1, 1, 1), material->kd), c->absorption);
}

static bool choose(rk_driver *driver, rk_error *error)
{
    if (rk_driver_debug(driver, "rays") && !driver->render.transparency)
        return rk_fail(error,
                       "--debug rays goes with --transparency: without it no ray passes a surface");
    return true;
}

static bool prepare(rk_driver *driver, rk_error *error)
{
    (void)error;
    const choices *c = driver->choices;
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], c);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], c);
    return true;
}

static const char *model_name(const rk_driver *driver)
{
    const rk_render_options *options = &driver->render;
    return options->transparency ? rk_glass_model_names.items[options->glass] : "opaque";
}

/* Crossings of all camera rays, counted without a max depth. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    char metric[32];
    snprintf(metric, sizeof metric, "render_%s", model_name(driver));
    rk_view view = rk_view_of(&driver->scene.camera, driver->render.width, driver->render.height);
    double sum = 0, most = 0;
    rk_counters counters = {0};
    for (uint32_t y = 0; y < driver->render.height; y++)
        for (uint32_t x = 0; x < driver->render.width; x++) {
            rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
            rk_crossing_list list;
            rk_crossings_gather(&driver->accel, &ray, RK_CROSSINGS_MAX, &list, &counters);
            sum += list.count;
            most = list.count > most ? list.count : most;
        }
    double rays = (double)driver->render.width * (double)driver->render.height;
    return rk_driver_row(driver, metric, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, "crossings_per_ray", "1", rk_timing_once(sum / rays), error) &&
           rk_driver_row(driver, "most_crossings", "1", rk_timing_once(most), error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const char *model = model_name(driver);
    char label[64];
    if (driver->debug)
        snprintf(label, sizeof label, "rays_%s_%u_%u", model, driver->pixel.x, driver->pixel.y);
    else if (driver->render.max_depth != rk_render_options_default().max_depth)
        snprintf(label, sizeof label, "%s_depth%u", model, driver->render.max_depth);
    else
        snprintf(label, sizeof label, "%s", model);
    if (!rk_driver_save(driver, label, error))
        return false;
    if (driver->debug && !driver->quiet)
        printf("pixel %u,%u: %u crossings, %u shadow rays, %u unoccluded\n", driver->pixel.x,
               driver->pixel.y, c->crossed, c->traced, c->unoccluded);
    return true;
}

static const rk_option options[] = {
    {"alpha", RK_FIELD(choices, alpha), "A",
     "opacity of all materials, 1 is opaque; by default their own", 0, 1, NAN, .of_scene = true},
    {"absorption", RK_FIELD(choices, absorption), "S",
     "absorption of all materials: white minus their colour, times S per world unit; by default "
     "their own",
     0, 1e6, NAN},
    RK_SIDE_VIEW_OPTIONS(choices, viewer),
    {"models", RK_FIELD(choices, models), NULL,
     "put the light by each model into DIR/tables/transparency_models.csv instead of drawing",
     .of_scene = true},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "panes";
    driver->drawn_x = 65; /* through all of the panes */
    driver->drawn_y = 58;
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "transparency",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"rays", draw_view, false}, {0}},
        .studies = (rk_driver_study[]){{&c.models, put_study, true}, {0}},
        .choose = choose,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
