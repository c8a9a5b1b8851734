/* Lens rays made four at a time are those of the features to the bit, for any number of them; where
 * they are not, the features' are taken. */
#include "test.h"

#include "base/random.h"
#include "features/glossy_reflection.h"
#include "render/disk_run.h"
#include "render/lens_rays.h"

#include <string.h>

enum { width = 300, height = 200, samples = 25 };

static float number(uint32_t i, uint32_t axis)
{
    return rk_unit_float(rk_hash(i, axis, 0, 1));
}

static rk_render_options options_of(rk_focal_surface focal)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    options.seed = 5;
    options.lens_samples = samples;
    options.lens = (rk_lens){1.3f, 70, focal};
    return options;
}

static rk_rendering rendering_of(const rk_render_options *options)
{
    const rk_camera camera = rk_camera_default();
    return (rk_rendering){.options = options, .view = rk_view_of(&camera, width, height)};
}

static void check_disk(uint32_t count, const float *x, const float *y)
{
    float run_x[RK_DISK_RUN_MAX], run_y[RK_DISK_RUN_MAX];
    memcpy(run_x, x, sizeof run_x);
    memcpy(run_y, y, sizeof run_y);
    rk_disk_run(count, run_x, run_y);
    for (uint32_t i = 0; i < count; i++) {
        const rk_vec2 at = rk_disk_at(RK_DISK_CONCENTRIC, (rk_vec2){x[i], y[i]});
        rk_check(memcmp(&at.x, &run_x[i], sizeof at.x) == 0 &&
                     memcmp(&at.y, &run_y[i], sizeof at.y) == 0,
                 "point %u of %u, for (%.9g, %.9g), is (%.9g, %.9g), not (%.9g, %.9g)", i, count,
                 (double)x[i], (double)y[i], (double)run_x[i], (double)run_y[i], (double)at.x,
                 (double)at.y);
    }
}

/* Quarters are the middle, axes, diagonals and corners of the square. */
static void a_run_of_points_on_the_disk_has_the_features_points(void **state)
{
    float x[RK_DISK_RUN_MAX], y[RK_DISK_RUN_MAX];
    (void)state;
    for (uint32_t round = 0; round < 200; round++) {
        for (uint32_t i = 0; i < RK_DISK_RUN_MAX; i++) {
            const bool in_quarters = round == 0;
            x[i] = in_quarters ? 0.25f * (float)(i % 4) : number(i, 2 * round);
            y[i] = in_quarters ? 0.25f * (float)(i / 4 % 4) : number(i, 2 * round + 1);
        }
        check_disk(round == 0 ? RK_DISK_RUN_MAX : 1 + round, x, y);
    }
}

/* The pixels of a run are scattered over the picture. */
static void check_rays(const rk_rendering *r, uint32_t count, uint32_t sample)
{
    uint32_t x[RK_BATCH_MAX], y[RK_BATCH_MAX];
    rk_lens_pixels pixels = {.count = 0};
    rk_ray_batch rays;
    for (uint32_t i = 0; i < count; i++) {
        x[i] = rk_hash(i, count, 0, 2) % width;
        y[i] = rk_hash(i, count, 1, 2) % height;
        rk_lens_pixels_add(&pixels, r->options, i, x[i], y[i]);
    }
    rk_lens_rays(r, &pixels, sample, &rays);
    rk_check_equal(rays.count, count, "each pixel has a ray");
    for (uint32_t i = 0; i < count; i++) {
        const rk_ray four = rk_batch_ray(&rays, i);
        const rk_ray one = rk_lens_ray_of_pixel(r, x[i], y[i], sample, samples);
        rk_check_equal(pixels.pixel[i], i, "pixels keep their order");
        rk_check(memcmp(&four, &one, sizeof one) == 0,
                 "sample %u of pixel (%u, %u), ray %u of %u, differs from rk_lens_ray's", sample,
                 x[i], y[i], i, count);
    }
}

static void the_rays_are_the_features_to_the_bit(void **state)
{
    (void)state;
    for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
        const rk_render_options options = options_of((rk_focal_surface)focal);
        const rk_rendering r = rendering_of(&options);
        for (uint32_t sample = 0; sample < samples; sample++)
            check_rays(&r, RK_BATCH_MAX - sample, sample);
        for (uint32_t count = 0; count < 8; count++)
            check_rays(&r, count, count);
        rk_check(rk_lens_rays_agree(&r, samples), "equal rays are not taken for equal");
    }
}

static void numbers_of_another_kind_are_not_taken_for_equal(void **state)
{
    (void)state;
    rk_render_options options = options_of(RK_FOCAL_PLANE);
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_ZSOBOL; kind++) {
        options.lens_sampling = (rk_sampler_kind)kind;
        const rk_rendering r = rendering_of(&options);
        rk_check(rk_lens_rays_agree(&r, samples) == (kind == RK_SAMPLER_SOBOL),
                 "of the kinds of numbers, four at a time are those of sobol, not of %s",
                 rk_sampler_name((rk_sampler_kind)kind));
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_run_of_points_on_the_disk_has_the_features_points),
    cmocka_unit_test(the_rays_are_the_features_to_the_bit),
    cmocka_unit_test(numbers_of_another_kind_are_not_taken_for_equal),
};

RK_SUITE("lens_rays", tests)
