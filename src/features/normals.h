/* Normals as colours: the first thing to look at in a new renderer, and the first thing to write
 * here. A unit vector n becomes the colour
 *
 *   (1 + n) / 2:   red for x, green for y, blue for z
 *
 * and a triangle's normal is the direction of the cross product of two of its edges. */
#ifndef RK_FEATURES_NORMALS_H
#define RK_FEATURES_NORMALS_H

#include "base/vec3.h"

/* Which normals a picture shows: none, those for shading, which are interpolated between a
 * triangle's corners, or that of each triangle's plane. */
typedef enum rk_normals_shown {
    RK_NORMALS_NONE,
    RK_NORMALS_SMOOTH,
    RK_NORMALS_FLAT
} rk_normals_shown;

/* Returns the colour of a unit vector: 0 becomes 1/2 in each channel, 1 becomes 1 and -1 becomes
 * 0. */
rk_vec3 rk_normals_colour(rk_vec3 n);

/* Returns the unit normal of the triangle with the corners a, b, c, on the side from which they run
 * counterclockwise; (0, 0, 0) if the triangle has no area. For areas between 2^-60 and 2^60 (1e-18
 * and 1e18): the squares of smaller and larger ones are beyond a float. */
rk_vec3 rk_normals_of_triangle(rk_vec3 a, rk_vec3 b, rk_vec3 c);

#endif
