/* Scenes that show light behind coloured glass: two thin panes, one in front of the other, and two
 * blocks of the same glass, thin and thick. x points to the left of the picture.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"

rk_material rk_builtin_glass(rk_vec3 colour, float alpha, float thickness)
{
    return (rk_material){.kd = colour,
                         .alpha = alpha,
                         .absorption =
                             rk_vec(-logf(colour.x) / thickness, -logf(colour.y) / thickness,
                                    -logf(colour.z) / thickness)};
}

void rk_builtin_put_quad(rk_mesh *mesh, rk_vec3 corner, rk_vec3 a, rk_vec3 b, uint16_t material)
{
    const rk_vec3 corners[4] = {corner, rk_add(corner, a), rk_add(rk_add(corner, a), b),
                                rk_add(corner, b)};
    for (uint32_t i = 0; i < 4; i++)
        mesh->positions[mesh->vertex_count + i] = corners[i];
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t *row = mesh->triangles[mesh->triangle_count];
        row[0] = mesh->vertex_count;
        row[1] = mesh->vertex_count + 1 + half;
        row[2] = mesh->vertex_count + 2 + half;
        mesh->triangle_materials[mesh->triangle_count++] = material;
    }
    mesh->vertex_count += 4;
}

bool rk_builtin_init_quads(rk_mesh *mesh, uint32_t quads, uint32_t materials, rk_error *error)
{
    if (!rk_mesh_init(mesh, 4 * quads, 2 * quads, materials, 0, error))
        return false;
    mesh->vertex_count = mesh->triangle_count = 0;
    return true;
}

/* --- two panes ------------------------------------------------------------------------------- */

enum { plaster, red, yellow, pane_materials };

/* A pane that faces the viewer. The left and the right one overlap in about the middle third. */
static void put_pane(rk_mesh *mesh, bool left, bool in_front, uint16_t material)
{
    const float x = left ? -0.15f : -0.35f, z = in_front ? -0.15f : 0;
    rk_builtin_put_quad(mesh, rk_vec(x, -0.45f, z), rk_vec(0, 0.65f, 0), rk_vec(0.5f, 0, 0),
                        material);
}

/* Red is on the left and yellow on the right, whichever is in front. */
bool rk_builtin_make_panes(rk_mesh *mesh, uint32_t yellow_first, rk_error *error)
{
    if (!rk_builtin_init_quads(mesh, 4, pane_materials, error))
        return false;
    rk_builtin_put_quad(mesh, rk_vec(-0.7f, -0.5f, -0.5f), rk_vec(0, 0, 1), rk_vec(1.4f, 0, 0),
                        plaster);
    rk_builtin_put_quad(mesh, rk_vec(-0.7f, -0.5f, 0.5f), rk_vec(0, 1, 0), rk_vec(1.4f, 0, 0),
                        plaster);
    put_pane(mesh, true, !yellow_first, red);
    put_pane(mesh, false, yellow_first, yellow);
    mesh->materials[red].kd = rk_vec(0.9f, 0.1f, 0.1f);
    mesh->materials[yellow].kd = rk_vec(0.9f, 0.8f, 0.1f);
    mesh->materials[red].alpha = mesh->materials[yellow].alpha = 0.5f;
    return true;
}

/* Light from the left, viewer on the right: the shadow lies beside the panes. */
void rk_builtin_arrange_panes(rk_scene *scene)
{
    scene->camera.rotation = rk_vec(10, 24, 0);
    scene->camera.distance = 2.1f;
    scene->lights[0] = rk_light_point(rk_vec(0.7f, 0.4f, -1.6f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}

/* --- two blocks ------------------------------------------------------------------------------ */

enum { stone, glass, block_materials };

static void put_block(rk_mesh *mesh, rk_vec3 low, rk_vec3 size)
{
    const rk_vec3 x = {size.x, 0, 0}, y = {0, size.y, 0}, z = {0, 0, size.z};
    rk_builtin_put_quad(mesh, low, y, x, glass);
    rk_builtin_put_quad(mesh, low, z, y, glass);
    rk_builtin_put_quad(mesh, low, x, z, glass);
    rk_builtin_put_quad(mesh, rk_add(low, z), x, y, glass);
    rk_builtin_put_quad(mesh, rk_add(low, x), y, z, glass);
    rk_builtin_put_quad(mesh, rk_add(low, y), z, x, glass);
}

/* The blocks end a thousandth above the floor, so that a ray hits the two at different
 * distances. */
bool rk_builtin_make_glass(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_builtin_init_quads(mesh, 13, block_materials, error))
        return false;
    rk_builtin_put_quad(mesh, rk_vec(-0.7f, -0.35f, -0.6f), rk_vec(0, 0, 1.2f), rk_vec(1.4f, 0, 0),
                        stone);
    put_block(mesh, rk_vec(0.1f, -0.349f, 0.02f), rk_vec(0.4f, 0.35f, 0.06f));
    put_block(mesh, rk_vec(-0.5f, -0.349f, -0.15f), rk_vec(0.4f, 0.35f, 0.4f));
    mesh->materials[glass] = rk_builtin_glass(rk_vec(0.35f, 0.75f, 0.55f), 0.3f, 0.4f);
    return true;
}

/* The light is behind the blocks: their shadows lie in front. */
void rk_builtin_arrange_glass(rk_scene *scene)
{
    scene->camera.rotation = rk_vec(40, 0, 0);
    scene->camera.distance = 2.1f;
    scene->lights[0] = rk_light_point(rk_vec(0, 1.6f, 1.6f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}
