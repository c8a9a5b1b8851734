/* Ray-triangle intersection (Moeller and Trumbore, "Fast, minimum storage ray/triangle
 * intersection", 1997), without the epsilon of their listing: an absolute threshold on the
 * determinant loses small triangles, and the signs decide without one. */
#ifndef RK_BASE_TRIANGLE_H
#define RK_BASE_TRIANGLE_H

#include "base/ray.h"
#include "base/vec3.h"

#include <stdbool.h>

/* One corner, the two edges from it, and the triangle's index in its mesh: 40 bytes, contiguous
 * within a leaf. */
typedef struct rk_triangle {
    rk_vec3 a, edge_ab, edge_ac;
    uint32_t index;
} rk_triangle;

/* Common to both tests below: true if the ray intersects the triangle at a positive, finite t.
 * Divides only after the line is known to hit. Edge-on triangles (det = 0) and NaN are misses. A
 * product of three lengths is formed: between 2^-126 and 2^127, scaling a scene by a power of two
 * changes no bit of t, u and v (so from 1e-11 to 1e11 around a unit scene). Larger products
 * overflow into a miss; smaller ones underflow into one, after losing precision at the edges. */
__attribute__((always_inline)) static inline bool
rk_triangle_intersect(const rk_triangle *triangle, const rk_ray *ray, rk_hit *cross)
{
    rk_vec3 p = rk_cross(ray->direction, triangle->edge_ac);
    float det = rk_dot(triangle->edge_ab, p);
    float sign = det < 0 ? -1.0f : 1.0f;
    det *= sign;
    rk_vec3 s = rk_scale(rk_sub(ray->origin, triangle->a), sign);
    float u_det = rk_dot(s, p);
    if (!(u_det >= 0 && u_det <= det))
        return false;
    rk_vec3 q = rk_cross(s, triangle->edge_ab);
    float v_det = rk_dot(ray->direction, q);
    if (!(v_det >= 0 && u_det + v_det <= det))
        return false;
    float t = rk_dot(triangle->edge_ac, q) / det;
    if (!(t > 0 && t < INFINITY))
        return false;
    *cross = (rk_hit){t, u_det / det, v_det / det, triangle->index};
    return true;
}

/* The side of the plane on which a point lies, and the side to which a direction points: numerator
 * and denominator of t, computed as in the test. A ray from `point` along `direction` can hit the
 * triangle only if both are positive or both negative; if they differ in sign it misses, whatever
 * the rounding. */
static inline float rk_triangle_side(const rk_triangle *triangle, rk_vec3 point)
{
    rk_vec3 s = rk_sub(point, triangle->a);
    return rk_dot(triangle->edge_ac, rk_cross(s, triangle->edge_ab));
}

static inline float rk_triangle_heading(const rk_triangle *triangle, rk_vec3 direction)
{
    return rk_dot(triangle->edge_ab, rk_cross(direction, triangle->edge_ac));
}

/* Closest-hit test. If the intersection is nearer than hit->t, or has the same t and a smaller
 * index (so that the result does not depend on the order of tests), the hit is replaced. Returns
 * whether it was. Start with hit = {ray->t_max, 0, 0, RK_MISS}. */
static inline bool rk_triangle_closest(const rk_triangle *triangle, const rk_ray *ray, rk_hit *hit)
{
    rk_hit cross;
    if (!rk_triangle_intersect(triangle, ray, &cross))
        return false;
    if (!(cross.t < hit->t || (cross.t == hit->t && cross.triangle < hit->triangle)))
        return false;
    *hit = cross;
    return true;
}

/* Any-hit test, for shadows: is there an intersection at 0 < t <= t_max? */
static inline bool rk_triangle_occludes(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_hit cross;
    return rk_triangle_intersect(triangle, ray, &cross) && cross.t <= ray->t_max;
}

#endif
