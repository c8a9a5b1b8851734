/* An environment: light from so far away that only its direction matters, as a map on the six faces
 * of a cube around the viewer. This header has the cube, the orientation of its faces, and its
 * memory; features/cubemap.h has the lookups.
 *
 * A face is a square picture seen from the cube's centre, with u in [0, 1] to the right and v in
 * [0, 1] upwards, as for textures. All orientations in this kit follow from this cross, cut out and
 * folded backwards around the viewer, who looks at -z:
 *
 *              +----+                         face   ahead  right   up
 *              | +y |                          +x     +x     +z     +y
 *         +----+----+----+----+                -x     -x     -z     +y
 *         | -x | -z | +x | +z |                +y     +y     +x     +z
 *         +----+----+----+----+                -y     -y     +x     -z
 *              | -y |                          +z     +z     -x     +y
 *              +----+                          -z     -z     +x     +y
 */
#ifndef RK_SCENE_ENVIRONMENT_H
#define RK_SCENE_ENVIRONMENT_H

#include "base/error.h"
#include "base/vec3.h"

#include <stdint.h>

/* Twice the axis (0 for x to 2 for z), plus 1 for the negative side. */
typedef enum rk_cube_face {
    RK_FACE_X,
    RK_FACE_MINUS_X,
    RK_FACE_Y,
    RK_FACE_MINUS_Y,
    RK_FACE_Z,
    RK_FACE_MINUS_Z,
    RK_FACES
} rk_cube_face;

typedef struct rk_cube_axes {
    rk_vec3 ahead, right, up; /* unit */
} rk_cube_axes;

/* The table above. */
extern const rk_cube_axes rk_cube_faces[RK_FACES];

/* Returns the direction to (u, v) of a face; its length is 1 to sqrt(3). */
static inline rk_vec3 rk_cube_direction(rk_cube_face face, float u, float v)
{
    const rk_cube_axes *axes = &rk_cube_faces[face];
    return rk_madd(rk_madd(axes->ahead, axes->right, 2 * u - 1), axes->up, 2 * v - 1);
}

/* Four faces side by side are as wide as the widest picture. */
enum { RK_CUBEMAP_SIDE_MAX = 8192 };

typedef struct rk_cubemap {
    uint32_t side;            /* of each face, in texels; 0: there is no map */
    rk_vec3 *faces[RK_FACES]; /* side * side, row by row from the top; one block of memory */
} rk_cubemap;

/* Makes a black map of 1 to RK_CUBEMAP_SIDE_MAX texels per side. */
bool rk_cubemap_init(rk_cubemap *map, uint32_t side, rk_error *error);

/* Turns the map by half a turn about y: what was at -z is at +z. */
void rk_cubemap_turn(rk_cubemap *map);

/* Accepts a zeroed map. */
void rk_cubemap_free(rk_cubemap *map);

/* Columns count from the left, rows from the top. */
static inline rk_vec3 *rk_cubemap_texel(const rk_cubemap *map, rk_cube_face face, uint32_t column,
                                        uint32_t row)
{
    return &map->faces[face][(size_t)row * map->side + column];
}

/* Returns the direction to a texel's centre; its length is 1 to sqrt(3). */
static inline rk_vec3 rk_cubemap_texel_direction(uint32_t side, rk_cube_face face, uint32_t column,
                                                 uint32_t row)
{
    float texels = (float)side;
    return rk_cube_direction(face, ((float)column + 0.5f) / texels,
                             ((float)(side - 1 - row) + 0.5f) / texels);
}

#endif
