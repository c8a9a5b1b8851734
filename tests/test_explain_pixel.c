/* A pixel's story must be the renderer's: the colour that it ends with is the picture's, and what
 * it tells on the way is what happened. */
#include "test_scene.h"

#include "driver/explain_pixel.h"
#include "scenes/sky.h"

/* A new string to free(). */
static char *narrate(const rk_scene *scene, rk_render_options options, uint32_t x, uint32_t y)
{
    rk_accel accel;
    rk_error error;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, scene, &error), error);
    rk_explain_pixel(out, scene, &accel, &options, x, y);
    rk_accel_free(&accel);
    fclose(out);
    return text;
}

static bool tells(const char *story, const char *part)
{
    return strstr(story, part) != NULL;
}

/* The vector behind the last `label` of the story; zero when there is none. */
static rk_vec3 told_vector(const char *story, const char *label)
{
    rk_vec3 v = {0, 0, 0};
    const char *last = NULL;
    for (const char *at = strstr(story, label); at; at = strstr(at + 1, label))
        last = at;
    if (last)
        sscanf(last + strlen(label), " (%f, %f, %f)", &v.x, &v.y, &v.z);
    return v;
}

/* Six digits behind the point are told. */
static void check_told(const char *story, const char *label, rk_vec3 want)
{
    rk_vec3 told = told_vector(story, label);
    rk_vec3 off = rk_abs3(rk_sub(told, want));
    rk_check(off.x <= 1e-6f && off.y <= 1e-6f && off.z <= 1e-6f,
             "%s should be (%g, %g, %g), but the story is:\n%s", label, (double)want.x,
             (double)want.y, (double)want.z, story);
}

static rk_render_options size_of(uint32_t width, uint32_t height, bool shadows)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    options.shadows = shadows;
    return options;
}

static void the_told_colour_is_the_rendered_one(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "sphere:320", "cube", "panes", "cornell-light"};
    for (int i = 0; i < 5; i++)
        for (int shadows = 0; shadows < 2; shadows++) {
            rk_scene scene = test_scene_builtin(names[i]);
            test_scene_light(&scene, rk_vec(-3, 0, -1), rk_vec(0.5f, 0, 0.25f));
            rk_render_options options = size_of(19, 13, shadows);
            options.reflections = options.transparency = shadows;
            test_picture picture = test_render(&scene, options, 1);
            for (uint32_t y = 0; y < options.height; y++)
                for (uint32_t x = 0; x < options.width; x++) {
                    char *story = narrate(&scene, options, x, y);
                    check_told(story, "colour (linear)", *rk_image_at(&picture.image, x, y));
                    free(story);
                }
            rk_image_free(&picture.image);
            rk_scene_free(&scene);
        }
}

/* A wall at z = 1 over the picture's left half (x > 0), a small square before a part of it, and a
 * light before both. */
static rk_scene make_stage(void)
{
    rk_scene scene = test_scene_make(4);
    test_scene_quad(&scene, 0, rk_vec(0, -9, 1), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(2.75f, -0.3f, 0), rk_vec(0.5f, 0, 0), rk_vec(0, 0.5f, 0));
    test_scene_light(&scene, rk_vec(5, 0, -1), rk_vec(1, 1, 1));
    return scene;
}

static void a_miss_is_told(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    char *story = narrate(&scene, size_of(20, 20, true), 15, 10);
    rk_check(tells(story, "met nothing") && tells(story, "black"), "a miss is black:\n%s", story);
    rk_check(tells(story, "pixel (15, 10)"), "the story begins with its pixel:\n%s", story);
    rk_check(!tells(story, "light 0"), "no light shines on nothing:\n%s", story);
    free(story);
    rk_scene_free(&scene);
}

static void an_environment_is_told(void **state)
{
    (void)state;
    /* Misses, glass in front of nothing, and a mirror. */
    rk_scene scene = test_scene_of(4, 2);
    rk_error error;
    test_scene_quad(&scene, 0, rk_vec(0, -9, 1), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(-1, -0.3f, 0), rk_vec(2, 0, 0), rk_vec(0, 0.5f, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    scene.mesh.materials[1].alpha = 0.25f;
    test_scene_light(&scene, rk_vec(5, 0, -1), rk_vec(1, 1, 1));
    rk_check_ok(rk_sky_make(&scene.environment, 8, &error), error);
    rk_render_options options = size_of(19, 13, true);
    options.reflections = options.transparency = true;
    test_picture picture = test_render(&scene, options, 1);
    int misses = 0, behind = 0;
    for (uint32_t y = 0; y < options.height; y++)
        for (uint32_t x = 0; x < options.width; x++) {
            char *story = narrate(&scene, options, x, y);
            check_told(story, "colour (linear)", *rk_image_at(&picture.image, x, y));
            misses += tells(story, "met nothing: the environment");
            behind += tells(story, "behind it all: the environment");
            free(story);
        }
    rk_check(misses > 10 && behind > 2, "%d misses, %d through glass", misses, behind);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void shadow_and_free_ways_are_told(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    rk_render_options options = size_of(20, 20, true);
    /* Half-way from wall to light is z = 0; in the square if the wall's x is in 0.5 to 1.5. */
    char *dark = narrate(&scene, options, 5, 10), *lit = narrate(&scene, options, 1, 10);
    rk_check(tells(dark, "in shadow"), "the square is in the way:\n%s", dark);
    check_told(dark, "colour (linear)", rk_vec(0, 0, 0));
    rk_check(tells(lit, "the way is free"), "nothing is in the way:\n%s", lit);
    free(dark);
    free(lit);
    options.shadows = false;
    char *unasked = narrate(&scene, options, 5, 10);
    rk_check(!tells(unasked, "shadow ray"), "no shadow ray was asked for:\n%s", unasked);
    rk_check(told_vector(unasked, "colour (linear)").x > 0, "without shadows it is lit:\n%s",
             unasked);
    free(unasked);
    rk_scene_free(&scene);
}

static void the_hit_is_told(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    char *story = narrate(&scene, size_of(21, 21, false), 5, 10);
    /* Pixel 5 of 21 is 5 pixels left of the middle: x = 5 / 21 of 2 tan 25 degrees, times 4. */
    float x = 4 * 2 * 0.46630766f * 5 / 21;
    rk_check(tells(story, "met triangle"), "the wall is met:\n%s", story);
    check_told(story, "    origin", rk_vec(0, 0, -3));
    check_told(story, "    point", rk_vec(x, 0, 1));
    check_told(story, "    face normal", rk_vec(0, 0, -1));
    check_told(story, "    shading normal", rk_vec(0, 0, -1));
    check_told(story, "    kd  ", rk_vec(0.8f, 0.8f, 0.8f));
    check_told(story, "    position", rk_vec(5, 0, -1));
    free(story);
    rk_scene_free(&scene);
}

static void lights_that_add_nothing_are_told(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    scene.light_count = 0;
    test_scene_light(&scene, rk_vec(1, 0, 3), rk_vec(1, 1, 1));
    test_scene_light(&scene, rk_vec(1, 0, -1), rk_vec(0, 0, 0));
    char *story = narrate(&scene, size_of(20, 20, true), 5, 10);
    rk_check(tells(story, "turned away"), "light 0 is behind the wall:\n%s", story);
    rk_check(tells(story, "light is black"), "light 1 is black:\n%s", story);
    rk_check(!tells(story, "shadow ray"), "neither needs a shadow ray:\n%s", story);
    free(story);
    rk_scene_free(&scene);
}

static void more_samples_than_the_centre_are_mentioned(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    rk_render_options options = size_of(20, 20, false);
    char *one = narrate(&scene, options, 5, 10);
    options.samples = 16;
    char *many = narrate(&scene, options, 5, 10);
    rk_check(tells(many, "averages 16 rays") && !tells(one, "averages"),
             "the story of one ray is not the pixel's colour then:\n%s", many);
    free(one);
    free(many);
    rk_scene_free(&scene);
}

static void mirrors_and_panes_on_the_way_are_told(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(6, 3);
    test_scene_wall(&scene, 0, 0, 1);
    test_scene_wall(&scene, 2, 1, 2);
    test_scene_wall(&scene, 4, -6, 0);
    scene.mesh.materials[1].alpha = 0.25f;
    scene.mesh.materials[2].ks = rk_vec(1, 1, 1);
    test_scene_light(&scene, rk_vec(1, 2, -2), rk_vec(1, 1, 1));
    rk_render_options options = size_of(20, 20, true);
    options.reflections = options.transparency = true;
    options.max_depth = 1;
    char *story = narrate(&scene, options, 5, 9);
    rk_check(tells(story, "alpha = 0.250000"), "the pane's opacity:\n%s", story);
    rk_check(tells(story, "the way leads through glass") || tells(story, "the way is free"),
             "what became of the shadow rays:\n%s", story);
    rk_check(!tells(story, "mirrored ray"), "the limit of 1 ends at the mirror:\n%s", story);
    free(story);
    options.max_depth = 3;
    story = narrate(&scene, options, 5, 9);
    rk_check(tells(story, "mirrored ray"), "the limit of 3 lets it be mirrored:\n%s", story);
    free(story);
    rk_scene_free(&scene);
}

static void a_light_with_an_extent_tells_how_much_of_it_is_seen(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = size_of(40, 40, true);
    char *story = narrate(&scene, options, 20, 12);
    rk_check(tells(story, "a parallelogram") && tells(story, "16 shadow rays, 16 of them not"),
             "the back wall sees the whole light:\n%s", story);
    free(story);
    rk_scene_free(&scene);
}

static void a_lens_is_told_of_where_there_is_one(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cube");
    rk_render_options options = size_of(40, 40, false);
    for (options.lens_samples = 0; options.lens_samples <= 15; options.lens_samples += 15) {
        char *story = narrate(&scene, options, 20, 20);
        rk_check(tells(story, "lens") == (options.lens_samples > 0), "the story is:\n%s", story);
        free(story);
    }
    rk_scene_free(&scene);
}

static void a_glow_is_told_of_where_there_may_be_one(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cube");
    rk_render_options options = size_of(40, 40, false);
    for (int on = 0; on < 2; on++) {
        options.bloom.on = on;
        char *story = narrate(&scene, options, 20, 20);
        rk_check(tells(story, "glow") == on, "the story is:\n%s", story);
        free(story);
    }
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_told_colour_is_the_rendered_one),
    cmocka_unit_test(a_miss_is_told),
    cmocka_unit_test(an_environment_is_told),
    cmocka_unit_test(shadow_and_free_ways_are_told),
    cmocka_unit_test(the_hit_is_told),
    cmocka_unit_test(lights_that_add_nothing_are_told),
    cmocka_unit_test(mirrors_and_panes_on_the_way_are_told),
    cmocka_unit_test(a_light_with_an_extent_tells_how_much_of_it_is_seen),
    cmocka_unit_test(more_samples_than_the_centre_are_mentioned),
    cmocka_unit_test(a_glow_is_told_of_where_there_may_be_one),
    cmocka_unit_test(a_lens_is_told_of_where_there_is_one),
};

RK_SUITE("narrate", tests)
