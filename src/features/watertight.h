/* Which rays hit a triangle, without gaps between neighbours:
 *
 *   (t, u, v) = (c' . (s x b'), s . (d x c'), d . (s x b')) / det,   det = b' . (d x c')
 *
 * with the ray o + t d, s = o - a, b' = b - a, c' = c - a (Moeller and Trumbore, "Fast, minimum
 * storage ray/triangle intersection", 1997). Only the signs of these determinants decide, and they
 * are those of the exact numbers: a float rejects what is certain, a double decides, and where
 * rounding could change a sign, an exact sum of doubles does (Shewchuk, "Adaptive precision
 * floating-point arithmetic and fast robust geometric predicates", 1997). So a ray through a common
 * edge or corner hits at least one of its triangles, at any scale. */
#ifndef RK_FEATURES_WATERTIGHT_H
#define RK_FEATURES_WATERTIGHT_H

#include "base/ray.h"
#include "base/simd4.h"
#include "base/triangle.h"

#include <stdbool.h>

/* Returns the intersection at 0 < t < infinity, whatever the ray's t_max; on a miss its triangle is
 * RK_MISS. Edges and corners belong to the triangle. A ray in the triangle's plane, a triangle
 * without area, NaN and infinity are misses, and so is a t above FLT_MAX. t, u and v are rounded
 * once from double; a t below the smallest float is that one. On a needle, whose det is nearly 0,
 * the double itself may be off by a few floats' width, although the hit is certain. Then t may lie
 * outside of the triangle's box, and a ray whose t_max is that t may miss the box in a tree. */
rk_hit rk_watertight_intersect(const rk_triangle *triangle, const rk_ray *ray);

/* Does double decide? False where rounding could change a sign, so that the test above computes
 * exactly. For counting such rays. */
bool rk_watertight_is_certain(const rk_triangle *triangle, const rk_ray *ray);

/* The same test for a ray that is displaced infinitesimally, in the same way for all triangles: it
 * passes through no edge and no corner, so it crosses a closed surface into it as often as out of
 * it. For counting crossings (features/transparency.h). Returns 1 where the ray enters (a, b and c
 * are counter-clockwise seen from its origin), -1 where it leaves, 0 for a miss; fills in the hit
 * unless it is a miss. */
int rk_watertight_cross(const rk_triangle *triangle, const rk_ray *ray, rk_hit *hit);

/* --- Four at once ----------------------------------------------------------------------------- */

/* The largest size of the direction's components, for rk_watertight_may_hit. */
static inline float rk_watertight_longest(const rk_ray *ray)
{
    rk_vec3 size = rk_abs3(ray->direction);
    return rk_max(size.x, rk_max(size.y, size.z));
}

/* The same determinants in float, of four rays or triangles: a bit is set where the ray may hit the
 * triangle at 0 < t <= t_max, and always set where it does. s: the origin seen from corner a; ab,
 * ac: the edges. The bounds, 2^-19 edge reach longest of u, v and det, and 2^-19 edge reach edge of
 * t det, are larger than all rounding errors; they are infinite or NaN, and reject nothing, where a
 * product overflows, and their parts of at least 2^-41 outweigh underflow. */
__attribute__((always_inline)) static inline uint32_t
rk_watertight_may_hit(rk_simd4x3 s, rk_simd4x3 direction, rk_simd4 longest, rk_simd4 t_max,
                      rk_simd4x3 ab, rk_simd4x3 ac)
{
    const rk_simd4 tiny = rk_simd4_all(0x1p-41f), half = rk_simd4_all(0.5f);
    t_max = rk_simd4_max(t_max, rk_simd4_all(0x1p-126f)); /* smaller ones are rounded coarsely */
    rk_simd4x3 p = rk_simd4x3_cross(direction, ac);
    rk_simd4 half_det = half * rk_simd4x3_dot(ab, p), u = rk_simd4x3_dot(s, p);
    rk_simd4 edge = rk_simd4_max(rk_simd4x3_size(ab), rk_simd4x3_size(ac)) + tiny;
    rk_simd4 area = edge * (rk_simd4x3_size(s) + edge), gamma = rk_simd4_all(0x1p-19f);
    rk_simd4 bound = area * rk_simd4_max(longest, tiny) * gamma, t_bound = area * edge * gamma;
    /* u lies outside of 0 .. det: farther from the middle than half of its length. */
    rk_simd4_mask outside = rk_simd4_abs(u - half_det) > rk_simd4_abs(half_det) + bound;
    if (rk_simd4_movemask(outside) == 15)
        return 0;
    rk_simd4x3 q = rk_simd4x3_cross(s, ab);
    rk_simd4 v = rk_simd4x3_dot(direction, q), half_rest = half_det - half * u;
    outside |= rk_simd4_abs(v - half_rest) > rk_simd4_abs(half_rest) + bound;
    /* t det, for a det above 0, lies outside of 0 .. t_max det. */
    rk_simd4 size = half_det + half_det, t = rk_simd4x3_dot(ac, q);
    t = rk_simd4_select(size < rk_simd4_all(0), -t, t);
    size = rk_simd4_abs(size);
    outside |= (size > bound) & ((t < -t_bound) | (t > t_max * (size + bound) + t_bound));
    return 15 & ~rk_simd4_movemask(outside);
}

/* The ray's closest hit among all triangles: if one is nearer than hit->t, or has the same t and a
 * smaller index (so that the result does not depend on the order of tests), the hit is replaced.
 * Start with hit = {ray->t_max, 0, 0, RK_MISS}. */
void rk_triangles_closest(const rk_triangle *triangles, uint32_t count, const rk_ray *ray,
                          rk_hit *hit);

/* Any-hit test, for shadows: the place of the first triangle that the ray hits at 0 < t <= t_max;
 * `count` if there is none. */
uint32_t rk_triangles_first_hit(const rk_triangle *triangles, uint32_t count, const rk_ray *ray);

/* Both for a single triangle. The first returns whether the hit was replaced. */
static inline bool rk_triangle_closest(const rk_triangle *triangle, const rk_ray *ray, rk_hit *hit)
{
    rk_hit found = rk_watertight_intersect(triangle, ray);
    bool nearer = found.t < hit->t || (found.t == hit->t && found.triangle < hit->triangle);
    if (found.triangle == RK_MISS || !nearer)
        return false;
    *hit = found;
    return true;
}

static inline bool rk_triangle_occludes(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_hit found = rk_watertight_intersect(triangle, ray);
    return found.triangle != RK_MISS && found.t <= ray->t_max;
}

#endif
