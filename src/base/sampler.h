/* A sampler gives sample k of a pixel one number in [0, 1) for each dimension: the lens, the time,
 * each light and so on read dimensions of their own. Numbers of different pixels or dimensions are
 * independent; numbers of one pixel and dimension are distributed according to the sampler's kind.
 * There is no state: a number depends only on pixel, sample and dimension. */
#ifndef RK_BASE_SAMPLER_H
#define RK_BASE_SAMPLER_H

#include "base/names.h"
#include "base/random.h"
#include "base/vec3.h"

typedef enum rk_sampler_kind {
    RK_SAMPLER_UNIFORM,         /* independent, uniformly distributed */
    RK_SAMPLER_STRATIFIED,      /* one in each of as many equal cells as there are samples */
    RK_SAMPLER_LOW_DISCREPANCY, /* a scrambled (0,2)-sequence: the first 2^k, for every k, have one
                                   in each cell of 2^-a x 2^-b, for every a + b = k */
    RK_SAMPLER_SOBOL,  /* the same, but dimensions of one pixel are joint: by rk_joint_2d of
                          features/sampling.h; the functions below know no joint dimensions */
    RK_SAMPLER_ZSOBOL, /* and pixels share it, in Z order, too: rk_joint_2d again */
} rk_sampler_kind;

/* Dimensions taken so far; each is the first of a pair. Lights take a pair for each light and
 * bounce, rough mirrors one for each bounce. A new feature needs none here: it has a block. */
enum {
    RK_DIMENSION_PIXEL = 0,
    RK_DIMENSION_LIGHT = 2,
    RK_DIMENSION_LENS = 1 << 16,
    RK_DIMENSION_GLOSSY = 1 << 17,
    RK_DIMENSION_TIME = 1 << 18,
    RK_DIMENSION_FEATURES = 1 << 19, /* a block for each feature: rk_feature_dimension */
    RK_DIMENSION_FURTHER = 1 << 20,  /* added to these for a pixel's further samples */
};

/* Cells can be halved down to 2^-24, the spacing of the samplers' numbers. */
enum { RK_SAMPLES_MAX = 1 << 24 };

/* The kinds' names in options, tables and names of pictures, such as "low-discrepancy". */
extern const rk_names rk_sampler_names;
const char *rk_sampler_name(rk_sampler_kind kind);

typedef struct rk_sampler {
    rk_sampler_kind kind;
    uint32_t seed;
    uint32_t samples; /* per pixel and dimension, 1 to RK_SAMPLES_MAX; the stratified kind and
                         zsobol need this number, and give no more samples */
    uint32_t width;   /* of the picture, whose pixels are numbered row by row; for zsobol */
} rk_sampler;

/* One number of `dimension`. A dimension is read either by rk_sample_1d or by rk_sample_2d: a pair
 * is distributed over the square, not as two single numbers. */
float rk_sample_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension);

/* A pair of numbers, from `dimension` and the next one. */
rk_vec2 rk_sample_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                     uint32_t dimension);

/* The pairs of samples `first` to `first + count - 1` of one pixel and dimension: the same as by
 * single calls, but faster. */
void rk_sample_2d_run(const rk_sampler *sampler, uint32_t pixel, uint32_t first, uint32_t count,
                      uint32_t dimension, rk_vec2 *pairs);

#endif
