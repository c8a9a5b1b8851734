/* The table of --efficiency: samples per pixel for the same error. The best allocation follows from
 * the true variance of each pixel: the mean square error over many pictures, at each power of two.
 * It is found from one half of the pictures and measured with the other, or it would pick pixels
 * that were lucky. In two ways, and the better one counts: by each level's own variances, and by a
 * power of the number of samples that is fitted to all levels, which has less noise. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>
#include <stdlib.h>

enum {
    levels = 6,
    least_level = 2,
    levels_beyond = 5
}; /* 4 to 128 samples, and more by the slope */

static const double errors[] = {0.02, 0.01};

typedef struct study {
    rk_driver *driver;
    size_t pixels;
    rk_image reference;
    float *variances[levels][2]; /* of each pixel, from the even and from the odd seeds */
    double even[levels];         /* sum of the variances over the pixels */
    double squares;              /* of the reference */
} study;

static double square(rk_vec3 v)
{
    return (double)rk_dot(v, v) / 3;
}

/* The same number of samples in each pixel, for each effect. */
static bool render_evenly(rk_driver *driver, uint32_t samples, uint32_t seed, rk_error *error)
{
    const rk_render_options usual = driver->render;
    rk_render_options *o = &driver->render;
    o->adaptive_sampling.error = 0;
    o->samples = samples;
    o->lens_samples = usual.lens_samples > 0 ? samples : 0;
    o->motion.samples = usual.motion.samples > 0 ? samples : 0;
    o->motion.sampling = RK_TIME_LOW_DISCREPANCY;
    o->seed = seed;
    bool ok = rk_driver_render(driver, error);
    driver->render = usual;
    return ok;
}

/* Adds the squared errors of driver->image to `sums` (may be NULL); returns their sum. */
static double add_errors(const study *s, float *sums, double weight)
{
    double all = 0;
    for (size_t i = 0; i < s->pixels; i++) {
        double e = weight * square(rk_sub(s->driver->image.pixels[i], s->reference.pixels[i]));
        if (sums)
            sums[i] += (float)e;
        all += e;
    }
    return all;
}

static bool measure_pixels(study *s, rk_error *error)
{
    const uint32_t seeds = ((const choices *)s->driver->choices)->seeds / 2 * 2;
    for (uint32_t level = 0; level < levels; level++)
        for (uint32_t seed = 0; seed < seeds; seed++) {
            if (!render_evenly(s->driver, 1u << (least_level + level), 1 + seed, error))
                return false;
            s->even[level] += add_errors(s, s->variances[level][seed % 2], 2.0 / seeds) / 2;
        }
    return true;
}

/* --- The best allocation ---------------------------------------------------------------------- */

/* What a pixel's variance falls by with each doubling beyond the levels. */
static double slope_of(const study *s)
{
    return sqrt(s->even[levels - 1] / s->even[levels - 3]);
}

static double variance_at(const study *s, uint32_t level, int half, size_t pixel, double slope)
{
    uint32_t last = level < levels ? level : levels - 1;
    return (double)s->variances[last][half][pixel] * pow(slope, level - last);
}

/* Evenly distributed samples for this variance, interpolated between powers of two. */
static double even_samples(const study *s, double variance)
{
    uint32_t i = 0;
    while (i + 2 < levels && s->even[i + 1] > variance)
        i++;
    double doublings = log(s->even[i] / variance) / log(s->even[i] / s->even[i + 1]);
    return exp2(least_level + i + doublings);
}

/* V = c n^-a, with the same a for all pixels; the mean of c over the levels. */
static double fitted_variance(const study *s, uint32_t level, int half, size_t pixel, double slope)
{
    double sum = 0;
    for (uint32_t i = 0; i < levels; i++)
        sum += (double)s->variances[i][half][pixel] * pow(slope, (double)level - i);
    return sum / levels;
}

typedef double variance_of(const study *s, uint32_t level, int half, size_t pixel, double slope);

typedef struct allocation {
    double samples, variance;
} allocation;

static allocation allocate(const study *s, variance_of *expected, double lambda)
{
    const double slope = slope_of(s);
    allocation sum = {0, 0};
    for (int half = 0; half < 2; half++)
        for (size_t i = 0; i < s->pixels; i++) {
            uint32_t best = 0;
            double least = (double)INFINITY;
            for (uint32_t level = 0; level < levels + levels_beyond; level++) {
                double cost =
                    expected(s, level, half, i, slope) + lambda * (1u << (least_level + level));
                if (cost < least) {
                    least = cost;
                    best = level;
                }
            }
            sum.samples += (1u << (least_level + best)) / 2.0;
            sum.variance += variance_at(s, best, 1 - half, i, slope) / 2;
        }
    return sum;
}

/* Neyman's, as the renderer would take them if it knew the fitted variances. */
static allocation allocate_by_deviation(const study *s, float lambda)
{
    const double slope = slope_of(s);
    allocation sum = {0, 0};
    for (int half = 0; half < 2; half++)
        for (size_t i = 0; i < s->pixels; i++) {
            float variance = (float)fitted_variance(s, 0, half, i, slope);
            uint32_t count = rk_adaptive_count(variance, lambda, RK_SAMPLES_MAX);
            uint32_t level = (uint32_t)ilogbf((float)count) - least_level;
            sum.samples += count / 2.0;
            sum.variance += variance_at(s, level, 1 - half, i, slope) / 2;
        }
    return sum;
}

/* The samples for at most this variance if the first round, which is thrown away, had no noise. */
static double known_of(const study *s, double variance)
{
    double fewest = (double)INFINITY;
    for (float power = -80; power < 0; power += 0.125f) {
        allocation a = allocate_by_deviation(s, exp2f(power));
        if (a.variance <= variance)
            fewest = fmin(fewest, a.samples);
    }
    return fewest + RK_ADAPTIVE_FIRST * (double)s->pixels;
}

/* The fewest samples with at most this variance. */
static double bound_of(const study *s, double variance)
{
    variance_of *const ways[] = {variance_at, fitted_variance};
    double fewest = even_samples(s, variance) * (double)s->pixels;
    for (int i = 0; i < 2; i++)
        for (double power = -60; power < 0; power += 0.25) {
            allocation a = allocate(s, ways[i], exp2(power));
            if (a.variance <= variance)
                fewest = fmin(fewest, a.samples);
        }
    return fewest;
}

/* --- Rows ------------------------------------------------------------------------------------- */

static bool put_row(study *s, double wanted, rk_error *error)
{
    rk_driver *driver = s->driver;
    const uint32_t seeds = ((const choices *)driver->choices)->seeds;
    const rk_render_options usual = driver->render;
    double samples = 0, variance = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        driver->render.adaptive_sampling.error = (float)wanted;
        driver->render.seed = 100 + seed;
        if (!rk_driver_render(driver, error))
            return false;
        samples += (double)driver->counters.taken_samples / (double)s->pixels / seeds;
        variance += add_errors(s, NULL, 1.0 / seeds);
    }
    driver->render = usual;
    const double even = even_samples(s, variance);
    const double bound = bound_of(s, variance) / (double)s->pixels;
    const double known = known_of(s, variance) / (double)s->pixels;
    char path[4096], cells[9][64];
    snprintf(cells[0], 64, "%s", ((const choices *)driver->choices)->effect);
    snprintf(cells[1], 64, "%.2g %%", 100 * wanted);
    snprintf(cells[2], 64, "%.3g %%", 100 * sqrt(variance / s->squares));
    snprintf(cells[3], 64, "%.1f", even);
    snprintf(cells[4], 64, "%.1f", samples);
    snprintf(cells[5], 64, "%.1f", known);
    snprintf(cells[6], 64, "%.1f", bound);
    snprintf(cells[7], 64, "%.2f", even / samples);
    snprintf(cells[8], 64, "%.0f %%", 100 * bound / samples);
    const char *const header[] = {"effect", "error", "reached", "even", "adaptive",
                                  "known",  "bound", "gain",    "share"};
    const char *row[9];
    for (int i = 0; i < 9; i++)
        row[i] = cells[i];
    return rk_driver_table(driver, "adaptive_sampling_efficiency", path, error) &&
           rk_table_put(path, header, row, 9, 2, error);
}

static bool allocate_study(study *s, rk_error *error)
{
    for (int level = 0; level < levels; level++)
        for (int half = 0; half < 2; half++)
            if (!(s->variances[level][half] =
                      rk_allocate(s->pixels, sizeof(float), "study", error)))
                return false;
    return true;
}

bool put_efficiency(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    study s = {.driver = driver, .pixels = (size_t)driver->render.width * driver->render.height};
    bool ok = render_evenly(driver, c->reference, UINT32_MAX, error) &&
              rk_image_init(&s.reference, driver->image.width, driver->image.height, error);
    for (size_t i = 0; ok && i < s.pixels; i++) {
        s.reference.pixels[i] = driver->image.pixels[i];
        s.squares += square(s.reference.pixels[i]);
    }
    ok = ok && allocate_study(&s, error) && measure_pixels(&s, error);
    for (size_t i = 0; ok && i < sizeof errors / sizeof *errors; i++)
        ok = put_row(&s, errors[i], error);
    for (int level = 0; level < levels; level++)
        for (int half = 0; half < 2; half++)
            free(s.variances[level][half]);
    rk_image_free(&s.reference);
    return ok;
}
