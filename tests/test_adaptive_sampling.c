/* Adaptive sampling: blocks of samples, the error that their differences tell, and the allocation
 * of samples to pixels, by hand, by brute force, and by noise of known variance. */
#include "test.h"

#include "base/random.h"
#include "features/adaptive_sampling.h"

static rk_vec3 grey(float value)
{
    return rk_vec(value, value, value);
}

/* `count` samples with the values first, first + 1, ... */
static rk_pixel_samples staircase(uint32_t count, float first)
{
    rk_pixel_samples pixel = {0};
    rk_adaptive_extend(&pixel, count);
    for (uint32_t i = 0; i < count; i++)
        rk_adaptive_add(&pixel, i, grey(first + (float)i));
    return pixel;
}

/* The pixel that the chapter computes by hand. */
static rk_pixel_samples by_hand(void)
{
    const float values[] = {1, 3, 5, 7, 3, 5, 7, 9};
    rk_pixel_samples pixel = {0};
    rk_adaptive_extend(&pixel, 8);
    for (uint32_t i = 0; i < 8; i++)
        rk_adaptive_add(&pixel, i, grey(values[i]));
    return pixel;
}

/* The chapter's row of eight pixels: the variance of each by itself, and pooled, in 12.125ths. */
static const float row_own[8] = {0, 0, 0, 64, 16, 0, 0, 0};
static const double row_pooled[8] = {1.25, 1.25, 129.25, 545.25, 257.25, 33.25, 1.25, 1.25};

/* Uniform in [0, 1), with the variance 1/12; independent of all others. */
static rk_vec3 noise(uint32_t pixel, uint32_t sample)
{
    return rk_vec(rk_unit_float(rk_case(pixel, sample, 0, 7)),
                  rk_unit_float(rk_case(pixel, sample, 1, 7)),
                  rk_unit_float(rk_case(pixel, sample, 2, 7)));
}

static rk_pixel_samples added_noise(uint32_t pixel, uint32_t count)
{
    rk_pixel_samples samples = {0};
    rk_adaptive_extend(&samples, count);
    for (uint32_t i = 0; i < count; i++)
        rk_adaptive_add(&samples, i, noise(pixel, i));
    return samples;
}

/* The same by the definitions, without the unit. */
static rk_pixel_samples summed_noise(uint32_t pixel, uint32_t count)
{
    double block[RK_ADAPTIVE_BLOCKS][3] = {{0}}, deviations = 0;
    for (int axis = 0; axis < 3; axis++) {
        double mean = 0;
        for (uint32_t i = 0; i < count; i++) {
            const double value = (double)rk_axis(noise(pixel, i), axis);
            block[4 * i / count][axis] += value;
            mean += value / count;
        }
        for (uint32_t i = 0; i < count; i++)
            deviations += pow((double)rk_axis(noise(pixel, i), axis) - mean, 2) / 3;
    }
    rk_pixel_samples samples = {.deviations = (float)deviations, .count = count};
    for (int i = 0; i < RK_ADAPTIVE_BLOCKS; i++)
        samples.block[i] = rk_vec((float)block[i][0], (float)block[i][1], (float)block[i][2]);
    return samples;
}

/* --- A pixel ---------------------------------------------------------------------------------- */

static void check_blocks(const rk_pixel_samples *pixel, const float want[4], const char *hint)
{
    for (int i = 0; i < 4; i++)
        rk_check_near(pixel->block[i].x, want[i], 0, "block %d: %s", i, hint);
}

/* The first and the last sample of each quarter, for every number of samples that 32 bits hold. */
static void check_ends_of_quarters(void)
{
    for (uint32_t count = 4; count; count *= 2)
        for (uint32_t i = 0; i < 8; i++) {
            rk_pixel_samples pixel = {0};
            rk_adaptive_extend(&pixel, count);
            uint32_t quarter = i / 2, sample = count / 4 * quarter + i % 2 * (count / 4 - 1);
            rk_adaptive_add(&pixel, sample, grey(1));
            rk_check(pixel.block[quarter].x == 1, "sample %u of %u: want it in block %u%s", sample,
                     count, quarter,
                     sample > UINT32_MAX / 4 ? ": 4 times its number exceeds 32 bits, so divide "
                                               "by the size of a block, count / 4"
                                             : "");
        }
}

static void a_sample_is_added_to_the_block_of_its_quarter(void **state)
{
    (void)state;
    rk_pixel_samples four = staircase(4, 1), eight = staircase(8, 1), many = staircase(64, 1);
    check_blocks(&four, (float[]){1, 2, 3, 4}, "of 4 samples each block has one");
    check_blocks(&eight, (float[]){3, 7, 11, 15}, "of 8 samples each block has two in a row");
    check_blocks(&many, (float[]){136, 392, 648, 904}, "of 64 samples each block has 16 in a row");
    const rk_pixel_samples pixel = by_hand();
    check_blocks(&pixel, (float[]){4, 12, 8, 16}, "samples 1, 3, 5, 7, 3, 5, 7, 9");
    rk_pixel_samples colour = {0};
    rk_adaptive_extend(&colour, 4);
    rk_adaptive_add(&colour, 2, rk_vec(1, 2, 3));
    rk_check(colour.block[2].x == 1 && colour.block[2].y == 2 && colour.block[2].z == 3,
             "a sample keeps its colour");
    check_ends_of_quarters();
}

static void the_samples_so_far_become_the_first_half(void **state)
{
    (void)state;
    rk_pixel_samples pixel = staircase(8, 1);
    rk_adaptive_extend(&pixel, 8);
    check_blocks(&pixel, (float[]){3, 7, 11, 15}, "8 samples, room for 8: nothing to do");
    rk_adaptive_extend(&pixel, 16);
    check_blocks(&pixel, (float[]){10, 26, 0, 0}, "8 samples, room for 16");
    rk_check_equal(pixel.count, 16, "the number of samples that it will have");
    pixel = by_hand();
    rk_adaptive_extend(&pixel, 16);
    check_blocks(&pixel, (float[]){16, 24, 0, 0}, "blocks of 4, 12, 8 and 16, room for 16 samples");
    pixel = staircase(8, 1);
    rk_adaptive_extend(&pixel, 32);
    check_blocks(&pixel, (float[]){36, 0, 0, 0}, "8 samples, room for 32");
    rk_adaptive_extend(&pixel, 128);
    check_blocks(&pixel, (float[]){36, 0, 0, 0}, "8 samples, room for 128");
}

static void samples_in_rounds_are_those_at_once(void **state)
{
    (void)state;
    for (uint32_t first = 4; first <= 64; first *= 2) {
        rk_pixel_samples rounds = staircase(first, 1), once = staircase(256, 1);
        rk_adaptive_extend(&rounds, 128);
        for (uint32_t i = first; i < 128; i++)
            rk_adaptive_add(&rounds, i, grey(1 + (float)i));
        rk_adaptive_extend(&rounds, 256);
        for (uint32_t i = 128; i < 256; i++)
            rk_adaptive_add(&rounds, i, grey(1 + (float)i));
        check_blocks(&rounds,
                     (float[]){once.block[0].x, once.block[1].x, once.block[2].x, once.block[3].x},
                     "256 samples in three rounds, and at once");
    }
}

static void the_mean_is_that_of_all_samples(void **state)
{
    (void)state;
    const rk_pixel_samples none = {0};
    rk_check_close(rk_adaptive_mean(&none).x, 0, 0, "no samples: black");
    for (uint32_t count = 4; count <= 1024; count *= 2) {
        const rk_pixel_samples pixel = staircase(count, 1);
        rk_check_near_or(rk_adaptive_mean(&pixel).y, (count + 1) / 2.0, 0,
                         RK_MISTAKES({(float)(count * (count + 1) / 2.0 / (count + 1)),
                                      "the sum is divided by n + 1"},
                                     {count * (count + 1) / 2.0, "the sum is not divided by n"},
                                     {3 * (3.0 * count / 4 + 1) / 8, "the last block is left out"}),
                         "1, 2, ... %u", count);
    }
}

/* --- Error ------------------------------------------------------------------------------------ */

static void differences_are_those_of_means(void **state)
{
    (void)state;
    /* Quarters have the means 1, 2, 4, 8, so halves 1.5 and 6. */
    for (uint32_t count = 4; count <= 1u << 24; count *= 2) {
        const float n = (float)(count / 4);
        const rk_pixel_samples pixel = {{grey(n), grey(2 * n), grey(4 * n), grey(8 * n)}, 0, count};
        const rk_adaptive_differences d = rk_adaptive_differences_of(&pixel);
        const double quarters = (1.0 / 4 + 16.0 / 4) / 2, halves = 4.5 * 4.5 / 4;
        rk_check_near_or(
            d.quarters, quarters, 1e-12,
            RK_MISTAKES({2 * quarters, "both pairs are added, and not averaged"},
                        {4 * quarters, "the squared difference of two means is not divided by 4"},
                        {3 * quarters, "the channels' squares are added, and not averaged"},
                        {(9.0 + 36) / 8, "quarters are compared with those of the other half"},
                        {(1.0 / 4 + 16.0 / 4) / 2 * (n * n), "sums are compared, not means"}),
            "%u samples, means 1, 2, 4, 8: the mean of |1 - 2|^2 / 4 and |4 - 8|^2 / 4", count);
        rk_check_near_or(
            d.halves, halves, 1e-12,
            RK_MISTAKES({4 * halves, "the squared difference of two means is not divided by 4"},
                        {halves / 4, "a half has two quarters, so its mean is half their sum"}),
            "%u samples, halves 1.5 and 6", count);
    }
    const rk_pixel_samples pixel_by_hand = {{grey(4), grey(12), grey(8), grey(16)}, 0, 8};
    const rk_adaptive_differences of_it = rk_adaptive_differences_of(&pixel_by_hand);
    rk_check_close(of_it.quarters, 4, 1e-12, "sums of two samples: 4, 12, 8, 16; means 2, 6, 4, 8");
    rk_check_close(of_it.halves, 1, 1e-12, "sums of two samples: 4, 12, 8, 16; halves 4 and 6");
}

static void differences_are_means_over_the_channels(void **state)
{
    (void)state;
    const rk_pixel_samples pixel = {{{2, 0, 0}, {0, 4, 0}, {0, 0, 6}, {0, 0, 0}}, 0, 4};
    const rk_adaptive_differences d = rk_adaptive_differences_of(&pixel);
    const double quarters = ((4.0 + 16) / 12 + 36.0 / 12) / 2;
    rk_check_near_or(d.quarters, quarters, 1e-12,
                     RK_MISTAKES({3 * quarters, "the channels' squares are added, not averaged"},
                                 {(4.0 + 16) / 24, "the third channel is left out"}),
                     "quarters, a third of the sum over three channels");
    rk_check_close(d.halves, (1.0 + 4 + 9) / 12, 1e-12, "halves (1, 2, 0) and (0, 0, 3)");
}

static void equal_samples_and_no_samples_do_not_differ(void **state)
{
    (void)state;
    const rk_pixel_samples none = {0}, equal = {{grey(6), grey(6), grey(6), grey(6)}, 0, 16};
    rk_check_close(rk_adaptive_differences_of(&none).halves, 0, 0, "no samples");
    rk_check_close(rk_adaptive_differences_of(&none).quarters, 0, 0, "no samples");
    rk_check_close(rk_adaptive_differences_of(&equal).halves, 0, 0, "equal samples");
    rk_check_close(rk_adaptive_differences_of(&equal).quarters, 0, 0, "equal samples");
}

/* Samples are numbers, and so are blocks, but the sum of two blocks is infinite as a float. */
static void check_sums_beyond_the_largest_float(void)
{
    const float last_half[] = {3e38f, -3e38f, 0};
    for (int i = 0; i < 3; i++) {
        const rk_vec3 first = grey(3e38f), last = grey(last_half[i]);
        const rk_pixel_samples pixel = {{first, first, last, last}, 0, 4};
        const rk_adaptive_differences d = rk_adaptive_differences_of(&pixel);
        rk_check(d.quarters == 0 && d.halves == 0,
                 "samples 3e38, 3e38, %g, %g: got quarters %g and halves %g, want 0 of both: the "
                 "sum of a half exceeds the largest float, so check the halves' difference too",
                 (double)last_half[i], (double)last_half[i], d.quarters, d.halves);
    }
}

static void a_sample_that_is_no_number_counts_as_no_difference(void **state)
{
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++)
        for (int block = 0; block < 4; block++) {
            rk_pixel_samples pixel = staircase(4, 1);
            pixel.block[block].y = bad[i];
            const rk_adaptive_differences d = rk_adaptive_differences_of(&pixel);
            rk_check_near(d.quarters, 0, 0, "%g in block %d", (double)bad[i], block);
            rk_check_near(d.halves, 0, 0, "%g in block %d", (double)bad[i], block);
        }
    check_sums_beyond_the_largest_float();
}

static void the_ratio_is_between_an_eighth_and_a_half(void **state)
{
    (void)state;
    const double ratios[][2] = {{0.25, 0.25}, {0.5, 0.5}, {0.125, 0.125}, {0.7, 0.5},
                                {3, 0.5},     {0.3, 0.3}, {0.01, 0.125},  {0, 0.125}};
    for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++)
        rk_check_near_or(
            rk_adaptive_ratio((rk_adaptive_differences){4, 4 * ratios[i][0]}), ratios[i][1], 1e-15,
            RK_MISTAKES({fmin(1 / ratios[i][0], 0.5), "quarters are divided by halves"},
                        {ratios[i][0], "the ratio is not limited to 1/8 .. 1/2"}),
            "quarters 4, halves %g: halves over quarters", 4 * ratios[i][0]);
    rk_check_close(rk_adaptive_ratio((rk_adaptive_differences){0, 0}), 0.5, 0, "no differences");
    rk_check_close(rk_adaptive_ratio((rk_adaptive_differences){0x1p-200, 0x1p-202}), 0.25, 1e-15,
                   "quarters 2^-200, halves 2^-202: a very dark picture");
}

static void later_doublings_are_nearer_to_a_half(void **state)
{
    (void)state;
    const double ratios[][2] = {{0.5, 0.5}, {0.25, 1 / 3.0}, {0.3, 1.1 / 3}, {3, 0.5}, {0, 0.25}};
    for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++)
        rk_check_near(rk_adaptive_later_ratio((rk_adaptive_differences){4, 4 * ratios[i][0]}),
                      ratios[i][1], 1e-15, "quarters 4, halves %g", 4 * ratios[i][0]);
}

static void variance_is_the_sum_of_the_series(void **state)
{
    (void)state;
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){6, 3}), 3, 1e-12,
                   "independent samples: V(n/2) - V(n) = V(n)");
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){4, 1}), 0.5, 1e-12,
                   "differences 4 and 1: r is 1/4, later 1/3");
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){8, 2}), 1, 1e-12,
                   "halves 2, a quarter of quarters: with r = (2/4 + 1/2) / 3");
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){80, 1}), 1 / 3.0, 1e-12,
                   "halves far below quarters: with r = (2/8 + 1/2) / 3");
    rk_check_near(ldexp(rk_adaptive_variance((rk_adaptive_differences){0x1p-198, 0x1p-200}), 200),
                  0.5, 1e-12, "differences 2^-198 and 2^-200, a very dark picture: V times 2^200");
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){0, 0}), 0, 0, "no differences");
    rk_check_close(rk_adaptive_variance((rk_adaptive_differences){0, 2}), 2, 1e-12,
                   "quarters that happen to be equal");
}

/* 16 sums of numbers below 1, and of squares of differences, in float: errors stay below 1e-6 in a
 * block of four, and below 1e-5 in all. */
static void check_added_noise(const rk_pixel_samples *added, uint32_t pixel, uint32_t count)
{
    const rk_pixel_samples want = summed_noise(pixel, count);
    for (int block = 0; block < RK_ADAPTIVE_BLOCKS; block++)
        for (int axis = 0; axis < 3; axis++)
            rk_check_near(rk_axis(added->block[block], axis), rk_axis(want.block[block], axis),
                          1e-6, "%u random samples: block %d", count, block);
    rk_check_near(added->deviations, want.deviations, 1e-5,
                  "%u random samples: squared deviations from their mean", count);
}

static void random_samples_are_added_as_their_sums(uint32_t count)
{
    enum { added_pixels = 256 };
    rk_pixel_samples added[added_pixels];
    for (uint32_t i = 0; i < added_pixels; i++)
        added[i] = added_noise(i, count);
    for (uint32_t i = 0; i < added_pixels; i++)
        check_added_noise(&added[i], i, count);
}

/* Variances of independent samples, over so many pixels that 5 standard errors are 3 %: a squared
 * difference of three channels has a relative variance of 2/3. */
static void noise_of_known_variance_is_measured(void **state)
{
    (void)state;
    enum { pixels = 1 << 14 };
    for (uint32_t count = 4; count <= 16; count *= 2) {
        random_samples_are_added_as_their_sums(count);
        rk_adaptive_differences sum = {0, 0};
        double own = 0;
        for (uint32_t i = 0; i < pixels; i++) {
            const rk_pixel_samples samples = summed_noise(i, count);
            const rk_adaptive_differences d = rk_adaptive_differences_of(&samples);
            sum.quarters += d.quarters / pixels;
            sum.halves += d.halves / pixels;
            own += (double)rk_adaptive_own_variance(&samples) / pixels;
        }
        const double tolerance = 5 * sqrt(2.0 / 3 / pixels);
        rk_check_near(12 * sum.halves * count, 1, tolerance, "halves of %u, by sigma^2 / n", count);
        rk_check_near(12 * sum.quarters * count, 2, 2 * tolerance, "quarters of %u, by sigma^2 / n",
                      count);
        rk_check_near(12 * own, 1, tolerance, "sigma^2 from %u samples of each pixel", count);
    }
}

static void error_is_relative_to_the_picture(void **state)
{
    (void)state;
    rk_check_near_or(rk_adaptive_error(1, 101), 0.1, 1e-12,
                     RK_MISTAKES({0.01, "the root is missing"},
                                 {sqrt(1 / 101.), "V is not subtracted from the squares of means"}),
                     "rk_adaptive_error(1, 101): V = 1, squares of means 100 + V");
    rk_check_close(rk_adaptive_error(4, 200), 1 / 7.0, 1e-12, "V = 4, squares 200");
    rk_check_close(rk_adaptive_error(4e-8, 4e-8 + 1e-4), 0.02, 1e-9, "a dark picture");
    rk_check_close(rk_adaptive_error(0x1p-200, 101 * 0x1p-200), 0.1, 1e-12,
                   "V = 2^-200, squares 101 times as much: a very dark picture");
    rk_check_close(rk_adaptive_error(0x1p200, 101 * 0x1p200), 0.1, 1e-12,
                   "V = 2^200, squares 101 times as much: a very bright picture");
    rk_check_close(rk_adaptive_error(0, 5), 0, 0, "no variance");
    rk_check_close(rk_adaptive_error(0, 0), 0, 0, "a black picture");
    rk_check(isinf(rk_adaptive_error(2, 2)), "nothing but noise");
    rk_check(isinf(rk_adaptive_error(2, 1)), "nothing but noise, less than its variance");
}

/* --- Variance --------------------------------------------------------------------------------- */

static void a_sample_adds_its_deviation(void **state)
{
    (void)state;
    const rk_pixel_samples pixel = {{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {0, 0, 0}}, 0, 4};
    rk_check_close(rk_adaptive_added_deviation(&pixel, 3, rk_vec(1, 2, 3)), 0, 1e-6,
                   "the mean of the three before");
    rk_check_near_or(
        rk_adaptive_added_deviation(&pixel, 3, rk_vec(5, 2, 3)), 0.75 * 16 / 3, 1e-6,
        RK_MISTAKES({16 / 3., "the whole squared deviation is added, as if the mean stayed"},
                    {0.75 * 16, "deviations are summed over the channels, not averaged"},
                    {0.75 * 4 / 3, "the deviation is added, not its square"},
                    {0.25 * 16 / 3, "it is multiplied by 1 / (n + 1), not by n / (n + 1)"}),
        "the fourth sample, red 4 above the others' mean: 3/4 of 4^2, over three channels");
    rk_check_close(rk_adaptive_added_deviation(&pixel, 3, rk_vec(3, 2, 3)), 0.75 * 4 / 3, 1e-6,
                   "red 2 above their mean: 3/4 of 2^2, over three channels");
    rk_check_close(rk_adaptive_added_deviation(&pixel, 3, rk_vec(3, 0, 4)), 0.75 * 9 / 3, 1e-6,
                   "red 2 above, green 2 below, blue 1 above");
    rk_check_close(rk_adaptive_added_deviation(&pixel, 0, rk_vec(3, 0, 4)), 0, 0, "the first one");
}

static void own_variance_is_that_of_the_samples(void **state)
{
    (void)state;
    const rk_pixel_samples pixel = by_hand();
    rk_check_close(rk_adaptive_own_variance(&pixel), 48 / 7.0, 1e-5,
                   "samples 1, 3, 5, 7, 3, 5, 7, 9: 48 / 7");
    for (uint32_t n = 4; n <= 1024; n *= 2) { /* of 1, 2, ... n it is n (n + 1) / 12 */
        const rk_pixel_samples once = staircase(n, 1);
        rk_check_near(rk_adaptive_own_variance(&once) / ((double)n * (n + 1) / 12), 1, 1e-5,
                      "1, 2, ... %u: the sample variance, with n - 1", n);
        rk_pixel_samples rounds = staircase(n, 1);
        rk_adaptive_extend(&rounds, 2 * n);
        for (uint32_t i = n; i < 2 * n; i++)
            rk_adaptive_add(&rounds, i, grey(1 + (float)i));
        rk_check_near(rk_adaptive_own_variance(&rounds) / (2.0 * n * (2 * n + 1) / 12), 1, 1e-5,
                      "1, 2, ... %u in two rounds", 2 * n);
    }
    /* Floats near 4096 are 2^-11 apart, so each of 64 means is off by as much at most. */
    const rk_pixel_samples dark = {.deviations = 0x1p-100f, .count = 8};
    rk_check_near(ldexp((double)rk_adaptive_own_variance(&dark), 100), 1 / 7.0, 1e-6,
                  "8 samples, squared deviations of 2^-100: sigma^2 times 2^100");
    const rk_pixel_samples far = staircase(64, 4096);
    rk_check_close(rk_adaptive_own_variance(&far) / (64 * 65 / 12.0), 1, 1e-4,
                   "4096, 4097, ...: deviations from the mean, not a difference of large squares");
}

static void no_samples_and_bad_ones_have_no_variance(void **state)
{
    (void)state;
    const rk_pixel_samples none = {0};
    rk_check_close(rk_adaptive_own_variance(&none), 0, 0, "no samples");
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        rk_pixel_samples pixel = staircase(4, 1);
        rk_adaptive_extend(&pixel, 8);
        for (uint32_t k = 4; k < 8; k++)
            rk_adaptive_add(&pixel, k, rk_vec(1, k == 5 ? bad[i] : 1, 1));
        rk_check_near(rk_adaptive_own_variance(&pixel), 0, 0, "%g among them", (double)bad[i]);
    }
}

static void pooling_keeps_a_constant(void **state)
{
    (void)state;
    float variance[20];
    for (int i = 0; i < 20; i++)
        variance[i] = 3;
    for (uint32_t y = 0; y < 4; y++)
        for (uint32_t x = 0; x < 5; x++)
            rk_check_near(rk_adaptive_pooled_variance(variance, 3, 8, 5, 4, x, y), 3, 1e-6,
                          "pixel (%u, %u) of a picture with variance 3 everywhere", x, y);
}

static void pooled_variance_is_weighted_by_samples(void **state)
{
    (void)state;
    const float variance[9] = {1, 2, 3, 4, 50, 6, 7, 8, 9};
    for (uint32_t count = 4; count <= 1u << 20; count *= 4)
        rk_check_near(rk_adaptive_pooled_variance(variance, 32, count, 3, 3, 1, 1),
                      (count * 50.0 + 4 * 5 + 4) / (count + 4 + 1 / 8.0), 1e-5 * 50,
                      "%u samples of variance 50, neighbours 5, picture 32", count);
    rk_check_near(rk_adaptive_pooled_variance(variance, 32, 0, 3, 3, 1, 1), (4 * 5 + 4) / 4.125,
                  1e-5, "no samples of its own");
}

static void neighbours_are_those_inside_the_picture(void **state)
{
    (void)state;
    const float variance[9] = {1, 2, 3, 4, 50, 6, 7, 8, 9};
    const struct {
        uint32_t x, y;
        double around;
    } at[] = {{0, 0, 56.0 / 3}, {2, 0, 58.0 / 3}, {0, 2, 62.0 / 3},
              {2, 2, 64.0 / 3}, {1, 0, 64.0 / 5}, {0, 1, 68.0 / 5}};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        rk_check_near(rk_adaptive_pooled_variance(variance, 0, 4, 3, 3, at[i].x, at[i].y),
                      (4 * (double)variance[3 * at[i].y + at[i].x] + 4 * at[i].around) /
                          (8 + 1 / 8.0),
                      1e-4, "pixel (%u, %u)", at[i].x, at[i].y);
    rk_check_close(rk_adaptive_pooled_variance(variance, 0, 4, 9, 1, 8, 0), (36 + 32) / 8.125, 1e-5,
                   "the end of a picture of one row");
    for (uint32_t x = 0; x < 8; x++)
        rk_check_near(rk_adaptive_pooled_variance(row_own, 10, 8, 8, 1, x, 0),
                      row_pooled[x] / 12.125, 1e-5 * 64,
                      "a row of variances 0 0 0 64 16 0 0 0, from 8 samples each: pixel %u", x);
    rk_check_close(rk_adaptive_pooled_variance(variance, 1, 8, 1, 1, 0, 0), 1, 1e-6, "one pixel");
}

static void no_pixel_is_trusted_to_be_without_noise(void **state)
{
    (void)state;
    const float variance[9] = {0};
    float before = 1;
    for (uint32_t count = 4; count <= 1u << 24; count *= 2) {
        float got = rk_adaptive_pooled_variance(variance, 1, count, 3, 3, 1, 1);
        rk_check(got > 0 && got < before, "%u equal samples: %g, with fewer %g", count, (double)got,
                 (double)before);
        before = got;
    }
}

/* --- Allocation ------------------------------------------------------------------------------- */

static const char count_too_low[] = "n is rounded down, not to the nearest power of two";
static const char count_too_high[] = "n is rounded up, not to the nearest power of two";

static void the_count_is_the_ratio_of_deviations(void **state)
{
    (void)state;
    const uint32_t most = 1u << 24;
    for (int k = 2; k <= 24; k++)
        for (int e = -60; e <= 60; e += 20)
            rk_check_near_or(
                rk_adaptive_count(ldexpf(1, 2 * k + e), ldexpf(1, e), most), ldexp(1, k), 0,
                RK_MISTAKES({ldexp(1, k - 1), count_too_low}, {ldexp(1, k + 1), count_too_high},
                            {ldexp(1, 2 * k), "the root is missing: sigma^2 / lambda"},
                            {k < 16 ? 0 : most, "2 n^2 exceeds 32 bits from n = 2^16 on: "
                                                "multiply floats, not whole numbers"}),
                "sigma^2 2^%d, lambda 2^%d: n = sigma / sqrt(lambda)", 2 * k + e, e);
}

enum { middles = 11 };

/* Neyman's number is sqrt(2) 2^k, or a little less or more: of predictions, too. `at`: sigma^2 /
 * lambda over 2 4^k. */
static void ask_near_middles(const float at[middles], int exponent, uint32_t counts[middles],
                             double samples[middles])
{
    for (int k = 2; k < middles; k++) {
        const float variance = ldexpf(at[k], 2 * k + 1 + exponent), lambda = ldexpf(1, exponent);
        const rk_adaptive_estimate one = {variance, 4, 0};
        counts[k] = rk_adaptive_count(variance, lambda, 4096);
        samples[k] = rk_adaptive_predict(&one, 1, lambda, 4096, 0.5).samples;
    }
}

static void check_near_middles(void)
{
    float below[middles], middle[middles], above[middles];
    for (int k = 0; k < middles; k++) {
        /* A float log2 is off by up to 1.5 of its ulps, which is ln 2 times as much of its argument
         * (here 1.04), and the argument by a rounding. */
        const float log = (float)(2 * k + 1), ulp = nextafterf(log, INFINITY) - log;
        below[k] = 1 - 1.25f * ulp;
        middle[k] = 1;
        above[k] = nextafterf(1, 2);
    }
    const struct {
        const float *at;
        const char *said;
        int exponent, more;
    } near[] = {{below, "just below the middle between", 0, 0},
                {middle, "exactly in the middle between", 0, 1},
                {middle, "exactly in the middle between", -60, 1},
                {middle, "exactly in the middle between", 61, 1},
                {above, "one float above the middle between", 0, 1}};
    uint32_t counts[5][middles];
    double samples[5][middles];
    for (int i = 0; i < 5; i++)
        ask_near_middles(near[i].at, near[i].exponent, counts[i], samples[i]);
    for (int i = 0; i < 5; i++)
        for (int k = 2; k < middles; k++) {
            rk_check_near(counts[i][k], ldexp(1, k + near[i].more), 0,
                          "sigma^2 / lambda %.9g, lambda 2^%d: n is %s 2^%d and 2^%d",
                          ldexp((double)near[i].at[k], 2 * k + 1), near[i].exponent, near[i].said,
                          k, k + 1);
            rk_check_near(
                samples[i][k], ldexp(1, k + near[i].more), 0,
                "a prediction's samples, sigma^2 / lambda %.9g, lambda 2^%d: n is %s 2^%d "
                "and 2^%d",
                ldexp((double)near[i].at[k], 2 * k + 1), near[i].exponent, near[i].said, k, k + 1);
        }
}

static void the_count_is_the_nearest_power_of_two_by_logarithm(void **state)
{
    (void)state;
    const float below = 1.9999f, above = 2.0001f; /* of the squared number */
    for (int k = 2; k < 12; k++) {
        rk_check_near_or(
            rk_adaptive_count(ldexpf(below, 2 * k), 1, 4096), ldexp(1, k), 0,
            RK_MISTAKES({ldexp(1, k + 1), count_too_high}, {ldexp(1, k - 1), count_too_low}),
            "n = sqrt(%g) 2^%d; by logarithm the middle between 2^%d and 2^%d is sqrt(2) "
            "times the first",
            (double)below, k, k, k + 1);
        rk_check_near_or(
            rk_adaptive_count(ldexpf(above, 2 * k), 1, 4096), ldexp(1, k + 1), 0,
            RK_MISTAKES({ldexp(1, k), count_too_low}, {ldexp(1, k + 2), count_too_high}),
            "n = sqrt(%g) 2^%d; by logarithm the middle between 2^%d and 2^%d is sqrt(2) "
            "times the first",
            (double)above, k, k, k + 1);
    }
    check_near_middles();
}

static void counts_have_limits(void **state)
{
    (void)state;
    const struct {
        float variance, lambda;
        uint32_t most, want;
    } at[] = {{0, 1, 64, 4},
              {1e-30f, 1, 64, 4},
              {1, INFINITY, 64, 4},
              {NAN, 1, 64, 4},
              {1e30f, 1, 64, 64},
              {INFINITY, 1, 64, 64},
              {1e-30f, 0x1p-149f, 64, 64},
              {4097, 1, 64, 64},
              {3e38f, 1e-38f, 1u << 24, 1u << 24},
              {-1, 1, 64, 4}};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        rk_check_near(rk_adaptive_count(at[i].variance, at[i].lambda, at[i].most), at[i].want, 0,
                      "variance %g, lambda %g, at most %u", (double)at[i].variance,
                      (double)at[i].lambda, at[i].most);
}

static void noisier_pixels_never_take_fewer_samples(void **state)
{
    (void)state;
    uint32_t by_variance = 0, by_lambda = 0;
    for (int i = -200; i <= 200; i++) {
        uint32_t more = rk_adaptive_count(exp2f((float)i / 8), 1, 4096);
        uint32_t cheaper = rk_adaptive_count(1, exp2f(-(float)i / 8), 4096);
        rk_check(more >= by_variance, "variance 2^(%d / 8): %u samples after %u", i, more,
                 by_variance);
        rk_check(cheaper >= by_lambda, "lambda 2^(%d / -8): %u samples after %u", i, cheaper,
                 by_lambda);
        by_variance = more;
        by_lambda = cheaper;
    }
}

/* Brute force: every allocation of powers of two to four pixels. */
static void no_allocation_of_as_many_samples_is_better(void **state)
{
    (void)state;
    const float variances[][4] = {
        {1, 4, 16, 64}, {1, 1, 1, 256}, {3, 30, 300, 3000}, {0, 1, 2, 900}};
    for (int s = 0; s < 4; s++)
        for (int l = -14; l <= 2; l++) {
            uint32_t n[4], total = 0;
            double got = 0;
            for (int i = 0; i < 4; i++) {
                n[i] = rk_adaptive_count(variances[s][i], exp2f((float)l / 2), 512);
                total += n[i];
                got += (double)variances[s][i] / n[i];
            }
            for (int code = 0; code < 4096; code++) {
                uint32_t samples = 0;
                double variance = 0;
                for (int i = 0; i < 4; i++) {
                    uint32_t count = 4u << (code >> 3 * i & 7);
                    samples += count;
                    variance += (double)variances[s][i] / count;
                }
                /* With n rounded to powers of two, lambda is the same up to a factor of 2 either
                 * way, and an allocation of as many samples may be 9/8 as good:
                 * (sqrt(2) + 1 / sqrt(2))^2 / 4. */
                rk_check(samples > total || variance * 9 / 8 >= got * (1 - 1e-6),
                         "set %d, lambda 2^(%d / 2): %u, %u, %u and %u samples leave the variance "
                         "%g, and as many leave %g",
                         s, l, n[0], n[1], n[2], n[3], got, variance);
            }
        }
}

/* 2^24 and 5 more, of which a sum of floats or of 24 bits loses the last. */
static void check_large_prediction(void)
{
    const rk_adaptive_estimate two[] = {{0x1p40f, 64, 1u << 24}, {640, 64, 5}};
    rk_adaptive_prediction p = rk_adaptive_predict(two, 2, INFINITY, 1u << 24, 1);
    rk_check_close(p.samples, 0x1p24 + 5, 0,
                   "a pixel of 2^24 samples, and one of 5: a float ends at 2^24");
    rk_check_close(p.variance - 0x1p34, 10, 0, "variances of 2^34 and 10: a float has 24 bits");
    const rk_adaptive_estimate many_samples = {0, 4, 1u << 31};
    const rk_adaptive_estimate three[] = {many_samples, many_samples, many_samples};
    p = rk_adaptive_predict(three, 3, INFINITY, 4, 1);
    rk_check_close(p.samples, 3 * 0x1p31, 0, "more samples than 32 bits can count");
}

/* The table in the chapter. */
static void check_prediction_by_hand(void)
{
    const struct {
        float lambda;
        double samples, variance;
    } at[] = {{0.01f, 192, 1.64}, {0.04f, 104, 3.18}, {0.08f, 88, 3.84}, {0.16f, 60, 6.26}};
    rk_adaptive_estimate row[8];
    for (int i = 0; i < 8; i++)
        row[i] = (rk_adaptive_estimate){(float)(row_pooled[i] / 12.125), 8, 0};
    for (int k = 0; k < 4; k++) {
        rk_adaptive_prediction p = rk_adaptive_predict(row, 8, at[k].lambda, 64, 0.5);
        rk_check_near(p.samples, at[k].samples, 0, "eight pixels, lambda %g: samples",
                      (double)at[k].lambda);
        rk_check_near(p.variance, at[k].variance, 0.005, "eight pixels, lambda %g: variance",
                      (double)at[k].lambda);
    }
}

/* Pictures' estimates are read by several threads at once. */
static void check_constant_estimates(void)
{
    const rk_adaptive_estimate own[] = {{64, 8, 0}, {1024, 8, 0}};
    const rk_adaptive_estimate *estimates = rk_read_only(own, sizeof own, "estimates");
    rk_adaptive_predict(estimates, 2, 1, 32, 0.25);
    rk_read_only_free();
}

/* From every sum of powers of two to powers of two. */
static void check_begun_doublings(void)
{
    enum { from = 4, to = 300, powers = 8 };
    static double got[to][powers];
    for (uint32_t n = from; n < to; n++)
        for (int k = 2; k < powers; k++) {
            const rk_adaptive_estimate one = {(float)n, n, 1u << k};
            got[n][k] = rk_adaptive_predict(&one, 1, INFINITY, 512, 0.25).variance;
        }
    for (uint32_t n = from; n < to; n++)
        for (int k = 2; k < powers; k++) {
            const uint32_t count = 1u << k;
            double want = 1;
            for (uint32_t more = n; more < count; more *= 2)
                want /= 4;
            for (uint32_t more = count; more < n; more *= 2)
                want *= 4;
            rk_check_near(got[n][k], want, 1e-9 * want,
                          "a variance of 1, by %u samples, predicted for %u, if a doubling "
                          "multiplies it by 1/4: the last doubling or halving counts as soon as it "
                          "is begun (from 36 to 4 samples there are four, as to 2.25)",
                          n, count);
        }
}

static void a_prediction_adds_up_pixels(void **state)
{
    (void)state;
    check_constant_estimates();
    check_prediction_by_hand();
    check_large_prediction();
    const rk_adaptive_estimate estimates[] = {{64, 8, 0}, {1024, 8, 0}, {0, 4, 0}, {4096, 64, 0}};
    const rk_adaptive_prediction p = rk_adaptive_predict(estimates, 4, 1, 32, 0.25);
    rk_check_close(p.samples, 8 + 32 + 4 + 32, 0, "counts");
    rk_check_close(p.variance, 64 / 8.0 + 1024 / 8.0 / 16 + 0 + 4096 / 64.0 * 4, 1e-9,
                   "each doubling multiplies by 1/4, each halving by 4");
    const rk_adaptive_prediction none = rk_adaptive_predict(estimates, 0, 1, 32, 0.25);
    rk_check(none.samples == 0 && none.variance == 0,
             "no pixels: got %g samples and the variance %g, want 0 of both", none.samples,
             none.variance);
    const rk_adaptive_prediction half = rk_adaptive_predict(estimates, 4, 1, 32, 0.5);
    rk_check_close(half.variance, 8 + 32 + 0 + 128, 1e-9, "independent samples: sigma^2 / n");
    const rk_adaptive_estimate sums[] = {{1000, 20, 0}, {20, 20, 0}};
    rk_check_close(rk_adaptive_predict(&sums[0], 1, 1, 32, 0.25).variance, 50 * 0.25, 1e-9,
                   "from 20 to 32 samples: one doubling");
    rk_check_close(rk_adaptive_predict(&sums[1], 1, 1, 32, 0.25).variance, 64, 1e-9,
                   "from 20 to 4 samples: three halvings, to 10, 5 and below");
    check_begun_doublings();
}

static void a_prediction_is_exact_for_independent_samples(void **state)
{
    (void)state;
    for (uint32_t from = 4; from <= 256; from *= 2)
        for (int k = 2; k <= 12; k++) {
            const rk_adaptive_estimate one = {ldexpf(1, 2 * k), from, 0};
            rk_check_near(rk_adaptive_predict(&one, 1, 1, 4096, 0.5).variance, ldexp(1, k), 1e-9,
                          "sigma 2^%d, estimated from %u samples", k, from);
        }
}

static void pixels_keep_the_samples_that_they_have(void **state)
{
    (void)state;
    const rk_adaptive_estimate estimates[] = {{64, 16, 16}, {1024, 16, 16}};
    const rk_adaptive_prediction p = rk_adaptive_predict(estimates, 2, 1, 64, 0.5);
    rk_check_close(p.samples, 16 + 32, 0, "8 would suffice for the first one, and it has 16");
    rk_check_close(p.variance, 64 / 16.0 + 1024 / 32.0, 1e-9, "variances of 16 and 32 samples");
    rk_check_close(rk_adaptive_predict(estimates, 2, INFINITY, 64, 0.5).samples, 32, 0, "no more");
}

enum { many = 500 };

static void make_estimates(rk_adaptive_estimate *estimates)
{
    for (uint32_t i = 0; i < many; i++)
        estimates[i] = (rk_adaptive_estimate){exp2f(20 * rk_unit_float(rk_case(i, 3, 0, 0)) - 20),
                                              4u << i % 5, 0};
}

static void lambda_reaches_the_variance_with_the_fewest_samples(void **state)
{
    (void)state;
    rk_adaptive_estimate estimates[many];
    make_estimates(estimates);
    /* The largest up to 0.1 %, and a little for rounding. */
    for (int i = 0; i < 32; i++) {
        const double want = exp2(-0.25 * i);
        float lambda = rk_adaptive_lambda(estimates, many, 1u << 20, 0.4, want, (double)INFINITY);
        rk_check(rk_adaptive_predict(estimates, many, lambda, 1u << 20, 0.4).variance <= want,
                 "variance %g is not reached by lambda %g", want, (double)lambda);
        rk_check(rk_adaptive_predict(estimates, many, 1.0011f * lambda, 1u << 20, 0.4).variance >
                     want,
                 "variance %g would be reached by a larger lambda than %g, by more than 0.1 %%",
                 want, (double)lambda);
    }
}

static void lambda_takes_no_more_samples_than_allowed(void **state)
{
    (void)state;
    rk_adaptive_estimate estimates[many];
    make_estimates(estimates);
    for (int i = 0; i < 8; i++) {
        const double samples = 8.0 * many * (1 << i);
        float lambda = rk_adaptive_lambda(estimates, many, 1u << 20, 0.4, 0, samples);
        rk_check(rk_adaptive_predict(estimates, many, lambda, 1u << 20, 0.4).samples >= samples,
                 "fewer than %g samples", samples);
        rk_check(rk_adaptive_predict(estimates, many, 1.002f * lambda, 1u << 20, 0.4).samples <
                     samples,
                 "more than %g samples", samples);
    }
}

static void lambda_is_the_smallest_if_nothing_suffices(void **state)
{
    (void)state;
    const rk_adaptive_estimate one = {1, 8, 0};
    rk_check_close(rk_adaptive_lambda(&one, 1, 64, 0.5, 1e-9, (double)INFINITY), 0x1p-149, 0,
                   "64 samples leave a variance of 1/64");
    const rk_adaptive_estimate none = {0, 8, 0};
    const float least_work = rk_adaptive_lambda(&none, 1, 64, 0.5, 0, (double)INFINITY);
    rk_check(least_work > 1e30f,
             "got lambda %g, want one above 1e30: without variance the least work suffices",
             (double)least_work);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_sample_is_added_to_the_block_of_its_quarter),
    cmocka_unit_test(the_samples_so_far_become_the_first_half),
    cmocka_unit_test(samples_in_rounds_are_those_at_once),
    cmocka_unit_test(the_mean_is_that_of_all_samples),
    cmocka_unit_test(differences_are_those_of_means),
    cmocka_unit_test(differences_are_means_over_the_channels),
    cmocka_unit_test(equal_samples_and_no_samples_do_not_differ),
    cmocka_unit_test(a_sample_that_is_no_number_counts_as_no_difference),
    cmocka_unit_test(the_ratio_is_between_an_eighth_and_a_half),
    cmocka_unit_test(later_doublings_are_nearer_to_a_half),
    cmocka_unit_test(variance_is_the_sum_of_the_series),
    cmocka_unit_test(error_is_relative_to_the_picture),
    cmocka_unit_test(a_sample_adds_its_deviation),
    cmocka_unit_test(own_variance_is_that_of_the_samples),
    cmocka_unit_test(no_samples_and_bad_ones_have_no_variance),
    cmocka_unit_test(noise_of_known_variance_is_measured),
    cmocka_unit_test(pooling_keeps_a_constant),
    cmocka_unit_test(pooled_variance_is_weighted_by_samples),
    cmocka_unit_test(neighbours_are_those_inside_the_picture),
    cmocka_unit_test(no_pixel_is_trusted_to_be_without_noise),
    cmocka_unit_test(the_count_is_the_ratio_of_deviations),
    cmocka_unit_test(the_count_is_the_nearest_power_of_two_by_logarithm),
    cmocka_unit_test(counts_have_limits),
    cmocka_unit_test(noisier_pixels_never_take_fewer_samples),
    cmocka_unit_test(no_allocation_of_as_many_samples_is_better),
    cmocka_unit_test(a_prediction_adds_up_pixels),
    cmocka_unit_test(a_prediction_is_exact_for_independent_samples),
    cmocka_unit_test(pixels_keep_the_samples_that_they_have),
    cmocka_unit_test(lambda_reaches_the_variance_with_the_fewest_samples),
    cmocka_unit_test(lambda_takes_no_more_samples_than_allowed),
    cmocka_unit_test(lambda_is_the_smallest_if_nothing_suffices),
};

RK_SUITE("adaptive_sampling", tests)
