/* Error against time: how fast each method's picture converges to a reference of very many
 * samples. */
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
