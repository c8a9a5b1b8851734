/* Ray-sphere intersection, accurate for small, distant spheres as well (Haines, Guenther,
 * Akenine-Moeller, "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019,
 * chapter 7). */
#ifndef RK_BASE_SPHERE_H
#define RK_BASE_SPHERE_H

#include "base/ray.h"
#include "base/vec3.h"

#include <stdbool.h>

typedef struct rk_sphere {
    rk_vec3 centre;
    float radius; /* > 0 */
} rk_sphere;

/* The t at which the ray's line enters and leaves the sphere, of any sign; false if the line
 * misses. */
static inline bool rk_sphere_span(const rk_sphere *sphere, const rk_ray *ray, float *t_near,
                                  float *t_far)
{
    rk_vec3 d = ray->direction, f = rk_sub(ray->origin, sphere->centre);
    float a = rk_dot(d, d), b = -rk_dot(f, d);
    /* The squared distance from the centre to the line, computed from the vector: a difference of
     * large squares would lose its digits. */
    rk_vec3 across = rk_madd(f, d, b / a);
    float inside = sphere->radius * sphere->radius - rk_dot(across, across);
    if (!(inside >= 0))
        return false;
    float q = b + copysignf(sqrtf(a * inside), b);
    float t_q = q / a;
    float t_c = (rk_dot(f, f) - sphere->radius * sphere->radius) / q;
    *t_near = t_q < t_c ? t_q : t_c;
    *t_far = t_q < t_c ? t_c : t_q;
    return true;
}

/* Returns the smallest t with 0 < t <= t_max at which the ray intersects the sphere, or
 * infinity. */
static inline float rk_sphere_intersect(const rk_sphere *sphere, const rk_ray *ray, float t_max)
{
    float t_near, t_far;
    if (!rk_sphere_span(sphere, ray, &t_near, &t_far))
        return INFINITY;
    float t = t_near > 0 ? t_near : t_far;
    return t > 0 && t <= t_max && t < INFINITY ? t : INFINITY;
}

/* Closest-hit test: if the sphere is nearer than hit->t, replaces the hit, with `index` as its
 * triangle. */
static inline bool rk_sphere_closest(const rk_sphere *sphere, uint32_t index, const rk_ray *ray,
                                     rk_hit *hit)
{
    float t = rk_sphere_intersect(sphere, ray, hit->t);
    if (!(t < hit->t || (t == hit->t && t < INFINITY && index < hit->triangle)))
        return false;
    *hit = (rk_hit){t, 0, 0, index};
    return true;
}

#endif
