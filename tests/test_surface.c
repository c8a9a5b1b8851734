/* Surfaces at a hit: the point within its error bound, the normals on the right side, and spawned
 * rays that do not hit their triangle again, so that shadows have no specks. */
#include "noise.h"
#include "test.h"

#include "base/interpolate.h"
#include "base/random.h"
#include "features/watertight.h"
#include "scene/surface.h"

/* --- triangles and rays ----------------------------------------------------------------------- */

static rk_mesh make_triangle(int optional_arrays)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3, 1, 1, optional_arrays, &error), error);
    memcpy(mesh.triangles, (uint32_t[1][3]){{0, 1, 2}}, sizeof(uint32_t[1][3]));
    return mesh;
}

/* A triangle with edges of about `scale`, at a distance of up to `offset` from the origin, the
 * third corner within `width` times scale of the opposite edge. */
typedef struct family {
    float scale, offset, width;
} family;

static const family families[] = {
    {1, 0, 1},       {1, 1, 1},         {1e-6f, 0, 1}, {1e-6f, 1e-3f, 1}, {1e6f, 0, 1},
    {1e6f, 1e6f, 1}, {1, 1e3f, 1},      {1, 1e6f, 1},  {1e3f, 1e6f, 1},   {1, 1, 1e-2f},
    {1, 0, 1e-4f},   {1e-3f, 1, 1e-2f}, {1, 0, 0.1f},  {1e6f, 0, 1e-3f},  {1e-6f, 0, 1e-3f},
};

static void place_corners(rk_mesh *mesh, noise *n, family f)
{
    rk_vec3 centre = rk_scale(in_cube(n), f.offset);
    rk_vec3 a = rk_madd(centre, in_cube(n), f.scale);
    rk_vec3 b = rk_madd(centre, in_cube(n), f.scale);
    mesh->positions[0] = a;
    mesh->positions[1] = b;
    mesh->positions[2] = rk_madd(rk_mix(a, b, between(n, 0, 1)), in_cube(n), f.width * f.scale);
}

/* A ray at a point of the triangle, and its hit; false if roundings make it miss. */
static bool aim(const rk_mesh *mesh, noise *n, family f, rk_ray *ray, rk_hit *hit)
{
    const rk_vec3 *p = mesh->positions;
    float u = between(n, 0, 1), v = between(n, 0, 1 - u);
    rk_vec3 target = rk_madd(rk_madd(rk_scale(p[0], 1 - u - v), p[1], u), p[2], v);
    rk_vec3 from = rk_madd(target, in_cube(n), 3 * f.scale);
    *ray = (rk_ray){from, rk_normalize(rk_sub(target, from)), INFINITY};
    *hit = (rk_hit){INFINITY, 0, 0, RK_MISS};
    rk_triangle triangle = {p[0], p[1], p[2], 0};
    return rk_triangle_closest(&triangle, ray, hit);
}

static long double exact_coordinate(const rk_mesh *mesh, const rk_hit *hit, int axis)
{
    long double u = (long double)hit->u, v = (long double)hit->v;
    const rk_vec3 *p = mesh->positions;
    return (1 - u - v) * (long double)rk_axis(p[0], axis) + u * (long double)rk_axis(p[1], axis) +
           v * (long double)rk_axis(p[2], axis);
}

/* --- the point -------------------------------------------------------------------------------- */

static void check_point(const rk_mesh *mesh, const rk_surface *surface, const rk_hit *hit)
{
    for (int axis = 0; axis < 3; axis++) {
        long double off =
            fabsl((long double)rk_axis(surface->point, axis) - exact_coordinate(mesh, hit, axis));
        float bound = rk_axis(surface->point_error, axis);
        rk_check(
            off <= (long double)bound,
            "axis %d: the point at u = %.9g, v = %.9g is %.3Lg off the triangle, but the bound "
            "says %.3g",
            axis, (double)hit->u, (double)hit->v, off, (double)bound);
    }
}

static void the_point_lies_within_its_error_bound(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {1, 0};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 10000; i++) {
            rk_ray ray;
            rk_hit hit;
            rk_surface surface;
            place_corners(&mesh, &n, families[f]);
            if (!aim(&mesh, &n, families[f], &ray, &hit))
                continue;
            rk_surface_at(&surface, &mesh, &ray, &hit);
            check_point(&mesh, &surface, &hit);
        }
    rk_mesh_free(&mesh);
}

static void a_distant_corner_does_not_move_the_point_off_the_opposite_edge(void **state)
{
    (void)state;
    /* 1 - u - v is about 0 there; its error of 2^-25 times 10^6 is a hundred times all others. */
    rk_mesh mesh = make_triangle(0);
    noise n = {2, 0};
    for (int i = 0; i < 50000; i++) {
        mesh.positions[0] = rk_scale(in_cube(&n), 1e6f);
        mesh.positions[1] = in_cube(&n);
        mesh.positions[2] = in_cube(&n);
        float u = between(&n, 0, 0.25f);
        rk_hit hit = {1, u, 1 - u, 0};
        if (hit.u + hit.v > 1)
            continue;
        rk_ray ray = {rk_vec(0, 0, 9), in_cube(&n), INFINITY};
        rk_surface surface;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        check_point(&mesh, &surface, &hit);
    }
    rk_mesh_free(&mesh);
}

static void the_error_bound_is_two_roundings_of_the_coordinates(void **state)
{
    (void)state;
    /* A bound that is too large would pass the tests above. */
    rk_mesh mesh = make_triangle(0);
    noise n = {3, 0};
    for (int i = 0; i < 10000; i++) {
        rk_ray ray;
        rk_hit hit;
        rk_surface surface;
        place_corners(&mesh, &n, families[1]);
        if (!aim(&mesh, &n, families[1], &ray, &hit))
            continue;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        rk_box box = rk_mesh_bounds(&mesh);
        rk_vec3 largest = rk_max3(rk_abs3(box.corner[0]), rk_abs3(box.corner[1]));
        for (int axis = 0; axis < 3; axis++)
            rk_check(rk_axis(surface.point_error, axis) <= 0x1.001p-23f * rk_axis(largest, axis),
                     "axis %d: an error of %.3g for coordinates up to %.3g is more than 2 x 2^-24",
                     axis, (double)rk_axis(surface.point_error, axis),
                     (double)rk_axis(largest, axis));
    }
    rk_mesh_free(&mesh);
}

static void a_surface_has_the_point_weights_and_material_of_its_hit(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3, 2, 3, 0, &error), error);
    mesh.positions[1] = rk_vec(4, 0, 0);
    mesh.positions[2] = rk_vec(0, 8, 0);
    memcpy(mesh.triangles, (uint32_t[2][3]){{0, 0, 0}, {0, 1, 2}}, sizeof(uint32_t[2][3]));
    mesh.triangle_materials[1] = 2;
    rk_ray ray = {rk_vec(1, 4, 3), rk_vec(0, 0, -1), INFINITY};
    rk_hit hit = {3, 0.25f, 0.5f, 1};
    rk_surface surface;
    rk_surface_at(&surface, &mesh, &ray, &hit);
    rk_check(surface.material == &mesh.materials[2], "the material is the hit triangle's");
    rk_check_close(surface.point.x, 1, 0, "a quarter of corner b; all numbers are exact");
    rk_check_close(surface.point.y, 4, 0, "half of corner c");
    rk_check_close(surface.barycentric.x, 0.25, 0, "the rest is corner a's");
    rk_check_close(surface.barycentric.y, 0.25, 0, "u is corner b's");
    rk_check_close(surface.barycentric.z, 0.5, 0, "v is corner c's");
    rk_check_equal(surface.triangle.index, 1, "the triangle's index is copied");
    rk_mesh_free(&mesh);
}

/* --- the normals ------------------------------------------------------------------------------ */

static void face_normals_are_unit_orthogonal_and_face_the_ray(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {4, 0};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 3000; i++) {
            rk_ray ray;
            rk_hit hit;
            rk_surface surface;
            place_corners(&mesh, &n, families[f]);
            if (!aim(&mesh, &n, families[f], &ray, &hit))
                continue;
            rk_surface_at(&surface, &mesh, &ray, &hit);
            const rk_vec3 *p = mesh.positions;
            rk_check_close(rk_length(surface.face_normal), 1, 3e-7, "a few roundings of float");
            rk_check(rk_dot(surface.face_normal, ray.direction) <= 0,
                     "the normal looks away from the ray");
            for (int k = 0; k < 3; k++) {
                rk_vec3 edge = rk_normalize(rk_sub(p[(k + 1) % 3], p[k]));
                /* Roundings of the normal and the edge; a difference of distant corners is exact by
                 * Sterbenz, or rounded once. */
                rk_check_close(rk_dot(surface.face_normal, edge), 0, 1e-6,
                               "the normal is orthogonal to the edges");
            }
            rk_check(memcmp(&surface.normal, &surface.face_normal, sizeof(rk_vec3)) == 0,
                     "without vertex normals the surface is flat");
        }
    rk_mesh_free(&mesh);
}

static void tiny_triangles_keep_their_normal(void **state)
{
    (void)state;
    /* The square of the cross product's length is 10^-120, far below a float's range. */
    rk_mesh mesh = make_triangle(0);
    mesh.positions[1] = rk_vec(1e-30f, 0, 0);
    mesh.positions[2] = rk_vec(0, 1e-30f, 0);
    rk_ray ray = {rk_vec(0, 0, 1), rk_vec(0.6f, 0, -0.8f), INFINITY};
    rk_hit hit = {1, 0.25f, 0.25f, 0};
    rk_surface surface;
    rk_surface_at(&surface, &mesh, &ray, &hit);
    rk_check_close(surface.face_normal.z, 1, 0, "the triangle is in the xy plane");
    for (int i = 0; i < 3; i++)
        mesh.positions[i].z = 1;
    rk_surface_at(&surface, &mesh, &ray, &hit);
    rk_check(rk_surface_spawn(&surface, rk_vec(0, 0, 1)).z > 1, "out on its own side");
    rk_check(rk_surface_spawn(&surface, rk_vec(0, 0, -1)).z < 1, "out on the other");
    rk_mesh_free(&mesh);
}

static void interpolated_normals_are_unit_and_on_the_side_of_the_face_normal(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(RK_MESH_NORMALS);
    noise n = {5, 0};
    for (int i = 0; i < 50000; i++) {
        rk_ray ray;
        rk_hit hit;
        rk_surface surface;
        place_corners(&mesh, &n, families[1]);
        for (int k = 0; k < 3; k++)
            mesh.normals[k] = rk_normalize(in_cube(&n));
        if (!aim(&mesh, &n, families[1], &ray, &hit))
            continue;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        rk_check_close(rk_length(surface.normal), 1, 3e-7, "a few roundings of float");
        rk_check(rk_dot(surface.normal, surface.face_normal) >= 0,
                 "the shading normal is on the other side than the face normal");
    }
    rk_mesh_free(&mesh);
}

static void interpolated_normals_are_weighted_by_the_corners(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(RK_MESH_NORMALS);
    mesh.positions[1] = rk_vec(1, 0, 0);
    mesh.positions[2] = rk_vec(0, 1, 0);
    mesh.normals[0] = rk_vec(1, 0, 0);
    mesh.normals[1] = rk_vec(0, 1, 0);
    mesh.normals[2] = rk_vec(0, 0, 1);
    rk_ray ray = {rk_vec(0, 0, 1), rk_vec(0, 0, -1), INFINITY};
    rk_hit hit = {1, 0.25f, 0.5f, 0};
    rk_surface surface;
    rk_surface_at(&surface, &mesh, &ray, &hit);
    double length = sqrt(0.25 * 0.25 + 0.25 * 0.25 + 0.5 * 0.5);
    rk_check_close(surface.normal.x, 0.25 / length, 2e-7, "weight 1 - u - v");
    rk_check_close(surface.normal.y, 0.25 / length, 2e-7, "weight u");
    rk_check_close(surface.normal.z, 0.5 / length, 2e-7, "weight v");
    rk_mesh_free(&mesh);
}

static void normals_that_cancel_give_way_to_the_face_normal(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(RK_MESH_NORMALS);
    mesh.positions[1] = rk_vec(1, 0, 0);
    mesh.positions[2] = rk_vec(0, 1, 0);
    mesh.normals[1] = rk_vec(1, 0, 0);
    mesh.normals[2] = rk_vec(-1, 0, 0);
    rk_ray ray = {rk_vec(0, 0, -1), rk_vec(0, 0, 1), INFINITY};
    rk_hit hit = {1, 0.5f, 0.5f, 0};
    rk_surface surface;
    rk_surface_at(&surface, &mesh, &ray, &hit);
    rk_check_close(surface.normal.z, -1, 0, "the face's normal, facing the ray");
    rk_mesh_free(&mesh);
}

static bool is_finite(rk_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void triangles_without_area_have_a_unit_normal_and_spawn_rays(void **state)
{
    (void)state;
    const rk_vec3 corners[][3] = {
        {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}},           {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}},           {{1e30f, 0, 0}, {1e30f, 0, 0}, {0, 1e30f, 0}},
        {{1e-40f, 0, 0}, {0, 1e-40f, 0}, {0, 0, 0}},
    };
    for (int arrays = 0; arrays <= RK_MESH_NORMALS; arrays += RK_MESH_NORMALS)
        for (size_t i = 0; i < sizeof corners / sizeof *corners; i++) {
            rk_mesh mesh = make_triangle(arrays);
            memcpy(mesh.positions, corners[i], sizeof corners[i]);
            rk_ray ray = {rk_vec(0, 0, 5), rk_vec(0, 0.6f, -0.8f), INFINITY};
            rk_hit hit = {1, 0.25f, 0.5f, 0};
            rk_surface surface;
            rk_surface_at(&surface, &mesh, &ray, &hit);
            rk_check_close(rk_length(surface.normal), 1, 3e-7, "unit, whatever the triangle");
            rk_check(is_finite(surface.point) && is_finite(surface.point_error), "NaN appeared");
            rk_check(is_finite(rk_surface_spawn(&surface, rk_vec(0, 1, 0))), "NaN appeared");
            rk_check(is_finite(rk_surface_spawn(&surface, rk_vec(0, 0, 0))), "NaN appeared");
            rk_mesh_free(&mesh);
        }
}

/* --- textures --------------------------------------------------------------------------------- */

/* Texture coordinates (0, 0), (1, 0), (0, 1) over a picture of 2 x 1: red left, green right. */
static rk_mesh make_textured_triangle(void)
{
    rk_error error;
    rk_mesh mesh = make_triangle(RK_MESH_TEXCOORDS);
    mesh.positions[1] = rk_vec(1, 0, 0);
    mesh.positions[2] = rk_vec(0, 1, 0);
    mesh.texcoords[1] = (rk_vec2){1, 0};
    mesh.texcoords[2] = (rk_vec2){0, 1};
    mesh.textures = rk_allocate(1, sizeof *mesh.textures, "textures", &error);
    mesh.texture_count = 1;
    rk_check_ok(rk_image_init(&mesh.textures[0].image, 2, 1, &error), error);
    *rk_image_at(&mesh.textures[0].image, 0, 0) = rk_vec(1, 0, 0);
    *rk_image_at(&mesh.textures[0].image, 1, 0) = rk_vec(0, 1, 0);
    mesh.materials[0].kd = rk_vec(0.5f, 0.25f, 0.125f);
    mesh.materials[0].kd_texture = &mesh.textures[0];
    return mesh;
}

static void check_kd(const rk_mesh *mesh, float u, float v, rk_vec3 want, const char *hint)
{
    rk_ray ray = {rk_vec(0, 0, 1), rk_vec(0, 0, -1), INFINITY};
    rk_hit hit = {1, u, v, 0};
    rk_surface surface;
    rk_surface_at(&surface, mesh, &ray, &hit);
    rk_vec3 got = rk_surface_kd(&surface, mesh);
    for (int axis = 0; axis < 3; axis++)
        rk_check_close(rk_axis(got, axis), rk_axis(want, axis), 0, hint);
}

static void the_texture_multiplies_the_diffuse_colour(void **state)
{
    (void)state;
    rk_mesh mesh = make_textured_triangle();
    const rk_vec3 left = {0.5f, 0, 0}, right = {0, 0.25f, 0};
    check_kd(&mesh, 0, 0, left, "the first corner has u = 0");
    check_kd(&mesh, 0.75f, 0, right, "three quarters to the second corner, which has u = 1");
    check_kd(&mesh, 0, 0.75f, left, "the third corner has u = 0");
    mesh.textures[0].filter = RK_TEXTURE_BILINEAR;
    check_kd(&mesh, 0.5f, 0.25f, rk_vec(0.25f, 0.125f, 0), "between two texels, half of each");
    rk_mesh_free(&mesh);
}

static void the_diffuse_colour_is_plain_where_there_is_no_texture(void **state)
{
    (void)state;
    rk_mesh mesh = make_textured_triangle();
    const rk_vec3 plain = mesh.materials[0].kd;
    free(mesh.texcoords);
    mesh.texcoords = NULL;
    check_kd(&mesh, 0.75f, 0, plain, "the mesh has no texture coordinates");
    rk_sphere sphere = {rk_vec(0, 0, 0), 1};
    rk_ray ray = {rk_vec(0, 0, 3), rk_vec(0, 0, -1), INFINITY};
    rk_hit hit = {2, 0, 0, 1};
    rk_surface surface;
    rk_surface_at_sphere(&surface, &sphere, &mesh.materials[0], &ray, &hit);
    rk_check_close(rk_surface_kd(&surface, &mesh).y, plain.y, 0, "a sphere has no coordinates");
    mesh.materials[0].kd_texture = NULL;
    check_kd(&mesh, 0.75f, 0, plain, "the material has no texture");
    rk_mesh_free(&mesh);
}

/* Weights with few binary digits, so that the products are exact. */
static void colours_of_vertices_are_interpolated_and_multiply_all_others(void **state)
{
    (void)state;
    rk_mesh mesh = make_textured_triangle();
    const rk_vec3 plain = mesh.materials[0].kd;
    rk_error error;
    mesh.colours = rk_allocate(3, sizeof *mesh.colours, "colours", &error);
    mesh.colours[0] = rk_vec(1, 0, 0);
    mesh.colours[1] = rk_vec(0, 1, 0.5f);
    mesh.colours[2] = rk_vec(0.5f, 0.25f, 1);
    check_kd(&mesh, 0.75f, 0, rk_vec(0, 0.25f * 0.75f, 0), "the texture is green there");
    mesh.materials[0].kd_texture = NULL;
    check_kd(&mesh, 0, 0, rk_vec(0.5f, 0, 0), "the first corner");
    check_kd(&mesh, 1, 0, rk_vec(0, 0.25f, 0.0625f), "the second corner");
    check_kd(&mesh, 0.25f, 0.25f, rk_mul(plain, rk_vec(0.625f, 0.3125f, 0.375f)),
             "half of the first, a quarter of the others");
    rk_surface sphere = {.material = &mesh.materials[0], .triangle = {.index = RK_MISS}};
    rk_check_close(rk_surface_kd(&sphere, &mesh).y, plain.y, 0, "a sphere has no vertices");
    rk_mesh_free(&mesh);
}

/* --- spawning --------------------------------------------------------------------------------- */

/* Any direction; every second one within a thousandth, or a millionth, of the triangle's plane. */
static rk_vec3 way_out(noise *n, const rk_surface *surface, int i)
{
    if (i % 2 == 0)
        return in_cube(n);
    rk_vec3 along = rk_cross(surface->face_normal, in_cube(n));
    return rk_madd(along, surface->face_normal, between(n, -1, 1) * (i % 4 == 1 ? 1e-3f : 1e-6f));
}

static void check_that_nothing_returns(uint32_t key, family f, int triangles)
{
    rk_mesh mesh = make_triangle(0);
    noise n = {key, 0};
    for (int i = 0; i < triangles; i++) {
        rk_ray ray;
        rk_hit hit;
        rk_surface surface;
        place_corners(&mesh, &n, f);
        if (!aim(&mesh, &n, f, &ray, &hit))
            continue;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        for (int k = 0; k < 8; k++) {
            rk_vec3 direction = rk_scale(way_out(&n, &surface, k), k < 4 ? 1 : 1e3f);
            rk_ray out = {rk_surface_spawn(&surface, direction), direction, INFINITY};
            rk_hit again = {INFINITY, 0, 0, RK_MISS};
            rk_check(!rk_triangle_closest(&surface.triangle, &out, &again),
                     "scale %g, offset %g, width %g: ray %d of triangle %d hit it again at t = "
                     "%.3g: a lit surface would get specks of shadow",
                     (double)f.scale, (double)f.offset, (double)f.width, k, i, (double)again.t);
        }
    }
    rk_mesh_free(&mesh);
}

static void a_spawned_ray_never_hits_its_triangle_again(void **state)
{
    (void)state;
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        check_that_nothing_returns((uint32_t)(100 + f), families[f], 10000);
}

static void a_spawner_gives_the_same_origins(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {27, 0};
    int same = 0, other = 0;
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 1000; i++) {
            rk_ray ray;
            rk_hit hit;
            rk_surface surface;
            rk_spawner spawner;
            rk_vec3 first = rk_vec(0, 0, 0);
            place_corners(&mesh, &n, families[f]);
            if (!aim(&mesh, &n, families[f], &ray, &hit))
                continue;
            rk_surface_at(&surface, &mesh, &ray, &hit);
            rk_spawner_start(&spawner, &surface);
            for (int k = 0; k < 24; k++) {
                rk_vec3 direction = way_out(&n, &surface, k * 5 % 8);
                rk_vec3 want = rk_surface_spawn(&surface, direction);
                rk_vec3 got = rk_spawner_origin(&spawner, direction);
                rk_check(memcmp(&got, &want, sizeof got) == 0,
                         "direction %d: origin (%.9g, %.9g, %.9g) instead of (%.9g, %.9g, %.9g)", k,
                         (double)got.x, (double)got.y, (double)got.z, (double)want.x,
                         (double)want.y, (double)want.z);
                if (k == 0)
                    first = got;
                else if (memcmp(&got, &first, sizeof got) == 0)
                    same++;
                else
                    other++;
            }
        }
    rk_check(same > 1000 && other > 1000, "%d the same, %d others: both should happen", same,
             other);
    rk_mesh_free(&mesh);
}

static void a_ray_is_spawned_on_the_side_of_its_direction(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {6, 0};
    for (int i = 0; i < 20000; i++) {
        rk_ray ray;
        rk_hit hit;
        rk_surface surface;
        place_corners(&mesh, &n, families[0]);
        if (!aim(&mesh, &n, families[0], &ray, &hit))
            continue;
        rk_surface_at(&surface, &mesh, &ray, &hit);
        rk_vec3 direction = rk_normalize(in_cube(&n));
        float cosine = rk_dot(direction, surface.face_normal);
        if (fabsf(cosine) < 1e-3f)
            continue;
        rk_vec3 step = rk_sub(rk_surface_spawn(&surface, direction), surface.point);
        float height = rk_dot(step, surface.face_normal) * copysignf(1, cosine);
        float bound = rk_dot(rk_abs3(surface.face_normal), surface.point_error);
        /* A common edge with a neighbour counts as hit; 1 % for the roundings of this sum. */
        rk_check(height >= 0.99f * bound,
                 "cosine %.3g: the step goes %.3g to its side, the error may be %.3g",
                 (double)cosine, (double)height, (double)bound);
    }
    rk_mesh_free(&mesh);
}

/* The step for ordinary triangles: on each axis the error bound, two roundings of both edges, and a
 * rounding outward, doubled at most a few times where the triangle test needs more. Triangles here
 * are at least a tenth as wide as long. */
static void the_step_is_a_few_error_bounds(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {7, 0};
    size_t doubled = 0, steps = 0;
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 3000; i++) {
            rk_ray ray;
            rk_hit hit;
            rk_surface surface;
            place_corners(&mesh, &n, families[f]);
            if (!aim(&mesh, &n, families[f], &ray, &hit))
                continue;
            rk_surface_at(&surface, &mesh, &ray, &hit);
            const rk_triangle *t = &surface.triangle;
            rk_vec3 ab = rk_sub(t->b, t->a), ac = rk_sub(t->c, t->a);
            float longest = rk_max(rk_length(ab), rk_length(ac));
            float area = rk_length(rk_cross(ab, ac));
            if (!(area > 0.1f * longest * longest))
                continue;
            rk_vec3 away = rk_sub(rk_surface_spawn(&surface, in_cube(&n)), surface.point);
            rk_vec3 step = rk_scale(surface.face_normal, rk_dot(away, surface.face_normal));
            float bound = rk_length(surface.point_error) + 0x1p-22f * longest;
            /* 2 ulp = 4 x 2^-24 |point| is covered by twice the error bound. */
            rk_check(rk_length(step) <= 8 * 3 * bound, "a step of %.3g where the errors are %.3g",
                     (double)rk_length(step), (double)bound);
            doubled += rk_length(step) > 3 * bound;
            steps++;
        }
    rk_check(steps > 10000 && doubled < steps / 100, "%zu of %zu steps had to be lengthened",
             doubled, steps);
    rk_mesh_free(&mesh);
}

static double distance_from_edge(const rk_triangle *t, rk_vec3 weights, rk_dvec3 move, int i)
{
    const rk_dvec3 corners[3] = {rk_widen(t->a), rk_widen(t->b), rk_widen(t->c)};
    rk_dvec3 from = corners[(i + 1) % 3], edge = rk_dmadd(corners[(i + 2) % 3], from, -1);
    rk_dvec3 point = rk_dmadd(move, from, -1), up = rk_dcross(rk_triangle_plane_of(t).normal, edge);
    for (int k = 0; k < 3; k++)
        point = rk_dmadd(point, corners[k], (double)rk_axis(weights, k));
    return rk_ddot(point, up) / rk_dlength(up);
}

/* Errors: weights in float that do not sum to 1 by 2^-24 of the triangle's size. */
static void a_point_close_to_an_edge_is_moved_away_from_all_edges(void **state)
{
    (void)state;
    noise n = {8, 0};
    for (int i = 0; i < 20000; i++) {
        rk_triangle t = {in_cube(&n), in_cube(&n), in_cube(&n), 0};
        t.c = i % 2 ? t.c : rk_madd(t.b, in_cube(&n), 1e-2f);
        float u = between(&n, 0, 1), v = i % 3 ? between(&n, 0, 1 - u) : 0;
        rk_vec3 weights = rk_vec(1 - u - v, u, v);
        double wanted = (double)between(&n, 0, 0.01f), length = 0, nearest = INFINITY;
        double perimeter = (double)(rk_length(rk_sub(t.a, t.b)) + rk_length(rk_sub(t.b, t.c)) +
                                    rk_length(rk_sub(t.c, t.a)));
        double inradius = rk_dlength(rk_triangle_plane_of(&t).normal) / perimeter;
        rk_dvec3 move = rk_surface_inset(&t, weights, wanted), none = {0, 0, 0};
        for (int k = 0; k < 3; k++) {
            nearest = fmin(nearest, distance_from_edge(&t, weights, none, k));
            rk_check(distance_from_edge(&t, weights, move, k) > fmin(wanted, inradius) - 1e-6,
                     "triangle %d: the point is moved to %.3g from edge %d, not to %.3g", i,
                     distance_from_edge(&t, weights, move, k), k, fmin(wanted, inradius));
        }
        length = rk_dlength(move);
        rk_check(nearest < wanted || length == 0, "a point far enough from all edges was moved");
    }
}

/* Away from the middle of an edge: at a right angle, however long and narrow the triangle. */
static void a_point_is_moved_no_farther_than_needed(void **state)
{
    (void)state;
    const rk_triangle sliver = {{0, 0, 0}, {1000, 0, 0}, {0, 1, 0}, 0};
    rk_dvec3 move = rk_surface_inset(&sliver, rk_vec(0.5f, 0.5f, 0), 0.125);
    rk_check_close(move.x, 0, 1e-9, "not along the sliver");
    rk_check_close(move.y, 0.125, 1e-9, "by the distance");
}

/* --- Vectors in registers --------------------------------------------------------------------- */

/* The same formulas as in surface.c, component by component: what vectors in registers must repeat
 * to the bit, because pictures may not depend on how they are computed. */
static float plain_coordinate(float a, float b, float c, const rk_hit *hit)
{
    double u = (double)hit->u, v = (double)hit->v;
    return (float)((1 - u - v) * (double)a + u * (double)b + v * (double)c);
}

static rk_vec3 plain_point(const rk_triangle *t, const rk_hit *hit)
{
    return rk_vec(plain_coordinate(t->a.x, t->b.x, t->c.x, hit),
                  plain_coordinate(t->a.y, t->b.y, t->c.y, hit),
                  plain_coordinate(t->a.z, t->b.z, t->c.z, hit));
}

static rk_vec3 plain_facing(rk_vec3 normal, rk_vec3 side)
{
    return rk_dot(normal, side) < 0 ? rk_negate(normal) : normal;
}

static rk_vec3 plain_face_normal(const rk_triangle *t, const rk_ray *ray)
{
    rk_vec3 backward = rk_negate(ray->direction);
    rk_dvec3 n = rk_triangle_plane_of(t).normal;
    double length = rk_dlength(n), scale = length > 0 ? 1 / length : 0;
    rk_vec3 unit = rk_vec((float)(n.x * scale), (float)(n.y * scale), (float)(n.z * scale));
    unit = plain_facing(unit, backward);
    return rk_dot(unit, unit) > 0 ? unit : rk_normalize(backward);
}

static rk_vec3 plain_normal(const rk_mesh *mesh, const rk_surface *surface)
{
    const rk_vec3 *n = mesh->normals;
    rk_vec3 smooth = rk_normalize(rk_interpolate3(n[0], n[1], n[2], surface->barycentric));
    return rk_dot(smooth, smooth) > 0 ? plain_facing(smooth, surface->face_normal)
                                      : surface->face_normal;
}

static rk_vec3 plain_error(const rk_surface *surface)
{
    const float eps = 0x1p-24f;
    const rk_triangle *t = &surface->triangle;
    rk_vec3 sizes =
        rk_interpolate3(rk_abs3(t->a), rk_abs3(t->b), rk_abs3(t->c), rk_abs3(surface->barycentric));
    return rk_scale(rk_max3(rk_abs3(surface->point), sizes), 2 * eps / (1 - 2 * eps));
}

static void check_bits(const char *what, rk_vec3 got, rk_vec3 want)
{
    rk_check(memcmp(&got, &want, sizeof got) == 0,
             "the %s is (%.9g, %.9g, %.9g), by plain arithmetic (%.9g, %.9g, %.9g)", what,
             (double)got.x, (double)got.y, (double)got.z, (double)want.x, (double)want.y,
             (double)want.z);
}

/* Every fourth triangle lies in a plane x = constant, or in x = 0; every fourth has no area. */
static void flatten(rk_mesh *mesh, int i)
{
    if (i % 4 == 1)
        for (int k = 0; k < 3; k++)
            mesh->positions[k].x = i % 8 == 1 ? mesh->positions[0].x : 0;
    if (i % 4 == 2)
        mesh->positions[2] = mesh->positions[i % 8 == 2];
}

static void a_surface_is_as_by_plain_arithmetic_to_the_bit(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(RK_MESH_NORMALS);
    noise n = {31, 0};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 3000; i++) {
            rk_surface surface;
            place_corners(&mesh, &n, families[f]);
            flatten(&mesh, i);
            for (int k = 0; k < 3; k++)
                mesh.normals[k] = rk_normalize(in_cube(&n));
            rk_ray ray = {in_cube(&n), in_cube(&n), INFINITY};
            rk_hit hit = {1, between(&n, 0, 1), between(&n, 0, 1), 0};
            rk_surface_at(&surface, &mesh, &ray, &hit);
            check_bits("point", surface.point, plain_point(&surface.triangle, &hit));
            check_bits("point's error", surface.point_error, plain_error(&surface));
            check_bits("face normal", surface.face_normal,
                       plain_face_normal(&surface.triangle, &ray));
            check_bits("normal", surface.normal, plain_normal(&mesh, &surface));
        }
    rk_mesh_free(&mesh);
}

static float plain_outward(float value, float step)
{
    return step > 0 ? nextafterf(value, INFINITY) : step < 0 ? nextafterf(value, -INFINITY) : value;
}

static rk_vec3 plain_step(rk_vec3 point, rk_vec3 normal, float distance)
{
    rk_vec3 step = rk_scale(normal, distance), start = rk_add(point, step);
    return rk_vec(plain_outward(start.x, step.x), plain_outward(start.y, step.y),
                  plain_outward(start.z, step.z));
}

static rk_vec3 plain_spawn(const rk_surface *surface, rk_vec3 direction)
{
    const float eps = 0x1p-24f;
    const rk_triangle *t = &surface->triangle;
    const rk_triangle_plane plane = rk_triangle_plane_of(t);
    rk_vec3 normal = plain_facing(surface->face_normal, direction);
    double heading = rk_triangle_plane_heading(&plane, direction);
    double area = rk_triangle_plane_heading(&plane, normal);
    if (heading * area < 0)
        normal = rk_negate(normal);
    rk_vec3 edges = rk_add(rk_abs3(rk_sub(t->b, t->a)), rk_abs3(rk_sub(t->c, t->a)));
    rk_vec3 error = rk_madd(surface->point_error, edges, 2 * eps / (1 - 2 * eps));
    float distance = rk_dot(rk_abs3(normal), error);
    rk_vec3 point = surface->point;
    if (area != 0)
        point = rk_narrow(rk_dmadd(
            rk_widen(point),
            rk_surface_inset(t, surface->barycentric, 6 * rk_dlength(rk_widen(error))), 1));
    rk_vec3 start = plain_step(point, normal, distance);
    for (int i = 0; i < 24; i++, distance *= 2, start = plain_step(point, normal, distance))
        if (heading * rk_triangle_plane_side(&plane, start) > 0 || heading == 0)
            break;
    return start;
}

static void a_ray_starts_as_by_plain_arithmetic_to_the_bit(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(0);
    noise n = {32, 0};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int i = 0; i < 3000; i++) {
            rk_surface surface;
            place_corners(&mesh, &n, families[f]);
            flatten(&mesh, i);
            rk_ray ray = {in_cube(&n), in_cube(&n), INFINITY};
            rk_hit hit = {1, between(&n, 0, 1), between(&n, 0, 1), 0};
            rk_surface_at(&surface, &mesh, &ray, &hit);
            for (int k = 0; k < 4; k++) {
                rk_vec3 direction = way_out(&n, &surface, k);
                check_bits("start", rk_surface_spawn(&surface, direction),
                           plain_spawn(&surface, direction));
            }
        }
    rk_mesh_free(&mesh);
}

/* On a sphere, which has no plane: the step is the point's error alone. It may end at 0, whose next
 * floats have another sign or none, or beyond the largest float. */
static void a_step_may_end_at_zero_or_infinity(void **state)
{
    (void)state;
    static const float at[] = {0x1p-20f, -0x1p-20f, 0x1.fffffep127f, -0x1.fffffep127f, 0x1p-149f};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        for (int side = -1; side <= 1; side += 2) {
            const rk_vec3 direction = rk_vec((float)side, 0, 0);
            const rk_surface surface = {.point = rk_vec(at[i], at[i], 0),
                                        .point_error = rk_vec(fabsf(at[i]), 0, 0),
                                        .face_normal = direction,
                                        .triangle = {.index = RK_MISS}};
            check_bits("start", rk_surface_spawn(&surface, direction),
                       plain_spawn(&surface, direction));
        }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_surface_has_the_point_weights_and_material_of_its_hit),
    cmocka_unit_test(the_point_lies_within_its_error_bound),
    cmocka_unit_test(a_distant_corner_does_not_move_the_point_off_the_opposite_edge),
    cmocka_unit_test(the_error_bound_is_two_roundings_of_the_coordinates),
    cmocka_unit_test(face_normals_are_unit_orthogonal_and_face_the_ray),
    cmocka_unit_test(tiny_triangles_keep_their_normal),
    cmocka_unit_test(interpolated_normals_are_unit_and_on_the_side_of_the_face_normal),
    cmocka_unit_test(interpolated_normals_are_weighted_by_the_corners),
    cmocka_unit_test(normals_that_cancel_give_way_to_the_face_normal),
    cmocka_unit_test(triangles_without_area_have_a_unit_normal_and_spawn_rays),
    cmocka_unit_test(the_texture_multiplies_the_diffuse_colour),
    cmocka_unit_test(the_diffuse_colour_is_plain_where_there_is_no_texture),
    cmocka_unit_test(colours_of_vertices_are_interpolated_and_multiply_all_others),
    cmocka_unit_test(a_spawned_ray_never_hits_its_triangle_again),
    cmocka_unit_test(a_spawner_gives_the_same_origins),
    cmocka_unit_test(a_ray_is_spawned_on_the_side_of_its_direction),
    cmocka_unit_test(the_step_is_a_few_error_bounds),
    cmocka_unit_test(a_point_close_to_an_edge_is_moved_away_from_all_edges),
    cmocka_unit_test(a_point_is_moved_no_farther_than_needed),
    cmocka_unit_test(a_surface_is_as_by_plain_arithmetic_to_the_bit),
    cmocka_unit_test(a_ray_starts_as_by_plain_arithmetic_to_the_bit),
    cmocka_unit_test(a_step_may_end_at_zero_or_infinity),
};

RK_SUITE("surface", tests)
