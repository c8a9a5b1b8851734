/* Draws the figures and measures the table of shading: a scene by one of the models, a model's
 * lobes over a plane, and the lobes' values as a table. */
#include "driver.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene by one of the shading models (--shading).\n"
    "--debug lobe draws the lobes of highlights of shininess 1 to 100,000.\n"
    "--lobes puts the values of normalized highlights into a table.\n"
    "--radiance puts the light that a surface reflects in each direction, by --shading, "
    "--shininess "
    "and --ks, into the table shading_radiance.";

/* The gradient in equal steps, by two stops at each boundary. */
static rk_gradient in_bands(const rk_gradient *smooth, uint32_t bands)
{
    rk_gradient stepped = {.count = 2 * bands};
    for (uint32_t i = 0; i < bands; i++) {
        float from = 2 * (float)i / (float)bands - 1, width = 2 / (float)bands;
        rk_vec3 colour = rk_gradient_at(smooth, from + 0.5f * width);
        stepped.stops[2 * i] = (rk_gradient_stop){from, colour};
        stepped.stops[2 * i + 1] =
            (rk_gradient_stop){2 * (float)(i + 1) / (float)bands - 1, colour};
    }
    return stepped;
}

static void set_material(rk_material *material, const choices *c)
{
    if (!isnan(c->ks))
        material->ks = rk_vec(c->ks, c->ks, c->ks);
    if (!isnan(c->shininess))
        material->shininess = c->shininess;
}

static bool choose(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_shading *shading = &driver->render.shading;
    bool has_lobe = shading->model == RK_SHADING_PHONG || shading->model == RK_SHADING_BLINN_PHONG;
    if (rk_driver_debug(driver, "lobe") && (!has_lobe || shading->normalized))
        return rk_fail(error, "--debug lobe goes with --shading phong or blinn-phong, and without "
                              "--normalized, which changes a lobe's size and not its shape");
    if (c->terminator && strncmp(driver->scene_name, "sphere:", 7) != 0)
        return rk_fail(error, "--terminator goes with --scene sphere:N: it compares with a sphere");
    if (c->bands)
        shading->gradient = in_bands(&shading->gradient, c->bands);
    return true;
}

static bool prepare(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_shading *shading = &driver->render.shading;
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], c);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], c);
    /* With pi times the light, diffuse surfaces of kd / pi look the same. */
    for (uint32_t i = 0; shading->normalized && i < scene->light_count; i++)
        for (uint32_t k = 0; k < 4; k++)
            scene->lights[i].colours[k] = rk_scale(scene->lights[i].colours[k], RK_PI);
    return !driver->debug || make_plane(driver, error);
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    char metric[32];
    snprintf(metric, sizeof metric, "render_%s",
             rk_shading_model_names.items[driver->render.shading.model]);
    return rk_driver_row(driver, metric, "ms", driver->render_ms, error) &&
           rk_driver_count_rows(driver, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_shading *shading = &driver->render.shading;
    const char *model = rk_shading_model_names.items[shading->model];
    char label[64];
    if (driver->debug)
        snprintf(label, sizeof label, "%s_%g", model, (double)c->incidence);
    else
        snprintf(label, sizeof label, "%s%s%s%s", model, shading->normalized ? "_normalized" : "",
                 c->bands ? "_bands" : "", driver->render.face_shadows ? "_faces" : "");
    return rk_driver_save(driver, label, error);
}

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "shininess";
}

static const rk_option options[] = {
    {"ks", RK_FIELD(choices, ks), "K",
     "specular colour of all materials, a grey; by default their own", 0, 1, NAN, .of_scene = true},
    {"shininess", RK_FIELD(choices, shininess), "S",
     "shininess of all materials; by default their own", 0, 1e6, NAN, .of_scene = true},
    {"bands", RK_FIELD(choices, bands), "N", "the gradient in N equal steps; 0: smooth", 0,
     RK_GRADIENT_STOPS_MAX / 2, 0},
    {"incidence", RK_FIELD(choices, incidence), "DEG",
     "angle of the light in --debug lobe and --radiance, degrees from the normal", 0, 89, 45},
    {"lobes", RK_FIELD(choices, lobes), NULL,
     "put values of the lobes into DIR/tables/shading_lobes.csv instead of drawing a picture"},
    {"radiance", RK_FIELD(choices, radiance), NULL,
     "put what a surface reflects by the viewer's angle into DIR/tables/shading_radiance.csv "
     "instead of drawing a picture"},
    {"terminator", RK_FIELD(choices, terminator), NULL,
     "put the error along the edge of a ball's shadow into DIR/tables/shading_terminator.csv; with "
     "--scene sphere:N"},
    {0},
};

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "shading",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = (rk_driver_view[]){{"lobe", draw_view, false}, {0}},
        .studies = (rk_driver_study[]){{&c.lobes, put_study, true},
                                       {&c.radiance, put_radiance, true},
                                       {&c.terminator, put_terminator, true},
                                       {0}},
        .choose = choose,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
