/* Looking up an environment map: which face of the cube a direction meets, where on it, and what
 * the texels around that place are together. The cube, the way its faces are turned and the
 * opposite way, from a place to its direction (rk_cube_direction), stand in scene/environment.h.
 *
 *   filter     colour                                          steps
 *   nearest    that of the texel                               at every texel's border
 *   bilinear   a mix of four texels of the same face           at the cube's edges
 *   seamless   also of those beyond the edge; at a corner,     nowhere
 *              where three meet, the fourth is their mean
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

/* Returns where a direction of any length meets the cube. On an edge x comes before y before z, so
 * (1, -1, -1) is on +x. What has no direction, the zero vector or NaN, is somewhere on the cube. */
rk_cube_place rk_cubemap_place(rk_vec3 direction);

/* Returns the map's colour in a direction of any length. The map has texels. */
rk_vec3 rk_cubemap_at(const rk_cubemap *map, rk_vec3 direction, rk_cubemap_filter filter);

/* Returns how much of the sphere a texel covers, in steradians; those of all six faces add up to
 * 4 pi. Texels of any face are alike. */
double rk_cubemap_solid_angle(uint32_t side, uint32_t column, uint32_t row);

#endif
