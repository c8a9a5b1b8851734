/* What the fast builder (accel/build/bvh_parts.h) keeps of a triangle, and the bins of its centre.
 * Not installed. */
#ifndef RK_ACCEL_BUILD_BVH_REFERENCE_H
#define RK_ACCEL_BUILD_BVH_REFERENCE_H

#include "base/simd4.h"

#include <math.h>

/* The box around a triangle. The fourth numbers are the lower and the upper half of its index:
 * whole numbers, because its bits would be a denormal float, which is slow to compute with. */
typedef struct reference {
    rk_simd4 low, high;
} reference;

typedef struct bounds {
    rk_simd4 low, high;
} bounds;

static const bounds nothing = {{INFINITY, INFINITY, INFINITY, INFINITY},
                               {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};

static inline bounds merge(bounds a, bounds b)
{
    return (bounds){rk_simd4_min(a.low, b.low), rk_simd4_max(a.high, b.high)};
}

static inline bounds add_point(bounds a, rk_simd4 x)
{
    return merge(a, (bounds){x, x});
}

/* A quarter of the corners' sum, so that no sum or extent overflows. */
static inline rk_simd4 centre_of(const reference *r)
{
    const rk_simd4 quarter = rk_simd4_all(0.25f);
    return r->low * quarter + r->high * quarter;
}

/* From a centre to its bins. */
typedef struct binning {
    int bins;
    rk_simd4 low, scale;
    rk_simd4_mask usable; /* axes on which centres differ */
} binning;

static inline rk_simd4_mask bins_of(const binning *b, rk_simd4 centre)
{
    return __builtin_convertvector((centre - b->low) * b->scale, rk_simd4_mask);
}

#endif
