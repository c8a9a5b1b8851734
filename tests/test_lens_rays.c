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

/* The pixels are scattered over the picture. */
static void choose_pixels(const rk_rendering *r, uint32_t count, rk_lens_pixels *pixels)
{
    pixels->count = 0;
    for (uint32_t i = 0; i < count; i++)
        rk_lens_pixels_add(pixels, r->options, i, rk_hash(i, count, 0, 2) % width,
                           rk_hash(i, count, 1, 2) % height);
}

static void check_rays(const rk_rendering *r, const rk_lens_pixels *pixels,
                       const rk_lens_group *group, uint32_t round)
{
    rk_ray_batch rays;
    rk_lens_rays(r, pixels, group, round, &rays);
    rk_check_equal(rays.count, pixels->count, "each pixel has a ray");
    for (uint32_t i = 0; i < pixels->count; i++) {
        const uint32_t x = (uint32_t)pixels->x[i], y = (uint32_t)pixels->y[i];
        const uint32_t sample = group->first + group->order[round][i];
        const rk_ray four = rk_batch_ray(&rays, i);
        const rk_ray one = rk_lens_ray_of_pixel(r, x, y, sample, samples);
        rk_check_equal(pixels->pixel[i], i, "pixels keep their order");
        rk_check(memcmp(&four, &one, sizeof one) == 0,
                 "sample %u of pixel (%u, %u), ray %u of %u, differs from rk_lens_ray's", sample, x,
                 y, i, pixels->count);
    }
}

/* The samples' own order, and the one by places on the lens. */
static void check_group(const rk_rendering *r, uint32_t pixel_count, uint32_t first, uint32_t count)
{
    rk_lens_pixels pixels;
    rk_lens_group group;
    choose_pixels(r, pixel_count, &pixels);
    rk_lens_group_start(&group, &pixels, first, count);
    for (uint32_t round = 0; round < count; round++)
        for (uint32_t i = 0; i < pixel_count; i++)
            rk_check_equal(group.order[round][i], round, "samples start in their own order");
    check_rays(r, &pixels, &group, count - 1);
    rk_lens_group_sort(&group, &pixels);
    for (uint32_t round = 0; round < count; round++)
        check_rays(r, &pixels, &group, round);
}

static void the_rays_are_the_features_to_the_bit(void **state)
{
    (void)state;
    for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
        const rk_render_options options = options_of((rk_focal_surface)focal);
        const rk_rendering r = rendering_of(&options);
        for (uint32_t count = 1; count <= RK_LENS_GROUP_MAX; count++)
            check_group(&r, RK_BATCH_MAX - count, 3 * count, count);
        for (uint32_t pixels = 0; pixels < 8; pixels++)
            check_group(&r, pixels, pixels, 5);
        rk_check(rk_lens_rays_agree(&r, samples), "equal rays are not taken for equal");
    }
}

static void every_pixel_takes_every_sample_once(void **state)
{
    (void)state;
    const rk_render_options options = options_of(RK_FOCAL_PLANE);
    const rk_rendering r = rendering_of(&options);
    for (uint32_t count = 1; count <= RK_LENS_GROUP_MAX; count++) {
        rk_lens_pixels pixels;
        rk_lens_group group;
        choose_pixels(&r, RK_BATCH_MAX, &pixels);
        rk_lens_group_start(&group, &pixels, 0, count);
        rk_lens_group_sort(&group, &pixels);
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            uint64_t taken = 0;
            for (uint32_t round = 0; round < count; round++)
                taken |= UINT64_C(1) << group.order[round][i];
            rk_check_equal(taken, (UINT64_C(1) << count) - 1, "a sample is left out");
        }
    }
}

/* The mean squared distance of neighbours' places on the lens, in its diameters; 1/4 at random. */
static double spread_of(const rk_rendering *r, const rk_lens_pixels *pixels,
                        const rk_lens_group *group)
{
    double sum = 0;
    for (uint32_t round = 0; round < group->count; round++) {
        rk_ray_batch rays;
        rk_lens_rays(r, pixels, group, round, &rays);
        for (uint32_t i = 1; i < pixels->count; i++) {
            const rk_ray a = rk_batch_ray(&rays, i - 1), b = rk_batch_ray(&rays, i);
            const rk_vec3 apart =
                rk_scale(rk_sub(a.origin, b.origin), 1000 / r->options->lens.aperture);
            sum += (double)rk_dot(apart, apart);
        }
    }
    return sum / group->count / (pixels->count - 1);
}

static void what_pixels_take_next_starts_at_nearby_places(void **state)
{
    (void)state;
    const rk_render_options options = options_of(RK_FOCAL_PLANE);
    const rk_rendering r = rendering_of(&options);
    rk_lens_pixels pixels;
    rk_lens_group group;
    choose_pixels(&r, RK_BATCH_MAX, &pixels);
    rk_lens_group_start(&group, &pixels, 0, samples);
    /* Points uniform over a disk of diameter 1 are sqrt(1/4) apart in root mean square. */
    rk_check_close(spread_of(&r, &pixels, &group), 0.25, 0.02, "in their own order they are apart");
    rk_lens_group_sort(&group, &pixels);
    /* Cells of a fifth of the lens: neighbours are at most a cell or two apart. */
    const double near = spread_of(&r, &pixels, &group);
    rk_check(near < 0.25 / 4, "the mean squared distance is %.3g, a quarter at random", near);
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
    cmocka_unit_test(every_pixel_takes_every_sample_once),
    cmocka_unit_test(what_pixels_take_next_starts_at_nearby_places),
    cmocka_unit_test(numbers_of_another_kind_are_not_taken_for_equal),
};

RK_SUITE("lens_rays", tests)
