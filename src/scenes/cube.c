/* The cube, plain and with a letter on each side. Order of sides and materials: -x +x -y +y -z
 * +z. Declared in scenes/makers.h. */
#include "scenes/makers.h"

/* Bits 0, 1, 2 of c give the signs of x, y, z of corner c. Each side begins bottom left as seen
 * from outside and continues counter-clockwise. Up is +y; on the top side it is +z and on the
 * bottom side -z, as for a camera that looks along z and tilts. */
static const uint8_t cube_sides[6][4] = {{0, 4, 6, 2}, {5, 1, 3, 7}, {5, 4, 0, 1},
                                         {3, 2, 6, 7}, {1, 0, 2, 3}, {4, 5, 7, 6}};

/* A positive side has the saturated colour of its axis, red, green or blue. */
static const rk_vec3 cube_colours[6] = {{0.8f, 0.5f, 0.45f}, {0.8f, 0.1f, 0.08f},
                                        {0.5f, 0.7f, 0.45f}, {0.15f, 0.6f, 0.1f},
                                        {0.5f, 0.6f, 0.8f},  {0.1f, 0.2f, 0.75f}};

static rk_vec3 cube_corner(int c)
{
    return rk_vec(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
}

bool rk_builtin_make_cube(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_mesh_init(mesh, 8, 12, 6, 0, error))
        return false;
    for (int c = 0; c < 8; c++)
        mesh->positions[c] = cube_corner(c);
    for (int i = 0; i < 12; i++) {
        const uint8_t *corner = cube_sides[i / 2];
        mesh->triangles[i][0] = corner[0];
        mesh->triangles[i][1] = corner[1 + i % 2];
        mesh->triangles[i][2] = corner[2 + i % 2];
        mesh->triangle_materials[i] = (uint16_t)(i / 2);
    }
    for (int i = 0; i < 6; i++)
        mesh->materials[i].kd = cube_colours[i];
    return true;
}

/* --- with a texture -------------------------------------------------------------------------- */

/* An F looks different in each of its eight orientations. */
static const char *const letter[8] = {
    /* clang-format off: one row of texels per line, the top one first */
    "........", ".#####..", ".##.....", ".####...", ".##.....", ".##.....", ".##.....", "........",
    /* clang-format on */
};

/* The dark letter on a bright chequered ground. */
static void paint(rk_image *image)
{
    const rk_vec3 ink = {0.05f, 0.05f, 0.1f}, bright = {1, 1, 1}, shade = {0.8f, 0.8f, 0.8f};
    for (size_t y = 0; y < 8; y++)
        for (size_t x = 0; x < 8; x++)
            *rk_image_at(image, x, y) = letter[y][x] == '#' ? ink : (x + y) % 2 ? shade : bright;
}

bool rk_builtin_make_cube_textured(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    /* Sides do not share corners: each has its own texture coordinates there. */
    if (!rk_mesh_init(mesh, 24, 12, 6, RK_MESH_TEXCOORDS, error))
        return false;
    mesh->textures = rk_allocate(1, sizeof *mesh->textures, "textures", error);
    mesh->texture_count = mesh->textures ? 1 : 0;
    if (!mesh->textures || !rk_image_init(&mesh->textures[0].image, 8, 8, error)) {
        rk_mesh_free(mesh);
        return false;
    }
    paint(&mesh->textures[0].image);
    static const rk_vec2 texcoords[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (uint32_t i = 0; i < 24; i++) {
        mesh->positions[i] = cube_corner(cube_sides[i / 4][i % 4]);
        mesh->texcoords[i] = texcoords[i % 4];
    }
    for (uint32_t i = 0; i < 12; i++) {
        const uint32_t first = 4 * (i / 2);
        mesh->triangles[i][0] = first;
        mesh->triangles[i][1] = first + 1 + i % 2;
        mesh->triangles[i][2] = first + 2 + i % 2;
        mesh->triangle_materials[i] = (uint16_t)(i / 2);
    }
    for (int i = 0; i < 6; i++) {
        mesh->materials[i].kd = cube_colours[i];
        mesh->materials[i].kd_texture = &mesh->textures[0];
    }
    return true;
}
