/* Draws the figures and measures the table of shading: a scene by one of the models, the models'
 * lobes over a plane, and the lobes' values as a table. */
#include "render/driver.h"
#include "base/file.h"

#include <stdio.h>
#include <string.h>

static const char summary[] =
    "Renders a scene by one of the shading models (--shading).\n"
    "--debug lobe draws how far highlights of shininess 1 to 100,000 reach.\n"
    "--lobes puts the values of normalised highlights into a table.";

static const char *const model_names[] = {"off", "lambert", "phong", "blinn-phong", "gradient"};
static const float shininess_shown[] = {1, 10, 100, 1e3f, 1e5f};
enum { shown = sizeof shininess_shown / sizeof shininess_shown[0] };

typedef struct choices {
    float ks, shininess; /* of all materials; NaN: their own */
    float incidence;     /* degrees from the normal */
    uint32_t bands;      /* of the gradient; 0: smooth */
    bool lobes;
} choices;

/* The gradient in even steps, by two stops at each border. */
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

static bool prepare(rk_driver *driver, const choices *c, rk_error *error)
{
    rk_shading *shading = &driver->render.shading;
    bool has_lobe = shading->model == RK_SHADING_PHONG || shading->model == RK_SHADING_BLINN_PHONG;
    if (rk_driver_debug(driver, "lobe") && (!has_lobe || shading->normalized))
        return rk_fail(error, "--debug lobe goes with --shading phong or blinn-phong, and without "
                              "--normalized, which changes a lobe's size and not its shape");
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], c);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], c);
    if (c->bands)
        shading->gradient = in_bands(&shading->gradient, c->bands);
    /* So that diffuse surfaces look the same, kd / pi gets pi times the light. */
    for (uint32_t i = 0; shading->normalized && i < scene->light_count; i++)
        for (uint32_t k = 0; k < 4; k++)
            scene->lights[i].colours[k] = rk_scale(scene->lights[i].colours[k], 3.14159265f);
    return true;
}

/* --- Lobes ----------------------------------------------------------------------------------- */

static const rk_vec3 up = {0, 1, 0}, white = {1, 1, 1};

/* At an angle from `up` to the right of the picture, where x is negative. */
static rk_vec3 at_angle(float degrees)
{
    float angle = degrees * 0.01745329f;
    return rk_vec(-sinf(angle), cosf(angle), 0);
}

static float lobe(rk_shading_model model, bool normalized, float shininess, rk_vec3 l, rk_vec3 v)
{
    const rk_shading shading = {.model = model, .normalized = normalized};
    return rk_shade(&shading, rk_vec(0, 0, 0), white, shininess, up, l, v, white).x;
}

/* The scene becomes a plane, seen from the side. */
static bool make_plane(rk_driver *driver, rk_error *error)
{
    rk_mesh plane;
    if (!rk_mesh_init(&plane, 4, 2, 1, 0, error))
        return false;
    for (uint32_t i = 0; i < 4; i++)
        plane.positions[i] = rk_vec(i & 1 ? 1.3f : -1.3f, 0, i & 2 ? 0.5f : -0.5f);
    plane.materials[0].kd = rk_vec(0.15f, 0.15f, 0.15f);
    memcpy(plane.triangles, (uint32_t[2][3]){{0, 2, 1}, {1, 2, 3}}, sizeof(uint32_t[2][3]));
    rk_scene_free(&driver->scene);
    driver->scene = (rk_scene){
        .name = "lobe",
        .mesh = plane,
        .camera = {{0, 0.5f, 0}, 4, {10, 0, 0}, 24},
        .light_count = 1,
        .lights = {rk_light_point(rk_vec(0, 8, 0), white)},
    };
    return true;
}

/* Each lobe as a curve whose distance from the point is the light that goes this way; directions
 * stand closer where sharp lobes are, around the mirror direction. */
static void draw_lobes(rk_overlay *overlay, rk_shading_model model, float incidence)
{
    const rk_vec3 point = {0, 0, 0}, l = at_angle(-incidence);
    rk_overlay_line(overlay, point, up, rk_vec(0.5f, 0.5f, 0.5f), 1);
    rk_overlay_line(overlay, point, rk_scale(at_angle(incidence), 1.15f), white, 1);
    rk_overlay_line(overlay, rk_scale(l, 1.3f), point, rk_vec(1, 0.9f, 0.3f), 4);
    for (uint32_t i = 0; i < shown; i++) {
        rk_vec3 last = point;
        for (int k = -200; k <= 200; k++) {
            float share = (float)k / 200, angle = incidence + 180 * share * share * share;
            rk_vec3 v = at_angle(rk_max(-90, rk_min(angle, 90)));
            rk_vec3 next = rk_scale(v, lobe(model, false, shininess_shown[i], l, v));
            rk_overlay_line(overlay, last, next, rk_overlay_colour(i), 3);
            last = next;
        }
        rk_overlay_line(overlay, last, point, rk_overlay_colour(i), 3);
    }
}

/* Rows of both models with light along the normal, by the viewer's angle from the mirror direction:
 * ten to a factor of ten, from a hundredth of a degree. */
static bool put_lobes(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"model", "shininess", "angle", "value", NULL};
    char path[4096], cells[3][32];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/shading_lobes.csv", driver->out);
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (uint32_t i = 0; i < shown; i++)
            for (int k = 0; k < 40; k++) {
                float angle = powf(10, 0.1f * (float)k - 2);
                float value =
                    lobe((rk_shading_model)model, true, shininess_shown[i], up, at_angle(angle));
                if (angle >= 90 || !(value > 1e-3f))
                    break;
                snprintf(cells[0], sizeof cells[0], "%g", (double)shininess_shown[i]);
                snprintf(cells[1], sizeof cells[1], "%.4g", (double)angle);
                snprintf(cells[2], sizeof cells[2], "%.6g", (double)value);
                const char *row[] = {model_names[model], cells[0], cells[1], cells[2]};
                if (!rk_table_put(path, header, row, 4, 3, error))
                    return false;
            }
    return true;
}

/* --- The driver ------------------------------------------------------------------------------ */

static bool save(rk_driver *driver, const choices *c, rk_error *error)
{
    const rk_shading *shading = &driver->render.shading;
    char label[64];
    if (driver->debug) {
        rk_overlay overlay;
        if (!rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                             error))
            return false;
        draw_lobes(&overlay, shading->model, c->incidence);
        rk_overlay_free(&overlay);
        snprintf(label, sizeof label, "%s_%g", model_names[shading->model], (double)c->incidence);
    } else {
        snprintf(label, sizeof label, "%s%s%s", model_names[shading->model],
                 shading->normalized ? "_normalized" : "", c->bands ? "_bands" : "");
    }
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c = {.ks = NAN, .shininess = NAN, .incidence = 45};
    const rk_option options[] = {
        {"ks", RK_OPTION_FLOAT, &c.ks, "K",
         "specular colour of all materials, a grey; by default their own", 0, 1},
        {"shininess", RK_OPTION_FLOAT, &c.shininess, "S", "of all materials; by default their own",
         0, 1e6},
        {"bands", RK_OPTION_UINT, &c.bands, "N", "the gradient in so many even steps; 0: smooth", 0,
         RK_GRADIENT_STOPS_MAX / 2},
        {"incidence", RK_OPTION_FLOAT, &c.incidence, "DEG",
         "of the light in --debug lobe, degrees from the normal", 0, 89},
        {"lobes", RK_OPTION_FLAG, &c.lobes, NULL,
         "put values of the lobes into DIR/tables/shading_lobes.csv instead of drawing a picture",
         0, 0},
        {0},
    };
    const char *const views[] = {"lobe", NULL};
    rk_driver driver = rk_driver_default("shading", summary);
    driver.scene_name = "shininess";
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = prepare(&driver, &c, &error);
    if (ok && c.lobes)
        return rk_driver_finish(&driver, put_lobes(&driver, &error), &error);
    if (ok && driver.debug)
        ok = make_plane(&driver, &error);
    ok = ok && rk_driver_build(&driver, &error) && rk_driver_render(&driver, &error);
    char metric[32];
    snprintf(metric, sizeof metric, "render_%s", model_names[driver.render.shading.model]);
    if (ok && driver.timing)
        ok = rk_driver_row(&driver, metric, "ms", driver.render_ms, &error);
    else if (ok)
        ok = save(&driver, &c, &error);
    return rk_driver_finish(&driver, ok, &error);
}
