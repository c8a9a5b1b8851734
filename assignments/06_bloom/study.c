/* The table of --errors: the time of each method of bloom, and its difference from the exact
 * filter. */
#include "driver.h"

#include <stdio.h>

typedef struct difference {
    double largest, rms;
} difference;

static difference difference_of(const rk_image *a, const rk_image *b)
{
    double largest = 0, squares = 0;
    for (size_t i = 0; i < pixels_of(a); i++)
        for (int axis = 0; axis < 3; axis++) {
            double d =
                fabs((double)rk_axis(a->pixels[i], axis) - (double)rk_axis(b->pixels[i], axis));
            largest = d > largest ? d : largest;
            squares += d * d;
        }
    return (difference){largest, sqrt(squares / (3 * (double)pixels_of(a)))};
}

static bool put_error(rk_driver *driver, const rk_bloom_options *options, double ms, difference d,
                      rk_error *error)
{
    static const char *const header[] = {"scene", "radius",    "method", "milliseconds",
                                         "taps",  "max_error", "rmse",   NULL};
    char path[4096], cells[5][32];
    if (!rk_driver_table(driver, "bloom_errors", path, error))
        return false;
    snprintf(cells[0], sizeof cells[0], "%u", options->radius);
    snprintf(cells[1], sizeof cells[1], "%.4g", ms);
    snprintf(cells[2], sizeof cells[2], "%.3g", d.largest);
    snprintf(cells[3], sizeof cells[3], "%.3g", d.rms);
    snprintf(cells[4], sizeof cells[4], "%.4g", taps_of(driver));
    const char *row[] = {driver->scene.name,
                         cells[0],
                         rk_bloom_method_names.items[options->method],
                         cells[1],
                         cells[4],
                         cells[2],
                         cells[3]};
    return rk_table_put(path, header, row, 7, 3, error);
}

/* Each method at several radii, against the exact filter. */
static bool put_errors(rk_driver *driver, const rk_bloom_options *options, rk_error *error)
{
    const uint32_t radii[] = {15, 50, 100, 250, 1000};
    rk_image exact = {0}, other = {0};
    bool ok = rk_image_init(&exact, driver->image.width, driver->image.height, error) &&
              rk_image_init(&other, driver->image.width, driver->image.height, error);
    for (size_t i = 0; ok && i < sizeof radii / sizeof *radii; i++)
        for (uint32_t method = 0; ok && method < rk_bloom_method_names.count; method++) {
            rk_bloom_options now = *options;
            rk_timing ms;
            now.radius = radii[i];
            now.method = (rk_bloom_method)method;
            rk_image *result = method == RK_BLOOM_EXACT ? &exact : &other;
            ok = bloom_copy(driver, &now, result, &ms, error) &&
                 put_error(driver, &now, ms.median, difference_of(result, &exact), error);
        }
    rk_image_free(&exact);
    rk_image_free(&other);
    return ok;
}

bool put_study(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return rk_driver_render(driver, error) && put_errors(driver, &c->bloom, error);
}
