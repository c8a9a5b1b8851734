/* Mirror reflection: the angle of reflection equals the angle of incidence. */
#ifndef RK_BASE_REFLECT_H
#define RK_BASE_REFLECT_H

#include "base/vec3.h"

/* Returns d - 2 (d.n) n, the direction d reflected by a mirror with the normal n. d: any length,
 * which is kept; n: unit, on either side of the mirror. */
static inline rk_vec3 rk_reflect(rk_vec3 d, rk_vec3 n)
{
    return rk_madd(d, n, -2 * rk_dot(d, n));
}

#endif
