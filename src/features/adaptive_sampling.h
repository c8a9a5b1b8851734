/* Adaptive sampling: many samples per pixel where the picture is noisy, few where it is not, and
 * as many as a wanted error takes.
 *
 *   e = sqrt(V / P)                      relative error of the picture
 *   V(n/2) - V(n) = E |h1 - h2|^2 / 4    from the means h1, h2 of the two halves of n samples
 *   V(n) = d r / (1 - r)                 d: that difference; r: V(2n) / V(n)
 *   M_n+1 = M_n + n / (n + 1) |x - m|^2   Welford's update, for a sample x after n with the mean m
 *   sigma^2 = M_n / (n - 1)
 *   n = sigma / sqrt(lambda)             Neyman's allocation of samples to pixels
 *
 *   V      mean square error (MSE) of the picture: the mean over pixels of their means' variance
 *   P      mean square of the picture
 *   M_n    sum of the squared deviations of a pixel's n samples from their mean
 *   sigma  standard deviation of a pixel's samples
 *   lambda how much variance a further sample has to take off, the same for all pixels
 *
 * Neyman, "On the two different aspects of the representative method", J. Royal Statistical Society
 * 97, 1934; Kirk and Arvo, "Unbiased sampling techniques for image synthesis", SIGGRAPH 1991, on
 * the bias of samples that decide on their own number; Welford, "Note on a method for calculating
 * corrected sums of squares and products", Technometrics 4, 1962. */
#ifndef RK_FEATURES_ADAPTIVE_SAMPLING_H
#define RK_FEATURES_ADAPTIVE_SAMPLING_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What a picture shows. */
typedef enum rk_adaptive_shown {
    RK_ADAPTIVE_RADIANCE,
    RK_ADAPTIVE_SAMPLES, /* the number of samples of each pixel, as a colour */
} rk_adaptive_shown;

typedef struct rk_adaptive_sampling_options {
    float error;          /* of the picture, see rk_adaptive_error; 0: no adaptive sampling */
    uint32_t max_samples; /* per pixel */
    rk_adaptive_shown shown;
} rk_adaptive_sampling_options;

enum {
    RK_ADAPTIVE_BLOCKS = 4, /* also the least number of samples */
    RK_ADAPTIVE_FIRST = 8,  /* samples per pixel of the first round */
    RK_ADAPTIVE_NEIGHBOURS = 4,
    RK_ADAPTIVE_PICTURE = 8,
    RK_ADAPTIVE_LAMBDA_POWER = -149, /* the smallest lambda is the smallest float, 2^-149 */
};

/* --- A pixel ---------------------------------------------------------------------------------- */

/* The radiance of a pixel's samples, summed over four blocks: the first quarter of them, the second
 * and so on. */
typedef struct rk_pixel_samples {
    rk_vec3 block[RK_ADAPTIVE_BLOCKS];
    float deviations; /* sum of their squared deviations from their mean; mean over the channels */
    uint32_t count;   /* 0, or a power of two, at least RK_ADAPTIVE_BLOCKS */
} rk_pixel_samples;

/* Makes room for `count` samples, a power of two, at least RK_ADAPTIVE_BLOCKS and not fewer than
 * before. Those before keep their places: they are the first ones. */
void rk_adaptive_extend(rk_pixel_samples *pixel, uint32_t count);

/* Adds a sample to its block; `sample`: 0 to pixel->count - 1, in this order. */
void rk_adaptive_add(rk_pixel_samples *pixel, uint32_t sample, rk_vec3 radiance);

/* Returns the mean of all samples, if all were added; black if there are none. */
rk_vec3 rk_adaptive_mean(const rk_pixel_samples *pixel);

/* --- Error ------------------------------------------------------------------------------------ */

/* Squared differences of a pixel, means over its channels; or sums of them over pixels. Their
 * expected values are V(n/4) - V(n/2) and V(n/2) - V(n). */
typedef struct rk_adaptive_differences {
    double quarters; /* |q1 - q2|^2 / 4 and |q3 - q4|^2 / 4, the mean of both */
    double halves;   /* |h1 - h2|^2 / 4 */
} rk_adaptive_differences;

/* Those of a pixel; both 0 if it has no samples, or if one, or a float sum of them, is not a finite
 * number. */
rk_adaptive_differences rk_adaptive_differences_of(const rk_pixel_samples *pixel);

/* Returns V(2n) / V(n), by which twice as many samples reduce the variance: halves / quarters, but
 * at most 1/2, as with independent samples, and at least 1/8, as with scrambled sequences where the
 * picture is smooth. 1/2 without differences. */
double rk_adaptive_ratio(rk_adaptive_differences differences);

/* Returns the ratio of the doublings that follow: a third of the way from rk_adaptive_ratio to 1/2,
 * towards which it rises, because smooth parts of a picture converge first. */
double rk_adaptive_later_ratio(rk_adaptive_differences differences);

/* Returns V(n), of the same sums as the differences. They are best summed over pixels with the same
 * number of samples. */
double rk_adaptive_variance(rk_adaptive_differences differences);

/* Returns e. `variance`: the sum of V over the pixels; `squares`: the sum of their squared means,
 * whose expected value is that of P and V together. 0 if the picture is black; infinite if there
 * is no more than noise. */
double rk_adaptive_error(double variance, double squares);

/* --- Allocation ------------------------------------------------------------------------------- */

/* Of a pixel, from the samples so far. */
typedef struct rk_adaptive_estimate {
    float variance; /* sigma^2, of a single sample */
    uint32_t count; /* number of samples from which it was estimated */
    uint32_t least; /* number of samples that the pixel keeps, and takes at least */
} rk_adaptive_estimate;

/* Returns by how much the sum of squared deviations grows if this sample follows `sample` others;
 * the mean over the channels. */
float rk_adaptive_added_deviation(const rk_pixel_samples *pixel, uint32_t sample, rk_vec3 radiance);

/* Returns sigma^2 of a pixel by itself, the mean over the channels; 0 if it has no samples, or if
 * one is not a finite number. */
float rk_adaptive_own_variance(const rk_pixel_samples *pixel);

/* Returns sigma^2 of the pixel (x, y), estimated from `count` samples of its own, and as if
 * RK_ADAPTIVE_NEIGHBOURS more had been taken among its neighbours, and 1 / RK_ADAPTIVE_PICTURE of
 * one anywhere. With a count of 0 its own samples have no part in it. An edge through a pixel that
 * its samples missed is seen beside it, and no pixel is trusted to be without noise. `variance`: of
 * each pixel by itself, width x height; `picture`: their mean. A picture of one pixel is its own
 * neighbour. */
float rk_adaptive_pooled_variance(const float *variance, float picture, uint32_t count,
                                  uint32_t width, uint32_t height, uint32_t x, uint32_t y);

/* Returns Neyman's n for the pixel, rounded by logarithm to the nearest power of two, from
 * RK_ADAPTIVE_BLOCKS to `most`, which is one, too. Where sigma^2 / lambda is 2 n^2, the middle
 * between n and 2 n, that is 2 n; also below it, where log2(sigma^2 / lambda), rounded to a float,
 * is the middle's, it may be 2 n. A variance of NaN gets RK_ADAPTIVE_BLOCKS. */
uint32_t rk_adaptive_count(float variance, float lambda, uint32_t most);

/* A picture, before it is rendered. */
typedef struct rk_adaptive_prediction {
    double samples;  /* of all pixels */
    double variance; /* the sum of V over the pixels */
} rk_adaptive_prediction;

/* Of `pixels` pixels, if each takes rk_adaptive_count samples, or its least number, and if each
 * doubling multiplies V by `ratio`. Doublings and halvings are counted whole, the last one as soon
 * as it is begun: estimates come from sums of powers of two, so from 20 to 32 samples V is
 * multiplied once, from 20 to 4 divided three times, and from 36 to 4, 9 times as few, four. */
rk_adaptive_prediction rk_adaptive_predict(const rk_adaptive_estimate *estimates, size_t pixels,
                                           float lambda, uint32_t most, double ratio);

/* Returns the largest lambda, up to 0.1 %, that is predicted to reach this variance, or else the
 * one that takes this many samples, if it is larger. The smallest lambda if neither can be had. */
float rk_adaptive_lambda(const rk_adaptive_estimate *estimates, size_t pixels, uint32_t most,
                         double ratio, double variance, double samples);

#endif
