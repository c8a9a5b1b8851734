/* All features in one scene: a statue on a rough mirror, between a ball of chrome, a block of glass
 * and a flying ball, below a lamp and optionally the sky. x points to the left of the picture.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"

#include <string.h>

/* The statue's own materials come last. */
enum { floor_material, glass_material, ball_material, statue_material };

enum { ball_triangles = 5120 };

static const rk_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* A closed box around 0 with flat faces; `half` has half of its sizes. */
static bool make_box(rk_mesh *mesh, rk_vec3 half, rk_error *error)
{
    if (!rk_mesh_init(mesh, 24, 12, 1, RK_MESH_NORMALS, error))
        return false;
    for (uint32_t face = 0; face < 6; face++) {
        float side = face % 2 ? 1 : -1;
        rk_vec3 normal = rk_scale(axes[face / 2], side);
        rk_vec3 u = axes[(face / 2 + 1) % 3], v = rk_cross(normal, u);
        for (uint32_t k = 0; k < 4; k++) {
            rk_vec3 corner =
                rk_madd(rk_madd(normal, u, k == 1 || k == 2 ? 1 : -1), v, k < 2 ? -1 : 1);
            mesh->positions[4 * face + k] = rk_mul(corner, half);
            mesh->normals[4 * face + k] = normal;
        }
        const uint32_t first = 4 * face;
        memcpy(mesh->triangles[2 * face], (uint32_t[3]){first, first + 1, first + 2}, 12);
        memcpy(mesh->triangles[2 * face + 1], (uint32_t[3]){first, first + 2, first + 3}, 12);
    }
    return true;
}

typedef struct part_list {
    rk_mesh floor, block, statue, ball;
} part_list;

static bool make_parts(part_list *parts, uint32_t triangles, rk_error *error)
{
    *parts = (part_list){0};
    return make_box(&parts->floor, rk_vec(30, 0.5f, 30), error) &&
           make_box(&parts->block, rk_vec(0.3f, 0.42f, 0.12f), error) &&
           rk_builtin_make_statue(&parts->statue, triangles, error) &&
           rk_mesh_normalize(&parts->statue, error) &&
           rk_builtin_make_sphere(&parts->ball, ball_triangles, error);
}

static void free_parts(part_list *parts)
{
    rk_mesh_free(&parts->floor);
    rk_mesh_free(&parts->block);
    rk_mesh_free(&parts->statue);
    rk_mesh_free(&parts->ball);
}

static bool assemble(rk_mesh *mesh, const part_list *p, rk_error *error)
{
    const rk_mesh *all[] = {&p->floor, &p->block, &p->statue, &p->ball};
    uint32_t vertices = 0, triangles = 0;
    for (int i = 0; i < 4; i++) {
        vertices += all[i]->vertex_count;
        triangles += all[i]->triangle_count;
    }
    if (!rk_mesh_init(mesh, vertices, triangles, statue_material + p->statue.material_count,
                      RK_MESH_NORMALS, error))
        return false;
    float ground = rk_mesh_bounds(&p->statue).corner[0].y;
    mesh->vertex_count = mesh->triangle_count = 0;
    rk_mesh_append(mesh, &p->floor, rk_vec(0, ground - 0.5f, 0), 1, floor_material);
    rk_mesh_append(mesh, &p->block, rk_vec(-0.78f, ground + 0.421f, -0.42f), 1, glass_material);
    rk_mesh_append(mesh, &p->statue, rk_vec(0, 0, 0), 1, statue_material);
    rk_mesh_append(mesh, &p->ball, rk_vec(0.5f, 0.42f, -0.35f), 0.13f, ball_material);
    mesh->materials[floor_material] = (rk_material){.kd = rk_vec(0.2f, 0.22f, 0.25f),
                                                    .ks = rk_vec(0.35f, 0.35f, 0.37f),
                                                    .shininess = 25,
                                                    .alpha = 1};
    mesh->materials[glass_material] = rk_builtin_glass(rk_vec(0.35f, 0.75f, 0.9f), 0.25f, 0.24f);
    mesh->materials[ball_material] =
        (rk_material){.kd = rk_vec(0.95f, 0.35f, 0.1f), .shininess = 1, .alpha = 1};
    return true;
}

bool rk_builtin_make_cover(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    part_list parts;
    bool ok = make_parts(&parts, number, error) && assemble(mesh, &parts, error);
    free_parts(&parts);
    return ok;
}

void rk_builtin_arrange_cover(rk_scene *scene)
{
    uint32_t ball = scene->mesh.triangle_count - ball_triangles;
    scene->moving[0] = (rk_moving){ball, ball_triangles, {-4, 0.5f, 1.5f}};
    scene->moving_count = 1;
    float ground = scene->mesh.positions[0].y + 1; /* the floor is a box of height 1 */
    scene->spheres[0] = (rk_sphere){rk_vec(0.85f, ground + 0.38f, 0.35f), 0.38f};
    scene->sphere_materials[0] = (rk_material){.kd = rk_vec(0.02f, 0.02f, 0.02f),
                                               .ks = rk_vec(0.92f, 0.92f, 0.9f),
                                               .shininess = 1e5f,
                                               .alpha = 1};
    scene->sphere_count = 1;
    rk_vec3 warm = rk_vec(1, 0.92f, 0.8f);
    scene->lights[0] = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                                  .position = rk_vec(1.2f, 2.4f, -2.2f),
                                  .edge01 = rk_vec(0.9f, 0, 0.5f),
                                  .edge02 = rk_vec(-0.3f, 0.6f, 0.5f),
                                  .colours = {warm, warm, warm, warm}};
    scene->lights[1] = rk_light_point(rk_vec(-3, 2.5f, -2), rk_vec(0.15f, 0.2f, 0.3f));
    scene->light_count = 2;
    scene->camera = (rk_camera){.look_at = rk_vec(0, -0.12f, 0),
                                .distance = 3.2f,
                                .rotation = rk_vec(9, -12, 0),
                                .fov = 42};
}
