/* Wrong scenes and options are refused with one sentence, before the first ray. */
#include "test_scene.h"

#include "render/options.h"

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

/* The error names `part`, and no ray was traced. */
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

static void the_options_that_these_tests_start_from_are_accepted(void **state)
{
    fixture *f = *state;
    rk_error error;
    rk_counters counters = {0};
    rk_check_ok(rk_render_check(&f->scene, &f->options, &error), error);
    rk_check_ok(
        rk_render(&f->image, &f->scene, &f->accel, &f->options, f->pool, &counters, NULL, &error),
        error);
    rk_check_equal(counters.primary_rays, side * side, "one per pixel");
}

/* Adds features with samples of their own: motion, a mirror and a light with an extent. */
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
    FIELD(sampling, RK_SAMPLER_ZSOBOL),
    FIELD(shading.model, RK_SHADING_GRADIENT),
    FIELD(glass, RK_GLASS_BEER_LAMBERT),
    FIELD(light.sampling, RK_SAMPLER_ZSOBOL),
    FIELD(light.domain, RK_LIGHT_DOMAIN_SOLID_ANGLE),
    FIELD(light.falloff, RK_FALLOFF_PHYSICAL),
    FIELD(bloom.border, RK_BLOOM_RENORMALIZE),
    FIELD(bloom.method, RK_BLOOM_PYRAMID),
    FIELD(environment_filter, RK_CUBEMAP_SEAMLESS),
    FIELD(lens.focal, RK_FOCAL_SPHERE),
    FIELD(lens_sampling, RK_SAMPLER_ZSOBOL),
    FIELD(motion.sampling, RK_TIME_UNIFORM),
    FIELD(glossy.weights, RK_GLOSSY_RENORMALIZED),
    FIELD(glossy.map, RK_DISK_CONCENTRIC),
    FIELD(glossy.sampling, RK_SAMPLER_ZSOBOL),
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

/* --- Rows ------------------------------------------------------------------------------------- */

/* Calls `claim` with each row of the renderer's and the features' options. */
static void for_each_row(fixture *f, void (*claim)(fixture *f, const rk_option *row))
{
    const rk_render_option_tables all = rk_render_options_tables(&f->options);
    for (size_t t = 0; t < all.count; t++)
        for (const rk_option *row = all.tables[t].rows; row->name; row++)
            claim(f, row);
}

static void *value_of(fixture *f, const rk_option *row)
{
    return (char *)&f->options + row->offset;
}

static void check_default(fixture *f, const rk_option *row)
{
    const float *number = value_of(f, row);
    const uint32_t *count = value_of(f, row);
    rk_check(row->field && row->help && row->kind != RK_OPTION_TEXT, "--%s: half a row", row->name);
    if (row->kind == RK_OPTION_FLOAT && !isnan(row->initial))
        rk_check(*number == (float)row->initial && *number >= (float)row->low &&
                     *number <= (float)row->high,
                 "--%s: the default %g should lie from %g to %g", row->name, (double)*number,
                 row->low, row->high);
    if (row->kind == RK_OPTION_UINT)
        rk_check(*count == row->initial && *count >= row->low && *count <= row->high,
                 "--%s: the default %u should lie from %g to %g", row->name, *count, row->low,
                 row->high);
    if (row->kind == RK_OPTION_CHOICE)
        rk_check(*count == row->initial && *count < row->names->count,
                 "--%s: the default %u should be one of %u names", row->name, *count,
                 row->names->count);
}

static void every_default_lies_in_its_range(void **state)
{
    fixture *f = *state;
    rk_error error;
    f->options = rk_render_options_default();
    for_each_row(f, check_default);
    rk_check_ok(rk_render_options_check(&f->options, &error), error);
}

static void check_beyond(fixture *f, const rk_option *row)
{
    const rk_render_options right = f->options;
    const double beyond[] = {row->low - fmax(1, fabs(row->low)), row->high + fmax(1, row->high)};
    for (int i = 0; i < 2; i++) {
        rk_error error = {""};
        if (row->kind == RK_OPTION_FLOAT)
            *(float *)value_of(f, row) = (float)beyond[i];
        else if (row->kind == RK_OPTION_UINT && beyond[i] >= 0 && beyond[i] <= UINT32_MAX)
            *(uint32_t *)value_of(f, row) = (uint32_t)beyond[i];
        else
            continue;
        rk_check(!rk_render_options_check(&f->options, &error), "--%s accepts %g", row->name,
                 beyond[i]);
        rk_check_error_names(error, row->field);
        f->options = right;
    }
}

static void a_number_out_of_range_is_refused_by_its_field(void **state)
{
    for_each_row(*state, check_beyond);
}

static void check_names(fixture *f, const rk_option *row)
{
    (void)f;
    if (row->kind != RK_OPTION_CHOICE)
        return;
    for (uint32_t i = 0; i < row->names->count; i++)
        for (uint32_t k = 0; k <= i; k++)
            rk_check(*row->names->items[i] &&
                         (i == k || strcmp(row->names->items[i], row->names->items[k]) != 0),
                     "--%s: its names should differ", row->name);
}

static void the_names_of_a_choice_differ(void **state)
{
    for_each_row(*state, check_names);
}

static const rk_option *spelled; /* to be found once */
static uint32_t spellings;

static void count_spellings(fixture *f, const rk_option *row)
{
    (void)f;
    spellings += strcmp(row->name, spelled->name) == 0;
    spellings += row->alias && strcmp(row->alias, spelled->name) == 0;
    spellings += row->alias && spelled->alias && strcmp(row->alias, spelled->alias) == 0;
}

static void check_spelling(fixture *f, const rk_option *row)
{
    spelled = row;
    spellings = 0;
    for_each_row(f, count_spellings);
    rk_check_equal(spellings, row->alias ? 2 : 1, row->name);
}

static void no_two_options_are_spelled_alike(void **state)
{
    for_each_row(*state, check_spelling);
}

/* --- Features --------------------------------------------------------------------------------- */

static void each_feature_has_its_descriptor_and_its_bit(void **state)
{
    (void)state;
#define RK_FEATURE(feature)                                                                        \
    {                                                                                              \
        const rk_plan plan = {.feature = true};                                                    \
        assert_string_equal(rk_features[RK_FEATURE_##feature]->stem, #feature);                    \
        for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)                                            \
            rk_check_equal(rk_plan_has(&plan, i), i == RK_FEATURE_##feature, #feature);            \
    }
#include "features/list.h"
#undef RK_FEATURE
}

static void a_shutter_that_closes_before_it_opens_is_refused(void **state)
{
    fixture *f = *state;
    f->options.motion.shutter = (rk_shutter){0.5f, 0.25f};
    check_refused(f, "closes at x = 0.25");
}

static void a_picture_without_pixels_or_samples_is_refused(void **state)
{
    fixture *f = *state;
    f->options.samples = 0;
    check_refused(f, "samples is 0, but it takes a whole number, 1 to");
    f->options.samples = 1;
    f->options.light.samples = 0;
    check_refused(f, "light.samples is 0");
    rk_error error = {""};
    f->options.light.samples = 1;
    f->options.width = 0;
    rk_check(!rk_render_check(&f->scene, &f->options, &error), "a picture is at least 1 wide");
    rk_check_error_names(error, "width is 0");
}

/* --- Numbers ---------------------------------------------------------------------------------- */

static void a_wrong_bloom_is_refused_before_the_picture_is_rendered(void **state)
{
    fixture *f = *state;
    const rk_bloom_options right = {.on = true, .threshold = 0.5f, .intensity = 1, .radius = 2};
    f->options.bloom = right;
    f->options.bloom.radius = RK_BLOOM_RADIUS_MAX + 1;
    check_refused(f, "bloom.radius is 4097, but it takes a whole number, 0 to 4096");
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

static void a_wrong_field_of_view_is_refused(void **state)
{
    fixture *f = *state;
    const float wrong[] = {0, 180, -1, 200, NAN, INFINITY};
    for (int i = 0; i < 6; i++) {
        f->scene.camera.fov = wrong[i];
        check_refused(f, "field of view");
    }
}

static void a_background_that_is_no_radiance_is_refused(void **state)
{
    fixture *f = *state;
    const float wrong[] = {-1, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        f->scene.background = wrong[i];
        check_refused(f, "the background is");
    }
}

static void a_camera_that_is_no_place_is_refused(void **state)
{
    fixture *f = *state;
    const rk_camera right = f->scene.camera;
    const float wrong[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++)
        for (int field = 0; field < 7; field++) {
            rk_camera *camera = &f->scene.camera;
            *camera = right;
            float *const members[] = {&camera->look_at.x,  &camera->look_at.y,  &camera->look_at.z,
                                      &camera->rotation.x, &camera->rotation.y, &camera->rotation.z,
                                      &camera->distance};
            *members[field] = wrong[i];
            check_refused(f, "the camera's look_at, rotation or distance");
        }
}

static void lights_that_are_not_numbers_are_refused_where_they_are_read(void **state)
{
    fixture *f = *state;
    rk_error error;
    const float wrong[] = {NAN, INFINITY, -INFINITY};
    const uint32_t corners[] = {1, 2, 4};
    for (uint32_t kind = RK_LIGHT_POINT; kind <= RK_LIGHT_PARALLELOGRAM; kind++)
        for (uint32_t field = 0; field < 7; field++) {
            rk_light *light = &f->scene.lights[0];
            *light = (rk_light){.kind = (rk_light_kind)kind, .position = {0, 0, -2}};
            rk_vec3 *const members[] = {&light->position,   &light->edge01,     &light->edge02,
                                        &light->colours[0], &light->colours[1], &light->colours[2],
                                        &light->colours[3]};
            const uint32_t needs[] = {1, 2, 4, 1, 2, 4, 4}; /* corners */
            members[field]->y = wrong[field % 3];
            if (corners[kind] >= needs[field])
                check_refused(f, "light 0 has a position, an edge or a colour");
            else
                rk_check_ok(rk_render_check(&f->scene, &f->options, &error), error);
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

static void a_tree_of_an_unknown_kind_or_without_usable_bins_is_refused(void **state)
{
    fixture *f = *state;
    const struct {
        uint32_t kind, bins;
        const char *part;
    } cases[] = {
        {9, 50, "kind is 9"},           {RK_ACCEL_WIDE + 1, 50, "kind is 6"},
        {RK_ACCEL_SAH, 0, "not 0"},     {RK_ACCEL_SAH_3, 1, "not 1"},
        {RK_ACCEL_SAH, 257, "not 257"}, {RK_ACCEL_SAH_3, 1000000, "not 1000000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_accel accel;
        rk_error error = {""};
        const rk_accel_options options = {(rk_accel_kind)cases[i].kind, cases[i].bins, NULL};
        rk_check(!rk_accel_build_with(&accel, &options, &f->scene, &error), "kind %u, %u bins",
                 cases[i].kind, cases[i].bins);
        rk_check_error_names(error, cases[i].part);
        rk_accel_free(&accel);
    }
}

static void a_tree_without_bins_ignores_their_number(void **state)
{
    fixture *f = *state;
    rk_accel accel;
    rk_error error;
    const rk_accel_options options = {RK_ACCEL_MEDIAN, 0, NULL};
    rk_check_ok(rk_accel_build_with(&accel, &options, &f->scene, &error), error);
    rk_accel_free(&accel);
}

#define in_fixture(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

static const struct CMUnitTest tests[] = {
    in_fixture(the_options_that_these_tests_start_from_are_accepted),
    in_fixture(samples_are_refused_however_large_their_product_is),
    in_fixture(as_many_samples_as_a_sampler_has_are_accepted),
    in_fixture(a_value_beyond_its_enumeration_is_refused_by_its_name),
    in_fixture(every_default_lies_in_its_range),
    in_fixture(a_number_out_of_range_is_refused_by_its_field),
    in_fixture(the_names_of_a_choice_differ),
    in_fixture(no_two_options_are_spelled_alike),
    in_fixture(each_feature_has_its_descriptor_and_its_bit),
    in_fixture(a_shutter_that_closes_before_it_opens_is_refused),
    in_fixture(a_picture_without_pixels_or_samples_is_refused),
    in_fixture(a_wrong_bloom_is_refused_before_the_picture_is_rendered),
    in_fixture(a_gradient_of_too_many_stops_is_refused),
    in_fixture(a_wrong_field_of_view_is_refused),
    in_fixture(a_background_that_is_no_radiance_is_refused),
    in_fixture(a_camera_that_is_no_place_is_refused),
    in_fixture(lights_that_are_not_numbers_are_refused_where_they_are_read),
    in_fixture(more_lights_or_spheres_than_there_is_room_for_are_refused),
    in_fixture(a_tree_of_an_unknown_kind_or_without_usable_bins_is_refused),
    in_fixture(a_tree_without_bins_ignores_their_number),
};

RK_SUITE("render_check", tests)
