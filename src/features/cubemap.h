/* Environment map lookup: the face of the cube that a direction hits, the place on that face, and
 * the mix of the texels around the place. scene/environment.h has the cube, the orientation of its
 * faces, and the inverse map, from a place to its direction (rk_cube_direction).
 *
 *   filter     colour                                          discontinuous
 *   nearest    the texel's                                     at every texel's border
 *   bilinear   a mix of four texels of the same face           at the cube's edges
 *   seamless   the same across edges; at a corner of three     nowhere
 *              texels their mean replaces the fourth
 *
 * A place on the border of two texels is in the one to its right, or above it; at the face's right
 * and upper edges in the last one.
 */
#ifndef RK_FEATURES_CUBEMAP_H
#define RK_FEATURES_CUBEMAP_H

#include "scene/environment.h"

typedef enum rk_cubemap_filter {
    RK_CUBEMAP_NEAREST,
    RK_CUBEMAP_BILINEAR,
    RK_CUBEMAP_SEAMLESS,
} rk_cubemap_filter;

/* A place on the cube. */
typedef struct rk_cube_place {
    rk_cube_face face;
    float u, v; /* in [0, 1], to the right and upwards */
} rk_cube_place;

/* Returns the place where a direction of any finite length hits the cube. On an edge x comes before
 * y before z, so (1, -1, -1) is on +x. The zero vector and NaN have no direction, but give a valid
 * place. */
rk_cube_place rk_cubemap_place(rk_vec3 direction);

/* Returns the map's colour in a direction of any finite length. The map must not be empty. */
rk_vec3 rk_cubemap_at(const rk_cubemap *map, rk_vec3 direction, rk_cubemap_filter filter);

/* Returns a texel's solid angle, in steradians, the same on every face, of a map of 1 to
 * RK_CUBEMAP_SIDE_MAX texels per side; over all six faces they sum to 4 pi. */
double rk_cubemap_solid_angle(uint32_t side, uint32_t column, uint32_t row);

#endif
