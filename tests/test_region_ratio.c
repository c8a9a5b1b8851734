/* The ratio of two renderers' pictures: against figures worked out by hand, and against known
 * noise. */
#include "test.h"

#include "base/random.h"
#include "driver/region_ratio.h"

enum { width = 60, height = 50, count = width * height };

static rk_image make(float grey)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    for (size_t i = 0; i < count; i++)
        image.pixels[i] = rk_vec(grey, grey, grey);
    return image;
}

static rk_picture_pair make_pair(float first, float second)
{
    return (rk_picture_pair){make(first), make(second)};
}

static void free_pair(rk_picture_pair *pair)
{
    rk_image_free(&pair->first);
    rk_image_free(&pair->second);
}

static void the_ratio_is_that_of_the_means(void **state)
{
    (void)state;
    rk_picture_pair ours = make_pair(1, 2), theirs = make_pair(0.5f, 0.25f);
    const rk_region_ratio got = rk_region_ratio_of(&ours, &theirs, NULL, RK_REGION_ALL);
    rk_check_close(got.ratio, 4, 1e-12, "1.5 over 0.375, in double");
    rk_check_equal(got.pixels, count, "all pixels count");
    free_pair(&ours);
    free_pair(&theirs);
}

static void only_pixels_of_the_region_count(void **state)
{
    (void)state;
    rk_picture_pair ours = make_pair(1, 1), theirs = make_pair(1, 1);
    uint8_t regions[count] = {0};
    for (size_t i = 0; i < 7; i++) {
        regions[i * 11] = 3;
        ours.first.pixels[i * 11] = ours.second.pixels[i * 11] = rk_vec(3, 3, 3);
    }
    rk_region_ratio got = rk_region_ratio_of(&ours, &theirs, regions, 3);
    rk_check_equal(got.pixels, 7, "seven pixels are in region 3");
    rk_check_close(got.ratio, 3, 1e-12, "the region's own ratio");
    got = rk_region_ratio_of(&ours, &theirs, regions, 0);
    rk_check_close(got.ratio, 1, 1e-12, "the other pixels are equal");
    rk_check(isnan(rk_region_ratio_of(&ours, &theirs, regions, 9).ratio), "no pixels, no ratio");
    free_pair(&ours);
    free_pair(&theirs);
}

static void sums_weigh_bright_pixels_more(void **state)
{
    (void)state;
    rk_picture_pair ours = make_pair(0, 0), theirs = make_pair(0, 0);
    ours.first.pixels[0] = ours.second.pixels[0] = rk_vec(9, 0, 0);
    theirs.first.pixels[0] = theirs.second.pixels[0] = rk_vec(0, 0, 10);
    ours.first.pixels[1] = ours.second.pixels[1] = rk_vec(0, 2, 0);
    theirs.first.pixels[1] = theirs.second.pixels[1] = rk_vec(0, 1, 0);
    const rk_region_ratio got = rk_region_ratio_of(&ours, &theirs, NULL, RK_REGION_ALL);
    rk_check_close(got.ratio, 1, 1e-12, "11 over 11, not the mean of .9 and 2");
    free_pair(&ours);
    free_pair(&theirs);
}

/* A picture whose channels share their noise, as those of one ray do. */
static void add_noise(rk_image *image, float deviation, uint32_t seed)
{
    for (uint32_t i = 0; i < count; i++) {
        /* Uniform, of variance 1. */
        const float noise = sqrtf(12) * (rk_unit_float(rk_hash(i, seed, 0, 7)) - 0.5f);
        const float value = image->pixels[i].x + deviation * noise;
        image->pixels[i] = rk_vec(value, value, value);
    }
}

static void the_standard_error_is_that_of_repeated_ratios(void **state)
{
    (void)state;
    const uint32_t runs = 400;
    double squares = 0, claimed = 0;
    for (uint32_t run = 0; run < runs; run++) {
        rk_picture_pair ours = make_pair(1, 1), theirs = make_pair(1, 1);
        add_noise(&ours.first, 0.2f, 4 * run);
        add_noise(&ours.second, 0.2f, 4 * run + 1);
        add_noise(&theirs.first, 0.1f, 4 * run + 2);
        add_noise(&theirs.second, 0.1f, 4 * run + 3);
        const rk_region_ratio got = rk_region_ratio_of(&ours, &theirs, NULL, RK_REGION_ALL);
        squares += (got.ratio - 1) * (got.ratio - 1);
        claimed += got.standard_error / runs;
        free_pair(&ours);
        free_pair(&theirs);
    }
    /* Two pictures of 3000 pixels: sqrt((.04 + .01) / 6000). An estimate from 3000 differences
     * deviates by 1 / sqrt(6000), the mean of 400 by a twentieth of it; four of these. */
    rk_check_close(claimed, sqrt(0.05 / (2 * count)), 2.6e-3 * 2.9e-3, "the error of the mean");
    /* The deviation of 400 ratios is known to 1 / sqrt(800) of itself: four of these. */
    rk_check_close(sqrt(squares / runs), claimed, 0.14 * claimed, "the ratios deviate as claimed");
}

static void only_a_ratio_near_1_with_little_noise_agrees(void **state)
{
    (void)state;
    const struct {
        double ratio, standard_error;
        rk_agreement want;
    } cases[] = {
        {1, 0, RK_AGREE},
        {1.0019, 0, RK_AGREE},
        {0.9981, 0, RK_AGREE},
        {1.0021, 0, RK_DISAGREE},
        {0.9979, 0, RK_DISAGREE},
        {1.0021, 1e-4, RK_AGREE},
        {1.0024, 1e-4, RK_DISAGREE},
        {1.001, 3e-3, RK_TOO_NOISY},
        {1.1, 3e-3, RK_DISAGREE},
        {(double)NAN, 0, RK_DISAGREE},
        {1, (double)NAN, RK_DISAGREE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const rk_region_ratio ratio = {1, cases[i].ratio, cases[i].standard_error};
        const rk_agreement got = rk_region_ratio_agreement(&ratio);
        rk_check(got == cases[i].want, "%g +- %g: got \"%s\", want \"%s\"", ratio.ratio,
                 ratio.standard_error, rk_agreement_names.items[got],
                 rk_agreement_names.items[cases[i].want]);
    }
}

static void the_difference_is_absolute_and_scaled(void **state)
{
    (void)state;
    rk_picture_pair a = make_pair(1, 2), b = make_pair(2, 2);
    rk_image shown = make(7);
    b.first.pixels[4] = rk_vec(0, 1, 3);
    rk_picture_pair_difference(&shown, &a, &b, 8);
    rk_check_close(shown.pixels[0].x, 4, 0, "8 |1.5 - 2|, exact in binary");
    rk_check_close(shown.pixels[4].x, 4, 0, "8 |1.5 - 1|");
    rk_check_close(shown.pixels[4].y, 0, 0, "8 |1.5 - 1.5|");
    rk_check_close(shown.pixels[4].z, 8, 0, "8 |1.5 - 2.5|");
    rk_picture_pair_mean(&shown, &b);
    rk_check_close(shown.pixels[4].z, 2.5, 0, "the mean of 3 and 2");
    rk_image_free(&shown);
    free_pair(&a);
    free_pair(&b);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_ratio_is_that_of_the_means),
    cmocka_unit_test(only_pixels_of_the_region_count),
    cmocka_unit_test(sums_weigh_bright_pixels_more),
    cmocka_unit_test(the_standard_error_is_that_of_repeated_ratios),
    cmocka_unit_test(only_a_ratio_near_1_with_little_noise_agrees),
    cmocka_unit_test(the_difference_is_absolute_and_scaled),
};

RK_SUITE("region_ratio", tests)
