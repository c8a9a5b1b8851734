/* A sampler gives sample k of a pixel one number in [0, 1) for each dimension: the lens, the time,
 * a light and so on each read dimensions of their own. */
#ifndef RK_BASE_SAMPLER_H
#define RK_BASE_SAMPLER_H

#include "base/random.h"
#include "base/vec3.h"

typedef enum rk_sampler_kind {
    RK_SAMPLER_UNIFORM, /* independent, uniformly distributed */
} rk_sampler_kind;

/* Dimensions taken so far; each is the first of a pair. */
enum { RK_DIMENSION_PIXEL = 0 };

typedef struct rk_sampler {
    rk_sampler_kind kind;
    uint32_t seed;
} rk_sampler;

static inline float rk_sample_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                                 uint32_t dimension)
{
    return rk_unit_float(rk_hash(sampler->seed, pixel, sample, dimension));
}

static inline rk_vec2 rk_sample_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                                   uint32_t dimension)
{
    return (rk_vec2){rk_sample_1d(sampler, pixel, sample, dimension),
                     rk_sample_1d(sampler, pixel, sample, dimension + 1)};
}

#endif
