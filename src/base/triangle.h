/* A triangle as the leaves of a tree keep it; features/watertight.h decides which rays hit it. */
#ifndef RK_BASE_TRIANGLE_H
#define RK_BASE_TRIANGLE_H

#include "base/dvec3.h"
#include "base/vec3.h"

#include <stdint.h>

/* The corners are the mesh's to the bit, so that neighbours agree on the edge that they share. The
 * index is the triangle's in its mesh. 40 bytes, contiguous within a leaf. */
typedef struct rk_triangle {
    rk_vec3 a, b, c;
    uint32_t index;
} rk_triangle;

/* The sum of the components' sizes. */
static inline double rk_dvec3_size(rk_dvec3 a)
{
    return fabs(a.x) + fabs(a.y) + fabs(a.z);
}

/* The plane of a triangle, in double. */
typedef struct rk_triangle_plane {
    rk_dvec3 a, normal;
    double edges; /* the product of both edges' sizes; bounds the normal's terms */
} rk_triangle_plane;

static inline rk_triangle_plane rk_triangle_plane_of(const rk_triangle *triangle)
{
    rk_dvec3 a = rk_widen(triangle->a), ab = rk_dmadd(rk_widen(triangle->b), a, -1);
    rk_dvec3 ac = rk_dmadd(rk_widen(triangle->c), a, -1);
    return (rk_triangle_plane){a, rk_dcross(ab, ac), rk_dvec3_size(ab) * rk_dvec3_size(ac)};
}

/* Returns v . normal, or 0 where rounding could change its sign: there are fewer than 16 roundings
 * (Higham 2002, section 3.1). */
static inline double rk_triangle_plane_dot(const rk_triangle_plane *plane, rk_dvec3 v)
{
    double dot = rk_ddot(v, plane->normal);
    return fabs(dot) > 0x1p-48 * rk_dvec3_size(v) * plane->edges ? dot : 0;
}

/* The side of the plane on which a point lies, and the side to which a direction points: a ray from
 * the point can hit the triangle only if they differ in sign. */
static inline double rk_triangle_plane_side(const rk_triangle_plane *plane, rk_vec3 point)
{
    return rk_triangle_plane_dot(plane, rk_dmadd(rk_widen(point), plane->a, -1));
}

static inline double rk_triangle_plane_heading(const rk_triangle_plane *plane, rk_vec3 direction)
{
    return rk_triangle_plane_dot(plane, rk_widen(direction));
}

#endif
