/* Four floats, one per lane, computed by one instruction. Each lane is rounded like a single float,
 * so results are the same to the bit. By the vector extensions of gcc and clang; by SSE, which
 * every x86-64 has, for operations that these lack; not installed. */
#ifndef RK_ACCEL_SIMD4_H
#define RK_ACCEL_SIMD4_H

#include "base/vec3.h"

#include <stdint.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { RK_SIMD4_WIDTH = 4 };

typedef float rk_simd4 __attribute__((vector_size(16)));
typedef int32_t rk_simd4_mask __attribute__((vector_size(16))); /* all bits of a lane, or none */

static inline rk_simd4 rk_simd4_all(float x)
{
    return (rk_simd4){x, x, x, x};
}

/* a where the mask is set, else b. */
static inline rk_simd4 rk_simd4_select(rk_simd4_mask mask, rk_simd4 a, rk_simd4 b)
{
    return (rk_simd4)((mask & (rk_simd4_mask)a) | (~mask & (rk_simd4_mask)b));
}

#ifdef __SSE2__

/* Like rk_min and rk_max: b where a is NaN. */
static inline rk_simd4 rk_simd4_min(rk_simd4 a, rk_simd4 b)
{
    return _mm_min_ps(a, b);
}

static inline rk_simd4 rk_simd4_max(rk_simd4 a, rk_simd4 b)
{
    return _mm_max_ps(a, b);
}

/* Bit i of the result is set if lane i is. */
static inline uint32_t rk_simd4_movemask(rk_simd4_mask mask)
{
    return (uint32_t)_mm_movemask_ps((rk_simd4)mask);
}

#else

static inline rk_simd4 rk_simd4_min(rk_simd4 a, rk_simd4 b)
{
    return rk_simd4_select(a < b, a, b);
}

static inline rk_simd4 rk_simd4_max(rk_simd4 a, rk_simd4 b)
{
    return rk_simd4_select(a > b, a, b);
}

static inline uint32_t rk_simd4_movemask(rk_simd4_mask mask)
{
    return (uint32_t)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}

#endif

/* Four vectors. */
typedef struct rk_simd4x3 {
    rk_simd4 x, y, z;
} rk_simd4x3;

static inline rk_simd4x3 rk_simd4x3_all(rk_vec3 a)
{
    return (rk_simd4x3){rk_simd4_all(a.x), rk_simd4_all(a.y), rk_simd4_all(a.z)};
}

static inline void rk_simd4x3_put(rk_simd4x3 *a, uint32_t lane, rk_vec3 value)
{
    a->x[lane] = value.x;
    a->y[lane] = value.y;
    a->z[lane] = value.z;
}

static inline rk_simd4x3 rk_simd4x3_sub(rk_simd4x3 a, rk_simd4x3 b)
{
    return (rk_simd4x3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline rk_simd4x3 rk_simd4x3_scale(rk_simd4x3 a, rk_simd4 s)
{
    return (rk_simd4x3){a.x * s, a.y * s, a.z * s};
}

static inline rk_simd4 rk_simd4x3_dot(rk_simd4x3 a, rk_simd4x3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline rk_simd4x3 rk_simd4x3_cross(rk_simd4x3 a, rk_simd4x3 b)
{
    return (rk_simd4x3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#endif
