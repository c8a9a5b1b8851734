/* The tables: the time of a lookup by each filter, and each filter's error. */
#include "driver.h"

#include "base/random.h"

#include <stdio.h>
#include <stdlib.h>

static rk_vec3 random_direction(uint32_t n)
{
    float z = 2 * rk_unit_float(rk_hash(n, 0, 1, 0)) - 1, r = sqrtf(1 - z * z);
    float angle = 6.2831853f * rk_unit_float(rk_hash(n, 1, 1, 0));
    return rk_vec(r * cosf(angle), r * sinf(angle), z);
}

/* Nanoseconds per lookup in random directions, and the time of the picture. */
bool put_rows(rk_driver *driver, rk_error *error)
{
    enum { directions = 1 << 16, rounds = 32 };
    double nanoseconds[RK_RUNS_MAX];
    rk_vec3 *d = rk_allocate(directions, sizeof *d, "directions", error);
    if (!d)
        return false;
    for (uint32_t n = 0; n < directions; n++)
        d[n] = random_direction(n);
    bool ok = rk_driver_row(driver, "render", "ms", driver->render_ms, error);
    for (uint32_t filter = 0; ok && filter < rk_cubemap_filter_names.count; filter++) {
        float sum = 0; /* read below, or the compiler would remove the lookups */
        for (uint32_t run = 0; run < driver->runs; run++) {
            double start = rk_clock_thread();
            for (uint32_t n = 0; n < rounds * directions; n++)
                sum += rk_cubemap_at(&driver->scene.environment, d[n % directions],
                                     (rk_cubemap_filter)filter)
                           .x;
            nanoseconds[run] = 1e9 * (rk_clock_thread() - start) / (rounds * directions);
        }
        if (!isfinite(sum))
            ok = rk_fail(error, "the environment is too bright to be summed up");
        char metric[48];
        snprintf(metric, sizeof metric, "lookup_%s_%u", rk_cubemap_filter_names.items[filter],
                 driver->scene.environment.side);
        ok = ok &&
             rk_driver_row(driver, metric, "ns", rk_timing_of(nanoseconds, driver->runs), error);
    }
    free(d);
    return ok;
}

/* A smooth function, to compare its map with. */
static rk_vec3 smooth(rk_vec3 d)
{
    d = rk_normalize(d);
    return rk_vec(0.5f + 0.5f * sinf(3 * d.x + d.y), 0.5f + 0.5f * d.y * d.z,
                  0.5f + 0.5f * cosf(2 * d.z));
}

static rk_vec3 smooth_texel(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    return smooth(rk_cubemap_texel_direction(side, face, column, row));
}

static double distance(rk_vec3 a, rk_vec3 b)
{
    return (double)rk_length(rk_sub(a, b));
}

/* Root mean square error over the sphere. */
static double error_of(const rk_cubemap *map, rk_cubemap_filter filter)
{
    enum { directions = 1 << 15 };
    double sum = 0;
    for (uint32_t n = 0; n < directions; n++) {
        rk_vec3 d = random_direction(n);
        double error = distance(rk_cubemap_at(map, d, filter), smooth(d));
        sum += error * error;
    }
    return sqrt(sum / directions);
}

/* The largest difference between two nearly equal directions on the two sides of an edge. */
static double step_of(const rk_cubemap *map, rk_cubemap_filter filter)
{
    const float below = 0.5f - 0x1p-22f, above = 0.5f + 0x1p-22f;
    double largest = 0;
    for (int i = 0; i < RK_FACES * 4 * 1024; i++) {
        rk_cube_face face = (rk_cube_face)(i / 4096);
        float along = ((float)(i % 1024) + 0.5f) / 1024, sign = i / 1024 % 2 ? 1 : -1;
        float in = 0.5f + sign * below, out = 0.5f + sign * above;
        bool upright = i / 2048 % 2;
        rk_vec3 a = rk_cube_direction(face, upright ? in : along, upright ? along : in);
        rk_vec3 b = rk_cube_direction(face, upright ? out : along, upright ? along : out);
        double step = distance(rk_cubemap_at(map, a, filter), rk_cubemap_at(map, b, filter));
        largest = step > largest ? step : largest;
    }
    return largest;
}

bool put_study(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"filter", "side", "rmse", "step", NULL};
    char path[4096], cells[3][32];
    if (!rk_driver_table(driver, "cubemap_filters", path, error))
        return false;
    for (uint32_t side = 2; side <= 256; side *= 2) {
        if (!paint_map(&driver->scene.environment, side, smooth_texel, error))
            return false;
        for (uint32_t filter = 0; filter < rk_cubemap_filter_names.count; filter++) {
            const rk_cubemap *map = &driver->scene.environment;
            snprintf(cells[0], sizeof cells[0], "%u", side);
            snprintf(cells[1], sizeof cells[1], "%.4g", error_of(map, (rk_cubemap_filter)filter));
            snprintf(cells[2], sizeof cells[2], "%.4g", step_of(map, (rk_cubemap_filter)filter));
            const char *row[] = {rk_cubemap_filter_names.items[filter], cells[0], cells[1],
                                 cells[2]};
            if (!rk_table_put(path, header, row, 4, 2, error))
                return false;
        }
    }
    return true;
}
