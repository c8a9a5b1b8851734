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

void rk_cubemap_free(rk_cubemap *map)
{
    free(map->faces[0]);
    *map = (rk_cubemap){0};
}
