/* Four numbers side by side, each in a lane of its own: what is done to them is done to all four at
 * once. Each lane is rounded as a single float is, so answers are the same to the bit. By the
 * vectors of gcc and clang, and by SSE, which every x86-64 has, where they have no word for it. */
#ifndef RK_ACCEL_SIMD4_H
#define RK_ACCEL_SIMD4_H

#include "base/vec3.h"

#include <stdint.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { RK_LANES = 4 };

typedef float rk_lanes __attribute__((vector_size(16)));
typedef int32_t rk_lane_mask __attribute__((vector_size(16))); /* all bits of a lane, or none */

static inline rk_lanes rk_lanes_all(float x)
{
    return (rk_lanes){x, x, x, x};
}

/* a where the mask is set, else b. */
static inline rk_lanes rk_lanes_choose(rk_lane_mask mask, rk_lanes a, rk_lanes b)
{
    return (rk_lanes)((mask & (rk_lane_mask)a) | (~mask & (rk_lane_mask)b));
}

#ifdef __SSE2__

/* As rk_min and rk_max: b where a is NaN. */
static inline rk_lanes rk_lanes_min(rk_lanes a, rk_lanes b)
{
    return _mm_min_ps(a, b);
}

static inline rk_lanes rk_lanes_max(rk_lanes a, rk_lanes b)
{
    return _mm_max_ps(a, b);
}

/* Bit i is set where lane i is. */
static inline uint32_t rk_lanes_set(rk_lane_mask mask)
{
    return (uint32_t)_mm_movemask_ps((rk_lanes)mask);
}

#else

static inline rk_lanes rk_lanes_min(rk_lanes a, rk_lanes b)
{
    return rk_lanes_choose(a < b, a, b);
}

static inline rk_lanes rk_lanes_max(rk_lanes a, rk_lanes b)
{
    return rk_lanes_choose(a > b, a, b);
}

static inline uint32_t rk_lanes_set(rk_lane_mask mask)
{
    return (uint32_t)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}

#endif

/* Four vectors. */
typedef struct rk_lanes3 {
    rk_lanes x, y, z;
} rk_lanes3;

static inline rk_lanes3 rk_lanes3_all(rk_vec3 a)
{
    return (rk_lanes3){rk_lanes_all(a.x), rk_lanes_all(a.y), rk_lanes_all(a.z)};
}

static inline void rk_lanes3_put(rk_lanes3 *a, uint32_t lane, rk_vec3 value)
{
    a->x[lane] = value.x;
    a->y[lane] = value.y;
    a->z[lane] = value.z;
}

static inline rk_lanes3 rk_lanes3_sub(rk_lanes3 a, rk_lanes3 b)
{
    return (rk_lanes3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline rk_lanes3 rk_lanes3_scale(rk_lanes3 a, rk_lanes s)
{
    return (rk_lanes3){a.x * s, a.y * s, a.z * s};
}

static inline rk_lanes rk_lanes3_dot(rk_lanes3 a, rk_lanes3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline rk_lanes3 rk_lanes3_cross(rk_lanes3 a, rk_lanes3 b)
{
    return (rk_lanes3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#endif
