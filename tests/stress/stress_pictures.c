/* Whole pictures: of odd shapes, under a lens and a bloom of any size, and by lights seen from the
 * side. Every pixel is finite, or the picture is refused. */
#include "../test_scene.h"

static bool is_finite(rk_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static rk_render_options everything(uint32_t width, uint32_t height)
{
    rk_render_options options = rk_render_options_default();
    options.width = width, options.height = height;
    options.shadows = options.reflections = options.transparency = true;
    options.shading.model = RK_SHADING_BLINN_PHONG;
    options.lens.aperture = 1e6f, options.lens_samples = 2;
    options.motion.samples = 2;
    options.glossy.samples = 1, options.glossy.radius = 1;
    options.ambient_occlusion.intensity = 1, options.ambient_occlusion.samples = 1;
    options.bloom.on = true, options.bloom.threshold = 0, options.bloom.intensity = 1;
    options.bloom.radius = RK_BLOOM_RADIUS_MAX;
    return options;
}

static void check_picture(const rk_scene *scene, rk_render_options options)
{
    test_picture picture = test_render(scene, options, 1);
    for (size_t i = 0; i < picture.image.width * picture.image.height; i++)
        rk_check(is_finite(picture.image.pixels[i]), "%zu x %zu: pixel %zu", picture.image.width,
                 picture.image.height, i);
    rk_image_free(&picture.image);
}

/* With a lens wider than the scene, and bloom wider than the picture by all methods and borders. */
static void pictures_of_any_shape_are_finite(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {
        {1, 1}, {1, RK_IMAGE_SIDE_MAX}, {RK_IMAGE_SIDE_MAX, 1}, {2, 3}, {17, 16}};
    rk_scene scene = test_scene_builtin("moving:2");
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        rk_render_options options = everything(sizes[i][0], sizes[i][1]);
        bool is_long = sizes[i][0] + sizes[i][1] > RK_IMAGE_SIDE_MAX;
        for (int method = 0; method < (is_long ? 1 : 4); method++)
            for (int border = 0; border < (is_long ? 1 : 3); border++) {
                options.bloom.method = (rk_bloom_method)method;
                options.bloom.border = (rk_bloom_border)border;
                check_picture(&scene, options);
            }
    }
    rk_scene_free(&scene);
}

static void larger_pictures_than_there_is_room_for_are_refused(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_error error;
    rk_render_options options = everything(1, 100000);
    rk_check(!rk_render_check(&scene, &options, &error), "1 x 100,000 is too high");
    rk_check_error_names(error, "height");
    rk_scene_free(&scene);
}

/* A light in the plane of the floor that it stands on, all around an edge-on wall, and a needle. */
static void lights_seen_from_the_side_give_finite_pictures(void **state)
{
    (void)state;
    static const rk_vec3 edges[][2] = {{{1, 0, 0}, {0, 0, 1}},
                                       {{1, 0, 0}, {0, 1, 0}},
                                       {{1, 0, 0}, {0, 1e-6f, 0}},
                                       {{1, 0, 0}, {2, 0, 0}},
                                       {{0, 0, 0}, {0, 0, 0}}};
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-1, -1, 0), rk_vec(2, 0, 0), rk_vec(0, 2, 0));
    for (size_t i = 0; i < sizeof edges / sizeof *edges; i++)
        for (int way = 0; way < 8; way++) {
            const rk_vec3 white = {1, 1, 1};
            scene.lights[0] = (rk_light){RK_LIGHT_PARALLELOGRAM,
                                         {-0.5f, -0.5f, 0},
                                         edges[i][0],
                                         edges[i][1],
                                         {white, white, white, white}};
            scene.light_count = 1;
            rk_render_options options = rk_render_options_default();
            options.width = options.height = 16, options.light.samples = 4;
            options.shadows = true;
            options.light.falloff = (rk_light_falloff)(way % 2);
            options.light.domain = (rk_light_domain)(way / 2 % 2);
            options.light.ratio = way / 4;
            check_picture(&scene, options);
        }
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(pictures_of_any_shape_are_finite),
    cmocka_unit_test(larger_pictures_than_there_is_room_for_are_refused),
    cmocka_unit_test(lights_seen_from_the_side_give_finite_pictures),
};

RK_SUITE("stress pictures", tests)
