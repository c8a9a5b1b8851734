/* Moving objects: the teapot and a ball above a floor, each on a path of its own. x points to the
 * left of the picture. Declared in scenes/makers.h. */
#include "scenes/makers.h"

#include <string.h>

enum { floor_material, teapot_material, ball_material, material_count };

static bool make_floor(rk_mesh *mesh, rk_error *error)
{
    if (!rk_mesh_init(mesh, 4, 2, 1, RK_MESH_NORMALS, error))
        return false;
    for (uint32_t i = 0; i < 4; i++) {
        mesh->positions[i] = rk_vec(i & 1 ? 0.74f : -0.74f, -0.35f, i & 2 ? 0.56f : -0.56f);
        mesh->normals[i] = rk_vec(0, 1, 0);
    }
    memcpy(mesh->triangles, (uint32_t[2][3]){{0, 2, 1}, {1, 2, 3}}, sizeof(uint32_t[2][3]));
    return true;
}

static bool assemble(rk_mesh *mesh, const rk_mesh *floor, const rk_mesh *teapot,
                     const rk_mesh *ball, rk_error *error)
{
    if (!rk_mesh_init(mesh, floor->vertex_count + teapot->vertex_count + ball->vertex_count,
                      floor->triangle_count + teapot->triangle_count + ball->triangle_count,
                      material_count, RK_MESH_NORMALS, error))
        return false;
    mesh->vertex_count = mesh->triangle_count = 0;
    rk_mesh_append(mesh, floor, rk_vec(0, 0, 0), 1, floor_material);
    rk_mesh_append(mesh, teapot, rk_vec(0.1f, -0.1f, 0.1f), 0.42f, teapot_material);
    rk_mesh_append(mesh, ball, rk_vec(-0.45f, -0.05f, -0.2f), 0.12f, ball_material);
    mesh->materials[teapot_material].kd = rk_vec(0.85f, 0.45f, 0.2f);
    mesh->materials[ball_material].kd = rk_vec(0.25f, 0.5f, 0.85f);
    return true;
}

enum { ball_triangles = 320 };

bool rk_builtin_make_moving(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    rk_mesh floor = {0}, teapot = {0}, ball = {0};
    bool ok = make_floor(&floor, error) && rk_builtin_make_teapot(&teapot, number, error) &&
              rk_mesh_normalize(&teapot, error) &&
              rk_builtin_make_sphere(&ball, ball_triangles, error) &&
              assemble(mesh, &floor, &teapot, &ball, error);
    rk_mesh_free(&floor);
    rk_mesh_free(&teapot);
    rk_mesh_free(&ball);
    return ok;
}

/* The teapot takes the classic path; the ball rises higher and falls again. */
void rk_builtin_arrange_moving(rk_scene *scene)
{
    uint32_t ball = scene->mesh.triangle_count - ball_triangles;
    scene->moving[0] = (rk_moving){2, ball - 2, {-4, 0.5f, 1.5f}};
    scene->moving[1] = (rk_moving){ball, ball_triangles, {0, -80, 6}};
    scene->moving_count = 2;
    scene->camera.rotation = rk_vec(20, 0, 0);
    scene->camera.distance = 2.2f;
    rk_scene_default_light(scene);
}
