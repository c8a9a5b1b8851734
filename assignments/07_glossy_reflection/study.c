/* The tables: how fast each map and sampler converges, and the effect of the weights where
 * directions lead into the surface. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

/* --- Error against time ----------------------------------------------------------------------- */

bool put_convergence(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_glossy_options *glossy = &driver->render.glossy;
    char truth[32], method[64];
    rk_image want;
    snprintf(truth, sizeof truth, "%u samples", c->reference);
    glossy->samples = c->reference;
    if (!rk_convergence_reference(driver, &want, error))
        return false;
    const rk_convergence study = {"glossy_reflection_convergence", &want, truth, c->seeds};
    bool ok = true;
    for (uint32_t i = 0; ok && i < 8; i++) { /* uniform to sobol */
        glossy->sampling = (rk_sampler_kind)(i / 2);
        glossy->map = (rk_disk_map)(i % 2);
        snprintf(method, sizeof method, "%s, %s", rk_sampler_name(glossy->sampling),
                 rk_disk_map_names.items[glossy->map]);
        for (glossy->samples = 1; ok && glossy->samples <= c->most; glossy->samples *= 4)
            ok = rk_convergence_row_of(driver, &study, method, glossy->samples, NULL, error);
    }
    rk_image_free(&want);
    return ok;
}

/* --- Weights ---------------------------------------------------------------------------------- */

/* The radiance from a direction in a room that is brighter above. */
static double radiance_from(rk_vec3 direction)
{
    return 1 + (double)direction.z;
}

/* The mean radiance over the disk, black below the surface: by the midpoints of a grid, whose error
 * at the rim is smaller than the table's digits. */
static double integral_of(const rk_glossy_disk *disk)
{
    enum { side = 2000 };
    double sum = 0, count = 0;
    for (int i = 0; i < side * side; i++) {
        rk_vec2 at = {(2 * (float)(i % side) + 1) / side - 1,
                      (2 * (float)(i / side) + 1) / side - 1};
        rk_vec3 direction;
        if (at.x * at.x + at.y * at.y > 1)
            continue;
        count++;
        if (rk_glossy_direction(disk, at, &direction))
            sum += radiance_from(direction);
    }
    return sum / count;
}

/* The mean of the estimates of `pixels` pixels. */
static double estimate_of(const rk_driver *driver, const rk_glossy_disk *disk,
                          rk_glossy_weights weights)
{
    enum { pixels = 4096 };
    const rk_glossy_options *glossy = &driver->render.glossy;
    const rk_sampler sampler =
        rk_render_sampler(&driver->render, glossy->sampling, glossy->samples);
    float fraction = weights == RK_GLOSSY_CLASSIC ? 1 : rk_glossy_fraction_above(disk);
    double sum = 0;
    for (uint32_t pixel = 0; pixel < pixels; pixel++)
        for (uint32_t i = 0; i < glossy->samples; i++) {
            rk_vec2 xi = rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_GLOSSY);
            rk_vec2 at = rk_glossy_point_above(disk, fraction, rk_disk_at(glossy->map, xi));
            rk_vec3 direction;
            if (rk_glossy_direction(disk, at, &direction))
                sum += radiance_from(direction);
        }
    return sum / ((double)pixels * glossy->samples);
}

bool put_policies(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"degrees", "radius",     "fraction above", "black below",
                                         "classic", "above only", "renormalized",   NULL};
    static const float degrees[] = {1, 2, 5, 10, 15, 20, 30};
    char path[4096];
    if (!rk_driver_table(driver, "glossy_reflection_policies", path, error))
        return false;
    float radius = driver->render.glossy.radius >= 0 ? driver->render.glossy.radius : 0.5f;
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
        float height = degrees[i] * 0.017453293f;
        rk_glossy_disk disk =
            rk_glossy_disk_of(rk_vec(cosf(height), 0, sinf(height)), radius, rk_vec(0, 0, 1));
        double above = (double)rk_glossy_fraction_above(&disk), black = integral_of(&disk);
        const double figures[] = {(double)degrees[i],
                                  (double)radius,
                                  above,
                                  black,
                                  estimate_of(driver, &disk, RK_GLOSSY_CLASSIC),
                                  black / above,
                                  estimate_of(driver, &disk, RK_GLOSSY_RENORMALIZED)};
        char cells[7][32];
        const char *row[7];
        for (int k = 0; k < 7; k++) {
            snprintf(cells[k], sizeof cells[k], k < 2 ? "%g" : "%.4f", figures[k]);
            row[k] = cells[k];
        }
        if (!rk_table_put(path, header, row, 7, 2, error))
            return false;
    }
    return true;
}
