/* Vectors of three doubles, for differences that float would lose: corners seen from afar or from
 * the side nearly coincide. GLSL uses the same name. */
#ifndef RK_BASE_DVEC3_H
#define RK_BASE_DVEC3_H

#include "base/vec3.h"

typedef struct rk_dvec3 {
    double x, y, z;
} rk_dvec3;

static inline rk_dvec3 rk_widen(rk_vec3 a)
{
    return (rk_dvec3){(double)a.x, (double)a.y, (double)a.z};
}

static inline rk_vec3 rk_narrow(rk_dvec3 a)
{
    return rk_vec((float)a.x, (float)a.y, (float)a.z);
}

static inline rk_dvec3 rk_dscale(rk_dvec3 a, double s)
{
    return (rk_dvec3){a.x * s, a.y * s, a.z * s};
}

/* a + s b */
static inline rk_dvec3 rk_dmadd(rk_dvec3 a, rk_dvec3 b, double s)
{
    return (rk_dvec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static inline double rk_ddot(rk_dvec3 a, rk_dvec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline rk_dvec3 rk_dcross(rk_dvec3 a, rk_dvec3 b)
{
    return (rk_dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double rk_dlength(rk_dvec3 a)
{
    return sqrt(rk_ddot(a, a));
}

#endif
