/* Notes on options without effect (driver/driver_options.h): a feature that neither this command
 * line's plan nor the usual one has. */
#include "driver/driver_options.h"

#include "render/options.h"

#include <stdio.h>
#include <string.h>

/* The first argument that names an option of the rows, or only the option of `field`. */
static const char *first_given(const rk_driver *driver, const rk_option *rows, const char *field)
{
    const rk_option_table table = {rows, NULL};
    for (char **argument = driver->argv; rows && *argument; argument++) {
        const rk_option *row = rk_options_find(&table, 1, *argument);
        if (row && (!field || strcmp(row->field, field) == 0))
            return *argument;
    }
    return NULL;
}

/* The same of the options that the renderer has without a feature. */
static const char *first_given_of_renderer(const rk_driver *driver, const char *field)
{
    rk_render_options options = driver->render;
    return first_given(driver, rk_render_options_tables(&options).tables[0].rows, field);
}

/* The option is named as it was typed. */
static void note(const rk_driver *driver, const char *given, const char *takes)
{
    if (given)
        fprintf(stderr, "%s: %.*s changes nothing in this picture: it takes %s\n", driver->feature,
                (int)strcspn(given, "="), given, takes);
}

static bool has_bounces(const rk_plan *plan)
{
    return plan->reflections || plan->transparency;
}

static void note_max_depth(const rk_driver *driver, const rk_plan *usual)
{
    rk_render_options options = driver->render;
    options.max_depth = 1; /* 0 has the effect that there are no bounces */
    const rk_plan plan = rk_plan_of(&driver->scene, &options);
    if (!has_bounces(&plan) && !has_bounces(usual))
        note(driver, first_given_of_renderer(driver, "max_depth"),
             "--reflections and a specular surface, or --transparency and a transparent one");
}

static void note_samples(const rk_driver *driver, const rk_plan *plan)
{
    if (plan->adaptive_sampling)
        note(driver, first_given_of_renderer(driver, "samples"), "a picture without --error");
}

/* Soft edges of what is cut out are no transparency. */
static bool is_translucent(const rk_image *opacity)
{
    size_t between = 0;
    const size_t count = opacity->width * opacity->height;
    for (size_t i = 0; i < count; i++)
        between += opacity->pixels[i].x > 0.05f && opacity->pixels[i].x < 0.95f;
    return between > count / 10;
}

/* Returns for how many materials that are opaque but for it. */
static uint32_t made_transparent_by(const rk_texture *texture, const rk_mesh *mesh)
{
    uint32_t users = 0;
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        const rk_material *m = &mesh->materials[i];
        users += m->alpha >= 1 && m->alpha_cutoff == 0 && m->alpha_texture == texture;
    }
    return users;
}

/* The opposite: an option that is missing. */
static void note_transparent(const rk_driver *driver)
{
    const rk_mesh *mesh = &driver->scene.mesh;
    uint32_t count = 0;
    if (!driver->mesh_path || driver->render.transparency)
        return;
    for (uint32_t i = 0; i < mesh->material_count; i++)
        count += mesh->materials[i].alpha < 1;
    for (uint32_t i = 0; i < mesh->texture_count; i++) { /* each is looked at once */
        const uint32_t users = made_transparent_by(&mesh->textures[i], mesh);
        count += users > 0 && is_translucent(&mesh->textures[i].image) ? users : 0;
    }
    if (count > 0)
        fprintf(stderr,
                "%s: %s: %u of %u materials are transparent, and drawn as opaque without "
                "--transparency\n",
                driver->feature, driver->mesh_path, count, mesh->material_count);
}

/* Options of a feature that the command line turns off have an effect, too: it is in the usual
 * plan. */
void rk_driver_note_unused(const rk_driver *driver)
{
    if (driver->quiet || driver->timing)
        return;
    const rk_plan plan = rk_plan_of(&driver->scene, &driver->render);
    const rk_plan usual = rk_plan_of(&driver->scene, &driver->render_usual);
    note_max_depth(driver, &usual);
    note_samples(driver, &plan);
    note_transparent(driver);
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (!rk_plan_has(&plan, i) && !rk_plan_has(&usual, i))
            note(driver, first_given(driver, rk_features[i]->options, NULL), rk_features[i]->takes);
}
