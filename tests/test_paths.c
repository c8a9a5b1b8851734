/* Paths with reflections and transparent surfaces: colours against closed forms in double, and the
 * exact limit max_depth. */
#include "test_scene.h"

static const double pi = 3.14159265358979323846;

/* A small odd size: a pixel's centre then lies on no diagonal of a wall, except in the middle. */
static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 14;
    options.height = 11;
    options.reflections = options.transparency = true;
    return options;
}

static const double light_at[3] = {0.4, 0.3, -2};

static void shine(rk_scene *scene)
{
    test_scene_light(scene, rk_vec(0.4f, 0.3f, -2), rk_vec(1, 1, 1));
}

/* Lambert's cosine at a wall of depth z, at the end of a path of length `reach` along z. */
static double cosine_on_wall(const rk_render_options *options, size_t x, size_t y, double z,
                             double reach)
{
    double half = tan(25 * pi / 180);
    double across = 2 * ((double)x + 0.5) / options->width - 1;
    double up = 1 - 2 * ((double)y + 0.5) / options->height;
    double px = -across * half * options->width / options->height * reach, py = up * half * reach;
    double l[3] = {light_at[0] - px, light_at[1] - py, light_at[2] - z};
    return fabs(l[2]) / sqrt(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
}

/* A dozen roundings per surface, of numbers up to 1; the eighth surface of a path adds up those of
 * seven. */
static const double rounding = 8 * 12 * 0x1p-24;

static void check_grey(const test_picture *picture, size_t x, size_t y, double want,
                       const char *hint)
{
    double got = (double)rk_image_at(&picture->image, x, y)->x;
    rk_check(fabs(got - want) <= rounding, "pixel (%zu, %zu): got %.9g, want %.9g within %.1g: %s",
             x, y, got, want, rounding, hint);
}

/* --- Mirrors --------------------------------------------------------------------------------- */

/* A mirror at z = 1, and a wall behind the viewer at z = -6. */
static rk_scene make_mirror(void)
{
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 1, 1);
    test_scene_wall(&scene, 2, -6, 0);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.5f, 0.5f);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].ks = rk_vec(0.75f, 0.75f, 0.75f);
    shine(&scene);
    return scene;
}

static void a_mirror_reflects_the_wall_behind_the_viewer(void **state)
{
    (void)state;
    rk_scene scene = make_mirror();
    rk_render_options options = small();
    test_picture picture = test_render(&scene, options, 1);
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++)
            /* 4 to the mirror, 7 back to the wall. */
            check_grey(&picture, x, y, 0.75 * 0.5 * cosine_on_wall(&options, x, y, -6, 11),
                       "ks times the radiance along the reflected ray");
    rk_check_equal(picture.counters.reflected_rays, 14 * 11, "a reflected ray per pixel");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void without_a_specular_colour_or_the_option_no_ray_is_reflected(void **state)
{
    (void)state;
    rk_scene scene = make_mirror();
    rk_render_options options = small();
    options.reflections = false;
    test_picture off = test_render(&scene, options, 1);
    rk_check_equal(off.counters.reflected_rays, 0, "the option is off");
    rk_check(rk_length(*rk_image_at(&off.image, 3, 3)) == 0, "the mirror itself is black");
    options.reflections = true;
    scene.mesh.materials[1].ks = rk_vec(0, 0, 0);
    rk_check(!rk_plan_of(&scene, &options).reflections, "nothing here reflects");
    test_picture dull = test_render(&scene, options, 1);
    rk_check_equal(dull.counters.reflected_rays, 0, "no surface reflects");
    rk_check(test_same_pixels(&off.image, &dull.image), "and so the picture is the same");
    rk_image_free(&off.image);
    rk_image_free(&dull.image);
    rk_scene_free(&scene);
}

static void reflections_end_exactly_at_max_depth(void **state)
{
    (void)state;
    /* Two mirrors that face each other, the viewer and the light between them: the k-th
     * reflected ray adds 2^-k of a Lambert's cosine, 7 units farther along each time. */
    rk_scene scene = test_scene_of(4, 1);
    for (uint32_t i = 0; i < 2; i++)
        test_scene_quad(&scene, 2 * i, rk_vec(-99, -99, i ? -6 : 1), rk_vec(198, 0, 0),
                        rk_vec(0, 198, 0));
    scene.mesh.materials[0].kd = scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    shine(&scene);
    rk_render_options options = small();
    for (options.max_depth = 0; options.max_depth <= 7; options.max_depth++) {
        test_picture picture = test_render(&scene, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++) {
                double want = 0;
                for (uint32_t k = 0; k <= options.max_depth; k++)
                    want += 0.5 * pow(0.5, k) *
                            cosine_on_wall(&options, x, y, k % 2 ? -6 : 1, 4 + 7 * (double)k);
                check_grey(&picture, x, y, want, "one term per reflected ray, and no more");
            }
        rk_check_equal(picture.counters.reflected_rays, 14 * 11 * options.max_depth,
                       "one more reflected ray for each step of the limit");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_convex_mirror_never_reflects_itself(void **state)
{
    (void)state;
    /* Interpolated normals would reflect rays at the rim into the body. */
    const char *const names[] = {"sphere:80", "sphere:1280"};
    for (size_t i = 0; i < 2; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_check(scene.mesh.normals, "the sphere is smooth");
        scene.mesh.materials[0].ks = rk_vec(1, 1, 1);
        rk_render_options options = small();
        options.width = options.height = 200;
        test_picture mirror = test_render(&scene, options, 2);
        options.reflections = false;
        test_picture plain = test_render(&scene, options, 2);
        rk_check(mirror.counters.reflected_rays > 1000, "the sphere is not in the picture");
        rk_check(test_same_pixels(&mirror.image, &plain.image),
                 "%s: a reflected ray hit the sphere that it left", names[i]);
        rk_image_free(&mirror.image);
        rk_image_free(&plain.image);
        rk_scene_free(&scene);
    }
}

/* --- Glass ----------------------------------------------------------------------------------- */

enum { pane_count = 5 };

/* Panes at z = 0, .1 ..., all half transparent, before a wall at z = 1. */
static rk_scene make_panes(void)
{
    rk_scene scene = test_scene_of(2 * pane_count + 2, 2);
    for (uint32_t i = 0; i < pane_count; i++)
        test_scene_wall(&scene, 2 * i, 0.1f * (float)i, 1);
    test_scene_wall(&scene, 2 * pane_count, 1, 0);
    scene.mesh.materials[1].alpha = 0.5f;
    shine(&scene);
    return scene;
}

static void transparent_surfaces_end_exactly_at_max_depth(void **state)
{
    (void)state;
    rk_scene scene = make_panes();
    rk_render_options options = small();
    for (options.max_depth = 0; options.max_depth <= pane_count + 1; options.max_depth++) {
        test_picture picture = test_render(&scene, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++) {
                double want = 0;
                for (uint32_t k = 0; k <= options.max_depth && k <= pane_count; k++) {
                    double z = k == pane_count ? 1 : (double)(0.1f * (float)k);
                    want += 0.8 * pow(0.5, k) * (k == pane_count ? 1 : 0.5) *
                            cosine_on_wall(&options, x, y, z, 3 + z);
                }
                check_grey(&picture, x, y, want, "alpha here + (1 - alpha) behind, to the limit");
            }
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void without_the_option_glass_is_opaque(void **state)
{
    (void)state;
    rk_scene scene = make_panes();
    rk_render_options options = small();
    options.transparency = false;
    test_picture picture = test_render(&scene, options, 1);
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++)
            check_grey(&picture, x, y, 0.8 * cosine_on_wall(&options, x, y, 0, 3),
                       "the first surface, as if it were opaque");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_scene_without_glass_is_rendered_as_without_the_option(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.shadows = true;
    options.width = options.height = 64;
    test_picture on = test_render(&scene, options, 2);
    options.transparency = false;
    test_picture off = test_render(&scene, options, 2);
    rk_check(test_same_pixels(&on.image, &off.image), "not the same to the bit");
    rk_check_equal(on.counters.box_tests, off.counters.box_tests, "box tests");
    rk_check_equal(on.counters.triangle_tests, off.counters.triangle_tests, "triangle tests");
    rk_image_free(&on.image);
    rk_image_free(&off.image);
    rk_scene_free(&scene);
}

static void reflections_and_transparent_surfaces_count_towards_max_depth(void **state)
{
    (void)state;
    /* The path from the viewer: glass, mirror, glass again, wall. The wall is the third surface
     * after the first. */
    rk_scene scene = test_scene_of(6, 3);
    test_scene_wall(&scene, 0, 1, 1);
    test_scene_wall(&scene, 2, -6, 0);
    test_scene_wall(&scene, 4, 0, 2);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.5f, 0.5f);
    scene.mesh.materials[1].kd = scene.mesh.materials[2].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].ks = rk_vec(1, 1, 1);
    scene.mesh.materials[2].alpha = 0.5f;
    shine(&scene);
    rk_render_options options = small();
    for (options.max_depth = 0; options.max_depth < 5; options.max_depth++) {
        test_picture picture = test_render(&scene, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++)
                check_grey(
                    &picture, x, y,
                    options.max_depth < 3 ? 0 : 0.25 * 0.5 * cosine_on_wall(&options, x, y, -6, 11),
                    "the wall shows through the glass, twice, from a max depth of 3 on");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_mirror_of_glass_both_reflects_and_transmits(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(6, 3);
    test_scene_wall(&scene, 0, 1, 0);
    test_scene_wall(&scene, 2, 0, 1);
    test_scene_wall(&scene, 4, -6, 2);
    scene.mesh.materials[0].kd = rk_vec(1, 0, 0);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].ks = rk_vec(1, 1, 1);
    scene.mesh.materials[1].alpha = 0.25f;
    scene.mesh.materials[2].kd = rk_vec(0, 1, 0);
    shine(&scene);
    rk_render_options options = small();
    test_picture picture = test_render(&scene, options, 1);
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            const rk_vec3 *got = rk_image_at(&picture.image, x, y);
            check_grey(&picture, x, y, 0.75 * cosine_on_wall(&options, x, y, 1, 4),
                       "1 - alpha of the wall behind it");
            rk_check_close(got->y, 0.25 * cosine_on_wall(&options, x, y, -6, 9), rounding,
                           "alpha times the reflection");
        }
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void batches_that_overflow_lose_nothing(void **state)
{
    (void)state;
    /* Six surfaces per ray of a full tile: more shading points than a batch holds. */
    rk_scene scene = make_panes();
    rk_render_options options = small();
    options.width = options.height = 64;
    test_picture whole = test_render(&scene, options, 2);
    for (size_t i = 0; i < 64 * 64; i++) {
        double want = 0;
        for (uint32_t k = 0; k <= pane_count; k++) {
            double z = k == pane_count ? 1 : (double)(0.1f * (float)k);
            want += 0.8 * pow(0.5, k) * (k == pane_count ? 1 : 0.5) *
                    cosine_on_wall(&options, i % 64, i / 64, z, 3 + z);
        }
        check_grey(&whole, i % 64, i / 64, want, "six surfaces per ray");
    }
    rk_image_free(&whole.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_mirror_reflects_the_wall_behind_the_viewer),
    cmocka_unit_test(without_a_specular_colour_or_the_option_no_ray_is_reflected),
    cmocka_unit_test(reflections_end_exactly_at_max_depth),
    cmocka_unit_test(a_convex_mirror_never_reflects_itself),
    cmocka_unit_test(transparent_surfaces_end_exactly_at_max_depth),
    cmocka_unit_test(without_the_option_glass_is_opaque),
    cmocka_unit_test(a_scene_without_glass_is_rendered_as_without_the_option),
    cmocka_unit_test(reflections_and_transparent_surfaces_count_towards_max_depth),
    cmocka_unit_test(a_mirror_of_glass_both_reflects_and_transmits),
    cmocka_unit_test(batches_that_overflow_lose_nothing),
};

RK_SUITE("paths", tests)
