/* Interpolates values at a triangle's corners by the barycentric weights of a point in it. */
#ifndef RK_BASE_INTERPOLATE_H
#define RK_BASE_INTERPOLATE_H

#include "base/vec3.h"

/* weights: of a, b and c, sum 1. At a corner, where its weight is 1 and the others are 0, the
 * result is that corner's value to the bit. */
static inline rk_vec3 rk_interpolate3(rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 weights)
{
    return rk_madd(rk_madd(rk_scale(a, weights.x), b, weights.y), c, weights.z);
}

static inline rk_vec2 rk_interpolate2(rk_vec2 a, rk_vec2 b, rk_vec2 c, rk_vec3 weights)
{
    return (rk_vec2){a.x * weights.x + b.x * weights.y + c.x * weights.z,
                     a.y * weights.x + b.y * weights.y + c.y * weights.z};
}

#endif
