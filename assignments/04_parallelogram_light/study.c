/* Two studies. Error against time: how fast each method's picture converges to a reference of very
 * many samples. Error against shininess: highlights by samples on the light, and by directions of
 * the lobe, too. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

typedef struct method {
    const char *name;
    rk_sampler_kind sampling;
    rk_light_domain domain;
    bool ratio;
    uint32_t early_out;
} method;

/* The last two differ only with physical falloff, and have no rows without it. */
static const method methods[] = {
    {"uniform", RK_SAMPLER_UNIFORM, RK_LIGHT_DOMAIN_AREA, false, 0},
    {"stratified", RK_SAMPLER_STRATIFIED, RK_LIGHT_DOMAIN_AREA, false, 0},
    {"low discrepancy", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, false, 0},
    {"early out", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, false, RK_LIGHT_EARLY_OUT},
    {"solid angle", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_SOLID_ANGLE, false, 0},
    {"ratio", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, true, 0},
};

/* The least noisy method; its bias falls with 1 / samples. */
static const method best = {"", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_SOLID_ANGLE, true, 0};

static void choose(rk_driver *driver, const method *m, uint32_t samples)
{
    rk_light_options *light = &driver->render.light;
    light->sampling = m->sampling;
    light->domain = m->domain;
    light->ratio = m->ratio;
    light->early_out = m->early_out;
    light->samples = samples;
}

bool put_study(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    bool physical = driver->render.light.falloff == RK_FALLOFF_PHYSICAL;
    size_t count = sizeof methods / sizeof *methods - (physical ? 0 : 2);
    char name[64], truth[32];
    rk_image reference;
    snprintf(name, sizeof name, "%s_convergence%s", driver->feature, physical ? "_physical" : "");
    snprintf(truth, sizeof truth, "%u samples", c->reference);
    choose(driver, &best, c->reference);
    if (!rk_convergence_reference(driver, &reference, error))
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++)
        for (uint32_t samples = 1; ok && samples <= c->most; samples *= 4) {
            choose(driver, &methods[i], samples);
            ok = rk_convergence_row_of(driver, name, methods[i].name, samples, &reference, truth,
                                       error);
        }
    rk_image_free(&reference);
    return ok;
}

/* --- Highlights ------------------------------------------------------------------------------- */

/* Samples on the light alone are as many as otherwise of both kinds. */
typedef struct technique {
    const char *name;
    rk_highlight_sampling highlights;
    uint32_t samples;
} technique;

static const technique techniques[] = {
    {"24 on the light", RK_HIGHLIGHT_LIGHT, 24},
    {"16 on the light, 8 of the lobe", RK_HIGHLIGHT_BALANCE, 16},
};

static double mean_of(const rk_image *image)
{
    double sum = 0;
    for (size_t i = 0; i < image->width * image->height; i++)
        for (int axis = 0; axis < 3; axis++)
            sum += (double)rk_axis(image->pixels[i], axis);
    return sum / (3 * (double)(image->width * image->height));
}

/* The error as a multiple of the picture's mean, which hardly depends on the shininess. */
static bool put_error(rk_driver *driver, const technique *t, float shininess,
                      const rk_image *reference, rk_error *error)
{
    static const char *const header[] = {"method", "shininess", "rmse", NULL};
    char path[4096], cells[2][32];
    driver->render.light.highlights = t->highlights;
    driver->render.light.samples = t->samples;
    if (!rk_driver_render(driver, error) ||
        !rk_driver_table(driver, "parallelogram_light_sharpness", path, error))
        return false;
    double rmse = rk_picture_compare(&driver->image, reference).rmse / mean_of(reference);
    snprintf(cells[0], sizeof cells[0], "%g", (double)shininess);
    snprintf(cells[1], sizeof cells[1], "%.4g", rmse);
    const char *row[] = {t->name, cells[0], cells[1]};
    return rk_table_put(path, header, row, 3, 2, error);
}

static void set_highlights(rk_scene *scene, float shininess)
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++) {
        rk_material *material = &scene->mesh.materials[i];
        material->kd = rk_vec(0, 0, 0);
        material->ks = rk_vec(0.4f, 0.4f, 0.4f);
        material->shininess = shininess;
    }
}

bool put_sharpness(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    bool ok = true;
    for (int k = 2; ok && k <= 12; k++) {
        rk_image reference;
        float shininess = powf(10, 0.5f * (float)k);
        set_highlights(&driver->scene, shininess);
        driver->render.light.highlights = RK_HIGHLIGHT_BALANCE;
        driver->render.light.samples = c->reference;
        if (!rk_convergence_reference(driver, &reference, error))
            return false;
        for (size_t i = 0; ok && i < sizeof techniques / sizeof *techniques; i++)
            ok = put_error(driver, &techniques[i], shininess, &reference, error);
        rk_image_free(&reference);
    }
    return ok;
}
