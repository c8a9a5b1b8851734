/* The pyramid between a point and a parallelogram light: where no surface reaches into it, no
 * shadow ray from the point to the light can be occluded. The same for several points at once: the
 * convex hull of them and of the light (shaft culling: Haines and Wallace, "Shaft culling for
 * efficient ray-cast radiosity", 1991). */
#ifndef RK_ACCEL_QUERY_PYRAMID_H
#define RK_ACCEL_QUERY_PYRAMID_H

#include "accel/accel.h"
#include "base/counters.h"
#include "scene/light.h"

enum { RK_PYRAMID_PLANES = 5 };

/* Contains, exactly, every ray from an apex to a sample of the light as both are computed in
 * float. */
typedef struct rk_pyramid {
    rk_vec3 apex;
    const rk_vec3 *others; /* further apexes, if there are several: the caller's */
    uint32_t other_count;
    rk_box box;          /* around it, with the slack */
    rk_dvec3 corners[4]; /* of the light, in their order around it */
    /* Its sides and its base: normal . (x - apex) <= limit within the pyramid. The sizes of
     * a normal's components add up to 1; it is zero where the light is seen edge-on or has no
     * area. */
    rk_dvec3 normals[RK_PYRAMID_PLANES];
    double limits[RK_PYRAMID_PLANES]; /* with the slack */
    double slack; /* on each axis, a ray passes its point of the light no farther away than this */
} rk_pyramid;

/* Of 1 or more apexes, where shadow rays start, which are kept by reference. The light is a
 * parallelogram or a segment. */
rk_pyramid rk_pyramid_around(const rk_vec3 *apexes, uint32_t count, const rk_light *light);

/* Does a plane certainly separate the triangle, or the sphere, from the pyramid? */
bool rk_pyramid_excludes_triangle(const rk_pyramid *pyramid, const rk_triangle *triangle);
bool rk_pyramid_excludes_sphere(const rk_pyramid *pyramid, const rk_sphere *sphere);

/* The surface that was last found in a pyramid: neighbouring ones often contain the same. */
typedef struct rk_pyramid_obstacle {
    bool known;
    rk_triangle triangle;
} rk_pyramid_obstacle;

/* Is the pyramid certainly free of surfaces? True only if rk_accel_occluded is false for every ray
 * from an apex to the light. May be false nonetheless: a triangle counts as inside unless one of
 * these planes separates the two: one across an axis of space, a side or the base of the pyramid,
 * the triangle's own, or, of a single apex, one through it and an edge of the triangle. The answer
 * depends on the scene, not on the tree. Moving objects are at rest. */
bool rk_pyramid_is_empty(const rk_pyramid *pyramid, const rk_accel *accel,
                         rk_pyramid_obstacle *obstacle, rk_counters *counters);

#endif
