/* Environments that are computed, not read from files. */
#include "driver.h"

#include "base/random.h"
#include "scenes/sky.h"

bool paint_map(rk_cubemap *map, uint32_t side, paint *colour, rk_error *error)
{
    rk_cubemap_free(map);
    if (!rk_cubemap_init(map, side, error))
        return false;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t row = 0; row < side; row++)
            for (uint32_t column = 0; column < side; column++)
                *rk_cubemap_texel(map, (rk_cube_face)face, column, row) =
                    colour(side, (rk_cube_face)face, column, row);
    return true;
}

static rk_vec3 sky(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    return rk_sky_at(rk_cubemap_texel_direction(side, face, column, row));
}

static rk_vec3 random_colour(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    uint32_t texel = ((uint32_t)face * side + row) * side + column;
    return rk_vec(rk_unit_float(rk_hash(texel, 0, 0, 0)), rk_unit_float(rk_hash(texel, 1, 0, 0)),
                  rk_unit_float(rk_hash(texel, 2, 0, 0)));
}

/* Is this place inked? `glyph` has rows of three cells; x and y count cells from its corner. */
static bool is_ink(const char *const glyph[5], int x, int y)
{
    return x >= 0 && x < 3 && y >= 0 && y < 5 && glyph[y][x] == '#';
}

/* The name of the face, such as +X, below the letter. */
static bool is_name(rk_cube_face face, int x, int y)
{
    static const char *const signs[2][5] = {{"...", ".#.", "###", ".#.", "..."},
                                            {"...", "...", "###", "...", "..."}};
    static const char *const axes[3][5] = {{"#.#", "#.#", ".#.", "#.#", "#.#"},
                                           {"#.#", "#.#", ".#.", ".#.", ".#."},
                                           {"###", "..#", ".#.", "#..", "###"}};
    return is_ink(signs[face % 2], x, y) || is_ink(axes[face / 2], x - 4, y);
}

/* Each face in the colour of its axis, red, green or blue, or the complementary one for the
 * negative side; on it an F, which looks different in each of its eight orientations. */
static rk_vec3 marked(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row)
{
    static const rk_vec3 colours[RK_FACES] = {{0.7f, 0.1f, 0.1f}, {0.1f, 0.6f, 0.6f},
                                              {0.1f, 0.6f, 0.1f}, {0.6f, 0.1f, 0.6f},
                                              {0.1f, 0.1f, 0.7f}, {0.7f, 0.6f, 0.1f}};
    static const char *const letter[5] = {"###", "#..", "##.", "#..", "#.."};
    int x = (int)(column * 33 / side), y = (int)(row * 33 / side);
    bool ink = is_ink(letter, x / 3 - 4, y / 3 - 3) || is_name(face, x - 13, y - 26);
    bool border = column == 0 || row == 0 || column == side - 1 || row == side - 1;
    return ink ? rk_vec(1, 1, 1) : border ? rk_vec(0, 0, 0) : colours[face];
}

bool paint_environment(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_cubemap *map = &driver->scene.environment;
    if (rk_driver_debug(driver, "seam"))
        return paint_map(map, c->side ? c->side : 8, random_colour, error);
    if (c->marked)
        return paint_map(map, c->side ? c->side : 256, marked, error);
    return c->side == 0 || paint_map(map, c->side, sky, error);
}
