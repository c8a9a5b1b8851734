/* Small scenes for the renderer's suites, and functions to render them. */
#ifndef RK_TESTS_TEST_SCENE_H
#define RK_TESTS_TEST_SCENE_H

#include "test.h"

#include "render/render.h"
#include "scenes/builtin.h"

/* A scene of `triangles` triangles with separate corners, all 0, of material 0, without lights. The
 * camera looks from (0, 0, -3) along +z; x points to the left of the picture, y up. */
static inline rk_scene test_scene_of(uint32_t triangles, uint32_t materials)
{
    rk_scene scene = {.name = "test", .camera = {.distance = 3, .fov = 50}};
    rk_error error;
    rk_check_ok(rk_mesh_init(&scene.mesh, 3 * triangles, triangles, materials, 0, &error), error);
    for (uint32_t i = 0; i < triangles; i++)
        for (uint32_t k = 0; k < 3; k++)
            scene.mesh.triangles[i][k] = 3 * i + k;
    return scene;
}

/* The same with one material. */
static inline rk_scene test_scene_make(uint32_t triangles)
{
    return test_scene_of(triangles, 1);
}

static inline void test_scene_triangle(rk_scene *scene, uint32_t index, rk_vec3 a, rk_vec3 b,
                                       rk_vec3 c)
{
    scene->mesh.positions[3 * index] = a;
    scene->mesh.positions[3 * index + 1] = b;
    scene->mesh.positions[3 * index + 2] = c;
}

/* A parallelogram as the triangles `index` and `index + 1`. */
static inline void test_scene_quad(rk_scene *scene, uint32_t index, rk_vec3 corner, rk_vec3 side_a,
                                   rk_vec3 side_b)
{
    rk_vec3 a = rk_add(corner, side_a), b = rk_add(corner, side_b), far = rk_add(a, side_b);
    test_scene_triangle(scene, index, corner, a, far);
    test_scene_triangle(scene, index + 1, corner, far, b);
}

/* A square wall at depth z, 20 units wide, as the triangles `index` and `index + 1`. */
static inline void test_scene_wall(rk_scene *scene, uint32_t index, float z, uint16_t material)
{
    test_scene_quad(scene, index, rk_vec(-10, -10, z), rk_vec(20, 0, 0), rk_vec(0, 20, 0));
    scene->mesh.triangle_materials[index] = scene->mesh.triangle_materials[index + 1] = material;
}

static inline void test_scene_light(rk_scene *scene, rk_vec3 position, rk_vec3 colour)
{
    scene->lights[scene->light_count++] = rk_light_point(position, colour);
}

static inline rk_scene test_scene_builtin(const char *name)
{
    rk_scene scene;
    rk_error error;
    rk_check_ok(rk_builtin_scene(&scene, name, &error), error);
    return scene;
}

typedef struct test_picture {
    rk_image image;
    rk_counters counters;
} test_picture;

static inline test_picture test_render(const rk_scene *scene, rk_render_options options,
                                       uint32_t threads)
{
    test_picture picture;
    rk_accel accel;
    rk_error error;
    rk_pool *pool = rk_pool_start(threads, &error);
    rk_check_ok(pool != NULL, error);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, scene, &error), error);
    rk_check_ok(rk_image_init(&picture.image, options.width, options.height, &error), error);
    /* Earlier contents of the image must not show through. */
    memset(picture.image.pixels, 0x55, options.width * options.height * sizeof(rk_vec3));
    rk_check_ok(
        rk_render(&picture.image, scene, &accel, &options, pool, &picture.counters, NULL, &error),
        error);
    rk_accel_free(&accel);
    rk_pool_stop(pool);
    return picture;
}

static inline bool test_same_pixels(const rk_image *a, const rk_image *b)
{
    return a->width == b->width && a->height == b->height &&
           memcmp(a->pixels, b->pixels, a->width * a->height * sizeof(rk_vec3)) == 0;
}

#endif
