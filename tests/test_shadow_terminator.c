/* The edge of a shadow on a smooth mesh of few faces: as on the surface that its normals describe,
 * without black faces. Flat meshes are as before, to the bit. */
#include "test_scene.h"

#include "base/random.h"
#include "scene/surface.h"

enum { side = 120 };

/* A ball of slices times stacks faces, each of two triangles, or of one at the poles. */
static rk_scene make_ball(uint32_t slices, uint32_t stacks, int arrays)
{
    const uint32_t corners = slices * (stacks + 1);
    rk_scene scene = {.name = "ball", .camera = {.distance = 3, .fov = 50}};
    rk_error error;
    rk_check_ok(rk_mesh_init(&scene.mesh, corners, 2 * slices * (stacks - 1), 1, arrays, &error),
                error);
    for (uint32_t i = 0; i < corners; i++) {
        float down = RK_PI * (float)(i / slices) / (float)stacks;
        float round = 2 * RK_PI * (float)(i % slices) / (float)slices;
        scene.mesh.positions[i] =
            rk_vec(sinf(down) * cosf(round), cosf(down), sinf(down) * sinf(round));
        if (arrays & RK_MESH_NORMALS)
            scene.mesh.normals[i] = scene.mesh.positions[i];
    }
    uint32_t(*t)[3] = scene.mesh.triangles;
    for (uint32_t stack = 0; stack < stacks; stack++)
        for (uint32_t i = 0; i < slices; i++) {
            uint32_t a = stack * slices + i, b = stack * slices + (i + 1) % slices;
            if (stack > 0)
                memcpy(t++, (uint32_t[3]){a, b, a + slices}, sizeof *t);
            if (stack + 1 < stacks)
                memcpy(t++, (uint32_t[3]){b, b + slices, a + slices}, sizeof *t);
        }
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    return scene;
}

static test_picture draw_with(const rk_scene *scene, bool shadows, bool face_shadows)
{
    rk_render_options options = rk_render_options_default();
    options.face_shadows = face_shadows;
    options.width = options.height = side;
    options.shadows = shadows;
    return test_render(scene, options, 1);
}

static test_picture draw(const rk_scene *scene, bool shadows)
{
    return draw_with(scene, shadows, false);
}

/* A ball that nothing else shades is lit wherever its normals face the light. */
static void check_lit_side(rk_vec3 light)
{
    rk_scene scene = make_ball(10, 6, RK_MESH_NORMALS);
    test_scene_light(&scene, light, rk_vec(1, 1, 1));
    test_picture shaded = draw(&scene, true), lit = draw(&scene, false);
    uint32_t black = 0, all = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        all += lit.image.pixels[i].x > 0;
        black += lit.image.pixels[i].x > 0 && !(shaded.image.pixels[i].x > 0);
    }
    rk_check(all > 500, "the light's side should be seen");
    rk_check(black == 0,
             "light at (%g, %g, %g): %u of %u pixels that the normals light are black: shadow rays "
             "enter the faces that are turned away",
             (double)light.x, (double)light.y, (double)light.z, black, all);
    rk_image_free(&shaded.image);
    rk_image_free(&lit.image);
    rk_scene_free(&scene);
}

static void a_ball_of_few_faces_has_no_black_faces_on_its_lit_side(void **state)
{
    (void)state;
    check_lit_side(rk_vec(5, 0, 0));
    check_lit_side(rk_vec(4, 3, 1));
    check_lit_side(rk_vec(-2, -3, -2));
    check_lit_side(rk_vec(0.5f, 4, 0));
}

static void an_option_keeps_the_black_faces_and_nothing_else_differs(void **state)
{
    (void)state;
    rk_scene scene = make_ball(10, 6, RK_MESH_NORMALS);
    test_scene_light(&scene, rk_vec(5, 2, 0), rk_vec(1, 1, 1));
    test_picture shaded = draw(&scene, true), faces = draw_with(&scene, true, true);
    uint32_t black = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        const rk_vec3 *was = &faces.image.pixels[i], *is = &shaded.image.pixels[i];
        black += !(was->x > 0) && is->x > 0;
        rk_check(!(was->x > 0) || memcmp(was, is, sizeof *is) == 0, "pixel %u is lit by both", i);
    }
    rk_check(black > 100, "with the option, %u pixels are black that are not without it", black);
    rk_image_free(&shaded.image);
    rk_image_free(&faces.image);
    rk_scene_free(&scene);
}

/* With an area light, whose shadow rays are grouped: as without shadows, but for the quadrature. */
static void an_area_light_has_no_black_faces_either(void **state)
{
    (void)state;
    rk_scene scene = make_ball(10, 6, RK_MESH_NORMALS);
    scene.lights[scene.light_count++] =
        (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                   .position = rk_vec(4, -0.5f, -0.5f),
                   .edge01 = rk_vec(0, 1, 0),
                   .edge02 = rk_vec(0, 0, 1),
                   .colours = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
    test_picture shaded = draw(&scene, true), lit = draw(&scene, false);
    for (uint32_t i = 0; i < side * side; i++)
        rk_check_close(shaded.image.pixels[i].x, lit.image.pixels[i].x, 1e-3,
                       "nothing occludes the light of a ball's lit side");
    rk_image_free(&shaded.image);
    rk_image_free(&lit.image);
    rk_scene_free(&scene);
}

/* The mean difference from the exact ball, where the normals face the light and the faces, which a
 * flat ball shows black, do not. There the error was the light itself: `black` asks for that. */
static double error_of(const test_picture pictures[3], const test_picture *lit, bool black)
{
    double sum = 0, count = 0;
    for (uint32_t i = 0; i < side * side; i++)
        if (lit->image.pixels[i].x > 0 && !(pictures[1].image.pixels[i].x > 0)) {
            double value = black ? 0 : (double)pictures[0].image.pixels[i].x;
            sum += fabs(value - (double)pictures[2].image.pixels[i].x);
            count++;
        }
    return sum / count;
}

static void the_error_of_a_ball_of_few_faces_falls(void **state)
{
    (void)state;
    rk_scene scenes[3] = {make_ball(10, 6, RK_MESH_NORMALS), make_ball(10, 6, 0),
                          make_ball(200, 120, RK_MESH_NORMALS)};
    test_picture pictures[3];
    for (int i = 0; i < 3; i++) {
        test_scene_light(&scenes[i], rk_vec(5, 2, 0), rk_vec(1, 1, 1));
        pictures[i] = draw(&scenes[i], true);
    }
    test_picture lit = draw(&scenes[0], false);
    double now = error_of(pictures, &lit, false);
    double before = error_of(pictures, &lit, true);
    rk_check(now < 0.5 * before,
             "a mean error of %.4f; if shadow rays start at the faces, it is %.4f", now, before);
    rk_image_free(&lit.image);
    for (int i = 0; i < 3; i++) {
        rk_image_free(&pictures[i].image);
        rk_scene_free(&scenes[i]);
    }
}

/* --- Where nothing changes -------------------------------------------------------------------- */

static rk_vec3 in_cube(uint32_t key, uint32_t dimension)
{
    float x[3];
    for (uint32_t i = 0; i < 3; i++)
        x[i] = 2 * rk_unit_float(rk_hash(key, dimension, i, 9)) - 1;
    return rk_vec(x[0], x[1], x[2]);
}

/* Points and directions of a mesh: how many rays to lights start elsewhere than other rays. */
static uint32_t moved_starts(const rk_mesh *mesh)
{
    uint32_t moved = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        float u = rk_unit_float(rk_hash(i, 1, 2, 3));
        rk_hit hit = {1, u, (1 - u) * rk_unit_float(rk_hash(i, 2, 2, 3)),
                      i % (uint32_t)mesh->triangle_count};
        rk_ray ray = {rk_vec(0, 0, 0), in_cube(i, 1), INFINITY};
        rk_vec3 direction = in_cube(i, 2);
        rk_surface surface;
        rk_spawner spawner;
        rk_surface_at(&surface, mesh, &ray, &hit);
        rk_spawner_start(&spawner, &surface);
        rk_vec3 start = rk_surface_spawn(&surface, direction);
        rk_vec3 to_light = rk_surface_spawn_to_light(&surface, direction);
        rk_vec3 again = rk_spawner_origin_to_light(&spawner, direction);
        rk_check(memcmp(&again, &to_light, sizeof again) == 0, "a spawner gives the same starts");
        moved += memcmp(&start, &to_light, sizeof start) != 0;
    }
    return moved;
}

/* Of the ball's faces: without normals, with those of the faces, and with interpolated ones, seen
 * from inside, which is concave, half of the time. */
static void flat_meshes_are_as_before_to_the_bit(void **state)
{
    (void)state;
    rk_scene flat = make_ball(10, 6, 0), smooth = make_ball(10, 6, RK_MESH_NORMALS);
    rk_check_equal(moved_starts(&flat.mesh), 0, "faces are flat without normals");
    uint32_t moved = moved_starts(&smooth.mesh);
    rk_check(moved > 100, "with normals, %u of 20000 rays start elsewhere: too few", moved);
    rk_scene_free(&flat);
    rk_scene_free(&smooth);
}

static void a_flat_room_with_normals_is_as_before_to_the_bit(void **state)
{
    (void)state;
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 36, 12, 1, RK_MESH_NORMALS, &error), error);
    for (uint32_t i = 0; i < 36; i++) {
        const float side_of = i < 18 ? 1 : -1, u = i % 6 == 1 || i % 6 == 2 || i % 6 == 4 ? 1 : -1;
        const float v = i % 6 == 2 || i % 6 == 4 || i % 6 == 5 ? 1 : -1;
        const uint32_t axis = i / 6 % 3;
        float p[3], n[3] = {0, 0, 0};
        p[axis] = side_of, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v, n[axis] = side_of;
        mesh.positions[i] = rk_vec(p[0], p[1], p[2]);
        mesh.normals[i] = rk_vec(n[0], n[1], n[2]);
        mesh.triangles[i / 3][i % 3] = i;
    }
    rk_check_equal(moved_starts(&mesh), 0, "normals of flat faces bend nothing: no light leaks in");
    rk_mesh_free(&mesh);
}

static void a_surface_seen_from_its_hollow_side_is_as_before(void **state)
{
    (void)state;
    rk_scene ball = make_ball(10, 6, RK_MESH_NORMALS);
    for (uint32_t i = 0; i < 5000; i++) {
        rk_hit hit = {1, 0.3f, 0.3f, i % (uint32_t)ball.mesh.triangle_count};
        rk_ray ray = {rk_vec(0, 0, 0), ball.mesh.positions[ball.mesh.triangles[hit.triangle][0]],
                      INFINITY};
        rk_vec3 direction = in_cube(i, 3);
        rk_surface surface;
        rk_surface_at(&surface, &ball.mesh, &ray, &hit);
        rk_vec3 start = rk_surface_spawn(&surface, direction);
        rk_vec3 to_light = rk_surface_spawn_to_light(&surface, direction);
        rk_check(memcmp(&start, &to_light, sizeof start) == 0, "a hollow is not convex");
    }
    rk_scene_free(&ball);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_ball_of_few_faces_has_no_black_faces_on_its_lit_side),
    cmocka_unit_test(an_option_keeps_the_black_faces_and_nothing_else_differs),
    cmocka_unit_test(an_area_light_has_no_black_faces_either),
    cmocka_unit_test(the_error_of_a_ball_of_few_faces_falls),
    cmocka_unit_test(flat_meshes_are_as_before_to_the_bit),
    cmocka_unit_test(a_flat_room_with_normals_is_as_before_to_the_bit),
    cmocka_unit_test(a_surface_seen_from_its_hollow_side_is_as_before),
};

RK_SUITE("shadow_terminator", tests)
