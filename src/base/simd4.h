/* Four floats, one per lane, computed by one instruction. Each lane is rounded like a single float,
 * so results are the same to the bit. By the vector extensions of gcc and clang; by SSE, which
 * every x86-64 has, for operations that these lack. */
#ifndef RK_BASE_SIMD4_H
#define RK_BASE_SIMD4_H

#include "base/vec3.h"

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { RK_SIMD4_WIDTH = 4 };

typedef float rk_simd4 __attribute__((vector_size(16)));
typedef int32_t rk_simd4_mask __attribute__((vector_size(16))); /* all bits of a lane, or none */
typedef double rk_simd4_pair __attribute__((vector_size(16)));  /* two doubles in their place */

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

static inline rk_simd4 rk_simd4_sqrt(rk_simd4 a)
{
    return _mm_sqrt_ps(a);
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

static inline rk_simd4 rk_simd4_sqrt(rk_simd4 a)
{
    return (rk_simd4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}

static inline uint32_t rk_simd4_movemask(rk_simd4_mask mask)
{
    return (uint32_t)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}

#endif

static inline uint32_t rk_simd4_lt(rk_simd4 a, rk_simd4 b)
{
    return rk_simd4_movemask(a < b);
}

#if defined __clang__ || __GNUC__ >= 12
#define RK_SIMD4_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define RK_SIMD4_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, (rk_simd4_mask){i, j, k, l})
#endif

/* x, y, z, z */
static inline rk_simd4 rk_simd4_of(rk_vec3 a)
{
    return (rk_simd4){a.x, a.y, a.z, a.z};
}

static inline rk_vec3 rk_simd4_vec(rk_simd4 a)
{
    return rk_vec(a[0], a[1], a[2]);
}

/* x, y, z, 0: a vector from memory, and back, in few instructions. */
static inline rk_simd4 rk_simd4_load3(const rk_vec3 *a)
{
    double xy; /* 8 bytes */
    memcpy(&xy, a, sizeof xy);
    const rk_simd4_pair low = {xy, 0};
    const rk_simd4 z = {a->z, 0, 0, 0};
    return RK_SIMD4_SHUFFLE((rk_simd4)low, z, 0, 1, 4, 5);
}

static inline void rk_simd4_store3(rk_vec3 *a, rk_simd4 value)
{
    const rk_simd4_pair low = (rk_simd4_pair)value;
    const double xy = low[0];
    memcpy(a, &xy, sizeof xy);
    a->z = value[2];
}

static inline rk_simd4 rk_simd4_load(const float *four)
{
    rk_simd4 x;
    memcpy(&x, four, sizeof x);
    return x;
}

static inline void rk_simd4_store(float *four, rk_simd4 x)
{
    memcpy(four, &x, sizeof x);
}

/* Of four floats the first three or the last three, the third or the fourth twice. */
static inline rk_simd4 rk_simd4_first3(const float *four)
{
    rk_simd4 x = rk_simd4_load(four);
    return RK_SIMD4_SHUFFLE(x, x, 0, 1, 2, 2);
}

static inline rk_simd4 rk_simd4_last3(const float *four)
{
    rk_simd4 x = rk_simd4_load(four);
    return RK_SIMD4_SHUFFLE(x, x, 1, 2, 3, 3);
}

static inline float rk_simd4_largest(rk_simd4 a)
{
    rk_simd4 b = rk_simd4_max(a, RK_SIMD4_SHUFFLE(a, a, 2, 3, 2, 3));
    return rk_simd4_max(b, RK_SIMD4_SHUFFLE(b, b, 1, 1, 1, 1))[0];
}

static inline float rk_simd4_smallest(rk_simd4 a)
{
    rk_simd4 b = rk_simd4_min(a, RK_SIMD4_SHUFFLE(a, a, 2, 3, 2, 3));
    return rk_simd4_min(b, RK_SIMD4_SHUFFLE(b, b, 1, 1, 1, 1))[0];
}

static inline rk_simd4 rk_simd4_abs(rk_simd4 a)
{
    const rk_simd4_mask sign = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    return (rk_simd4)((rk_simd4_mask)a & ~sign);
}

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

/* The sum of the components' sizes. */
static inline rk_simd4 rk_simd4x3_size(rk_simd4x3 a)
{
    return rk_simd4_abs(a.x) + rk_simd4_abs(a.y) + rk_simd4_abs(a.z);
}

/* Row i becomes column i. */
static inline void rk_simd4_transpose(rk_simd4 rows[4])
{
    rk_simd4 low[2], high[2];
    for (int i = 0; i < 2; i++) {
        low[i] = RK_SIMD4_SHUFFLE(rows[2 * i], rows[2 * i + 1], 0, 4, 1, 5);
        high[i] = RK_SIMD4_SHUFFLE(rows[2 * i], rows[2 * i + 1], 2, 6, 3, 7);
    }
    rows[0] = RK_SIMD4_SHUFFLE(low[0], low[1], 0, 1, 4, 5);
    rows[1] = RK_SIMD4_SHUFFLE(low[0], low[1], 2, 3, 6, 7);
    rows[2] = RK_SIMD4_SHUFFLE(high[0], high[1], 0, 1, 4, 5);
    rows[3] = RK_SIMD4_SHUFFLE(high[0], high[1], 2, 3, 6, 7);
}

static inline rk_simd4x3 rk_simd4x3_load(const rk_vec3 *a, const rk_vec3 *b, const rk_vec3 *c,
                                         const rk_vec3 *d)
{
    rk_simd4 at[4] = {rk_simd4_load3(a), rk_simd4_load3(b), rk_simd4_load3(c), rk_simd4_load3(d)};
    rk_simd4_transpose(at);
    return (rk_simd4x3){at[0], at[1], at[2]};
}

/* Each as by rk_normalize. */
static inline rk_simd4x3 rk_simd4x3_normalize(rk_simd4x3 a)
{
    const rk_simd4 length = rk_simd4_sqrt(rk_simd4x3_dot(a, a)), one = rk_simd4_all(1);
    return rk_simd4x3_scale(a, rk_simd4_select(length > rk_simd4_all(0), one / length, one));
}

#endif
