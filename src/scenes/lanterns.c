/* A row of lanterns on posts in the water, at night: small things, many times as bright as white.
 * No surface emits light, so they reflect more than arrives: 25 times a weak light beside the
 * camera. Declared in scenes/makers.h. */
#include "scenes/makers.h"

enum { water, wood, material_count };
enum { lantern_count = 6, quads_per_post = 4 };

static const float surface_y = -0.35f, post_height = 0.42f, post_width = 0.03f, radius = 0.07f;

/* The foot of a post: each further back than the one before. */
static rk_vec3 foot_of(uint32_t i)
{
    static const float across[lantern_count] = {0.42f, -0.54f, 0.26f, -0.4f, 0.69f, -0.08f};
    return rk_vec(across[i], surface_y, -0.55f + 0.55f * (float)i);
}

static void put_post(rk_mesh *mesh, rk_vec3 foot)
{
    const rk_vec3 up = rk_vec(0, post_height, 0);
    rk_vec3 corner = rk_add(foot, rk_vec(-post_width / 2, 0, -post_width / 2));
    rk_vec3 side = rk_vec(post_width, 0, 0);
    for (int k = 0; k < quads_per_post; k++) {
        rk_builtin_put_quad(mesh, corner, up, side, wood);
        corner = rk_add(corner, side);
        side = rk_vec(-side.z, 0, side.x);
    }
}

bool rk_builtin_make_lanterns(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_builtin_init_quads(mesh, 1 + lantern_count * quads_per_post, material_count, error))
        return false;
    rk_builtin_put_quad(mesh, rk_vec(-30, surface_y, -5), rk_vec(0, 0, 60), rk_vec(60, 0, 0),
                        water);
    for (uint32_t i = 0; i < lantern_count; i++)
        put_post(mesh, foot_of(i));
    mesh->materials[water] = (rk_material){.kd = rk_vec(0.002f, 0.003f, 0.006f),
                                           .ks = rk_vec(0.22f, 0.25f, 0.3f),
                                           .shininess = 50,
                                           .alpha = 1};
    mesh->materials[wood] =
        (rk_material){.kd = rk_vec(0.6f, 0.42f, 0.28f), .shininess = 1, .alpha = 1};
    return true;
}

void rk_builtin_arrange_lanterns(rk_scene *scene)
{
    static const rk_vec3 colours[] = {{25, 11, 3}, {25, 5, 4},  {24, 18, 8},
                                      {6, 15, 25}, {25, 11, 3}, {8, 22, 10}};
    for (uint32_t i = 0; i < lantern_count; i++) {
        rk_vec3 above = rk_vec(0, post_height + radius, 0);
        scene->spheres[i] = (rk_sphere){rk_add(foot_of(i), above), radius};
        scene->sphere_materials[i] = (rk_material){.kd = colours[i], .shininess = 1, .alpha = 1};
    }
    scene->sphere_count = lantern_count;
    scene->camera = (rk_camera){
        .look_at = rk_vec(0, -0.12f, 0), .distance = 2, .rotation = rk_vec(9, 0, 0), .fov = 38};
    scene->lights[0] = rk_light_point(rk_vec(0, 0.2f, -1.97f), rk_vec(0.14f, 0.14f, 0.14f));
    scene->light_count = 1;
}
