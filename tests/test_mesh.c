/* Meshes: made, refused when broken, scaled into the unit ball. */
#include "test.h"

#include "scene/mesh.h"

static rk_mesh make_square(void)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 4, 2, 1, 0, &error), error);
    mesh.positions[0] = rk_vec(1, 1, 5);
    mesh.positions[1] = rk_vec(3, 1, 5);
    mesh.positions[2] = rk_vec(3, 3, 5);
    mesh.positions[3] = rk_vec(1, 3, 5);
    memcpy(mesh.triangles, (uint32_t[2][3]){{0, 1, 2}, {0, 2, 3}}, sizeof(uint32_t[2][3]));
    return mesh;
}

static void a_valid_mesh_is_accepted(void **state)
{
    (void)state;
    rk_mesh mesh = make_square();
    rk_error error;
    rk_check_ok(rk_mesh_validate(&mesh, "square", &error), error);
    rk_mesh_free(&mesh);
}

static void an_index_out_of_range_is_refused_with_its_place(void **state)
{
    (void)state;
    rk_mesh mesh = make_square();
    mesh.triangles[1][2] = 4;
    rk_error error;
    rk_check(!rk_mesh_validate(&mesh, "square.obj", &error), "index 4 of 4 vertices was accepted");
    rk_check_error_names(error, "square.obj");
    rk_check_error_names(error, "triangle 1");
    rk_mesh_free(&mesh);
}

static void nan_and_infinity_are_refused_with_their_place(void **state)
{
    (void)state;
    const float broken[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        rk_mesh mesh = make_square();
        mesh.positions[3].y = broken[i];
        rk_error error;
        rk_check(!rk_mesh_validate(&mesh, "square", &error), "%f was accepted", (double)broken[i]);
        rk_check_error_names(error, "vertex 3");
        rk_mesh_free(&mesh);
    }
}

static void a_broken_material_is_refused_with_its_place(void **state)
{
    (void)state;
    rk_mesh mesh = make_square();
    const rk_material valid = mesh.materials[0];
    rk_material broken[10];
    for (int i = 0; i < 10; i++)
        broken[i] = valid;
    broken[0].kd.y = NAN;
    broken[1].ks.z = INFINITY;
    broken[2].shininess = -1;
    broken[3].alpha = 1.5f;
    broken[4].alpha = NAN;
    broken[5].absorption.x = -1e-30f;
    broken[6].absorption.y = -1;
    broken[7].absorption.z = -INFINITY;
    broken[8].absorption.x = INFINITY;
    broken[9].absorption.y = NAN;
    for (int i = 0; i < 10; i++) {
        rk_error error;
        mesh.materials[0] = broken[i];
        rk_check(!rk_mesh_validate(&mesh, "square", &error), "material %d was accepted", i);
        rk_check_error_names(error, "square: material 0");
        rk_check_error_names(error, i < 5 ? "colour" : "absorption");
    }
    mesh.materials[0].absorption = rk_vec(0, 1, 1e30f);
    rk_error error;
    rk_check_ok(rk_mesh_validate(&mesh, "square", &error), error);
    rk_mesh_free(&mesh);
}

static void a_colour_that_is_not_finite_is_refused(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3, 1, 1, RK_MESH_COLOURS, &error), error);
    rk_check_ok(rk_mesh_validate(&mesh, "red", &error), error);
    mesh.colours[2].y = NAN;
    rk_check(!rk_mesh_validate(&mesh, "red", &error), "NaN was accepted");
    rk_check_error_names(error, "red: the colour of vertex 2");
    rk_mesh_free(&mesh);
}

/* --- textures -------------------------------------------------------------------------------- */

static rk_mesh make_textured_square(void)
{
    rk_mesh mesh = make_square();
    rk_error error;
    mesh.textures = rk_allocate(2, sizeof *mesh.textures, "textures", &error);
    mesh.texture_count = 2;
    for (int i = 0; i < 2; i++)
        rk_check_ok(rk_image_init(&mesh.textures[i].image, 4, 4, &error), error);
    mesh.materials[0].kd_texture = &mesh.textures[1];
    return mesh;
}

static void a_texture_is_one_of_the_meshs_and_has_an_image(void **state)
{
    (void)state;
    rk_mesh mesh = make_textured_square();
    rk_texture stranger = mesh.textures[1];
    rk_error error;
    rk_check_ok(rk_mesh_validate(&mesh, "square", &error), error);
    mesh.materials[0].kd_texture = &stranger;
    rk_check(!rk_mesh_validate(&mesh, "square", &error), "a stranger's texture was accepted");
    rk_check_error_names(error, "material 0");
    mesh.materials[0].kd_texture = &mesh.textures[1];
    rk_image_free(&mesh.textures[1].image);
    rk_check(!rk_mesh_validate(&mesh, "square", &error), "a texture without image was accepted");
    rk_mesh_free(&mesh);
}

/* If images are not freed, AddressSanitizer reports the leak. */
static void a_mesh_frees_its_textures_and_may_be_freed_again(void **state)
{
    (void)state;
    rk_mesh mesh = make_textured_square();
    rk_mesh_free(&mesh);
    rk_check(mesh.textures == NULL && mesh.texture_count == 0, "the textures are still there");
    rk_mesh_free(&mesh);
}

/* --- moving and smoothing -------------------------------------------------------------------- */

static void normalizing_puts_the_mean_at_zero_and_the_farthest_vertex_at_one(void **state)
{
    (void)state;
    rk_mesh mesh = make_square();
    rk_error error;
    rk_check_ok(rk_mesh_normalize(&mesh, &error), error);
    /* The square's corners are at distance sqrt 2 from its centre (2, 2, 5). */
    rk_check_close(mesh.positions[0].x, -0.70710678, 1e-7, "one rounding to float");
    rk_check_close(mesh.positions[2].y, 0.70710678, 1e-7, "one rounding to float");
    rk_check_close(mesh.positions[2].z, 0, 0, "the square is in its centre's plane");
    rk_mesh_free(&mesh);
}

static void a_vertex_stored_twice_counts_once_in_the_mean(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 5, 1, 1, 0, &error), error);
    /* Distinct points: -1, 1 and (0 = -0); the mean is 0 only if -1 and the zeros count once. */
    const float x[] = {-1, -1, 1, 0, -0.0f};
    for (int i = 0; i < 5; i++)
        mesh.positions[i] = rk_vec(x[i], 0, 0);
    rk_check_ok(rk_mesh_normalize(&mesh, &error), error);
    rk_check_close(mesh.positions[0].x, -1, 0, "the mean should be of distinct vertices");
    rk_mesh_free(&mesh);
}

static void a_mesh_of_one_point_normalizes_to_zero(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 1, 0, 1, 0, &error), error);
    mesh.positions[0] = rk_vec(7, 8, 9);
    rk_check_ok(rk_mesh_normalize(&mesh, &error), error);
    rk_check_close(rk_length(mesh.positions[0]), 0, 0, "no division by the zero radius");
    rk_mesh_free(&mesh);
}

static void huge_coordinates_normalize_without_overflow(void **state)
{
    (void)state;
    rk_mesh mesh = make_square();
    for (int i = 0; i < 4; i++)
        mesh.positions[i] = rk_scale(mesh.positions[i], 5e37f);
    rk_error error;
    rk_check_ok(rk_mesh_normalize(&mesh, &error), error);
    rk_check_close(mesh.positions[0].x, -0.70710678, 1e-6,
                   "computed in double, so the squares fit");
    rk_mesh_free(&mesh);
}

static void smooth_normals_weigh_faces_by_area(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 4, 2, 1, 0, &error), error);
    /* Two faces on the x axis: one in the xy plane with area 1, one in the xz plane with area 3. */
    mesh.positions[1] = rk_vec(2, 0, 0);
    mesh.positions[2] = rk_vec(0, 1, 0);
    mesh.positions[3] = rk_vec(0, 0, 3);
    memcpy(mesh.triangles, (uint32_t[2][3]){{0, 1, 2}, {0, 3, 1}}, sizeof(uint32_t[2][3]));
    rk_check_ok(rk_mesh_smooth(&mesh, &error), error);
    rk_check_close(mesh.normals[0].z, 1 / sqrt(10), 1e-7, "(0, 3, 1) / sqrt 10");
    rk_check_close(mesh.normals[0].y, 3 / sqrt(10), 1e-7, "(0, 3, 1) / sqrt 10");
    rk_check_close(mesh.normals[2].z, 1, 1e-7, "a corner of one face has that face's normal");
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_valid_mesh_is_accepted),
    cmocka_unit_test(an_index_out_of_range_is_refused_with_its_place),
    cmocka_unit_test(nan_and_infinity_are_refused_with_their_place),
    cmocka_unit_test(a_broken_material_is_refused_with_its_place),
    cmocka_unit_test(a_colour_that_is_not_finite_is_refused),
    cmocka_unit_test(a_texture_is_one_of_the_meshs_and_has_an_image),
    cmocka_unit_test(a_mesh_frees_its_textures_and_may_be_freed_again),
    cmocka_unit_test(normalizing_puts_the_mean_at_zero_and_the_farthest_vertex_at_one),
    cmocka_unit_test(a_vertex_stored_twice_counts_once_in_the_mean),
    cmocka_unit_test(a_mesh_of_one_point_normalizes_to_zero),
    cmocka_unit_test(huge_coordinates_normalize_without_overflow),
    cmocka_unit_test(smooth_normals_weigh_faces_by_area),
};

RK_SUITE("mesh", tests)
