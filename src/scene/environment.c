/* The table of the cube's faces, from which all orientations follow, and the texels in one block.
 * */
#include "scene/environment.h"

#include <stdlib.h>

const rk_cube_axes rk_cube_faces[RK_FACES] = {
    [RK_FACE_X] = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    [RK_FACE_MINUS_X] = {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
    [RK_FACE_Y] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
    [RK_FACE_MINUS_Y] = {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    [RK_FACE_Z] = {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
    [RK_FACE_MINUS_Z] = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
};

bool rk_cubemap_init(rk_cubemap *map, uint32_t side, rk_error *error)
{
    *map = (rk_cubemap){0};
    if (side < 1 || side > RK_CUBEMAP_SIDE_MAX)
        return rk_fail(error, "a cube map of %u texels per side: choose 1 to %d", side,
                       RK_CUBEMAP_SIDE_MAX);
    size_t texels = (size_t)side * side;
    rk_vec3 *block = rk_allocate(RK_FACES * texels, sizeof *block, "cube map", error);
    if (!block)
        return false;
    map->side = side;
    for (int face = 0; face < RK_FACES; face++)
        map->faces[face] = block + (size_t)face * texels;
    return true;
}

static void swap(rk_vec3 *a, rk_vec3 *b)
{
    const rk_vec3 kept = *a;
    *a = *b;
    *b = kept;
}

void rk_cubemap_turn(rk_cubemap *map)
{
    const size_t texels = (size_t)map->side * map->side;
    for (size_t i = 0; i < texels; i++) {
        swap(&map->faces[RK_FACE_X][i], &map->faces[RK_FACE_MINUS_X][i]);
        swap(&map->faces[RK_FACE_Z][i], &map->faces[RK_FACE_MINUS_Z][i]);
    }
    for (size_t i = 0; i < texels / 2; i++) { /* these turn in their planes */
        swap(&map->faces[RK_FACE_Y][i], &map->faces[RK_FACE_Y][texels - 1 - i]);
        swap(&map->faces[RK_FACE_MINUS_Y][i], &map->faces[RK_FACE_MINUS_Y][texels - 1 - i]);
    }
}

void rk_cubemap_free(rk_cubemap *map)
{
    free(map->faces[0]);
    *map = (rk_cubemap){0};
}
