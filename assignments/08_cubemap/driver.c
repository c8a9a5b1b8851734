/* Draws the figures and measures the tables of cubemap: a scene in its environment, the map as a
 * cross, marked faces, the filters close up at a corner of the cube, and their errors. */
#include "driver.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene in an environment (--environment), seen in mirrors and where rays miss.\n"
    "--marked uses a map with a letter on each face.\n"
    "--debug cross draws the map unfolded.\n"
    "--debug seam draws a map of random colours around a corner of three faces.\n"
    "--filters puts the filters' errors and steps into a table.";

static void set_material(rk_material *material, float mirror)
{
    material->ks = rk_vec(mirror, mirror, mirror);
    material->kd = rk_scale(material->kd, 1 - mirror);
}

static void set_materials(rk_scene *scene, float mirror)
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], mirror);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], mirror);
}

static bool choose(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    bool seam = rk_driver_debug(driver, "seam"), is_sky = strcmp(driver->environment, "sky") == 0;
    if (c->side && !is_sky && !seam && !c->marked)
        return rk_fail(error, "--side: a file has its own size; this goes with --environment sky, "
                              "--marked and --debug seam");
    if (driver->debug && driver->pixel.given)
        return rk_fail(error,
                       "--debug %s shows the map and not the scene, so there is no pixel to "
                       "explain: leave it or --pixel out",
                       driver->debug);
    return true;
}

static bool prepare(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    if (!isnan(c->mirror))
        set_materials(&driver->scene, c->mirror);
    return paint_environment(driver, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    char label[320];
    const char *file = driver->environment, *slash = strrchr(file, '/');
    const char *filter = rk_cubemap_filter_names.items[driver->render.environment_filter];
    bool is_sky = strcmp(file, "sky") == 0;
    if (driver->debug)
        snprintf(label, sizeof label, "%s_%s", driver->debug, filter);
    else
        snprintf(label, sizeof label, "%s%s%s%s%.200s", c->marked ? "marked_" : "",
                 isnan(c->mirror) ? "" : "mirror_", filter, is_sky ? "" : "_",
                 is_sky  ? ""
                 : slash ? slash + 1
                         : file);
    return rk_driver_save(driver, label, error);
}

static const rk_option options[] = {
    {"mirror", RK_FIELD(choices, mirror), "K",
     "specular colour of all materials, a grey; their diffuse colour is scaled by 1 - K; by "
     "default their own",
     0, 1, NAN, .of_scene = true},
    {"side", RK_FIELD(choices, side), "N",
     "texels per side of the built-in sky, --marked or --debug seam; 0: 256, and 8 for --debug "
     "seam",
     0, RK_CUBEMAP_SIDE_MAX, 0, .of_scene = true},
    {"marked", RK_FIELD(choices, marked), NULL,
     "use an environment of six colours, with an upright letter F on each face", .of_scene = true},
    {"filters", RK_FIELD(choices, filters), NULL,
     "put errors and steps at edges, by the map's size, into DIR/tables/cubemap_filters.csv "
     "instead of drawing"},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "statue";
    driver->environment = "sky";
    driver->render.reflections = true; /* without them mirrors are black */
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "cubemap",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"cross", draw_cross, true}, {"seam", draw_seam, true}, {0}},
        .studies = (rk_driver_study[]){{&c.filters, put_study, true}, {0}},
        .choose = choose,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
