/* Random numbers one after the other, the same in every run. */
#ifndef RK_TESTS_NOISE_H
#define RK_TESTS_NOISE_H

#include "base/random.h"
#include "base/vec3.h"
#include "test.h"

typedef struct noise {
    uint32_t key, drawn;
} noise;

static inline float between(noise *n, float low, float high)
{
    return low + (high - low) * rk_unit_float(rk_case(n->key, n->drawn++, 3, 4));
}

/* In [-1, 1] along each axis. */
static inline rk_vec3 in_cube(noise *n)
{
    float x = between(n, -1, 1), y = between(n, -1, 1);
    return rk_vec(x, y, between(n, -1, 1));
}

#endif
