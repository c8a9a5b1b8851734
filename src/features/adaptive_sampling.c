/* A picture is rendered in rounds. Each round estimates the variance of every pixel, and the next
 * one takes samples where it pays: n proportional to the standard deviation. Samples that decide
 * are thrown away, or else pixels that happened to look smooth would keep their error: a bias.
 *
 * The variance of means is estimated from the differences between halves and quarters of a pixel's
 * samples (the method of batch means: Law and Kelton, "Simulation modeling and analysis", 1982),
 * because low-discrepancy samples have a smaller error than independent ones with the same
 * variance. That takes sums over many pixels; which pixel is noisier than another is told by the
 * variance of its single samples. */
#include "features/adaptive_sampling.h"

#include <math.h>

/* Contents, in the order of the chapter. */
static double squared_difference(rk_vec3 a, rk_vec3 b, double count);
static float neighbours_mean(const float *variance, uint32_t width, uint32_t height, uint32_t x,
                             uint32_t y);
static bool is_enough(rk_adaptive_prediction p, double variance, double samples);

/* --- A pixel ---------------------------------------------------------------------------------- */

void rk_adaptive_extend(rk_pixel_samples *pixel, uint32_t count)
{
    rk_vec3 *block = pixel->block;
    if (pixel->count == 0)
        pixel->count = count;
    for (; pixel->count < count; pixel->count *= 2) {
        /* solution */
        block[0] = rk_add(block[0], block[1]);
        block[1] = rk_add(block[2], block[3]);
        block[2] = block[3] = rk_vec(0, 0, 0);
        /* starter
        // First step: the samples so far become the first half.
        end */
    }
}

void rk_adaptive_add(rk_pixel_samples *pixel, uint32_t sample, rk_vec3 radiance)
{
    pixel->deviations += rk_adaptive_added_deviation(pixel, sample, radiance);
    /* solution */
    uint32_t i = sample / (pixel->count / RK_ADAPTIVE_BLOCKS);
    pixel->block[i] = rk_add(pixel->block[i], radiance);
    /* starter
    // First step: the block of the sample.
    pixel->block[0] = rk_add(pixel->block[0], radiance);
    end */
}

rk_vec3 rk_adaptive_mean(const rk_pixel_samples *pixel)
{
    const rk_vec3 *block = pixel->block;
    rk_vec3 sum = rk_add(rk_add(block[0], block[1]), rk_add(block[2], block[3]));
    return pixel->count > 0 ? rk_scale(sum, 1 / (float)pixel->count) : rk_vec(0, 0, 0);
}

/* --- Error ------------------------------------------------------------------------------------ */

/* |a - b|^2 / 4 of the means of `count` samples each, from their sums; the mean over channels. */
static double squared_difference(rk_vec3 a, rk_vec3 b, double count)
{
    /* solution */
    double x = (double)a.x - (double)b.x, y = (double)a.y - (double)b.y;
    double z = (double)a.z - (double)b.z;
    return (x * x + y * y + z * z) / (3 * 4 * count * count);
    /* starter
    // Second step.
    return 0;
    end */
}

rk_adaptive_differences rk_adaptive_differences_of(const rk_pixel_samples *pixel)
{
    /* solution */
    const rk_vec3 *block = pixel->block;
    const double half = pixel->count / 2, quarter = pixel->count / 4;
    if (pixel->count == 0)
        return (rk_adaptive_differences){0, 0};
    rk_adaptive_differences d = {
        (squared_difference(block[0], block[1], quarter) +
         squared_difference(block[2], block[3], quarter)) /
            2,
        squared_difference(rk_add(block[0], block[1]), rk_add(block[2], block[3]), half)};
    bool are_finite = isfinite(d.quarters) && isfinite(d.halves);
    return are_finite ? d : (rk_adaptive_differences){0, 0};
    /* starter
    // Second step: of the means of quarters, and of the means of halves.
    return (rk_adaptive_differences){0, 0};
    end */
}

double rk_adaptive_ratio(rk_adaptive_differences differences)
{
    /* solution */
    if (!(differences.quarters > 0))
        return 0.5;
    return fmin(fmax(differences.halves / differences.quarters, 0.125), 0.5);
    /* starter
    // Third step: the halves' difference divided by the quarters', within its limits.
    return 0.5;
    end */
}

double rk_adaptive_later_ratio(rk_adaptive_differences differences)
{
    /* solution */
    return (2 * rk_adaptive_ratio(differences) + 0.5) / 3;
    /* starter
    // Third step: a third of the way from the ratio to 1/2.
    return 0.5;
    end */
}

/* V(n) - V(2n), V(2n) - V(4n) and so on add up to V(n): a geometric series, if each is r times the
 * one before. */
double rk_adaptive_variance(rk_adaptive_differences differences)
{
    /* solution */
    double ratio = rk_adaptive_later_ratio(differences);
    return differences.halves * ratio / (1 - ratio);
    /* starter
    // Third step: d r / (1 - r), with the later ratio as r.
    return 0;
    end */
}

double rk_adaptive_error(double variance, double squares)
{
    /* solution */
    if (!(variance > 0))
        return 0;
    return squares > variance ? sqrt(variance / (squares - variance)) : (double)INFINITY;
    /* starter
    // Third step: the root of V / P.
    return 0;
    end */
}

/* --- Allocation ------------------------------------------------------------------------------- */

float rk_adaptive_added_deviation(const rk_pixel_samples *pixel, uint32_t sample, rk_vec3 radiance)
{
    if (sample == 0)
        return 0;
    /* solution */
    const float n = (float)sample;
    const rk_vec3 *block = pixel->block;
    rk_vec3 mean = rk_scale(rk_add(rk_add(block[0], block[1]), rk_add(block[2], block[3])), 1 / n);
    rk_vec3 deviation = rk_sub(radiance, mean);
    return n / (n + 1) * rk_dot(deviation, deviation) / 3;
    /* starter
    // Fourth step: Welford's update, from the mean of the samples so far.
    return 0;
    end */
}

float rk_adaptive_own_variance(const rk_pixel_samples *pixel)
{
    /* solution */
    if (pixel->count == 0 || !isfinite(pixel->deviations))
        return 0;
    return pixel->deviations / (float)(pixel->count - 1);
    /* starter
    // Fourth step: the deviations' mean, with n - 1 in place of n.
    return 0;
    end */
}

static float neighbours_mean(const float *variance, uint32_t width, uint32_t height, uint32_t x,
                             uint32_t y)
{
    /* solution */
    const uint32_t left = x > 0 ? x - 1 : x, right = x + 1 < width ? x + 1 : x;
    const uint32_t top = y > 0 ? y - 1 : y, bottom = y + 1 < height ? y + 1 : y;
    float sum = 0;
    uint32_t pixels = 0;
    for (uint32_t j = top; j <= bottom; j++)
        for (uint32_t i = left; i <= right; i++)
            if (i != x || j != y) {
                sum += variance[(size_t)j * width + i];
                pixels++;
            }
    return pixels > 0 ? sum / (float)pixels : variance[0];
    /* starter
    // Fourth step: the mean of up to eight pixels, without (x, y) itself.
    return variance[(size_t)y * width + x];
    end */
}

float rk_adaptive_pooled_variance(const float *variance, float picture, uint32_t count,
                                  uint32_t width, uint32_t height, uint32_t x, uint32_t y)
{
    const float of_neighbours = RK_ADAPTIVE_NEIGHBOURS, of_picture = 1 / (float)RK_ADAPTIVE_PICTURE;
    const float own = variance[(size_t)y * width + x];
    const float around = neighbours_mean(variance, width, height, x, y);
    /* solution */
    float sum = (float)count * own + of_neighbours * around + of_picture * picture;
    return sum / ((float)count + of_neighbours + of_picture);
    /* starter
    // Fourth step: the mean of all three, weighted by the numbers of samples.
    return (own + around + picture) / 3 + 0 * of_neighbours * of_picture * (float)count;
    end */
}

uint32_t rk_adaptive_count(float variance, float lambda, uint32_t most)
{
    /* solution */
    uint32_t count = RK_ADAPTIVE_BLOCKS;
    /* By logarithm, sqrt(2) n is the middle between n and 2 n. */
    while (count < most && variance >= 2 * (float)count * (float)count * lambda)
        count *= 2;
    return count;
    /* starter
    // Fifth step: the root of variance / lambda, rounded to the nearest power of two, by logarithm.
    return most < RK_ADAPTIVE_FIRST ? most : RK_ADAPTIVE_FIRST;
    end */
}

rk_adaptive_prediction rk_adaptive_predict(const rk_adaptive_estimate *estimates, size_t pixels,
                                           float lambda, uint32_t most, double ratio)
{
    /* solution */
    rk_adaptive_prediction sum = {0, 0};
    for (size_t i = 0; i < pixels; i++) {
        uint32_t count = rk_adaptive_count(estimates[i].variance, lambda, most);
        if (count < estimates[i].least)
            count = estimates[i].least;
        double variance = (double)estimates[i].variance / estimates[i].count;
        for (uint64_t n = estimates[i].count; n < count; n *= 2)
            variance *= ratio;
        for (uint64_t n = count; n < estimates[i].count; n *= 2)
            variance /= ratio;
        sum.samples += count;
        sum.variance += variance;
    }
    return sum;
    /* starter
    // Fifth step: sums over the pixels.
    return (rk_adaptive_prediction){(double)pixels, 0};
    end */
}

static bool is_enough(rk_adaptive_prediction p, double variance, double samples)
{
    return p.variance <= variance || p.samples >= samples;
}

float rk_adaptive_lambda(const rk_adaptive_estimate *estimates, size_t pixels, uint32_t most,
                         double ratio, double variance, double samples)
{
    /* solution */
    float low = RK_ADAPTIVE_LAMBDA_POWER, high = 128; /* powers of two: all floats are between */
    while (high - low > 0x1p-10f) {
        float middle = (low + high) / 2;
        rk_adaptive_prediction p =
            rk_adaptive_predict(estimates, pixels, exp2f(middle), most, ratio);
        if (is_enough(p, variance, samples))
            low = middle;
        else
            high = middle;
    }
    return exp2f(low);
    /* starter
    // Sixth step: bisection.
    return 1;
    end */
}
