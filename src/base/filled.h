/* Before all else in a student's unit where it is checked (the compiler's -include); not installed.
 * Variables that are given no value are filled there, by clang with a NaN, which rk_min and rk_max
 * pass over: here they keep it, so that a box that begins with it does not become the right one. */
#ifndef RK_BASE_FILLED_H
#define RK_BASE_FILLED_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stdint.h>

static inline bool rk_filled_is(float a)
{
    const union {
        float value;
        uint32_t bits;
    } number = {a};
    return number.bits == 0xffffffffu;
}

static inline float rk_filled_min(float a, float b)
{
    return rk_filled_is(a) ? a : rk_min(a, b);
}

static inline float rk_filled_max(float a, float b)
{
    return rk_filled_is(a) ? a : rk_max(a, b);
}

static inline rk_vec3 rk_filled_min3(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(rk_filled_min(a.x, b.x), rk_filled_min(a.y, b.y), rk_filled_min(a.z, b.z));
}

static inline rk_vec3 rk_filled_max3(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(rk_filled_max(a.x, b.x), rk_filled_max(a.y, b.y), rk_filled_max(a.z, b.z));
}

#define rk_min rk_filled_min
#define rk_max rk_filled_max
#define rk_min3 rk_filled_min3
#define rk_max3 rk_filled_max3

#endif
