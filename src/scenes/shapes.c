/* The simplest scenes: a triangle, a sphere, a sphere beside an exact one.
 * Declared in scenes/makers.h. */
#include "scenes/makers.h"
#include "scenes/ring.h"

#include <string.h>

bool rk_builtin_make_triangle(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_mesh_init(mesh, 3, 1, 1, 0, error))
        return false;
    /* Equilateral, facing the default camera, which looks along +z. */
    const float half_root_3 = 0.8660254f;
    mesh->positions[0] = rk_vec(0, 1, 0);
    mesh->positions[1] = rk_vec(-half_root_3, -0.5f, 0);
    mesh->positions[2] = rk_vec(half_root_3, -0.5f, 0);
    memcpy(mesh->triangles, (uint32_t[1][3]){{0, 2, 1}}, sizeof(uint32_t[1][3]));
    mesh->materials[0].kd = rk_vec(0.8f, 0.5f, 0.2f);
    return true;
}

/* --- sphere: an icosahedron, each edge divided into f parts, projected onto the sphere ------- */

/* Corners of the icosahedron of radius 1 with poles on the y axis: between them are two
 * pentagons. */
typedef struct corner {
    double x, y, z;
} corner;

static corner pentagon_corner(uint32_t s, double y, double offset)
{
    double angle = 6.28318530717958647692 * (s + offset) / 5;
    return (corner){2 / sqrt(5) * sin(angle), y, 2 / sqrt(5) * cos(angle)};
}

static corner low_corner(uint32_t s)
{
    return pentagon_corner(s, -1 / sqrt(5), 0);
}

static corner high_corner(uint32_t s)
{
    return pentagon_corner(s, 1 / sqrt(5), 0.5);
}

/* The point of a face with the weights i, j, k, projected onto the sphere. */
static rk_vec3 face_point(corner a, uint32_t i, corner b, uint32_t j, corner c, uint32_t k)
{
    double x = a.x * i + b.x * j + c.x * k;
    double y = a.y * i + b.y * j + c.y * k;
    double z = a.z * i + b.z * j + c.z * k;
    double length = sqrt(x * x + y * y + z * z);
    return rk_vec((float)(x / length), (float)(y / length), (float)(z / length));
}

/* Vertex j of sector s (a fifth) of ring k: rings 0 to f widen from the lower pole, f to 2 f run
 * between the pentagons, 2 f to 3 f narrow to the upper pole. */
static rk_vec3 sphere_point(uint32_t f, uint32_t k, uint32_t s, uint32_t j)
{
    const corner lowest = {0, -1, 0}, highest = {0, 1, 0};
    if (k <= f)
        return face_point(low_corner(s), k - j, low_corner(s + 1), j, lowest, f - k);
    if (k >= 2 * f)
        return face_point(high_corner(s), 3 * f - k - j, high_corner(s + 1), j, highest, k - 2 * f);
    uint32_t up = k - f, down = f - up;
    if (j <= down)
        return face_point(low_corner(s), down - j, low_corner(s + 1), j, high_corner(s), up);
    return face_point(low_corner(s + 1), down, high_corner(s), up - (j - down), high_corner(s + 1),
                      j - down);
}

static uint32_t sphere_sector(uint32_t f, uint32_t k)
{
    return k <= f ? k : k <= 2 * f ? f : 3 * f - k;
}

bool rk_builtin_make_sphere(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    uint32_t f = 1;
    while (20 * f * f < number)
        f++;
    if (!rk_mesh_init(mesh, 10 * f * f + 2, 20 * f * f, 1, RK_MESH_NORMALS, error))
        return false;
    uint32_t(*row)[3] = mesh->triangles;
    rk_ring below = {0, 0};
    for (uint32_t k = 0; k <= 3 * f; k++) {
        uint32_t sector = sphere_sector(f, k);
        rk_ring ring = {below.first + below.count, sector ? 5 * sector : 1};
        for (uint32_t i = 0; i < ring.count; i++)
            mesh->positions[ring.first + i] =
                sphere_point(f, k, sector ? i / sector : 0, sector ? i % sector : 0);
        if (k > 0)
            row = rk_ring_stitch(row, below, ring);
        below = ring;
    }
    memcpy(mesh->normals, mesh->positions, mesh->vertex_count * sizeof *mesh->normals);
    return true;
}

/* Two balls on a floor, at x and -x; x points to the left of the picture. */
static const float ball_x = 0.5f, ball_radius = 0.48f;

bool rk_builtin_make_spheres(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    rk_mesh ball;
    if (!rk_builtin_make_sphere(&ball, number, error))
        return false;
    uint32_t v = ball.vertex_count, t = ball.triangle_count;
    bool ok = rk_mesh_init(mesh, v + 4, t + 2, 1, RK_MESH_NORMALS, error);
    if (ok) {
        for (uint32_t i = 0; i < v; i++)
            mesh->positions[i] = rk_madd(rk_vec(ball_x, 0, 0), ball.positions[i], ball_radius);
        memcpy(mesh->normals, ball.normals, v * sizeof *mesh->normals);
        memcpy(mesh->triangles, ball.triangles, t * sizeof *mesh->triangles);
        for (uint32_t i = 0; i < 4; i++) {
            mesh->positions[v + i] =
                rk_vec(i & 1 ? 1.1f : -1.1f, -ball_radius, i & 2 ? 0.8f : -0.8f);
            mesh->normals[v + i] = rk_vec(0, 1, 0);
        }
        const uint32_t floor[2][3] = {{v, v + 2, v + 1}, {v + 1, v + 2, v + 3}};
        memcpy(mesh->triangles[t], floor, sizeof floor);
    }
    rk_mesh_free(&ball);
    return ok;
}

void rk_builtin_arrange_spheres(rk_scene *scene)
{
    scene->spheres[0] = (rk_sphere){rk_vec(-ball_x, 0, 0), ball_radius};
    scene->sphere_materials[0] = scene->mesh.materials[0];
    scene->sphere_count = 1;
    rk_scene_default_light(scene);
}
