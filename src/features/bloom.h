/* Bloom: what is bright glows into what is around it, as in a lens and in the eye.
 *
 *   luminance  Y = .2126 R + .7152 G + .0722 B (ITU-R BT.709)
 *   mask       the pixels with Y >= threshold; all others become 0
 *   filter     w_k = C(2r, r + k) / 4^r for k = -r .. r, along the rows, then along the columns
 *   result     image + intensity x filtered mask
 *
 * The w_k are a row of Pascal's triangle over its sum, so they sum to 1; their variance is r / 2.
 * Of pixels beyond the border a filter sees nothing (zero), what the border's pixel has (clamp), or
 * nothing, and its result is divided by the weights that remain (renormalise).
 *
 * Work is cut to the light: where no pixel of a row glows the row is not filtered, and taps whose
 * weights together cannot change a float are left out. All here is pure; post/bloom_stage.h has the
 * memory and the threads. */
#ifndef RK_FEATURES_BLOOM_H
#define RK_FEATURES_BLOOM_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum rk_bloom_border {
    RK_BLOOM_ZERO,
    RK_BLOOM_CLAMP,
    RK_BLOOM_RENORMALIZE,
} rk_bloom_border;

/* The filter itself, or one that is close to it and cheaper (post/blur.h). */
typedef enum rk_bloom_method {
    RK_BLOOM_EXACT,
    RK_BLOOM_GAUSSIAN,
    RK_BLOOM_RECURSIVE,
    RK_BLOOM_PYRAMID,
} rk_bloom_method;

enum { RK_BLOOM_RADIUS_MAX = 4096 };

typedef struct rk_bloom_options {
    bool on;
    float threshold; /* of the luminance */
    float intensity; /* 0 or more */
    uint32_t radius; /* pixels, up to RK_BLOOM_RADIUS_MAX */
    rk_bloom_border border;
    rk_bloom_method method;
} rk_bloom_options;

/* A symmetric filter. */
typedef struct rk_bloom_filter {
    uint32_t reach;       /* it sees so many pixels on either side; up to RK_BLOOM_RADIUS_MAX */
    const float *weights; /* of the pixels 0 .. reach away: reach + 1 values */
    rk_bloom_border border;
} rk_bloom_filter;

/* Pixels from `first` to before `end`. */
typedef struct rk_bloom_span {
    size_t first, end;
} rk_bloom_span;

/* Y; that of a grey is the grey, to the bit. */
float rk_bloom_luminance(rk_vec3 colour);

/* Is the luminance at or above the threshold? What is not finite never glows: it would take all
 * pixels around it along. */
bool rk_bloom_is_bright(rk_vec3 colour, float threshold);

/* From the first to the last pixel of the row that glows; empty (first == end) if none does. Looks
 * at no pixel between the two. */
rk_bloom_span rk_bloom_bright_span(const rk_vec3 *row, size_t width, float threshold);

/* w_0 .. w_radius: radius + 1 values, each the float that is nearest to the binomial weight. */
void rk_bloom_weights(uint32_t radius, float *weights);

/* The smallest reach at which the weights left out, of both sides together, sum to at most 2^-25,
 * half of an ulp below 1: filtered without them, no pixel changes by more than that share of the
 * brightest. It is about 3.9 sqrt(radius). */
uint32_t rk_bloom_reach(uint32_t radius, const float *weights);

/* The mask of the pixels from - reach to before from + count + reach of a row, of which those
 * beyond the border are the filter's affair; `masked` has room for count + 2 reach. Pixels outside
 * of `lit` do not glow and are not looked at. from + count <= width. */
void rk_bloom_bright_pass(const rk_bloom_filter *filter, const rk_vec3 *row, size_t width,
                          float threshold, rk_bloom_span lit, size_t from, size_t count,
                          rk_vec3 *masked);

/* The weights that fall on pixels of a line of `length`, for the pixel at `place`; renormalising
 * divides by it. */
float rk_bloom_weight_inside(const rk_bloom_filter *filter, size_t place, size_t length);

/* Floats that are filtered at a time: 16 pixels, or three lines of a cache. */
enum { RK_BLOOM_BLOCK = 48 };

/* sum[i] = sum over k of w_k lines[reach + k][i], for 0 <= i < count; count is a multiple of
 * RK_BLOOM_BLOCK. `lines` are 2 reach + 1, each `count` floats long; NULL is a line of zeros, which
 * costs nothing. To filter along columns, lines are rows, one below the other; to filter along a
 * row they are the same row, each a pixel further on. Returns how many lines were not NULL. */
uint32_t rk_bloom_blur_lines(const rk_bloom_filter *filter, const float *const *lines, size_t count,
                             float *restrict sum);

/* pixels[i] += gain x glow[i] for `count` floats. */
void rk_bloom_composite(float *restrict pixels, const float *restrict glow, size_t count,
                        float gain);

#endif
