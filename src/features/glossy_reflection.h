/* Glossy reflection: a rough mirror reflects each ray through a random point of a disk around the
 * reflected direction. */
#ifndef RK_FEATURES_GLOSSY_REFLECTION_H
#define RK_FEATURES_GLOSSY_REFLECTION_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stdint.h>

/* Completes the unit vector w to a right-handed orthonormal basis u, v, w, for every w; accurate to
 * a few ulps of 1 if w is. */
void rk_basis_of(rk_vec3 w, rk_vec3 *u, rk_vec3 *v);

/* How xi becomes a point of the unit disk. Both are uniform over its area; the concentric map keeps
 * neighbours together, so that well-spread xi stay well spread. */
typedef enum rk_disk_map {
    RK_DISK_POLAR,      /* r = sqrt(xi.x), phi = 2 pi xi.y */
    RK_DISK_CONCENTRIC, /* squares around the middle of the unit square become circles */
} rk_disk_map;

/* Returns the point of the unit disk for xi in [0, 1)^2; its length is at most 1, apart from
 * rounding. */
rk_vec2 rk_disk_at(rk_disk_map map, rk_vec2 xi);

/* Returns the disk's radius for a material's shininess s >= 0: 0.5 / s, at most 1. With radius 1
 * directions are nearly three times as dense at the rim, 45 degrees from the centre, as at the
 * centre; a wider disk no longer looks like a reflection. So shininess 0 has radius 1, too. */
float rk_glossy_radius(float shininess);

/* The disk is perpendicular to the reflected direction, centred at its tip. */
typedef struct rk_glossy_disk {
    rk_vec3 w;           /* unit: the reflected direction */
    rk_vec3 u, v;        /* unit: the disk's own axes */
    float radius;        /* 0 to 1000; the disk is at distance 1 */
    rk_vec3 face_normal; /* unit: of the surface, on the side of w, so w . face_normal is never
                            below 0, apart from rounding */
} rk_glossy_disk;

rk_glossy_disk rk_glossy_disk_of(rk_vec3 reflected, float radius, rk_vec3 face_normal);

/* Fills in the unit direction to the point `at` of the disk, given on the unit disk; exactly w for
 * radius 0 and for the centre. Returns false if it leads into the surface, below the face or along
 * it: it is filled in, too, but is to be discarded. Directions above the face but below the horizon
 * of an interpolated shading normal are kept, because the surface does not occlude them. */
bool rk_glossy_direction(const rk_glossy_disk *disk, rk_vec2 at, rk_vec3 *direction);

/* Returns the fraction of the disk's area above the face: 1/2 to 1, because the centre is above
 * it, apart from rounding. */
float rk_glossy_fraction_above(const rk_glossy_disk *disk);

/* Moves a point of the unit disk up into the part above the face, which has this fraction of the
 * area: until the fraction of the disk that is farther up has shrunk by `fraction_above`, and to
 * the same place between the two points of the rim at its height. So uniform points become uniform
 * points of that part, and neighbours stay neighbours. With a fraction of 1 points stay where they
 * are. A point of the rim, even a rounding outside of it, stays in the disk, apart from rounding.
 */
rk_vec2 rk_glossy_point_above(const rk_glossy_disk *disk, float fraction_above, rk_vec2 at);

/* How the part of the disk below the surface counts. The weight of each sample is 1 / samples. */
typedef enum rk_glossy_weights {
    RK_GLOSSY_CLASSIC,      /* as black, by discarding: grazing reflections get dark */
    RK_GLOSSY_RENORMALIZED, /* not at all: points are moved above the surface, and their mean is
                               that over the part above */
} rk_glossy_weights;

#endif
