/* Rough mirrors in the renderer: what they show against closed forms, how many rays they send, and
 * that nothing is drawn where nothing is rough. */
#include "test_scene.h"

#include "accel/query/trace.h"

static const double pi = 3.14159265358979323846;

/* Surfaces show their colour, however they are lit. */
static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 14;
    options.height = 11;
    options.reflections = true;
    options.shading.model = RK_SHADING_OFF;
    options.glossy.samples = 64;
    options.glossy.radius = 0.3f;
    return options;
}

static void make_mirror(rk_material *material)
{
    material->kd = rk_vec(0, 0, 0);
    material->ks = rk_vec(1, 1, 1);
}

/* A mirror at z = 1, and behind the viewer, at z = -6, a wall that fills the half x < 0. */
static rk_scene make_half(void)
{
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 1, 0);
    test_scene_quad(&scene, 2, rk_vec(-99, -99, -6), rk_vec(99, 0, 0), rk_vec(0, 198, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    make_mirror(&scene.mesh.materials[0]);
    scene.mesh.materials[1].kd = rk_vec(1, 1, 1);
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    return scene;
}

/* The fraction of a disk of a radius at the tip of the unit vector w that is above the plane
 * through 0 with the unit normal n: by chords parallel to the plane, 1e-3 exact. */
static double fraction_above(rk_dvec3 w, double radius, rk_dvec3 n)
{
    enum { chords = 400 };
    double height = rk_ddot(w, n), slope = radius * sqrt(fmax(1 - height * height, 0)), sum = 0;
    for (int i = 0; i < chords; i++) {
        double at = (2 * i + 1.0) / chords - 1;
        sum += height + slope * at > 0 ? 2 * sqrt(1 - at * at) : 0;
    }
    return fmin(sum * 2 / chords / pi, 1);
}

/* The camera's direction through the middle of a pixel. */
static rk_dvec3 pixel_direction(const rk_render_options *options, size_t x, size_t y)
{
    double half = tan(25 * pi / 180);
    double across = 2 * ((double)x + 0.5) / options->width - 1;
    double up = 1 - 2 * ((double)y + 0.5) / options->height;
    rk_dvec3 d = {-across * half * options->width / options->height, up * half, 1};
    return rk_dscale(d, 1 / rk_dlength(d));
}

static double red_at(const test_picture *picture, size_t x, size_t y)
{
    return (double)rk_image_at(&picture->image, x, y)->x;
}

/* --- The picture ------------------------------------------------------------------------------ */

static void check_half(rk_sampler_kind sampling, rk_disk_map map)
{
    const uint32_t samples = 4096;
    rk_scene scene = make_half();
    rk_render_options options = small();
    options.glossy.samples = samples;
    options.glossy.sampling = sampling;
    options.glossy.map = map;
    test_picture picture = test_render(&scene, options, 2);
    int partly = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            rk_dvec3 w = pixel_direction(&options, x, y);
            double at = 4 * w.x / w.z; /* where the mirror is hit, on the x axis */
            w.z = -w.z;
            /* The plane from there to the edge of the wall. */
            rk_dvec3 n = rk_dscale((rk_dvec3){-7, 0, at}, 1 / hypot(7, at));
            double want = fraction_above(w, (double)options.glossy.radius, n);
            partly += want > 0.01 && want < 0.99;
            /* 5 standard deviations of independent samples; others are no worse. */
            rk_check(
                fabs(red_at(&picture, x, y) - want) <= 5 * 0.5 / sqrt(samples),
                "pixel (%zu, %zu), sampler %d: got %.4f, want %.4f, the fraction of the disk in "
                "which rays hit the wall",
                x, y, (int)sampling, red_at(&picture, x, y), want);
        }
    rk_check(partly > 40, "only %d pixels show the edge of the wall", partly);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void the_mean_is_the_integral_over_the_disk(void **state)
{
    (void)state;
    check_half(RK_SAMPLER_UNIFORM, RK_DISK_POLAR);
    check_half(RK_SAMPLER_STRATIFIED, RK_DISK_CONCENTRIC);
    check_half(RK_SAMPLER_LOW_DISCREPANCY, RK_DISK_CONCENTRIC);
}

static void pixel_samples_and_glossy_samples_multiply(void **state)
{
    (void)state;
    /* 256 x 16 samples of a pixel far away have the mean of 4096 samples of its centre. */
    rk_scene scene = make_half();
    rk_render_options options = small();
    options.width = options.height = 1;
    options.samples = 256;
    options.glossy.samples = 16;
    scene.camera.fov = 0.01f;
    test_picture picture = test_render(&scene, options, 1);
    rk_check_equal(picture.counters.glossy_samples, 4096, "a disk for each ray of the pixel");
    /* 5 standard deviations: the edge halves the disk. */
    rk_check_close(red_at(&picture, 0, 0), 0.5, 5 * 0.5 / 64,
                   "half of the disk's rays hit the wall");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* A mirror for a floor, in a room that is white all around. */
static rk_scene make_white_room(void)
{
    rk_scene scene = test_scene_of(2, 1);
    test_scene_quad(&scene, 0, rk_vec(-5, -0.2f, -5), rk_vec(10, 0, 0), rk_vec(0, 0, 10));
    make_mirror(&scene.mesh.materials[0]);
    scene.spheres[0] = (rk_sphere){rk_vec(0, 0, 0), 50};
    scene.sphere_materials[0] = (rk_material){.kd = rk_vec(1, 1, 1), .alpha = 1};
    scene.sphere_count = 1;
    test_scene_light(&scene, rk_vec(0, 1, 0), rk_vec(1, 1, 1));
    return scene;
}

static test_picture render_white_room(rk_render_options *options)
{
    rk_scene scene = make_white_room();
    options->width = options->height = 40; /* tiles that are not full, and batches that overflow */
    test_picture picture = test_render(&scene, *options, 2);
    rk_scene_free(&scene);
    return picture;
}

/* Of the disk that a pixel shows; 1 beside the floor. */
static double fraction_at(const rk_render_options *options, size_t x, size_t y)
{
    rk_dvec3 w = pixel_direction(options, x, y);
    bool floor = w.y < 0 && fabs(-0.2 / w.y * w.x) < 5 && -0.2 / w.y * w.z < 8;
    return floor ? fraction_above((rk_dvec3){w.x, -w.y, w.z}, 0.3, (rk_dvec3){0, 1, 0}) : 1;
}

static void check_darkened(uint32_t samples)
{
    rk_render_options options = small();
    options.glossy.weights = RK_GLOSSY_CLASSIC;
    options.glossy.samples = samples;
    test_picture picture = render_white_room(&options);
    double sum = 0, wanted = 0;
    int cut = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            double want = fraction_at(&options, x, y), got = red_at(&picture, x, y);
            cut += want < 0.99;
            sum += got;
            wanted += want;
            /* 5 standard deviations of an estimated fraction, and a whole sample where few are
             * below. */
            double tolerance = 2e-3 + 5 * sqrt(want * (1 - want) / samples) + 1.0 / samples;
            rk_check(fabs(got - want) <= tolerance,
                     "pixel (%zu, %zu), %u samples: got %.5f, want %.5f within %.5f", x, y, samples,
                     got, want, tolerance);
        }
    rk_check(cut > 100, "the floor intersects only %d disks", cut);
    /* A sample's standard deviation is at most 1/2. */
    rk_check_close(sum / 1600, wanted / 1600, 5 * 0.5 * sqrt(cut / (double)samples) / 1600 + 2e-3,
                   "over the picture, errors average out");
    rk_image_free(&picture.image);
}

static void classic_weights_darken_grazing_mirrors(void **state)
{
    (void)state;
    check_darkened(64);
    check_darkened(1);
}

static void renormalized_weights_keep_a_white_room_white(void **state)
{
    (void)state;
    const uint32_t samples[] = {1, 2, 3, 4, 64};
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++)
        for (int kind = 0; kind < 3; kind++) {
            rk_render_options options = small();
            options.glossy.samples = samples[i];
            options.glossy.sampling = (rk_sampler_kind)kind;
            test_picture picture = render_white_room(&options);
            int cut = 0;
            for (size_t y = 0; y < options.height; y++)
                for (size_t x = 0; x < options.width; x++) {
                    cut += fraction_at(&options, x, y) < 0.99;
                    /* Sums of 64 weights round 64 times. */
                    rk_check(
                        fabs(red_at(&picture, x, y) - 1) <= 64 * 0x1p-24,
                        "pixel (%zu, %zu), %u samples by sampler %d: got %.6f, want 1, although "
                        "part of the disk is below the floor",
                        x, y, samples[i], kind, red_at(&picture, x, y));
                }
            rk_check(cut > 100, "the floor intersects only %d disks", cut);
            rk_image_free(&picture.image);
        }
}

/* --- How many rays ---------------------------------------------------------------------------- */

static void only_the_first_mirror_splits_a_path(void **state)
{
    (void)state;
    /* Two mirrors that face each other. */
    rk_scene scene = test_scene_of(4, 1);
    for (uint32_t i = 0; i < 2; i++)
        test_scene_quad(&scene, 2 * i, rk_vec(-999, -999, i ? -6 : 1), rk_vec(1998, 0, 0),
                        rk_vec(0, 1998, 0));
    scene.mesh.materials[0].kd = scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    rk_render_options options = small();
    options.glossy.radius = 0.05f; /* no ray is so slanting that a mirror intersects its disk */
    for (options.max_depth = 0; options.max_depth <= 6; options.max_depth++) {
        test_picture picture = test_render(&scene, options, 2);
        uint64_t want = 14ull * 11 * 64 * options.max_depth;
        rk_check_equal(picture.counters.reflected_rays, want,
                       "64 rays at the first mirror, and one of each at all others");
        rk_check_equal(picture.counters.glossy_samples, want, "as many samples are drawn");
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++)
                /* 0.5 of itself and 0.5 of the reflection; sums of 64 weights round 64 times. */
                rk_check_close(red_at(&picture, x, y), 1 - pow(0.5, options.max_depth + 1),
                               64 * 0x1p-24, "a ray that is not spread has the weight of all");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_mirror_behind_glass_splits_a_path_too(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(6, 3);
    test_scene_wall(&scene, 0, 1, 0);
    test_scene_wall(&scene, 2, 0, 1);
    test_scene_quad(&scene, 4, rk_vec(-99, -99, -6), rk_vec(198, 0, 0), rk_vec(0, 198, 0));
    scene.mesh.triangle_materials[4] = scene.mesh.triangle_materials[5] = 2;
    make_mirror(&scene.mesh.materials[0]);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].alpha = 0.5f;
    scene.mesh.materials[2].kd = rk_vec(1, 1, 1);
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    rk_render_options options = small();
    options.transparency = true;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.glossy_samples, 14 * 11 * 64, "at the mirror behind the glass");
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++)
            rk_check_close(red_at(&picture, x, y), 0.25, 64 * 0x1p-24,
                           "the glass absorbs half on the way there, and half on the way back");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- Rays that are traced together ---------------------------------------------------------- */

static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return rk_unit_float(rk_hash(a, b, c, 17));
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(2 * noise(a, b, 0) - 1, 2 * noise(a, b, 1) - 1, 2 * noise(a, b, 2) - 1);
}

/* A few groups of all widths, from 2 rays to 64. */
static rk_ray_batch make_ray_groups(uint32_t key)
{
    rk_ray_batch rays = {.count = 0};
    for (uint32_t k = 0; rays.count + 64 <= RK_BATCH_MAX; k++) {
        uint32_t size = 2 + (uint32_t)(63 * noise(key, k, 3));
        rk_vec3 origin = rk_scale(noise3(key, k), 0.9f), w = rk_normalize(noise3(key, k + 100));
        float radius = 2 * powf(noise(key, k, 4), 4);
        if (k % 4 == 3) /* around an axis, on which directions change their sign */
            w = rk_vec(0, 0, k % 8 == 3 ? 1 : -1);
        for (uint32_t i = 0; i < size; i++) {
            rk_vec3 aside = rk_scale(noise3(key + 1000, 100 * k + i), radius);
            rk_ray ray = {origin, rk_normalize(rk_add(w, aside)), INFINITY};
            rk_batch_push(&rays, &ray);
        }
    }
    return rays;
}

static void rays_of_a_mirror_find_what_single_rays_find(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "cornell-glass", "sphere:1280", "spheres",
                                 "statue:2000"};
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        rk_scene scene = test_scene_builtin(names[n]);
        rk_accel binary, accel;
        rk_error error;
        rk_check_ok(rk_accel_build(&binary, RK_ACCEL_SAH_3, &scene, &error) &&
                        rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, &error),
                    error);
        uint32_t hit_count = 0;
        rk_counters unused = {0};
        for (uint32_t key = 0; key < 400; key++) {
            rk_ray_batch rays = make_ray_groups(key);
            rk_hit_batch want, got;
            rk_accel_closest(&binary, &rays, &want, &unused);
            rk_accel_closest(&accel, &rays, &got, &unused);
            for (uint32_t i = 0; i < rays.count; i++) {
                hit_count += want.triangle[i] != RK_MISS;
                rk_check(got.triangle[i] == want.triangle[i] && got.t[i] == want.t[i] &&
                             (want.triangle[i] == RK_MISS ||
                              (got.u[i] == want.u[i] && got.v[i] == want.v[i])),
                         "%s, batch %u, ray %u: hit triangle %d at %.9g, want %d at %.9g", names[n],
                         key, i, (int)got.triangle[i], (double)got.t[i], (int)want.triangle[i],
                         (double)want.t[i]);
            }
        }
        rk_check(hit_count > 5000, "%s: only %u rays have a hit", names[n], hit_count);
        rk_accel_free(&binary);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static void trace_one_by_one(const rk_accel *accel, const rk_ray_batch *rays, rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_ray_batch alone;
        rk_hit_batch hit;
        alone.count = 0;
        rk_batch_push(&alone, &ray);
        rk_accel_closest(accel, &alone, &hit, counters);
    }
}

/* Four points of a mirror, 64 reflections each, within a disk of radius 0.1. */
static rk_ray_batch make_reflections(uint32_t key)
{
    rk_ray_batch rays = {.count = 0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rk_vec3 origin = rk_scale(noise3(key, i / 64), 0.9f);
        rk_vec3 w = rk_normalize(noise3(key, 100 + i / 64));
        rk_vec3 aside = rk_scale(noise3(key + 1000, i), 0.1f);
        rk_ray ray = {origin, rk_normalize(rk_add(w, aside)), INFINITY};
        rk_batch_push(&rays, &ray);
    }
    return rays;
}

static void rays_of_a_mirror_share_their_work(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_accel accel;
    rk_error error;
    rk_counters single = {0}, together = {0};
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, &error), error);
    for (uint32_t key = 0; key < 400; key++) {
        rk_ray_batch rays = make_reflections(key);
        rk_hit_batch hits;
        trace_one_by_one(&accel, &rays, &single);
        rk_accel_closest(&accel, &rays, &hits, &together);
    }
    const uint64_t apart = single.box_tests + single.triangle_tests;
    const uint64_t joint = together.box_tests + together.triangle_tests;
    rk_check(joint < apart / 2, "%llu tests together, %llu by single rays: no work is saved",
             (unsigned long long)joint, (unsigned long long)apart);
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

/* --- Without rough mirrors -------------------------------------------------------------------- */

static void check_same_as_perfect(const rk_scene *scene, rk_render_options options,
                                  const char *hint)
{
    test_picture rough = test_render(scene, options, 2);
    options.glossy.samples = 0;
    test_picture perfect = test_render(scene, options, 2);
    rk_check_equal(rough.counters.glossy_samples, 0, hint);
    rk_check_equal(rough.counters.reflected_rays, perfect.counters.reflected_rays, hint);
    rk_check(test_same_pixels(&rough.image, &perfect.image), "not the same to the bit: %s", hint);
    rk_image_free(&rough.image);
    rk_image_free(&perfect.image);
}

static void radius_0_is_a_perfect_mirror(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.width = options.height = 64;
    options.shadows = true;
    options.shading.model = RK_SHADING_LAMBERT;
    options.glossy.radius = 0;
    check_same_as_perfect(&scene, options, "a disk of radius 0 is a point");
    options.glossy.radius = NAN;
    for (uint32_t i = 0; i < scene.mesh.material_count; i++)
        scene.mesh.materials[i].shininess = INFINITY;
    check_same_as_perfect(&scene, options, "0.5 over an infinite shininess is 0");
    rk_scene_free(&scene);
}

static void a_tiny_radius_is_nearly_a_perfect_mirror(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("sphere:80");
    scene.mesh.materials[0].ks = rk_vec(1, 1, 1);
    rk_render_options options = small();
    options.width = options.height = 64;
    options.glossy.radius = 1e-6f;
    test_picture rough = test_render(&scene, options, 2);
    options.glossy.samples = 0;
    test_picture perfect = test_render(&scene, options, 2);
    rk_check(rough.counters.glossy_samples > 10000, "the mirror is not in the picture");
    for (size_t i = 0; i < 64 * 64; i++)
        rk_check_close(rough.image.pixels[i].x, perfect.image.pixels[i].x, 64 * 0x1p-24,
                       "all directions are nearly one");
    rk_image_free(&rough.image);
    rk_image_free(&perfect.image);
    rk_scene_free(&scene);
}

static void without_rough_mirrors_no_sample_is_drawn(void **state)
{
    (void)state;
    rk_scene scene = make_half();
    rk_render_options options = small();
    rk_check(rk_plan_of(&scene, &options).glossy_reflection, "here it is needed");
    options.reflections = false;
    rk_check(!rk_plan_of(&scene, &options).glossy_reflection, "mirrors are off");
    check_same_as_perfect(&scene, options, "mirrors are off");
    options = small();
    options.max_depth = 0;
    check_same_as_perfect(&scene, options, "nothing is reflected");
    options = small();
    scene.mesh.materials[0].ks = rk_vec(0, 0, 0);
    rk_check(!rk_plan_of(&scene, &options).glossy_reflection, "there is no mirror");
    check_same_as_perfect(&scene, options, "there is no mirror");
    rk_scene_free(&scene);
}

static void threads_do_not_change_the_picture(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.width = 70;
    options.height = 50;
    options.shadows = true;
    options.shading.model = RK_SHADING_LAMBERT;
    test_picture one = test_render(&scene, options, 1);
    for (uint32_t threads = 2; threads <= 4; threads++) {
        test_picture more = test_render(&scene, options, threads);
        rk_check(test_same_pixels(&one.image, &more.image), "%u threads: another picture", threads);
        rk_check_equal(one.counters.glossy_samples, more.counters.glossy_samples, "samples");
        rk_check_equal(one.counters.triangle_tests, more.counters.triangle_tests, "tests");
        rk_image_free(&more.image);
    }
    rk_image_free(&one.image);
    rk_scene_free(&scene);
}

static void another_seed_is_other_noise(void **state)
{
    (void)state;
    rk_scene scene = make_half();
    rk_render_options options = small();
    test_picture a = test_render(&scene, options, 1);
    options.seed = 1;
    test_picture b = test_render(&scene, options, 1);
    rk_check(!test_same_pixels(&a.image, &b.image), "the seed is not used");
    rk_image_free(&a.image);
    rk_image_free(&b.image);
    rk_scene_free(&scene);
}

static void more_samples_than_a_sampler_has_are_an_error(void **state)
{
    (void)state;
    rk_scene scene = make_half();
    rk_render_options options = small();
    rk_accel accel;
    rk_image image;
    rk_counters counters;
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(1, &error);
    rk_check_ok(pool != NULL, error);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    rk_check_ok(rk_image_init(&image, options.width, options.height, &error), error);
    options.samples = 65536;
    options.glossy.samples = 16384;
    rk_check(!rk_render(&image, &scene, &accel, &options, pool, &counters, NULL, &error),
             "2^30 samples per pixel: more than a sampler has");
    rk_check_error_names(error, "16777216");
    rk_image_free(&image);
    rk_accel_free(&accel);
    rk_pool_stop(pool);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_mean_is_the_integral_over_the_disk),
    cmocka_unit_test(pixel_samples_and_glossy_samples_multiply),
    cmocka_unit_test(classic_weights_darken_grazing_mirrors),
    cmocka_unit_test(renormalized_weights_keep_a_white_room_white),
    cmocka_unit_test(only_the_first_mirror_splits_a_path),
    cmocka_unit_test(a_mirror_behind_glass_splits_a_path_too),
    cmocka_unit_test(rays_of_a_mirror_find_what_single_rays_find),
    cmocka_unit_test(rays_of_a_mirror_share_their_work),
    cmocka_unit_test(radius_0_is_a_perfect_mirror),
    cmocka_unit_test(a_tiny_radius_is_nearly_a_perfect_mirror),
    cmocka_unit_test(without_rough_mirrors_no_sample_is_drawn),
    cmocka_unit_test(threads_do_not_change_the_picture),
    cmocka_unit_test(another_seed_is_other_noise),
    cmocka_unit_test(more_samples_than_a_sampler_has_are_an_error),
};

RK_SUITE("glossy_reflection_stage", tests)
