/* Bloom over whole pictures: against the full filter in double, equal for any number of threads, no
 * work where there is no light, and the errors of the cheaper methods. */
#include "test_scene.h"

#include "base/random.h"
#include "post/bloom_stage.h"
#include "post/blur.h"

/* --- Pictures --------------------------------------------------------------------------------- */

static rk_image make(size_t width, size_t height)
{
    rk_image image;
    rk_error error = {""};
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    return image;
}

static rk_image copy_of(const rk_image *image)
{
    rk_image copy = make(image->width, image->height);
    memcpy(copy.pixels, image->pixels, image->width * image->height * sizeof *copy.pixels);
    return copy;
}

/* Noise of up to `most`; about the given fraction of its rows is black. */
static rk_image noise(size_t width, size_t height, float most, float black)
{
    rk_image image = make(width, height);
    for (uint32_t i = 0; i < width * height; i++)
        if (rk_unit_float(rk_hash(i / (uint32_t)width, 0, 0, 1)) >= black)
            image.pixels[i] = rk_scale(rk_vec(rk_unit_float(rk_hash(i, 0, 0, 2)),
                                              rk_unit_float(rk_hash(i, 1, 0, 2)),
                                              rk_unit_float(rk_hash(i, 2, 0, 2))),
                                       most);
    return image;
}

static rk_bloom_options options_of(uint32_t radius, rk_bloom_border border, rk_bloom_method method)
{
    rk_bloom_options options = rk_bloom_options_default();
    options.on = true;
    options.radius = radius;
    options.border = border;
    options.method = method;
    return options;
}

static rk_counters apply_bloom(rk_image *image, const rk_bloom_options *options, uint32_t threads)
{
    rk_counters counters = {0};
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(threads, &error);
    rk_check_ok(pool != NULL, error);
    rk_check_ok(rk_bloom_stage(image, options, pool, &counters, &error), error);
    rk_pool_stop(pool);
    return counters;
}

/* --- Against the full filter ------------------------------------------------------------------ */

/* C(2r, r + k) / 4^r by halves of neighbours' sums. */
static void weights_in_double(int radius, double *weights)
{
    double row[130] = {1};
    for (int n = 1; n <= 2 * radius; n++)
        for (int k = n; k >= 0; k--)
            row[k] = (row[k] + (k ? row[k - 1] : 0)) / 2;
    for (int k = 0; k <= radius; k++)
        weights[k] = row[radius + k];
}

static double full_filter(const rk_image *image, int x, int y, const rk_bloom_options *options)
{
    int radius = (int)options->radius, width = (int)image->width, height = (int)image->height;
    double weights[65], sum = 0, weight_inside = 0;
    weights_in_double(radius, weights);
    for (int j = y - radius; j <= y + radius; j++)
        for (int i = x - radius; i <= x + radius; i++) {
            int ci = i < 0 ? 0 : i < width ? i : width - 1;
            int cj = j < 0 ? 0 : j < height ? j : height - 1;
            if ((ci != i || cj != j) && options->border != RK_BLOOM_CLAMP)
                continue;
            rk_vec3 pixel = *rk_image_at(image, (size_t)ci, (size_t)cj);
            double weight = weights[abs(i - x)] * weights[abs(j - y)];
            weight_inside += weight;
            sum += rk_bloom_is_bright(pixel, options->threshold) ? weight * (double)pixel.y : 0;
        }
    return options->border == RK_BLOOM_RENORMALIZE ? sum / weight_inside : sum;
}

/* For pixels of up to 1: two passes of up to 2r + 1 terms, rounded at each product and each sum,
 * and the taps beyond the reach. */
static double tolerance_of(uint32_t radius)
{
    return 4 * (2 * radius + 4) * 0x1p-24;
}

static void check_against_full_filter(const rk_image *before, const rk_bloom_options *options)
{
    rk_image after = copy_of(before);
    apply_bloom(&after, options, 2);
    for (size_t y = 0; y < before->height; y++)
        for (size_t x = 0; x < before->width; x += 1 + before->width / 9) {
            double want = (double)rk_image_at(before, x, y)->y +
                          (double)options->intensity * full_filter(before, (int)x, (int)y, options);
            double got = (double)rk_image_at(&after, x, y)->y;
            rk_check(fabs(got - want) <= tolerance_of(options->radius),
                     "%zu x %zu, radius %u, border %d, pixel (%zu, %zu): got %.9g, want %.9g",
                     before->width, before->height, options->radius, options->border, x, y, got,
                     want);
        }
    rk_image_free(&after);
}

static void bloom_equals_the_full_filter(void **state)
{
    (void)state;
    const size_t sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {16, 16}, {17, 5}, {61, 47}};
    const uint32_t radii[] = {0, 1, 15, 50};
    for (size_t s = 0; s < 6; s++)
        for (size_t r = 0; r < 4; r++)
            for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
                rk_image image = noise(sizes[s][0], sizes[s][1], 1, 0.5f);
                rk_bloom_options options =
                    options_of(radii[r], (rk_bloom_border)border, RK_BLOOM_EXACT);
                check_against_full_filter(&image, &options);
                rk_image_free(&image);
            }
}

static void light_in_a_corner_obeys_the_border_mode(void **state)
{
    (void)state;
    for (int corner = 0; corner < 4; corner++)
        for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
            rk_image image = make(50, 33);
            *rk_image_at(&image, corner & 1 ? 49 : 0, corner & 2 ? 32 : 0) = rk_vec(1, 1, 1);
            rk_bloom_options options = options_of(6, (rk_bloom_border)border, RK_BLOOM_EXACT);
            check_against_full_filter(&image, &options);
            rk_image_free(&image);
        }
}

static void any_number_of_threads_makes_the_same_picture(void **state)
{
    (void)state;
    for (int method = RK_BLOOM_EXACT; method <= RK_BLOOM_PYRAMID; method++) {
        rk_image before = noise(150, 90, 1, 0.3f), one = copy_of(&before);
        rk_bloom_options options = options_of(20, RK_BLOOM_RENORMALIZE, (rk_bloom_method)method);
        rk_counters want = apply_bloom(&one, &options, 1);
        for (uint32_t threads = 2; threads <= 5; threads++) {
            rk_image many = copy_of(&before);
            rk_counters got = apply_bloom(&many, &options, threads);
            rk_check(test_same_pixels(&one, &many), "method %d, %u threads", method, threads);
            rk_check(memcmp(&got, &want, sizeof got) == 0, "method %d, %u threads: other counters",
                     method, threads);
            rk_image_free(&many);
        }
        rk_image_free(&one);
        rk_image_free(&before);
    }
}

/* --- No light, no work ------------------------------------------------------------------------ */

static void without_bright_pixels_each_pixel_is_read_once(void **state)
{
    (void)state;
    rk_image before = noise(100, 70, 0.4f, 0), after = copy_of(&before);
    rk_bloom_options options = options_of(15, RK_BLOOM_CLAMP, RK_BLOOM_EXACT);
    rk_counters counters = apply_bloom(&after, &options, 2);
    rk_check(test_same_pixels(&before, &after), "the picture is untouched");
    rk_check_equal(counters.bloom_pixels_read, 100 * 70, "each is read once");
    rk_check_equal(counters.bloom_taps, 0, "nothing is filtered");
    rk_image_free(&before);
    rk_image_free(&after);
}

static void bloom_that_is_off_does_nothing(void **state)
{
    (void)state;
    rk_image before = noise(40, 30, 1, 0), after = copy_of(&before);
    rk_bloom_options off = options_of(15, RK_BLOOM_ZERO, RK_BLOOM_EXACT), faint = off;
    off.on = false;
    faint.intensity = 0;
    rk_counters first = apply_bloom(&after, &off, 1), second = apply_bloom(&after, &faint, 1);
    rk_check(test_same_pixels(&before, &after), "the picture is untouched");
    rk_check_equal(first.bloom_pixels_read + first.bloom_taps, 0, "off");
    rk_check_equal(second.bloom_pixels_read + second.bloom_taps, 0, "an intensity of 0");
    rk_image_free(&before);
    rk_image_free(&after);
}

static uint64_t taps_for_rows(size_t first, size_t second)
{
    rk_image image = make(600, 600);
    *rk_image_at(&image, 300, first) = *rk_image_at(&image, 300, second) = rk_vec(1, 1, 1);
    rk_bloom_options options = options_of(15, RK_BLOOM_ZERO, RK_BLOOM_EXACT);
    rk_counters counters = apply_bloom(&image, &options, 2);
    rk_image_free(&image);
    return counters.bloom_taps;
}

static void a_point_of_light_costs_only_its_neighbourhood(void **state)
{
    (void)state;
    /* The light reaches 29 pixels of its row, which fit into two blocks of 16 pixels, of 29 taps
     * each. Their columns have one tap for each pixel of 29 rows. */
    uint64_t taps = taps_for_rows(300, 300);
    rk_check(taps <= 2 * 29 * 32, "%llu taps for one pixel among 360000", (unsigned long long)taps);
    rk_check(taps >= 29 * 29, "%llu taps are too few for a filter of 29 x 29",
             (unsigned long long)taps);
}

static void dark_rows_between_bright_ones_cost_nothing(void **state)
{
    (void)state;
    rk_check_equal(taps_for_rows(100, 500), 2 * taps_for_rows(300, 300), "twice the taps of one");
}

static double taps_per_pixel(uint32_t radius)
{
    rk_image image = make(320, 320);
    for (size_t i = 0; i < 320 * 320; i++)
        image.pixels[i] = rk_vec(1, 1, 1);
    rk_bloom_options options = options_of(radius, RK_BLOOM_CLAMP, RK_BLOOM_EXACT);
    rk_counters counters = apply_bloom(&image, &options, 2);
    rk_image_free(&image);
    return (double)counters.bloom_taps / (320 * 320);
}

static void taps_grow_with_the_square_root_of_the_radius(void **state)
{
    (void)state;
    double few = taps_per_pixel(10), many = taps_per_pixel(1000);
    rk_check(many <= 2 * 2 * 130, "radius 1000: %g taps per pixel, of 2 x 2001", many);
    rk_check(many <= 14 * few, "100 times the radius: %g times the taps", many / few);
}

static void pixels_that_are_not_finite_do_not_spread(void **state)
{
    (void)state;
    for (int method = RK_BLOOM_EXACT; method <= RK_BLOOM_PYRAMID; method++) {
        rk_image image = make(30, 30);
        *rk_image_at(&image, 10, 10) = rk_vec(NAN, 1, 1);
        *rk_image_at(&image, 20, 20) = rk_vec(INFINITY, INFINITY, INFINITY);
        *rk_image_at(&image, 15, 15) = rk_vec(1, 1, 1);
        /* Finite, but a sum of two may be infinite. */
        for (size_t x = 22; x < 28; x++)
            *rk_image_at(&image, x, 5) = rk_scale(rk_vec(1, 1, 1), x < 25 ? 8e37f : 3e38f);
        rk_bloom_options options = options_of(
            5, method == RK_BLOOM_EXACT ? RK_BLOOM_CLAMP : RK_BLOOM_ZERO, (rk_bloom_method)method);
        apply_bloom(&image, &options, 1);
        size_t odd = 0;
        for (size_t i = 0; i < 900; i++)
            odd += isfinite(image.pixels[i].x) ? 0 : 1;
        rk_check(odd == 2, "method %d: %zu pixels are not finite, want the 2 that were not", method,
                 odd);
        rk_image_free(&image);
    }
}

/* --- Cheaper methods -------------------------------------------------------------------------- */

/* A bright disk and a bright frame on black. */
static rk_image lamps(void)
{
    rk_image image = make(300, 260);
    for (size_t y = 0; y < 260; y++)
        for (size_t x = 0; x < 300; x++) {
            double across = (double)x - 150, down = (double)y - 120;
            bool bright = across * across + down * down < 900 || x < 20 || y >= 250;
            *rk_image_at(&image, x, y) = bright ? rk_vec(1, 1, 1) : rk_vec(0, 0, 0);
        }
    return image;
}

static double largest_difference(const rk_image *a, const rk_image *b)
{
    double largest = 0;
    for (size_t i = 0; i < a->width * a->height; i++)
        largest = fmax(largest, fabs((double)a->pixels[i].y - (double)b->pixels[i].y));
    return largest;
}

static void cheaper_methods_are_close_to_the_filter(void **state)
{
    (void)state;
    /* Measured errors, rounded up, relative to the lamps' brightness; Young and van Vliet's
     * recursion is the least accurate. */
    const double most[] = {0, 0.004, 0.035, 0.012};
    const uint32_t radii[] = {15, 100, 400};
    for (size_t r = 0; r < 3; r++)
        for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
            rk_image exact = lamps();
            rk_bloom_options options =
                options_of(radii[r], (rk_bloom_border)border, RK_BLOOM_EXACT);
            apply_bloom(&exact, &options, 2);
            for (int method = RK_BLOOM_GAUSSIAN; method <= RK_BLOOM_PYRAMID; method++) {
                rk_image near = lamps();
                options.method = (rk_bloom_method)method;
                apply_bloom(&near, &options, 2);
                double off = largest_difference(&exact, &near);
                rk_check(off <= most[method], "radius %u, border %d, method %d: off by %g",
                         radii[r], border, method, off);
                rk_check(off > 0, "method %d is the exact filter", method);
                rk_image_free(&near);
            }
            rk_image_free(&exact);
        }
}

static void a_gaussians_weights_sum_to_one(void **state)
{
    (void)state;
    for (uint32_t radius = 0; radius <= 1000; radius += 1 + radius / 3) {
        float weights[1001 + RK_BLUR_GAUSSIAN_MORE];
        uint32_t reach = rk_blur_gaussian(0.5 * radius, weights);
        rk_check(reach <= radius + RK_BLUR_GAUSSIAN_MORE, "radius %u: a reach of %u", radius,
                 reach);
        double sum = (double)weights[0];
        for (uint32_t k = 1; k <= reach; k++)
            sum += 2 * (double)weights[k];
        rk_check_close(sum, 1, 0x1p-24, "each weight is rounded");
    }
}

static void every_method_handles_small_radii(void **state)
{
    (void)state;
    for (uint32_t radius = 0; radius <= 3; radius++)
        for (int method = RK_BLOOM_GAUSSIAN; method <= RK_BLOOM_PYRAMID; method++) {
            rk_image exact = lamps(), near = lamps();
            rk_bloom_options options = options_of(radius, RK_BLOOM_CLAMP, RK_BLOOM_EXACT);
            apply_bloom(&exact, &options, 1);
            options.method = (rk_bloom_method)method;
            apply_bloom(&near, &options, 1);
            double off = largest_difference(&exact, &near);
            rk_check(off <= (radius ? 0.1 : 1e-6), "radius %u, method %d: off by %g", radius,
                     method, off);
            rk_image_free(&exact);
            rk_image_free(&near);
        }
}

/* --- Options and the renderer ----------------------------------------------------------------- */

static void options_out_of_range_are_refused(void **state)
{
    (void)state;
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(1, &error);
    rk_image image = noise(8, 8, 1, 0), before = copy_of(&image);
    rk_counters counters = {0};
    rk_bloom_options options = options_of(RK_BLOOM_RADIUS_MAX + 1, RK_BLOOM_ZERO, RK_BLOOM_EXACT);
    rk_check(!rk_bloom_stage(&image, &options, pool, &counters, &error), "a radius of 4097");
    rk_check_error_names(error, "4096");
    options = options_of(3, RK_BLOOM_ZERO, RK_BLOOM_EXACT);
    options.threshold = NAN;
    rk_check(!rk_bloom_stage(&image, &options, pool, &counters, &error), "a threshold of NaN");
    rk_check_error_names(error, "threshold");
    const float wrong[] = {-1, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        options = options_of(3, RK_BLOOM_ZERO, RK_BLOOM_EXACT);
        options.intensity = wrong[i];
        rk_check(!rk_bloom_stage(&image, &options, pool, &counters, &error), "an intensity of %g",
                 (double)wrong[i]);
        rk_check_error_names(error, "intensity");
    }
    rk_check(test_same_pixels(&image, &before), "an error leaves the picture as it was");
    rk_pool_stop(pool);
    rk_image_free(&image);
    rk_image_free(&before);
}

static void the_renderer_adds_bloom_to_its_picture(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = rk_render_options_default();
    options.width = 80;
    options.height = 60;
    test_picture plain = test_render(&scene, options, 2);
    rk_check_equal(plain.counters.bloom_pixels_read + plain.counters.bloom_taps, 0,
                   "without bloom no pixel is read again");
    options.bloom.on = true;
    test_picture bloomed = test_render(&scene, options, 2);
    rk_check(bloomed.counters.bloom_taps > 0, "the box has bright walls");
    rk_check_equal(bloomed.counters.primary_rays, plain.counters.primary_rays, "rays stay counted");
    rk_counters counters = apply_bloom(&plain.image, &options.bloom, 1);
    rk_check(test_same_pixels(&plain.image, &bloomed.image), "the picture, and then its bloom");
    rk_check_equal(counters.bloom_taps, bloomed.counters.bloom_taps, "the same work");
    scene.light_count = 0;
    test_picture dark = test_render(&scene, options, 1);
    rk_check_equal(dark.counters.bloom_pixels_read, 0, "a scene without light has no bloom");
    rk_image_free(&plain.image);
    rk_image_free(&bloomed.image);
    rk_image_free(&dark.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(bloom_equals_the_full_filter),
    cmocka_unit_test(light_in_a_corner_obeys_the_border_mode),
    cmocka_unit_test(any_number_of_threads_makes_the_same_picture),
    cmocka_unit_test(without_bright_pixels_each_pixel_is_read_once),
    cmocka_unit_test(bloom_that_is_off_does_nothing),
    cmocka_unit_test(a_point_of_light_costs_only_its_neighbourhood),
    cmocka_unit_test(dark_rows_between_bright_ones_cost_nothing),
    cmocka_unit_test(taps_grow_with_the_square_root_of_the_radius),
    cmocka_unit_test(pixels_that_are_not_finite_do_not_spread),
    cmocka_unit_test(cheaper_methods_are_close_to_the_filter),
    cmocka_unit_test(a_gaussians_weights_sum_to_one),
    cmocka_unit_test(every_method_handles_small_radii),
    cmocka_unit_test(options_out_of_range_are_refused),
    cmocka_unit_test(the_renderer_adds_bloom_to_its_picture),
};

RK_SUITE("bloom_stage", tests)
