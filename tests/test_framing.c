/* Mesh files before the camera: their front, their size in the picture, strays, and the light. */
#include "test.h"

#include "scene/framing.h"

#include <string.h>

enum { ROWS = 12, COLUMNS = 24, BALL = 2 * ROWS * COLUMNS, BALL_VERTICES = (ROWS + 1) * COLUMNS };

static rk_mesh make_mesh(uint32_t vertices, uint32_t triangles)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, vertices, triangles, 1, 0, &error), error);
    return mesh;
}

/* Puts a ball's triangles into a mesh, the n-th of its balls. */
static void put_ball(rk_mesh *mesh, uint32_t n, rk_vec3 centre, float radius)
{
    for (uint32_t i = 0; i < BALL_VERTICES; i++) {
        float latitude = RK_PI * (float)(i / COLUMNS) / ROWS,
              longitude = 2 * RK_PI * (float)(i % COLUMNS) / COLUMNS;
        rk_vec3 p = rk_vec(sinf(latitude) * cosf(longitude), cosf(latitude),
                           sinf(latitude) * sinf(longitude));
        mesh->positions[n * BALL_VERTICES + i] = rk_madd(centre, p, radius);
    }
    for (uint32_t i = 0; i < ROWS * COLUMNS; i++) {
        uint32_t a = n * BALL_VERTICES + i,
                 b = n * BALL_VERTICES + i / COLUMNS * COLUMNS + (i + 1) % COLUMNS;
        memcpy(mesh->triangles[n * BALL + 2 * i], (uint32_t[3]){a, b, b + COLUMNS},
               sizeof(uint32_t[3]));
        memcpy(mesh->triangles[n * BALL + 2 * i + 1], (uint32_t[3]){a, b + COLUMNS, a + COLUMNS},
               sizeof(uint32_t[3]));
    }
}

/* Puts a triangle of this size after the others. */
static void put_triangle(rk_mesh *mesh, rk_vec3 corner, float size)
{
    const uint32_t v = mesh->vertex_count - 3;
    mesh->positions[v] = corner;
    mesh->positions[v + 1] = rk_add(corner, rk_vec(size, 0, 0));
    mesh->positions[v + 2] = rk_add(corner, rk_vec(0, size, 0));
    memcpy(mesh->triangles[mesh->triangle_count - 1], (uint32_t[3]){v, v + 1, v + 2},
           sizeof(uint32_t[3]));
}

static rk_mesh make_ball(rk_vec3 centre, float radius)
{
    rk_mesh mesh = make_mesh(BALL_VERTICES, BALL);
    put_ball(&mesh, 0, centre, radius);
    return mesh;
}

static rk_mesh make_triangle(rk_vec3 corner, float size)
{
    rk_mesh mesh = make_mesh(3, 1);
    put_triangle(&mesh, corner, size);
    return mesh;
}

typedef struct seen {
    double left, right, top, bottom; /* as fractions of the picture */
    double near;                     /* depth */
} seen;

/* Frames the mesh, and returns where its first triangles are in the picture. */
static seen frame(rk_mesh *mesh, rk_camera camera, size_t width, size_t height, uint32_t triangles,
                  rk_framed *framed)
{
    rk_error error;
    rk_check_ok(rk_mesh_frame(mesh, &camera, width, height, framed, &error), error);
    rk_view view = rk_view_of(&camera, width, height);
    seen s = {1, 0, 1, 0, INFINITY};
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        rk_vec2 pixel;
        float depth;
        rk_vec3 p = mesh->positions[mesh->triangles[i / 3][i % 3]];
        rk_check(rk_view_project(&view, p, &pixel, &depth), "a vertex is behind the camera");
        s.left = fmin(s.left, (double)pixel.x / (double)width);
        s.right = fmax(s.right, (double)pixel.x / (double)width);
        s.top = fmin(s.top, (double)pixel.y / (double)height);
        s.bottom = fmax(s.bottom, (double)pixel.y / (double)height);
        s.near = fmin(s.near, (double)depth);
    }
    return s;
}

/* Coordinates of a few units are rounded to floats, and so are the view's axes. */
static const double rounding = 1e-5;

/* The shorter side has as much room to both planes of the frame; in the picture that is nearly the
 * same. */
static const double room = 0.03;

static void check_two_thirds(seen s)
{
    const double width = s.right - s.left, height = s.bottom - s.top;
    rk_check_close(fmax(width, height), 2.0 / 3, rounding, "the longer side of the bounds");
    rk_check_close(s.left + s.right, 1, width > height ? rounding : room,
                   "as much room on the left as on the right");
    rk_check_close(s.top + s.bottom, 1, width > height ? room : rounding,
                   "as much room above as below");
}

static const rk_vec3 zero = {0, 0, 0};

static rk_camera turned(float pitch, float yaw)
{
    rk_camera camera = rk_camera_default();
    camera.rotation = rk_vec(pitch, yaw, 0);
    return camera;
}

/* --- Size and place -------------------------------------------------------------------------- */

static void a_mesh_fills_two_thirds_of_the_picture_from_all_sides(void **state)
{
    (void)state;
    const size_t shapes[][2] = {{800, 800}, {300, 200}, {200, 300}};
    for (int i = 0; i < 3; i++)
        for (float yaw = 0; yaw < 360; yaw += 45) {
            rk_mesh mesh = make_mesh(2 * BALL_VERTICES, 2 * BALL); /* two balls, unlike in size */
            rk_framed framed;
            put_ball(&mesh, 0, rk_vec(1, 2, 3), 1);
            put_ball(&mesh, 1, rk_vec(2, 2.5f, 3), 0.5f);
            seen s =
                frame(&mesh, turned(yaw / 3, yaw), shapes[i][0], shapes[i][1], 2 * BALL, &framed);
            check_two_thirds(s);
            rk_check_equal(framed.triangles, 2 * BALL, "no strays");
            rk_mesh_free(&mesh);
        }
}

static void neither_unit_nor_place_of_a_file_matters(void **state)
{
    (void)state;
    const float sizes[] = {1e-30f, 1e-3f, 1, 1e6f, 1e37f};
    for (int i = 0; i < 5; i++) {
        rk_framed framed;
        rk_mesh mesh = make_triangle(rk_vec(3 * sizes[i], -5 * sizes[i], 2 * sizes[i]), sizes[i]);
        check_two_thirds(frame(&mesh, rk_camera_default(), 100, 100, 1, &framed));
        rk_mesh_free(&mesh);
    }
}

/* The mean of the vertices would be near the fine ball, and the coarse one out of the middle. */
static void where_vertices_are_dense_does_not_matter(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(BALL_VERTICES + 3, BALL + 1);
    rk_framed framed;
    put_ball(&mesh, 0, zero, 1);
    put_triangle(&mesh, rk_vec(3, 0, 0), 1);
    check_two_thirds(frame(&mesh, rk_camera_default(), 100, 100, BALL + 1, &framed));
    rk_check_equal(framed.triangles, BALL + 1, "a triangle at three radii is no stray");
    rk_mesh_free(&mesh);
}

static void vertices_without_a_triangle_do_not_count(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(5, 1);
    rk_framed framed;
    put_triangle(&mesh, rk_vec(1, 1, 1), 1);
    mesh.positions[0] = rk_vec(1000, 0, 0);
    check_two_thirds(frame(&mesh, rk_camera_default(), 100, 100, 1, &framed));
    rk_mesh_free(&mesh);
}

static void the_middle_is_at_the_cameras_target(void **state)
{
    (void)state;
    rk_mesh mesh = make_ball(rk_vec(5, 6, 7), 2);
    rk_camera camera = rk_camera_default();
    camera.look_at = rk_vec(0.5f, 0.25f, -1);
    rk_framed framed;
    check_two_thirds(frame(&mesh, camera, 100, 100, BALL, &framed));
    rk_vec3 middle = zero;
    for (uint32_t i = 0; i < 2; i++) /* the poles */
        middle = rk_madd(middle, mesh.positions[i ? BALL_VERTICES - 1 : 0], 0.5f);
    /* In perspective, the middle of a ball's picture is not that of the ball. */
    rk_check_close(rk_length(rk_sub(middle, camera.look_at)), 0, 0.05, "twentieth of a radius");
    rk_mesh_free(&mesh);
}

static void a_mesh_of_one_point_is_only_moved(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(rk_vec(7, 8, 9), 0);
    rk_camera camera = rk_camera_default();
    rk_framed framed;
    rk_error error;
    rk_check_ok(rk_mesh_frame(&mesh, &camera, 100, 100, &framed, &error), error);
    rk_check_close(rk_length(mesh.positions[2]), 0, 0, "at the target");
    rk_mesh_free(&mesh);
}

static void a_mesh_without_triangles_is_left_alone(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(1, 0);
    rk_camera camera = rk_camera_default();
    rk_framed framed;
    rk_error error;
    mesh.positions[0] = rk_vec(7, 8, 9);
    rk_check_ok(rk_mesh_frame(&mesh, &camera, 100, 100, &framed, &error), error);
    rk_check_close(mesh.positions[0].x, 7, 0, "nothing is seen");
    rk_mesh_free(&mesh);
}

static void a_needle_along_the_view_keeps_its_distance(void **state)
{
    (void)state;
    rk_mesh mesh = make_triangle(zero, 0);
    rk_framed framed;
    mesh.positions[2] = rk_vec(0, 0, 100);
    seen s = frame(&mesh, turned(0, 0), 100, 100, 1, &framed);
    rk_check_close(s.near, 1.5, rounding, "half of the distance of 3");
    rk_mesh_free(&mesh);
}

/* --- Strays ---------------------------------------------------------------------------------- */

static void a_stray_triangle_does_not_shrink_the_others(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        rk_mesh mesh = make_mesh(BALL_VERTICES + 3, BALL + 1);
        rk_framed framed;
        put_ball(&mesh, 0, zero, 1);
        put_triangle(&mesh, rk_vec(axis == 0 ? 500 : 0, axis == 1 ? -500 : 0, axis == 2 ? 500 : 0),
                     1);
        check_two_thirds(frame(&mesh, rk_camera_default(), 100, 100, BALL, &framed));
        rk_check_equal(framed.triangles, BALL, "the ball's");
        rk_check_close(framed.extent, 2.0 / 501, 1e-4, "the ball's diameter of what there is");
        rk_mesh_free(&mesh);
    }
}

static void a_second_half_far_away_is_no_stray(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(2 * BALL_VERTICES, 2 * BALL);
    rk_framed framed;
    put_ball(&mesh, 0, zero, 1);
    put_ball(&mesh, 1, rk_vec(500, 0, 0), 1);
    check_two_thirds(frame(&mesh, turned(0, 0), 100, 100, 2 * BALL, &framed));
    rk_check_equal(framed.triangles, 2 * BALL, "both");
    rk_check_close(framed.extent, 1, 0, "all");
    rk_mesh_free(&mesh);
}

/* Its middle is among the ball's triangles, its corners are not. */
static void a_triangle_around_all_others_is_a_stray(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(BALL_VERTICES + 3, BALL + 1);
    rk_framed framed;
    put_ball(&mesh, 0, zero, 1);
    put_triangle(&mesh, rk_vec(-500, -500, 0), 1000);
    check_two_thirds(frame(&mesh, rk_camera_default(), 100, 100, BALL, &framed));
    rk_check_equal(framed.triangles, BALL, "the ball's");
    rk_mesh_free(&mesh);
}

/* --- Front and up ---------------------------------------------------------------------------- */

/* A file's axes and, in the picture of the default camera, right, up and towards the viewer. */
static void check_faces(rk_up up, rk_front named, rk_vec3 right, rk_vec3 top, rk_vec3 front)
{
    const rk_vec3 want[3] = {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3, 1, 1, RK_MESH_NORMALS, &error), error);
    mesh.positions[0] = mesh.normals[0] = right;
    mesh.positions[1] = mesh.normals[1] = top;
    mesh.positions[2] = mesh.normals[2] = front;
    rk_mesh_face_viewer(&mesh, up, named);
    for (int i = 0; i < 3; i++) {
        rk_check_close(rk_dot(mesh.positions[i], want[i]), 1, 0, "only signs and places change");
        rk_check_close(rk_dot(mesh.normals[i], want[i]), 1, 0, "normals turn, too");
    }
    rk_mesh_free(&mesh);
}

static void the_front_of_a_file_is_plus_z_and_faces_the_viewer(void **state)
{
    (void)state;
    check_faces(RK_UP_Y, RK_FRONT_USUAL, rk_vec(1, 0, 0), rk_vec(0, 1, 0), rk_vec(0, 0, 1));
}

static void where_z_is_up_the_front_is_minus_y(void **state)
{
    (void)state;
    check_faces(RK_UP_Z, RK_FRONT_USUAL, rk_vec(1, 0, 0), rk_vec(0, 0, 1), rk_vec(0, -1, 0));
}

static void where_x_is_up_the_front_is_plus_z(void **state)
{
    (void)state;
    check_faces(RK_UP_X, RK_FRONT_USUAL, rk_vec(0, -1, 0), rk_vec(1, 0, 0), rk_vec(0, 0, 1));
}

static rk_vec3 signed_axis(rk_front front)
{
    const int axis = ((int)front - RK_FRONT_X) % 3;
    return rk_scale(rk_vec(axis == 0, axis == 1, axis == 2), front < RK_FRONT_MINUS_X ? 1 : -1);
}

static void any_other_axis_can_be_the_front(void **state)
{
    (void)state;
    int pairs = 0;
    for (int up = RK_UP_X; up <= RK_UP_Z; up++) {
        const rk_vec3 top = rk_vec(up == RK_UP_X, up == RK_UP_Y, up == RK_UP_Z);
        for (int front = RK_FRONT_X; front <= RK_FRONT_MINUS_Z; front++) {
            const rk_vec3 towards = signed_axis((rk_front)front);
            if (rk_front_is_up((rk_front)front, (rk_up)up))
                continue;
            pairs++;
            check_faces((rk_up)up, (rk_front)front, rk_cross(top, towards), top, towards);
        }
    }
    rk_check_equal(pairs, 12, "each of three axes up, with four fronts");
}

/* --- The light ------------------------------------------------------------------------------- */

static rk_scene framed_scene(float pitch, float yaw)
{
    rk_mesh mesh = make_ball(zero, 1);
    rk_framing framing = rk_framing_default();
    rk_scene scene;
    rk_framed framed;
    rk_error error;
    framing.rotation = rk_vec(pitch, yaw, 0);
    rk_check_ok(rk_scene_framed(&scene, "ball", &mesh, &framing, &framed, &error), error);
    rk_check(mesh.positions == NULL, "the scene has the mesh");
    return scene;
}

static void check_top(uint32_t of_file, rk_up asked, rk_vec3 top)
{
    rk_mesh mesh;
    rk_framing framing = rk_framing_default();
    rk_scene scene;
    rk_framed framed;
    rk_error error;
    framing.up = asked;
    rk_check_ok(rk_mesh_init(&mesh, 3, 1, 1, RK_MESH_NORMALS, &error), error);
    mesh.up = of_file;
    mesh.triangles[0][1] = 1, mesh.triangles[0][2] = 2;
    mesh.positions[1] = rk_vec(1, 0, 0), mesh.positions[2] = rk_vec(0, 1, 1);
    mesh.normals[0] = mesh.normals[1] = mesh.normals[2] = top;
    rk_check_ok(rk_scene_framed(&scene, "one", &mesh, &framing, &framed, &error), error);
    rk_check_close(scene.mesh.normals[0].y, 1, 0, "what is up in the file is up in the picture");
    rk_scene_free(&scene);
}

static void a_file_stands_by_the_axis_that_it_names(void **state)
{
    (void)state;
    check_top(0, RK_UP_OF_FILE, rk_vec(0, 1, 0));
    check_top(1, RK_UP_OF_FILE, rk_vec(1, 0, 0));
    check_top(3, RK_UP_OF_FILE, rk_vec(0, 0, 1));
    check_top(3, RK_UP_Y, rk_vec(0, 1, 0)); /* the user knows better */
    check_top(3, RK_UP_Z, rk_vec(0, 0, 1)); /* once */
}

static void the_light_turns_with_the_camera(void **state)
{
    (void)state;
    for (float yaw = 0; yaw < 360; yaw += 15) {
        rk_scene scene = framed_scene(yaw - 180, yaw);
        rk_view view = rk_view_of(&scene.camera, 100, 100);
        rk_vec3 light = rk_normalize(scene.lights[0].position);
        rk_check_equal(scene.light_count, 1, "one light");
        rk_check(rk_dot(light, view.right) < -0.1f, "to the left");
        rk_check(rk_dot(light, view.up) > 0.1f, "above");
        rk_check(rk_dot(light, rk_normalize(view.position)) > 0.5f,
                 "more than 60 degrees from the view: most of the visible side is dark");
        rk_scene_free(&scene);
    }
}

static void from_the_default_camera_it_is_the_default_light(void **state)
{
    (void)state;
    rk_vec3 rotation = rk_camera_default().rotation;
    rk_scene scene = framed_scene(rotation.x, rotation.y), usual = {0};
    rk_scene_default_light(&usual);
    rk_vec3 off = rk_sub(scene.lights[0].position, usual.lights[0].position);
    rk_check_close(rk_length(off), 0, 4e-6, "a few roundings of coordinates up to 4");
    rk_scene_free(&scene);
}

static void a_broken_mesh_is_refused_and_the_scene_empty(void **state)
{
    (void)state;
    rk_mesh mesh = make_ball(zero, 1);
    rk_framing framing = rk_framing_default();
    rk_scene scene;
    rk_framed framed;
    rk_error error;
    mesh.triangles[5][1] = BALL_VERTICES;
    rk_check(!rk_scene_framed(&scene, "ball", &mesh, &framing, &framed, &error),
             "an index too large");
    rk_check_error_names(error, "ball: triangle 5");
    rk_check(!mesh.positions && !scene.mesh.positions, "the mesh is freed");
}

static void the_middle_of_an_environment_turns_to_plus_z(void **state)
{
    (void)state;
    rk_cubemap map;
    rk_error error;
    const uint32_t side = 3;
    rk_check_ok(rk_cubemap_init(&map, side, &error), error);
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < side * side; i++)
            map.faces[face][i] =
                rk_cubemap_texel_direction(side, (rk_cube_face)face, i % side, i / side);
    rk_cubemap_turn(&map);
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t i = 0; i < side * side; i++) {
            rk_vec3 d = rk_cubemap_texel_direction(side, (rk_cube_face)face, i % side, i / side);
            rk_vec3 off = rk_sub(map.faces[face][i], rk_vec(-d.x, d.y, -d.z));
            rk_check_close(rk_length(off), 0, 1e-6, "roundings of texels' centres");
        }
    rk_cubemap_free(&map);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_mesh_fills_two_thirds_of_the_picture_from_all_sides),
    cmocka_unit_test(neither_unit_nor_place_of_a_file_matters),
    cmocka_unit_test(where_vertices_are_dense_does_not_matter),
    cmocka_unit_test(vertices_without_a_triangle_do_not_count),
    cmocka_unit_test(the_middle_is_at_the_cameras_target),
    cmocka_unit_test(a_mesh_of_one_point_is_only_moved),
    cmocka_unit_test(a_mesh_without_triangles_is_left_alone),
    cmocka_unit_test(a_needle_along_the_view_keeps_its_distance),
    cmocka_unit_test(a_stray_triangle_does_not_shrink_the_others),
    cmocka_unit_test(a_second_half_far_away_is_no_stray),
    cmocka_unit_test(a_triangle_around_all_others_is_a_stray),
    cmocka_unit_test(the_front_of_a_file_is_plus_z_and_faces_the_viewer),
    cmocka_unit_test(where_z_is_up_the_front_is_minus_y),
    cmocka_unit_test(where_x_is_up_the_front_is_plus_z),
    cmocka_unit_test(any_other_axis_can_be_the_front),
    cmocka_unit_test(a_file_stands_by_the_axis_that_it_names),
    cmocka_unit_test(the_light_turns_with_the_camera),
    cmocka_unit_test(from_the_default_camera_it_is_the_default_light),
    cmocka_unit_test(a_broken_mesh_is_refused_and_the_scene_empty),
    cmocka_unit_test(the_middle_of_an_environment_turns_to_plus_z),
};

RK_SUITE("framing", tests)
