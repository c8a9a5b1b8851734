/* How errors are distributed over the screen: their size after a blur, and their power by
 * frequency. Pictures of many seeds are compared with one of many samples. */
#include "driver.h"

#include "driver/convergence.h"

#include <complex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 16 };
static const double t_95 = 2.131; /* Student's t, of 15 degrees of freedom */

static const rk_sampler_kind kinds[] = {RK_SAMPLER_UNIFORM, RK_SAMPLER_STRATIFIED, RK_SAMPLER_SOBOL,
                                        RK_SAMPLER_ZSOBOL};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* --- The filter ------------------------------------------------------------------------------- */

enum { TAPS_MAX = 64 }; /* four standard deviations, each at most 16 pixels */

/* Along rows (step 1) or columns (step: the width). Weights within the picture have the sum 1. */
static void blur_line(rk_vec3 *pixels, size_t count, size_t step, const float *weights, size_t taps,
                      rk_vec3 *line)
{
    for (size_t i = 0; i < count; i++) {
        float total = 0;
        line[i] = rk_vec(0, 0, 0);
        for (size_t k = i > taps ? i - taps : 0; k < count && k <= i + taps; k++) {
            float weight = weights[k > i ? k - i : i - k];
            line[i] = rk_madd(line[i], pixels[k * step], weight);
            total += weight;
        }
        line[i] = rk_scale(line[i], 1 / total);
    }
    for (size_t i = 0; i < count; i++)
        pixels[i * step] = line[i];
}

bool blur_image(rk_image *image, float sigma, rk_error *error)
{
    float weights[TAPS_MAX + 1];
    const size_t taps = (size_t)ceilf(4 * sigma);
    const size_t longer = image->width > image->height ? image->width : image->height;
    rk_vec3 *line = rk_allocate_unset(longer, sizeof *line, "a line of the picture", error);
    if (!line)
        return false;
    for (size_t i = 0; i <= taps; i++)
        weights[i] = expf(-(float)(i * i) / (2 * sigma * sigma));
    for (size_t y = 0; y < image->height; y++)
        blur_line(rk_image_at(image, 0, y), image->width, 1, weights, taps, line);
    for (size_t x = 0; x < image->width; x++)
        blur_line(rk_image_at(image, x, 0), image->height, image->width, weights, taps, line);
    free(line);
    return true;
}

/* --- Errors of many seeds --------------------------------------------------------------------- */

double mean_square(const rk_image *image)
{
    double squares = 0;
    for (size_t i = 0; i < image->width * image->height; i++)
        for (int axis = 0; axis < 3; axis++)
            squares +=
                (double)rk_axis(image->pixels[i], axis) * (double)rk_axis(image->pixels[i], axis);
    return squares / (3 * (double)(image->width * image->height));
}

/* A picture of the reference, and its root mean square. */
static bool render_truth(rk_driver *driver, rk_image *want, double *rms, rk_error *error)
{
    const choices *c = driver->choices;
    set_samples(driver, RK_SAMPLER_SOBOL, c->reference);
    if (!rk_convergence_reference(driver, want, error))
        return false;
    *rms = sqrt(mean_square(want));
    return true;
}

/* Renders into the driver's image, and subtracts the truth. */
static bool render_error(rk_driver *driver, uint32_t seed, const rk_image *want, rk_error *error)
{
    driver->render.seed += seed;
    bool ok = rk_driver_render(driver, error);
    driver->render.seed -= seed;
    for (size_t i = 0; ok && i < want->width * want->height; i++)
        driver->image.pixels[i] = rk_sub(driver->image.pixels[i], want->pixels[i]);
    return ok;
}

/* --- Errors after a blur ---------------------------------------------------------------------- */

enum { BLURS = 3 };
static const float blurs[BLURS] = {0, 1, 2}; /* standard deviations, pixels */

/* The root of the mean square over the seeds, in per cent, and half of its 95 % interval. */
static void print_error(char text[48], const double squares[SEEDS], double rms)
{
    double mean = 0, variance = 0;
    for (int i = 0; i < SEEDS; i++)
        mean += squares[i] / SEEDS;
    for (int i = 0; i < SEEDS; i++)
        variance += (squares[i] - mean) * (squares[i] - mean) / (SEEDS - 1) / SEEDS;
    double error = 100 * sqrt(mean) / rms;
    snprintf(text, 48, "%.2f ± %.2f", error, t_95 * error * sqrt(variance) / mean / 2);
}

static bool put_kind(rk_driver *driver, rk_sampler_kind kind, uint32_t samples,
                     const rk_image *want, double rms, rk_error *error)
{
    static const char *const header[] = {"effect",    "samples",   "kind", "single",
                                         "blurred_1", "blurred_2", NULL};
    const choices *c = driver->choices;
    double squares[BLURS][SEEDS];
    char path[4096], number[16], text[BLURS][48];
    set_samples(driver, kind, samples);
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        if (!render_error(driver, seed, want, error))
            return false;
        /* One blur after the other: their variances add up. */
        for (int k = 0; k < BLURS; k++) {
            float more = k ? sqrtf(blurs[k] * blurs[k] - blurs[k - 1] * blurs[k - 1]) : 0;
            if (more > 0 && !blur_image(&driver->image, more, error))
                return false;
            squares[k][seed] = mean_square(&driver->image);
        }
    }
    for (int k = 0; k < BLURS; k++)
        print_error(text[k], squares[k], rms);
    snprintf(number, sizeof number, "%u", samples);
    const char *row[] = {
        effect_names.items[c->effect], number, rk_sampler_name(kind), text[0], text[1], text[2]};
    return rk_driver_table(driver, "sampling_blurred", path, error) &&
           rk_table_put(path, header, row, 6, 3, error);
}

bool put_blurred(rk_driver *driver, rk_error *error)
{
    static const uint32_t numbers[] = {1, 2, 3, 4, 6, 8, 16};
    rk_image want;
    double rms;
    if (!render_truth(driver, &want, &rms, error))
        return false;
    bool ok = true;
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++)
        for (int k = 0; ok && k < KINDS; k++)
            ok = put_kind(driver, kinds[k], numbers[n], &want, rms, error);
    rk_image_free(&want);
    return ok;
}

/* --- Power by frequency ----------------------------------------------------------------------- */

enum { SIDE_MAX = 128 }; /* of the square from which frequencies are taken */

typedef struct spectrum {
    size_t side;
    double complex roots[SIDE_MAX]; /* of unity */
    double complex values[SIDE_MAX * SIDE_MAX];
    double power[SIDE_MAX / 2 + 1]; /* by cycles along the side, up to the Nyquist frequency */
    double counts[SIDE_MAX / 2 + 1];
} spectrum;

/* The discrete Fourier transform along a line, by its definition. */
static void transform(spectrum *s, double complex *line, size_t step)
{
    double complex sums[SIDE_MAX] = {0};
    for (size_t k = 0; k < s->side; k++)
        for (size_t i = 0; i < s->side; i++)
            sums[k] += s->roots[i * k % s->side] * line[i * step];
    for (size_t k = 0; k < s->side; k++)
        line[k * step] = sums[k];
}

/* Adds the power of the image's green, by the distance from frequency 0. */
static void add_power(spectrum *s, const rk_image *image)
{
    const size_t n = s->side;
    for (size_t i = 0; i < n * n; i++)
        s->values[i] = (double)rk_image_at(image, i % n, i / n)->y;
    for (size_t i = 0; i < n; i++)
        transform(s, s->values + i * n, 1);
    for (size_t i = 0; i < n; i++)
        transform(s, s->values + i, n);
    for (size_t i = 1; i < n * n; i++) {
        size_t x = i % n, y = i / n;
        size_t at =
            (size_t)lround(hypot((double)(x < n - x ? x : n - x), (double)(y < n - y ? y : n - y)));
        if (at > n / 2)
            continue;
        s->power[at] +=
            creal(s->values[i]) * creal(s->values[i]) + cimag(s->values[i]) * cimag(s->values[i]);
        s->counts[at]++;
    }
}

/* White noise has the same power at all frequencies: 1, as it is divided by its mean. */
static bool put_power(rk_driver *driver, const spectrum *s, const char *kind, double white,
                      rk_error *error)
{
    static const char *const header[] = {"effect", "samples", "kind", "frequency", "power", NULL};
    const choices *c = driver->choices;
    char path[4096], number[16], frequency[24], power[24];
    bool ok = rk_driver_table(driver, "sampling_spectrum", path, error);
    snprintf(number, sizeof number, "%u", c->samples);
    for (size_t i = 1; ok && i <= s->side / 2; i++) {
        snprintf(frequency, sizeof frequency, "%.4f", (double)i / (double)s->side);
        snprintf(power, sizeof power, "%.4g", s->power[i] / s->counts[i] / white);
        const char *row[] = {effect_names.items[c->effect], number, kind, frequency, power};
        ok = rk_table_put(path, header, row, 5, 4, error);
    }
    return ok;
}

static bool put_kinds_power(rk_driver *driver, spectrum *s, const rk_image *want, rk_error *error)
{
    const choices *c = driver->choices;
    double white = 0;
    for (int k = 0; k < KINDS; k++) {
        memset(s->power, 0, sizeof s->power);
        memset(s->counts, 0, sizeof s->counts);
        set_samples(driver, kinds[k], c->samples);
        for (uint32_t seed = 0; seed < SEEDS; seed++) {
            if (!render_error(driver, seed, want, error))
                return false;
            add_power(s, &driver->image);
        }
        for (size_t i = 1; k == 0 && i <= s->side / 2; i++) /* of independent samples */
            white += s->power[i] / s->counts[i] / (double)(s->side / 2);
        if (!put_power(driver, s, rk_sampler_name(kinds[k]), white, error))
            return false;
    }
    return true;
}

bool put_spectrum(rk_driver *driver, rk_error *error)
{
    rk_image want;
    double rms;
    const size_t width = driver->image.width, height = driver->image.height;
    if (width != height || width < 2 || width > SIDE_MAX)
        return rk_fail(error,
                       "the picture is %zu x %zu pixels, but --spectrum takes a square of 2 to %d "
                       "pixels on a side",
                       width, height, SIDE_MAX);
    spectrum *s = rk_allocate(1, sizeof *s, "a spectrum", error);
    if (!s)
        return false;
    s->side = width;
    for (size_t i = 0; i < width; i++)
        s->roots[i] = cexp(-2 * RK_PI_DOUBLE * I * (double)i / (double)width);
    bool ok = render_truth(driver, &want, &rms, error);
    if (ok) {
        ok = put_kinds_power(driver, s, &want, error);
        rk_image_free(&want);
    }
    free(s);
    return ok;
}
