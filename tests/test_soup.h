/* Meshes and rays for testing trees, and a ray's hit found without a tree. */
#ifndef RK_TESTS_TEST_SOUP_H
#define RK_TESTS_TEST_SOUP_H

#include "test.h"

#include "base/random.h"
#include "features/watertight.h"
#include "scene/mesh.h"

/* Triangles with separate corners, not yet placed. */
static inline rk_mesh make_mesh(uint32_t triangles)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3 * triangles, triangles, 1, 0, &error), error);
    for (uint32_t i = 0; i < triangles; i++)
        for (uint32_t k = 0; k < 3; k++)
            mesh.triangles[i][k] = 3 * i + k;
    return mesh;
}

/* A number in [-1, 1), the same for the same three keys. */
static inline float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return 2 * rk_unit_float(rk_case(a, b, c, 1)) - 1;
}

static inline rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(noise(a, b, 0), noise(a, b, 1), noise(a, b, 2));
}

/* Triangles of about `size` scattered in the cube [-1, 1]^3. */
static inline rk_mesh make_soup(uint32_t triangles, float size, uint32_t seed)
{
    rk_mesh mesh = make_mesh(triangles);
    for (uint32_t i = 0; i < triangles; i++) {
        rk_vec3 centre = noise3(seed, 4 * i);
        for (uint32_t k = 0; k < 3; k++)
            mesh.positions[3 * i + k] = rk_madd(centre, noise3(seed, 4 * i + 1 + k), size);
    }
    return mesh;
}

/* One number for all positions and triangles of a mesh: builders only read them. */
static inline uint32_t mesh_checksum(const rk_mesh *mesh)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t corner = mesh->triangles[i][k], bits[3];
            memcpy(bits, &mesh->positions[corner], sizeof bits);
            sum = (sum ^ corner ^ bits[0] ^ bits[1] << 8 ^ bits[2] << 16) * 0x9e3779b1u + k;
        }
    return sum;
}

static inline void check_mesh_unchanged(const rk_mesh *mesh, uint32_t checksum)
{
    rk_check(mesh_checksum(mesh) == checksum,
             "building changed the caller's mesh of %u triangles, which is constant: order "
             "references to its triangles instead",
             mesh->triangle_count);
}

static inline rk_hit closest_by_brute_force(const rk_mesh *mesh, const rk_ray *ray)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->triangles[i];
        rk_triangle triangle = {mesh->positions[corner[0]], mesh->positions[corner[1]],
                                mesh->positions[corner[2]], i};
        rk_triangle_closest(&triangle, ray, &hit);
    }
    return hit;
}

/* Rays from around the mesh through it, every eighth along an axis, some with a bounded t_max. */
static inline rk_ray make_ray(uint32_t i, uint32_t seed, rk_box bounds)
{
    rk_vec3 half = rk_scale(rk_box_extent(bounds), 0.5f);
    rk_vec3 centre = rk_add(bounds.corner[0], half);
    rk_vec3 from = rk_add(centre, rk_mul(rk_scale(noise3(seed, 2 * i), 2), half));
    rk_vec3 to = rk_add(centre, rk_mul(noise3(seed, 2 * i + 1), half));
    rk_vec3 direction = rk_sub(to, from);
    if (i % 8 == 0)
        direction =
            rk_vec(i % 24 == 0 ? 1.0f : 0, i % 24 == 8 ? -1.0f : 0, i % 24 == 16 ? 1.0f : 0);
    return (rk_ray){from, direction, i % 5 == 0 ? 0.75f : INFINITY};
}

#endif
