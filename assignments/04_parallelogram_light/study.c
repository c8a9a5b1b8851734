/* Three studies. Error against time: how fast each method's picture converges to a reference of
 * very many samples. Error against shininess: highlights by samples on the light, and by directions
 * of the lobe, too. Early outs: error and shadow rays. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

typedef struct method {
    const char *name;
    rk_sampler_kind sampling;
    rk_light_domain domain;
    bool ratio;
    uint32_t early_out;
    rk_light_visibility_method visibility;
} method;

/* The last two differ only with physical falloff, and have no rows without it. */
static const method methods[] = {
    {"uniform", RK_SAMPLER_UNIFORM, RK_LIGHT_DOMAIN_AREA, false, 0, RK_LIGHT_RAYS},
    {"stratified", RK_SAMPLER_STRATIFIED, RK_LIGHT_DOMAIN_AREA, false, 0, RK_LIGHT_RAYS},
    {"low discrepancy", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, false, 0, RK_LIGHT_RAYS},
    {"sobol", RK_SAMPLER_SOBOL, RK_LIGHT_DOMAIN_AREA, false, 0, RK_LIGHT_RAYS},
    {"pyramids", RK_SAMPLER_SOBOL, RK_LIGHT_DOMAIN_AREA, false, 0, RK_LIGHT_PYRAMIDS},
    {"early out", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, false, RK_LIGHT_EARLY_OUT,
     RK_LIGHT_RAYS},
    {"solid angle", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_SOLID_ANGLE, false, 0,
     RK_LIGHT_RAYS},
    {"ratio", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_AREA, true, 0, RK_LIGHT_RAYS},
};

/* The least noisy method; its bias falls with 1 / samples. */
static const method best = {
    "", RK_SAMPLER_LOW_DISCREPANCY, RK_LIGHT_DOMAIN_SOLID_ANGLE, true, 0, RK_LIGHT_RAYS};

static void choose(rk_driver *driver, const method *m, uint32_t samples)
{
    rk_light_options *light = &driver->render.light;
    light->sampling = m->sampling;
    light->domain = m->domain;
    light->ratio = m->ratio;
    light->early_out = m->early_out;
    light->visibility = m->visibility;
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
    const rk_convergence study = {name, &reference, truth, c->seeds};
    bool ok = true;
    for (size_t i = 0; i < count; i++)
        for (uint32_t samples = 1; ok && samples <= c->most; samples *= 4) {
            choose(driver, &methods[i], samples);
            ok = rk_convergence_row_of(driver, &study, methods[i].name, samples, NULL, error);
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
    static const char *const header[] = {"method",    "shininess", "rmse", "rmse_low",
                                         "rmse_high", "seeds",     NULL};
    const choices *c = driver->choices;
    char path[4096], cells[5][32];
    rk_seed_errors off;
    driver->render.light.highlights = t->highlights;
    driver->render.light.samples = t->samples;
    if (!rk_convergence_errors(driver, reference, c->seeds, &off, error) ||
        !rk_driver_table(driver, "parallelogram_light_sharpness", path, error))
        return false;
    const double errors[] = {off.rmse, off.rmse_low, off.rmse_high};
    snprintf(cells[0], sizeof cells[0], "%g", (double)shininess);
    for (int i = 0; i < 3; i++)
        snprintf(cells[1 + i], sizeof cells[1 + i], "%.4g", errors[i] / mean_of(reference));
    snprintf(cells[4], sizeof cells[4], "%u", c->seeds);
    const char *row[] = {t->name, cells[0], cells[1], cells[2], cells[3], cells[4]};
    return rk_table_put(path, header, row, 6, 2, error);
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

/* --- Early outs ------------------------------------------------------------------------------- */

typedef struct early_out {
    const char *name;
    uint32_t samples, first; /* shadow rays after which points may stop; 0: all are traced */
} early_out;

static const early_out early_outs[] = {
    {"all", 64, 0},  {"after 16", 64, 16},  {"after 32", 64, 32},
    {"all", 256, 0}, {"after 16", 256, 16}, {"after 64", 256, 64},
};

/* Errors in per cent of the picture's mean. */
static bool put_early_out(rk_driver *driver, const early_out *e, const rk_image *reference,
                          rk_error *error)
{
    static const char *const header[] = {"samples",  "traced",    "shadow_rays", "rmse",
                                         "rmse_low", "rmse_high", "bias",        NULL};
    const choices *c = driver->choices;
    char path[4096], cells[6][32];
    rk_seed_errors off;
    driver->render.light.samples = e->samples;
    driver->render.light.early_out = e->first;
    if (!rk_convergence_errors(driver, reference, c->seeds, &off, error) ||
        !rk_driver_table(driver, "parallelogram_light_early_outs", path, error))
        return false;
    const double shadow_rays =
        (double)driver->counters.shadow_rays / (double)driver->counters.primary_rays;
    const double errors[] = {off.rmse, off.rmse_low, off.rmse_high, off.bias};
    snprintf(cells[0], sizeof cells[0], "%u", e->samples);
    snprintf(cells[1], sizeof cells[1], "%.1f", shadow_rays);
    for (int i = 0; i < 4; i++)
        snprintf(cells[2 + i], sizeof cells[2 + i], "%.3g", 100 * errors[i] / mean_of(reference));
    const char *row[] = {cells[0], e->name, cells[1], cells[2], cells[3], cells[4], cells[5]};
    return rk_table_put(path, header, row, 7, 2, error);
}

bool put_early_outs(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_image reference;
    driver->render.light.early_out = 0;
    driver->render.light.visibility = RK_LIGHT_RAYS;
    driver->render.light.samples = c->reference;
    if (!rk_convergence_reference(driver, &reference, error))
        return false;
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof early_outs / sizeof *early_outs; i++)
        ok = put_early_out(driver, &early_outs[i], &reference, error);
    rk_image_free(&reference);
    return ok;
}
