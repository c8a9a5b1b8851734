/* Glossy reflection: a mirror that is not quite smooth sends each ray not along the reflected
 * direction alone, but to anywhere in a disk around it. */
#ifndef RK_FEATURES_GLOSSY_REFLECTION_H
#define RK_FEATURES_GLOSSY_REFLECTION_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stdint.h>

/* Completes the unit vector w to a right-handed basis u, v, w of unit vectors at right angles, for
 * every w; to a few units in the last place of 1 where w is a unit vector to as much. */
void rk_basis_of(rk_vec3 w, rk_vec3 *u, rk_vec3 *v);

/* How xi becomes a point of the unit disk. Both are even over its area; the concentric map keeps
 * neighbours together, so that well-spread xi stay well spread. */
typedef enum rk_disk_map {
    RK_DISK_POLAR,      /* r = sqrt(xi.x), theta = 2 pi xi.y */
    RK_DISK_CONCENTRIC, /* squares around the middle of the unit square become circles */
} rk_disk_map;

/* Returns the point of the unit disk for xi in [0, 1)^2; its length is at most 1, but for rounding.
 */
rk_vec2 rk_disk_at(rk_disk_map map, rk_vec2 xi);

/* The disk's radius for a material's shininess s >= 0: 0.5 / s, but no more than 1. At 1 directions
 * are nearly three times as dense at the rim, 45 degrees from the middle, as in the middle; what
 * is wider no longer looks like a reflection. So 1 also is the radius for shininess 0. */
float rk_glossy_radius(float shininess);

/* The disk stands at the tip of the reflected direction, at a right angle to it. */
typedef struct rk_glossy_disk {
    rk_vec3 w;           /* unit: the reflected direction */
    rk_vec3 u, v;        /* unit: the disk's own axes */
    float radius;        /* >= 0; the disk is at distance 1 */
    rk_vec3 face_normal; /* unit: of the surface, on the side into which w leads, so w . face_normal
                            is never below 0, but for rounding */
} rk_glossy_disk;

rk_glossy_disk rk_glossy_disk_of(rk_vec3 reflected, float radius, rk_vec3 face_normal);

/* The unit direction to the point `at` of the disk, given on the unit disk. Exactly w for radius 0
 * and for the middle. False if it leads into the surface, below the face or along it: such a
 * direction is filled in, too, but is to be discarded. What is above the face but below the horizon
 * of an interpolated shading normal is kept, as nothing is in its way. */
bool rk_glossy_direction(const rk_glossy_disk *disk, rk_vec2 at, rk_vec3 *direction);

/* Returns the share of the disk's area that is above the face: 1/2 to 1, as the middle is above. */
float rk_glossy_fraction_above(const rk_glossy_disk *disk);

/* What directions that were discarded cost. */
typedef enum rk_glossy_weights {
    RK_GLOSSY_CLASSIC,      /* they count as black: grazing reflections get dark */
    RK_GLOSSY_RENORMALIZED, /* the mean over the part of the disk that is above the face */
} rk_glossy_weights;

/* Returns what each of the `above` samples, of `samples` in all, counts for in the estimate of what
 * the surface mirrors; 0 if none is above. `share`: that of the disk. Classic is 1 / samples.
 * Renormalised is 1 / above, and a little more: with the probability (1 - share)^samples none is
 * above and the estimate is 0, for which the others make up. So for independent samples, be it a
 * single one, the mean of the estimates is exactly the integral. */
float rk_glossy_weight(rk_glossy_weights weights, uint32_t above, uint32_t samples, float share);

#endif
