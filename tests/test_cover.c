/* All features in one picture: each takes part, each can be left out, and one that is left out or
 * that the scene does not need leaves its counters at 0. */
#include "test_scene.h"

#include "scenes/sky.h"

static rk_render_options everything(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 60;
    options.height = 40;
    options.shadows = options.reflections = options.transparency = true;
    options.shading.model = RK_SHADING_BLINN_PHONG;
    options.glass = RK_GLASS_BEER_LAMBERT;
    options.light.samples = 4;
    options.glossy.samples = 2;
    options.bloom.on = true;
    options.lens = (rk_lens){.focal_distance = 3.2f, .aperture = 60};
    options.lens_samples = 4;
    options.motion.samples = 4;
    options.motion.shutter.close = 0.1f;
    return options;
}

static rk_scene make_cover(void)
{
    rk_scene scene = test_scene_builtin("cover:2000");
    rk_error error;
    rk_check_ok(rk_sky_make(&scene.environment, 32, &error), error);
    return scene;
}

/* The counter of each feature, and how it is left out. */
typedef enum feature {
    mirrors,
    rough,
    lights,
    shadows,
    lens,
    motion,
    bloom,
    sky,
    feature_count
} feature;

static const char *const names[] = {
    "mirrors", "rough mirrors", "lights with an extent", "shadows", "lens", "motion", "bloom",
    "sky"};

static uint64_t count_of(feature f, const rk_counters *c)
{
    const uint64_t counts[] = {c->reflected_rays, c->glossy_samples,     c->light_samples,
                               c->shadow_rays,    c->lens_samples,       c->time_samples,
                               c->bloom_taps,     c->environment_lookups};
    return counts[f];
}

static void leave_out(feature f, rk_render_options *options, rk_scene *scene)
{
    switch (f) {
    case mirrors:
        options->reflections = false;
        break;
    case rough:
        options->glossy.samples = 0;
        break;
    case lights:
        scene->lights[0].kind = RK_LIGHT_POINT;
        break;
    case shadows:
        options->shadows = false;
        break;
    case lens:
        options->lens.aperture = 0;
        break;
    case motion:
        options->motion.samples = 0;
        break;
    case bloom:
        options->bloom.on = false;
        break;
    case sky:
        rk_cubemap_free(&scene->environment);
        break;
    case feature_count:
        break;
    }
}

static void all_features_take_part(void **state)
{
    (void)state;
    rk_scene scene = make_cover();
    test_picture picture = test_render(&scene, everything(), 2);
    for (int f = 0; f < feature_count; f++)
        rk_check(count_of((feature)f, &picture.counters) > 0, "%s took no part", names[f]);
    for (size_t i = 0; i < 60 * 40; i++)
        rk_check(isfinite(rk_length(picture.image.pixels[i])), "pixel %zu is not finite", i);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void each_can_be_left_out_at_no_cost(void **state)
{
    (void)state;
    rk_scene scene = make_cover();
    test_picture all = test_render(&scene, everything(), 2);
    rk_scene_free(&scene);
    for (int f = 0; f < feature_count; f++) {
        rk_render_options options = everything();
        scene = make_cover();
        leave_out((feature)f, &options, &scene);
        test_picture without = test_render(&scene, options, 2);
        rk_check(count_of((feature)f, &without.counters) == 0, "%s left out, but counted",
                 names[f]);
        rk_check(!test_same_pixels(&all.image, &without.image), "%s left out, and nothing changed",
                 names[f]);
        rk_image_free(&without.image);
        rk_scene_free(&scene);
    }
    rk_image_free(&all.image);
}

static void the_picture_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_scene scene = make_cover();
    test_picture one = test_render(&scene, everything(), 1);
    test_picture three = test_render(&scene, everything(), 3);
    rk_check(test_same_pixels(&one.image, &three.image), "threads change the picture");
    rk_check(memcmp(&one.counters, &three.counters, sizeof one.counters) == 0,
             "threads change the work");
    rk_image_free(&one.image);
    rk_image_free(&three.image);
    rk_scene_free(&scene);
}

static void a_scene_that_needs_none_pays_for_none(void **state)
{
    (void)state;
    /* A dull statue and a point light, with all options of features that the scene does not need.
     */
    rk_scene scene = test_scene_builtin("statue:2000");
    for (uint32_t i = 0; i < scene.mesh.material_count; i++)
        scene.mesh.materials[i].ks = rk_vec(0, 0, 0);
    rk_render_options plain = rk_render_options_default(), full = everything();
    plain.width = full.width;
    plain.height = full.height;
    plain.shadows = true;
    full.shading = plain.shading;
    full.lens.aperture = 0;
    full.bloom.threshold =
        100; /* nothing is that bright: the picture is read once, and not filtered */
    test_picture want = test_render(&scene, plain, 2), got = test_render(&scene, full, 2);
    rk_check(test_same_pixels(&want.image, &got.image), "not the same picture to the bit");
    got.counters.bloom_pixels_read = 0;
    rk_check(memcmp(&want.counters, &got.counters, sizeof want.counters) == 0,
             "something was done that this scene does not need");
    rk_image_free(&want.image);
    rk_image_free(&got.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(all_features_take_part),
    cmocka_unit_test(each_can_be_left_out_at_no_cost),
    cmocka_unit_test(the_picture_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(a_scene_that_needs_none_pays_for_none),
};

RK_SUITE("cover", tests)
