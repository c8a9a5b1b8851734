/* Environments: the cube's memory and orientation, the built-in sky, and a map in the renderer:
 * where rays miss, in mirrors, behind transparent surfaces, and nowhere else. */
#include "test_scene.h"

#include "base/random.h"
#include "base/reflect.h"
#include "scenes/sky.h"

/* --- The cube --------------------------------------------------------------------------------- */

static void a_map_has_one_to_8192_texels_a_side(void **state)
{
    (void)state;
    rk_cubemap map;
    rk_error error = {""};
    const uint32_t wrong[] = {0, RK_CUBEMAP_SIDE_MAX + 1, UINT32_MAX};
    for (size_t i = 0; i < 3; i++) {
        rk_check(!rk_cubemap_init(&map, wrong[i], &error), "a side of %u was accepted", wrong[i]);
        rk_check_error_names(error, "1 to 8192");
        rk_check(map.side == 0 && !map.faces[0], "a map was left behind");
        rk_cubemap_free(&map);
    }
    rk_check_ok(rk_cubemap_init(&map, 3, &error), error);
    for (int face = 0; face < RK_FACES; face++)
        for (int i = 0; i < 9; i++)
            rk_check(rk_length(map.faces[face][i]) == 0, "a new map is black");
    rk_cubemap_free(&map);
    rk_check(map.side == 0 && !map.faces[0], "a freed map is empty");
    rk_cubemap_free(&map);
}

static void faces_are_seen_from_inside_and_not_mirrored(void **state)
{
    (void)state;
    for (int face = 0; face < RK_FACES; face++) {
        const rk_cube_axes *axes = &rk_cube_faces[face];
        rk_vec3 behind = rk_cross(axes->right, axes->up);
        rk_check(rk_length(rk_add(behind, axes->ahead)) == 0,
                 "face %d: right x up points back to the viewer", face);
        rk_check_equal(rk_axis(axes->ahead, face / 2), face % 2 ? -1 : 1,
                       "the face's axis and sign");
    }
}

/* Neighbours in the cross have an edge in common. */
static void the_cross_folds_up(void **state)
{
    (void)state;
    const struct {
        rk_cube_face left, right;
    } rows[] = {{RK_FACE_MINUS_X, RK_FACE_MINUS_Z},
                {RK_FACE_MINUS_Z, RK_FACE_X},
                {RK_FACE_X, RK_FACE_Z},
                {RK_FACE_Z, RK_FACE_MINUS_X}};
    for (int i = 0; i < 4; i++)
        for (float v = 0; v <= 1; v += 0.25f)
            rk_check(rk_length(rk_sub(rk_cube_direction(rows[i].left, 1, v),
                                      rk_cube_direction(rows[i].right, 0, v))) == 0,
                     "the right edge of face %d is the left one of face %d", (int)rows[i].left,
                     (int)rows[i].right);
    for (float u = 0; u <= 1; u += 0.25f) {
        rk_check(rk_length(rk_sub(rk_cube_direction(RK_FACE_MINUS_Z, u, 1),
                                  rk_cube_direction(RK_FACE_Y, u, 0))) == 0,
                 "+y is above -z");
        rk_check(rk_length(rk_sub(rk_cube_direction(RK_FACE_MINUS_Z, u, 0),
                                  rk_cube_direction(RK_FACE_MINUS_Y, u, 1))) == 0,
                 "-y is below -z");
        rk_check(rk_length(rk_sub(rk_cube_direction(RK_FACE_MINUS_Y, u, 0),
                                  rk_cube_direction(RK_FACE_Z, 1 - u, 0))) == 0,
                 "below -y, +z continues upside down");
    }
}

/* --- The sky ---------------------------------------------------------------------------------- */

static void the_sun_stands_where_the_default_light_does(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("triangle");
    rk_vec3 to_light = scene.lights[0].position;
    rk_check(rk_sky_at(to_light).x > 10, "the sun is bright");
    rk_check(rk_sky_at(rk_negate(to_light)).x < 1, "and the opposite direction is not");
    rk_scene_free(&scene);
}

static void the_sky_is_above_and_the_ground_below(void **state)
{
    (void)state;
    rk_vec3 zenith = rk_sky_at(rk_vec(0, 1, 0)), nadir = rk_sky_at(rk_vec(0, -1, 0));
    rk_vec3 horizon = rk_sky_at(rk_vec(0, 0, 1));
    rk_check(zenith.z > 2 * zenith.x, "blue above");
    rk_check(nadir.x > nadir.z && nadir.x < horizon.x, "dark ground below");
    rk_check(horizon.x > zenith.x && horizon.y > zenith.y, "bright at the horizon");
}

static void the_sky_is_continuous_and_ignores_lengths(void **state)
{
    (void)state;
    for (int path = 0; path < 3; path++) {
        rk_vec3 last = {0, 0, 0};
        for (int i = 0; i <= 20000; i++) {
            double angle = 2 * 3.14159265358979 * i / 20000;
            /* Up and down through the sun, through the sides, and along the horizon. */
            float c = (float)cos(angle), s = (float)sin(angle);
            rk_vec3 d = path == 0   ? rk_vec(0, s, -c)
                        : path == 1 ? rk_vec(c, s, 0)
                                    : rk_vec(c, 0, s);
            rk_vec3 next = rk_sky_at(d), far = rk_sky_at(rk_scale(d, 1000));
            rk_check(isfinite(next.x) && next.x >= 0 && next.y >= 0 && next.z >= 0, "a colour");
            rk_check(rk_length(rk_sub(next, far)) < 1e-3f, "the direction's length matters");
            /* The sun's edge is steepest: it rises to 45 within a hundredth, at most 1.5 times as
             * steeply as on average; a step is 2 pi / 20000. */
            rk_check(i == 0 || rk_length(rk_sub(next, last)) <= 1.5 * 45 / 0.01 * 3.2e-4,
                     "a step at %d of path %d", i, path);
            last = next;
        }
    }
}

static void a_sky_map_is_the_sky_at_its_centres(void **state)
{
    (void)state;
    rk_cubemap map;
    rk_error error;
    rk_check_ok(rk_sky_make(&map, 5, &error), error);
    for (uint32_t i = 0; i < RK_FACES * 25; i++) {
        rk_cube_face face = (rk_cube_face)(i / 25);
        rk_vec3 want = rk_sky_at(rk_cubemap_texel_direction(5, face, i % 5, i / 5 % 5));
        rk_vec3 got = *rk_cubemap_texel(&map, face, i % 5, i / 5 % 5);
        rk_check(memcmp(&got, &want, sizeof got) == 0, "texel %u differs", i);
    }
    rk_cubemap_free(&map);
}

/* --- Rendering -------------------------------------------------------------------------------- */

/* A small odd size: a pixel's centre then lies on no diagonal of a wall, except in the middle. */
static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 14;
    options.height = 11;
    options.reflections = options.transparency = true;
    return options;
}

enum { pixels = 14 * 11 };

/* A few texels of noise, so that colours differ for all directions and filters. */
static void add_environment(rk_scene *scene)
{
    rk_error error;
    rk_check_ok(rk_cubemap_init(&scene->environment, 8, &error), error);
    for (uint32_t i = 0; i < RK_FACES * 64; i++)
        scene->environment.faces[0][i] =
            rk_vec(rk_unit_float(rk_hash(1, i, 0, 0)), rk_unit_float(rk_hash(1, i, 1, 0)), 2);
}

static rk_vec3 camera_direction(const rk_scene *scene, const rk_render_options *options, size_t x,
                                size_t y)
{
    rk_view view = rk_view_of(&scene->camera, options->width, options->height);
    return rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f).direction;
}

/* Each pixel is `weight` times the map's colour in its direction, or in the direction reflected
 * at a mirror across z. */
static void check_picture(const rk_scene *scene, const rk_render_options *options,
                          const test_picture *picture, bool reflected, float weight)
{
    for (size_t y = 0; y < options->height; y++)
        for (size_t x = 0; x < options->width; x++) {
            rk_vec3 d = camera_direction(scene, options, x, y);
            if (reflected)
                d.z = -d.z;
            rk_vec3 want = rk_scale(
                rk_cubemap_at(&scene->environment, d, options->environment_filter), weight);
            rk_vec3 got = *rk_image_at(&picture->image, x, y);
            /* Roundings of a direction, 8 texels a side. */
            rk_check(rk_length(rk_sub(got, want)) <= 1e-5f,
                     "pixel (%zu, %zu): got (%g, %g, %g), want (%g, %g, %g)", x, y, (double)got.x,
                     (double)got.y, (double)got.z, (double)want.x, (double)want.y, (double)want.z);
        }
}

/* Renders, and checks every pixel and the number of lookups. */
static void check_rendered(const rk_scene *scene, const rk_render_options *options, bool reflected,
                           float weight)
{
    test_picture picture = test_render(scene, *options, 2);
    check_picture(scene, options, &picture, reflected, weight);
    rk_check_equal(picture.counters.environment_lookups, weight > 0 ? pixels : 0,
                   "a lookup for each ray that reaches it");
    rk_image_free(&picture.image);
}

static void a_miss_takes_the_map_or_black(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    rk_render_options options = small();
    test_picture black = test_render(&scene, options, 2);
    for (int i = 0; i < pixels; i++)
        rk_check(rk_length(black.image.pixels[i]) == 0, "black without a map");
    rk_check_equal(black.counters.primary_rays, 0, "an empty scene without a map needs no rays");
    rk_check_equal(black.counters.environment_lookups, 0, "there is no map");
    add_environment(&scene);
    for (int filter = 0; filter <= RK_CUBEMAP_SEAMLESS; filter++) {
        options.environment_filter = (rk_cubemap_filter)filter;
        check_rendered(&scene, &options, false, 1);
    }
    rk_image_free(&black.image);
    rk_scene_free(&scene);
}

static void objects_in_front_hide_the_environment(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    add_environment(&scene);
    rk_render_options options = small();
    for (int transparency = 0; transparency < 2; transparency++) {
        options.transparency = transparency;
        check_rendered(&scene, &options, false, 0);
    }
    rk_scene_free(&scene);
}

static void a_mirror_reflects_the_environment(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[0].ks = rk_vec(0.75f, 0.75f, 0.75f);
    add_environment(&scene);
    rk_render_options options = small();
    check_rendered(&scene, &options, true, 0.75f);
    options.max_depth = 0;
    check_rendered(&scene, &options, true, 0);
    rk_scene_free(&scene);
}

/* Black walls at z = 0, .1 ..., of the opacity .5. */
static rk_scene make_transparent_walls(uint32_t count)
{
    rk_scene scene = test_scene_make(2 * count);
    for (uint32_t i = 0; i < count; i++)
        test_scene_wall(&scene, 2 * i, 0.1f * (float)i, 0);
    scene.mesh.materials[0].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[0].alpha = 0.5f;
    add_environment(&scene);
    return scene;
}

static void the_environment_shows_through_transparent_surfaces(void **state)
{
    (void)state;
    for (uint32_t walls = 1; walls <= 3; walls++) {
        rk_scene scene = make_transparent_walls(walls);
        rk_render_options options = small();
        check_rendered(&scene, &options, false, ldexpf(1, -(int)walls));
        rk_scene_free(&scene);
    }
}

static void max_depth_hides_the_environment_like_a_wall(void **state)
{
    (void)state;
    rk_scene scene = make_transparent_walls(3);
    rk_render_options options = small();
    for (options.max_depth = 0; options.max_depth < 5; options.max_depth++)
        check_rendered(&scene, &options, false, options.max_depth < 3 ? 0 : 0.125f);
    rk_scene_free(&scene);
}

static void a_wall_behind_glass_hides_the_environment(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 0, 0);
    test_scene_wall(&scene, 2, 1, 1);
    scene.mesh.materials[0].alpha = 0.5f;
    add_environment(&scene);
    rk_render_options options = small();
    check_rendered(&scene, &options, false, 0);
    rk_scene_free(&scene);
}

static void the_environment_adds_to_direct_light(void **state)
{
    (void)state;
    /* A grey mirror: its diffuse part does not depend on the environment. */
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    test_scene_light(&scene, rk_vec(0.4f, 0.3f, -2), rk_vec(1, 1, 1));
    rk_render_options options = small();
    test_picture without = test_render(&scene, options, 1);
    rk_check_equal(without.counters.environment_lookups, 0, "there is no environment");
    add_environment(&scene);
    test_picture with = test_render(&scene, options, 1);
    for (int i = 0; i < pixels; i++)
        with.image.pixels[i] = rk_sub(with.image.pixels[i], without.image.pixels[i]);
    check_picture(&scene, &options, &with, true, 0.5f);
    rk_image_free(&without.image);
    rk_image_free(&with.image);
    rk_scene_free(&scene);
}

static void a_scene_without_an_environment_pays_nothing_for_it(void **state)
{
    (void)state;
    /* A closed room: the same work with an environment, which no ray reaches. */
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.shadows = true;
    options.environment_filter = RK_CUBEMAP_NEAREST;
    test_picture without = test_render(&scene, options, 2);
    rk_check_equal(without.counters.environment_lookups, 0, "there is none");
    rk_check(!rk_plan_of(&scene, &options).cubemap, "it is not in the plan");
    add_environment(&scene);
    rk_check(rk_plan_of(&scene, &options).cubemap, "now it is in the plan");
    test_picture with = test_render(&scene, options, 2);
    rk_check_equal(with.counters.box_tests, without.counters.box_tests, "box tests");
    rk_check_equal(with.counters.triangle_tests, without.counters.triangle_tests, "triangle tests");
    rk_check_equal(with.counters.shadow_rays, without.counters.shadow_rays, "shadow rays");
    rk_image_free(&without.image);
    rk_image_free(&with.image);
    rk_scene_free(&scene);
}

static void without_lights_an_environment_needs_no_shadow_rays(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    add_environment(&scene);
    rk_render_options options = small();
    options.shadows = true;
    rk_plan plan = rk_plan_of(&scene, &options);
    rk_check(plan.rays && !plan.lights && !plan.shadow_rays,
             "it is visible, but there is no light");
    test_picture picture = test_render(&scene, options, 1);
    rk_check_equal(picture.counters.shadow_rays, 0, "no lights, no shadows");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void every_sample_looks_up_the_environment(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    add_environment(&scene);
    rk_render_options options = small();
    options.samples = 9;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.environment_lookups, 9 * pixels, "one per sample");
    for (int i = 0; i < pixels; i++)
        rk_check_close(picture.image.pixels[i].z, 2, 9 * 2 * 0x1p-23,
                       "a mean of samples, not their sum");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* Replaces the map by one of this grey in all its texels. */
static void make_grey(rk_scene *scene, float grey)
{
    for (uint32_t i = 0; i < RK_FACES * 64; i++)
        scene->environment.faces[0][i] = rk_vec(grey, grey, grey);
}

static void a_background_is_an_environment_of_one_grey(void **state)
{
    (void)state;
    for (uint32_t walls = 0; walls <= 2; walls++) {
        rk_scene scene = make_transparent_walls(walls);
        scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
        make_grey(&scene, 0.25f);
        rk_render_options options = small();
        options.environment_filter = RK_CUBEMAP_NEAREST;
        for (int transparency = 0; transparency < 2; transparency++) {
            options.transparency = transparency;
            test_picture want = test_render(&scene, options, 2);
            rk_cubemap_free(&scene.environment);
            scene.background = 0.25f;
            test_picture got = test_render(&scene, options, 2);
            rk_check_equal(got.counters.environment_lookups, 0, "there is no map to look up");
            rk_check(memcmp(got.image.pixels, want.image.pixels, pixels * sizeof(rk_vec3)) == 0,
                     "%u walls: a map of one grey and a background differ", walls);
            rk_check(rk_length(got.image.pixels[0]) > 0, "it is seen");
            rk_image_free(&got.image);
            rk_image_free(&want.image);
            add_environment(&scene);
            make_grey(&scene, 0.25f);
            scene.background = 0;
        }
        rk_scene_free(&scene);
    }
}

static void an_environment_hides_the_background(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    scene.background = 0.25f;
    add_environment(&scene);
    const rk_render_options options = small();
    check_rendered(&scene, &options, false, 1);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_map_has_one_to_8192_texels_a_side),
    cmocka_unit_test(faces_are_seen_from_inside_and_not_mirrored),
    cmocka_unit_test(the_cross_folds_up),
    cmocka_unit_test(the_sun_stands_where_the_default_light_does),
    cmocka_unit_test(the_sky_is_above_and_the_ground_below),
    cmocka_unit_test(the_sky_is_continuous_and_ignores_lengths),
    cmocka_unit_test(a_sky_map_is_the_sky_at_its_centres),
    cmocka_unit_test(a_miss_takes_the_map_or_black),
    cmocka_unit_test(objects_in_front_hide_the_environment),
    cmocka_unit_test(a_mirror_reflects_the_environment),
    cmocka_unit_test(the_environment_shows_through_transparent_surfaces),
    cmocka_unit_test(max_depth_hides_the_environment_like_a_wall),
    cmocka_unit_test(a_wall_behind_glass_hides_the_environment),
    cmocka_unit_test(the_environment_adds_to_direct_light),
    cmocka_unit_test(a_scene_without_an_environment_pays_nothing_for_it),
    cmocka_unit_test(without_lights_an_environment_needs_no_shadow_rays),
    cmocka_unit_test(every_sample_looks_up_the_environment),
    cmocka_unit_test(a_background_is_an_environment_of_one_grey),
    cmocka_unit_test(an_environment_hides_the_background),
};

RK_SUITE("cubemap_stage", tests)
