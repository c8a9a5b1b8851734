/* The tables: errors of pictures against a reference, and how fast they fall. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

enum { FIT_FROM = 4 }; /* samples: before, an error need not yet follow its power */

/* The straight line through log(error) over log(samples). */
typedef struct fit {
    double n, x, y, xx, xy;
} fit;

static void add_point(fit *f, uint32_t samples, double error)
{
    double x = log(samples), y = log(error);
    if (samples < FIT_FROM)
        return;
    f->n += 1, f->x += x, f->y += y, f->xx += x * x, f->xy += x * y;
}

static double slope_of(const fit *f)
{
    return (f->n * f->xy - f->x * f->y) / (f->n * f->xx - f->x * f->x);
}

/* How many samples have this error. */
static double samples_for(const fit *f, double error)
{
    double slope = slope_of(f), at_1 = (f->y - slope * f->x) / f->n;
    return exp((log(error) - at_1) / slope);
}

static bool put_slope(rk_driver *driver, const char *method, const fit *f, double rms,
                      rk_error *error)
{
    static const char *const header[] = {"effect", "kind", "slope", "for_one_percent", NULL};
    const choices *c = driver->choices;
    char path[4096], slope[32], wanted[32];
    snprintf(slope, sizeof slope, "%.3f", slope_of(f));
    snprintf(wanted, sizeof wanted, "%.0f", samples_for(f, 0.01 * rms));
    const char *row[] = {effect_names.items[c->effect], method, slope, wanted};
    return rk_driver_table(driver, "sampling_slopes", path, error) &&
           rk_table_put(path, header, row, 4, 2, error);
}

static bool put_kind(rk_driver *driver, rk_sampler_kind kind, const rk_image *want, rk_error *error)
{
    const choices *c = driver->choices;
    char table[64], reference[32];
    fit f = {0};
    snprintf(table, sizeof table, "sampling_%s", effect_names.items[c->effect]);
    snprintf(reference, sizeof reference, "%u samples", c->reference);
    const rk_convergence study = {table, want, reference, c->seeds};
    for (uint32_t samples = 2; samples <= c->most; samples *= 2) {
        double rmse;
        set_samples(driver, kind, samples);
        if (!rk_convergence_row_of(driver, &study, rk_sampler_name(kind), samples, &rmse, error))
            return false;
        add_point(&f, samples, rmse);
    }
    return put_slope(driver, rk_sampler_name(kind), &f, sqrt(mean_square(want)), error);
}

bool put_convergence(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_image want;
    set_samples(driver, RK_SAMPLER_SOBOL, c->reference); /* with another seed */
    if (!rk_convergence_reference(driver, &want, error))
        return false;
    bool ok = true;
    for (int kind = RK_SAMPLER_UNIFORM; ok && kind <= RK_SAMPLER_SOBOL; kind++)
        ok = put_kind(driver, (rk_sampler_kind)kind, &want, error);
    rk_image_free(&want);
    return ok;
}
