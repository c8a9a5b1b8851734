/* What cannot be drawn is refused with one sentence, before the first ray. */
#include "test_scene.h"

enum { side = 8 };

typedef struct fixture {
    rk_scene scene;
    rk_accel accel;
    rk_pool *pool;
    rk_image image;
    rk_render_options options;
} fixture;

static int set_up(void **state)
{
    rk_error error;
    fixture *f = calloc(1, sizeof *f);
    *state = f;
    if (!f)
        return -1;
    f->scene = test_scene_make(2);
    test_scene_wall(&f->scene, 0, 0, 0);
    test_scene_light(&f->scene, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    f->options = rk_render_options_default();
    f->options.width = f->options.height = side;
    f->pool = rk_pool_start(1, &error);
    return f->pool && rk_accel_build(&f->accel, RK_ACCEL_MEDIAN, &f->scene, &error) &&
                   rk_image_init(&f->image, side, side, &error)
               ? 0
               : -1;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    rk_accel_free(&f->accel);
    rk_image_free(&f->image);
    rk_pool_stop(f->pool);
    rk_scene_free(&f->scene);
    free(f);
    return 0;
}

/* The error names `part`, and not a ray was sent. */
static void check_refused(fixture *f, const char *part)
{
    rk_error error = {""};
    rk_counters counters = {0};
    rk_image_at(&f->image, 0, 0)->x = 7;
    bool done =
        rk_render(&f->image, &f->scene, &f->accel, &f->options, f->pool, &counters, NULL, &error);
    rk_check(!done, "it was drawn, with %llu rays, but should be refused for its \"%s\"",
             (unsigned long long)counters.primary_rays, part);
    rk_check_error_names(error, part);
    rk_check(!strchr(error.text, '\n'), "an error is one line: %s", error.text);
    rk_check(rk_image_at(&f->image, 0, 0)->x == 7, "\"%s\": the picture was touched", part);
}

static void what_the_tests_begin_with_is_drawn(void **state)
{
    fixture *f = *state;
    rk_error error;
    rk_counters counters = {0};
    rk_check_ok(rk_render_check(&f->scene, &f->options, &error), error);
    rk_check_ok(
        rk_render(&f->image, &f->scene, &f->accel, &f->options, f->pool, &counters, NULL, &error),
        error);
    rk_check_equal(counters.primary_rays, side * side, "one a pixel");
}

/* Gives the scene what takes samples of its own: motion, a mirror and a wide light. */
static void add_all_that_is_sampled(fixture *f)
{
    rk_error error;
    rk_scene_move_mesh(&f->scene, (rk_motion){0, 0, 1});
    f->scene.mesh.materials[0].ks = rk_vec(1, 1, 1);
    f->scene.lights[0].kind = RK_LIGHT_PARALLELOGRAM;
    f->options.reflections = true;
    rk_accel_free(&f->accel);
    rk_check_ok(rk_accel_build(&f->accel, RK_ACCEL_MEDIAN, &f->scene, &error), error);
}

/* --- Samples ---------------------------------------------------------------------------------- */

static void samples_are_refused_however_large_their_product_is(void **state)
{
    fixture *f = *state;
    const uint32_t most = UINT32_MAX, limit = RK_SAMPLES_MAX;
    /* Own, of the lens, in time, of rough mirrors, of the light. */
    const uint32_t cases[][5] = {
        {2, 0, most, 0, 1},          {most, 0, 4, 0, 1},      {most, 0, most, 0, 1},
        {1, 0, limit + 1, 0, 1},     {limit + 1, 0, 0, 0, 1}, {1, most, 0, 0, 1},
        {1, most, most, most, most}, {most, 0, 0, most, 1},   {limit, 0, 0, 1u << 8, 1u << 8},
        {1, 0, 0, 1, most},          {1, 0, 0, limit, limit},
    };
    add_all_that_is_sampled(f);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const uint32_t *n = cases[i];
        f->options.samples = n[0];
        f->options.lens_samples = n[1];
        f->options.motion.samples = n[2];
        f->options.glossy.samples = n[3];
        f->options.light.samples = n[4];
        check_refused(f, "16777216 samples");
    }
}

static void as_many_samples_as_a_sampler_has_are_accepted(void **state)
{
    fixture *f = *state;
    rk_error error;
    add_all_that_is_sampled(f);
    f->options.light.samples = 1;
    f->options.samples = 1 << 10;
    f->options.motion.samples = RK_SAMPLES_MAX;
    rk_check_ok(rk_render_check(&f->scene, &f->options, &error), error);
}

/* --- Enumerations ----------------------------------------------------------------------------- */

#define FIELD(name, last)                                                                          \
    {                                                                                              \
#name, offsetof(rk_render_options, name), last                                             \
    }

static const struct {
    const char *name;
    size_t offset;
    uint32_t last;
} fields[] = {
    FIELD(sampling, RK_SAMPLER_LOW_DISCREPANCY),
    FIELD(shading.model, RK_SHADING_GRADIENT),
    FIELD(glass, RK_GLASS_BEER_LAMBERT),
    FIELD(light.sampling, RK_SAMPLER_LOW_DISCREPANCY),
    FIELD(light.domain, RK_LIGHT_DOMAIN_SOLID_ANGLE),
    FIELD(light.falloff, RK_FALLOFF_PHYSICAL),
    FIELD(bloom.border, RK_BLOOM_RENORMALIZE),
    FIELD(bloom.method, RK_BLOOM_PYRAMID),
    FIELD(environment_filter, RK_CUBEMAP_SEAMLESS),
    FIELD(lens.focal, RK_FOCAL_SPHERE),
    FIELD(lens_sampling, RK_SAMPLER_LOW_DISCREPANCY),
    FIELD(motion.sampling, RK_TIME_LOW_DISCREPANCY),
    FIELD(glossy.weights, RK_GLOSSY_RENORMALIZED),
    FIELD(glossy.map, RK_DISK_CONCENTRIC),
    FIELD(glossy.sampling, RK_SAMPLER_LOW_DISCREPANCY),
};

static void a_value_beyond_its_enumeration_is_refused_by_its_name(void **state)
{
    fixture *f = *state;
    const rk_render_options right = f->options;
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        unsigned char *field = (unsigned char *)&f->options + fields[i].offset;
        const uint32_t wrong[] = {fields[i].last + 1, 99, UINT32_MAX};
        for (int k = 0; k < 3; k++) {
            memcpy(field, &wrong[k], sizeof wrong[k]);
            check_refused(f, fields[i].name);
        }
        rk_error error;
        memcpy(field, &fields[i].last, sizeof fields[i].last);
        rk_check_ok(rk_render_check(&f->scene, &f->options, &error), error);
        f->options = right;
    }
}

/* --- Numbers ---------------------------------------------------------------------------------- */

static void a_wrong_bloom_is_refused_before_the_picture_is_rendered(void **state)
{
    fixture *f = *state;
    const rk_bloom_options right = {.on = true, .threshold = 0.5f, .intensity = 1, .radius = 2};
    f->options.bloom = right;
    f->options.bloom.radius = RK_BLOOM_RADIUS_MAX + 1;
    check_refused(f, "at most 4096 pixels");
    f->options.bloom = right;
    f->options.bloom.threshold = NAN;
    check_refused(f, "threshold");
    const float wrong[] = {-1, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        f->options.bloom = right;
        f->options.bloom.intensity = wrong[i];
        check_refused(f, "intensity");
    }
}

static void a_gradient_of_too_many_stops_is_refused(void **state)
{
    fixture *f = *state;
    f->options.shading.gradient.count = RK_GRADIENT_STOPS_MAX + 1;
    check_refused(f, "at most 16 stops");
}

/* --- Scenes ----------------------------------------------------------------------------------- */

static void a_field_of_view_that_is_none_is_refused(void **state)
{
    fixture *f = *state;
    const float wrong[] = {0, 180, -1, 200, NAN, INFINITY};
    for (int i = 0; i < 6; i++) {
        f->scene.camera.fov = wrong[i];
        check_refused(f, "field of view");
    }
}

static void more_lights_or_spheres_than_there_is_room_for_are_refused(void **state)
{
    fixture *f = *state;
    f->scene.light_count = 99;
    check_refused(f, "99 lights");
    f->scene.light_count = 1;
    f->scene.sphere_count = RK_SPHERES_MAX + 1;
    check_refused(f, "17 spheres");
    f->scene.sphere_count = 0;
    f->scene.lights[0].kind = RK_LIGHT_PARALLELOGRAM + 1;
    check_refused(f, "light 0");
}

/* --- Trees ------------------------------------------------------------------------------------ */

static void a_tree_of_no_kind_or_without_usable_bins_is_refused(void **state)
{
    fixture *f = *state;
    const struct {
        uint32_t kind, bins;
        const char *part;
    } cases[] = {
        {9, 50, "kind is 9"},           {RK_ACCEL_SAH_3 + 1, 50, "kind is 3"},
        {RK_ACCEL_SAH, 0, "not 0"},     {RK_ACCEL_SAH_3, 1, "not 1"},
        {RK_ACCEL_SAH, 257, "not 257"}, {RK_ACCEL_SAH_3, 1000000, "not 1000000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_accel accel;
        rk_error error = {""};
        rk_check(!rk_accel_build_binned(&accel, (rk_accel_kind)cases[i].kind, cases[i].bins,
                                        &f->scene, &error),
                 "kind %u, %u bins", cases[i].kind, cases[i].bins);
        rk_check_error_names(error, cases[i].part);
        rk_accel_free(&accel);
    }
}

static void a_tree_without_bins_does_not_ask_for_them(void **state)
{
    fixture *f = *state;
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build_binned(&accel, RK_ACCEL_MEDIAN, 0, &f->scene, &error), error);
    rk_accel_free(&accel);
}

#define in_fixture(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

static const struct CMUnitTest tests[] = {
    in_fixture(what_the_tests_begin_with_is_drawn),
    in_fixture(samples_are_refused_however_large_their_product_is),
    in_fixture(as_many_samples_as_a_sampler_has_are_accepted),
    in_fixture(a_value_beyond_its_enumeration_is_refused_by_its_name),
    in_fixture(a_wrong_bloom_is_refused_before_the_picture_is_rendered),
    in_fixture(a_gradient_of_too_many_stops_is_refused),
    in_fixture(a_field_of_view_that_is_none_is_refused),
    in_fixture(more_lights_or_spheres_than_there_is_room_for_are_refused),
    in_fixture(a_tree_of_no_kind_or_without_usable_bins_is_refused),
    in_fixture(a_tree_without_bins_does_not_ask_for_them),
};

RK_SUITE("render_check", tests)
