/* Bloom: bright pixels spread light over their neighbours, as in a lens and in the eye.
 *
 *   luminance  Y = .2126 R + .7152 G + .0722 B (ITU-R BT.709)
 *   mask       the pixels with Y >= threshold; all others become 0
 *   filter     w_k = C(2r, r + k) / 4^r for k = -r .. r, along the rows, then along the columns
 *   result     image + intensity x filtered mask
 *
 * The w_k are a row of Pascal's triangle over its sum, so they sum to 1; their variance is r / 2.
 * Beyond the border the filter takes black (zero), the border's own pixel (clamp), or leaves those
 * taps out and divides by the weights that remain (renormalize).
 *
 * Only light costs time: rows without a bright pixel are not filtered, and taps whose weights
 * together cannot change a float are left out. Everything here is pure; post/bloom_stage.h has the
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
    uint32_t reach;       /* pixels on either side of the middle, up to RK_BLOOM_RADIUS_MAX */
    const float *weights; /* of the pixels 0 .. reach away: reach + 1 values */
    rk_bloom_border border;
} rk_bloom_filter;

/* Pixels from `first` to before `end`. */
typedef struct rk_bloom_span {
    size_t first, end;
} rk_bloom_span;

/* Returns Y; for a grey, the grey itself, to the bit. */
float rk_bloom_luminance(rk_vec3 colour);

/* A sum of two colours up to this one is finite. */
#define RK_BLOOM_BRIGHTEST 0x1p126f

/* Is the luminance at or above the threshold? Never true for pixels of which a colour is NaN, or
 * larger than RK_BLOOM_BRIGHTEST, or smaller than its opposite: blurred, they would spoil all
 * pixels around them. */
bool rk_bloom_is_bright(rk_vec3 colour, float threshold);

/* Returns the span from the row's first to its last bright pixel; empty (first == end) if there is
 * none. Reads no pixel between the two. */
rk_bloom_span rk_bloom_bright_span(const rk_vec3 *row, size_t width, float threshold);

/* Fills in w_0 .. w_radius: radius + 1 values, each the float nearest to the binomial weight,
 * of two equally near ones the even one. */
void rk_bloom_weights(uint32_t radius, float *weights);

/* Returns the smallest reach at which the weights left out, of both sides together, sum to at most
 * 2^-25, half of an ulp below 1: filtered without them, no pixel changes by more than that fraction
 * of the brightest. It is about 3.9 sqrt(radius). */
uint32_t rk_bloom_reach(uint32_t radius, const float *weights);

/* Fills in the mask of a row's pixels, from - reach to before from + count + reach; beyond the
 * border, by filter->border. `masked`: count + 2 reach values. Pixels outside of `bright` are dark
 * and are not read. from + count <= width. */
void rk_bloom_bright_pass(const rk_bloom_filter *filter, const rk_vec3 *row, size_t width,
                          float threshold, rk_bloom_span bright, size_t from, size_t count,
                          rk_vec3 *masked);

/* Returns the sum, to an ulp, of the weights that fall inside a line of `length` pixels, for the
 * pixel at `place`; renormalizing divides by it. */
float rk_bloom_weight_inside(const rk_bloom_filter *filter, size_t place, size_t length);

/* Floats that are filtered at a time: 16 pixels, or three cache lines. */
enum { RK_BLOOM_BLOCK = 48 };

/* sum[i] = sum over k of w_k lines[reach + k][i], for 0 <= i < count; count is a multiple of
 * RK_BLOOM_BLOCK. `lines`: 2 reach + 1 pointers, each to `count` floats; NULL is a line of zeros,
 * which costs nothing. To filter along columns, the lines are successive rows; to filter along a
 * row, they are the same row, each one pixel further on. Returns the number of lines that are not
 * NULL. It is called for each strip of the picture, and allocates nothing. */
uint32_t rk_bloom_blur_lines(const rk_bloom_filter *filter, const float *const *lines, size_t count,
                             float *sum);

/* pixels[i] += gain x blurred[i] for `count` floats. */
void rk_bloom_composite(float *pixels, const float *blurred, size_t count, float gain);

#endif
