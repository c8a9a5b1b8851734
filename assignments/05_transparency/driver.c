/* Draws the figures and measures the tables of transparency: a scene with its glass, the way of one
 * pixel's ray through it, and what the three models of shadows make of a few panes. */
#include "render/driver.h"
#include "base/file.h"
#include "render/crossings.h"
#include "render/side_view.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene with glass (--transparency; --shadows as --glass says).\n"
    "--debug rays shows the way of the ray of --pixel from beside the camera.\n"
    "--models puts the light behind a few panes and blocks into a table.";

static const char *const model_names[] = {"multiplicative", "ordered", "beer-lambert"};
enum { model_count = sizeof model_names / sizeof model_names[0] };

typedef struct choices {
    float alpha, absorption; /* of all materials; NaN: their own */
    rk_side_view viewer;     /* where --debug rays is seen from */
    bool models;
} choices;

static void set_material(rk_material *material, const choices *c)
{
    if (!isnan(c->alpha))
        material->alpha = c->alpha;
    if (!isnan(c->absorption)) /* what the colour lacks is absorbed */
        material->absorption = rk_scale(rk_sub(rk_vec(1, 1, 1), material->kd), c->absorption);
}

static bool prepare(rk_driver *driver, const choices *c, rk_error *error)
{
    if (rk_driver_debug(driver, "rays") && !driver->render.transparency)
        return rk_fail(error, "--debug rays goes with --transparency: without it no ray goes on");
    rk_scene *scene = &driver->scene;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        set_material(&scene->mesh.materials[i], c);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        set_material(&scene->sphere_materials[i], c);
    return true;
}

/* --- The way of a ray ------------------------------------------------------------------------- */

typedef struct drawing {
    const rk_driver *driver;
    rk_overlay overlay;
    rk_counters counters; /* nobody reads them */
} drawing;

static rk_vec3 along(const rk_ray *ray, float t)
{
    return rk_madd(ray->origin, ray->direction, t);
}

/* What is seen along the rest of a view ray, from t on: surfaces in their own colours, as if fully
 * lit, blended with those behind them. */
static rk_vec3 colour_behind(drawing *d, const rk_ray *ray, float t, uint32_t limit)
{
    rk_ray rest = {along(ray, t), ray->direction, INFINITY};
    rk_crossing_list list;
    float weights[RK_CROSSINGS_MAX], behind;
    rk_crossings_gather(&d->driver->accel, &rest, limit, &list, &d->counters);
    rk_transparency_weights(list.crossings, list.count, weights, &behind);
    rk_vec3 colour = rk_vec(0, 0, 0);
    for (uint32_t k = 0; k < list.count; k++)
        colour = rk_madd(colour, list.crossings[k].kd, weights[k]);
    return colour;
}

/* A light's colour where a shadow ray has still to go from t to 1. */
static rk_vec3 colour_of_light(drawing *d, const rk_ray *ray, float t)
{
    rk_ray rest = {along(ray, t), rk_scale(ray->direction, 1 - t), 1};
    return rk_crossings_transmit(&d->driver->accel, &rest, d->driver->render.glass, &d->counters);
}

/* One stretch after the other, each in the colour that is on its way there. */
static void draw_view_ray(drawing *d, const rk_ray *ray, const rk_crossing_list *list)
{
    float from = 0;
    for (uint32_t k = 0; k < list->count; k++) {
        const rk_crossing *crossing = &list->crossings[k];
        rk_vec3 colour = colour_behind(d, ray, (from + crossing->t) / 2, list->limit - k);
        rk_overlay_line(&d->overlay, along(ray, from), along(ray, crossing->t), colour, 5);
        from = crossing->t;
    }
    for (uint32_t k = 0; k < list->count; k++)
        rk_overlay_point(&d->overlay, along(ray, list->crossings[k].t), list->crossings[k].kd, 6);
    rk_overlay_point(&d->overlay, ray->origin, rk_vec(1, 1, 1), 8);
}

static void draw_shadow_ray(drawing *d, const rk_surface *surface, rk_vec3 light)
{
    rk_vec3 start = rk_surface_leave(surface, rk_sub(light, surface->point));
    rk_ray ray = {start, rk_sub(light, start), 1};
    rk_crossing_list list;
    rk_crossings_gather(&d->driver->accel, &ray, RK_CROSSINGS_MAX, &list, &d->counters);
    for (uint32_t k = 0; k <= list.count; k++) {
        float from = k ? list.crossings[k - 1].t : 0;
        float to = k < list.count ? list.crossings[k].t : 1;
        rk_overlay_line(&d->overlay, along(&ray, from), along(&ray, to),
                        colour_of_light(d, &ray, (from + to) / 2), 3);
    }
    rk_overlay_point(&d->overlay, light, rk_vec(1, 1, 1), 8);
}

static void draw_rays(drawing *d, const rk_ray *ray)
{
    const rk_scene *scene = &d->driver->scene;
    rk_crossing_list list;
    rk_crossings_gather(&d->driver->accel, ray, d->driver->render.recursion + 1, &list,
                        &d->counters);
    draw_view_ray(d, ray, &list);
    if (list.count == 0 || !d->driver->render.shadows)
        return;
    rk_hit last = rk_crossing_hit(&list.crossings[list.count - 1]);
    rk_surface surface;
    rk_scene_surface(&surface, scene, ray, &last);
    for (uint32_t i = 0; i < scene->light_count; i++)
        draw_shadow_ray(d, &surface,
                        rk_light_sample_at(&scene->lights[i], RK_FALLOFF_NONE, RK_LIGHT_MAP_AREA,
                                           surface.point, (rk_vec2){0.5f, 0.5f})
                            .position);
}

/* The ray is the camera's, the picture is drawn from beside it. Nothing hides the ray: it is to be
 * seen through walls as well. */
static bool render_rays(rk_driver *driver, const choices *c, rk_error *error)
{
    rk_ray ray = rk_side_view_ray(driver);
    drawing d = {.driver = driver};
    if (!rk_side_view_render(&c->viewer, driver, &d.overlay, error))
        return false;
    draw_rays(&d, &ray);
    rk_overlay_free(&d.overlay);
    return true;
}

/* --- Tables ----------------------------------------------------------------------------------- */

/* Crossings of all camera rays, counted without a limit of recursion. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    char metric[32];
    snprintf(metric, sizeof metric, "render_%s",
             driver->render.transparency ? model_names[driver->render.glass] : "opaque");
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

/* On the way from the point to the light: two panes of half opacity, or a block of blue glass that
 * is entered and left. */
typedef struct way {
    const char *name;
    float t[2];
    float alpha;
    rk_vec3 kd[2], absorption;
} way;

static const way ways[] = {
    {"red, then yellow glass", {0.25f, 0.5f}, 0.5f, {{1, 0, 0}, {1, 1, 0}}, {0, 0, 0}},
    {"yellow, then red glass", {0.25f, 0.5f}, 0.5f, {{1, 1, 0}, {1, 0, 0}}, {0, 0, 0}},
    {"a block 0.125 thick",
     {0.25f, 0.375f},
     0.25f,
     {{0.5f, 0.75f, 1}, {0.5f, 0.75f, 1}},
     {2, 1, 0}},
    {"a block 0.5 thick", {0.25f, 0.75f}, 0.25f, {{0.5f, 0.75f, 1}, {0.5f, 0.75f, 1}}, {2, 1, 0}},
};

static rk_vec3 light_along(const way *w, rk_glass_model model)
{
    rk_crossing crossings[2];
    for (int i = 0; i < 2; i++)
        crossings[i] = (rk_crossing){.t = w->t[i],
                                     .entering = i == 0,
                                     .alpha = w->alpha,
                                     .kd = w->kd[i],
                                     .absorption = w->absorption};
    return rk_transparency_transmit(model, crossings, 2, 1);
}

static bool put_models(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"way", "model", "red", "green", "blue", NULL};
    char path[4096], cells[3][32];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/transparency_models.csv", driver->out);
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++)
        for (int model = 0; model < model_count; model++) {
            rk_vec3 share = light_along(&ways[w], (rk_glass_model)model);
            for (int axis = 0; axis < 3; axis++)
                snprintf(cells[axis], sizeof cells[axis], "%.4f", (double)rk_axis(share, axis));
            const char *row[] = {ways[w].name, model_names[model], cells[0], cells[1], cells[2]};
            if (!rk_table_put(path, header, row, 5, 2, error))
                return false;
        }
    return true;
}

/* --- The driver ------------------------------------------------------------------------------- */

static bool save(rk_driver *driver, rk_error *error)
{
    const char *model = driver->render.transparency ? model_names[driver->render.glass] : "opaque";
    char label[64];
    if (driver->debug)
        snprintf(label, sizeof label, "rays_%s_%u_%u", model, driver->pixel.x, driver->pixel.y);
    else if (driver->render.recursion != rk_render_options_default().recursion)
        snprintf(label, sizeof label, "%s_recursion%u", model, driver->render.recursion);
    else
        snprintf(label, sizeof label, "%s", model);
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c = {.alpha = NAN, .absorption = NAN, .viewer = rk_side_view_default()};
    const rk_option options[] = {
        {"alpha", RK_OPTION_FLOAT, &c.alpha, "A",
         "opacity of all materials, 1 is opaque; by default their own", 0, 1},
        {"absorption", RK_OPTION_FLOAT, &c.absorption, "S",
         "of all materials: what their colour lacks of white, times S in each world unit; by "
         "default their own",
         0, 1e6},
        RK_SIDE_VIEW_OPTIONS(c.viewer),
        {"models", RK_OPTION_FLAG, &c.models, NULL,
         "put the models' light into DIR/tables/transparency_models.csv instead of drawing", 0, 0},
        {0},
    };
    const char *const views[] = {"rays", NULL};
    rk_driver driver = rk_driver_default("transparency", summary);
    driver.scene_name = "panes";
    driver.drawn_x = 65; /* through all of the panes */
    driver.drawn_y = 58;
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = prepare(&driver, &c, &error);
    if (ok && c.models)
        return rk_driver_finish(&driver, put_models(&driver, &error), &error);
    ok = ok && rk_driver_build(&driver, &error) &&
         (driver.debug ? render_rays(&driver, &c, &error) : rk_driver_render(&driver, &error));
    if (ok && driver.timing)
        ok = put_rows(&driver, &error);
    else if (ok)
        ok = save(&driver, &error);
    return rk_driver_finish(&driver, ok, &error);
}
