/* The three kinds of samples: as evenly distributed as they claim, independent between pixels and
 * dimensions, and useful: their estimates have smaller errors. Seeds are fixed, so these tests
 * always give the same result; true randomness would exceed the statistical limits once in a
 * million times (z = 4.75). */
#include "test.h"

#include "base/sampler.h"

static const double z_limit = 4.75;

static const rk_sampler_kind kinds[3] = {RK_SAMPLER_UNIFORM, RK_SAMPLER_STRATIFIED,
                                         RK_SAMPLER_LOW_DISCREPANCY};
static const char *const kind_names[3] = {"uniform", "stratified", "low discrepancy"};

static rk_sampler sampler_of(rk_sampler_kind kind, uint32_t samples)
{
    return (rk_sampler){kind, 7, samples, 0};
}

/* --- numbers --------------------------------------------------------------------------------- */

static void uniform_samples_are_the_hash_of_their_place(void **state)
{
    (void)state;
    rk_sampler sampler = {.kind = RK_SAMPLER_UNIFORM, .seed = 3};
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec2 got = rk_sample_2d(&sampler, i, 2 * i, 5 * i);
        rk_check_close(got.x, rk_unit_float(rk_hash(3, i, 2 * i, 5 * i)), 0,
                       "pictures depend on it");
        rk_check_close(got.y, rk_unit_float(rk_hash(3, i, 2 * i, 5 * i + 1)), 0, "and on this");
    }
}

static void check_number(float x, const char *hint)
{
    rk_check(x >= 0 && x < 1, "%s: %.9g is not in [0, 1)", hint, (double)x);
    double steps = (double)x * 0x1p24;
    rk_check_close(steps, floor(steps), 0, "a multiple of 2^-24");
}

static void numbers_are_multiples_of_2_to_the_minus_24_below_one(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 2, 3, 7, 1000, 65536, 65537, 1000003, RK_SAMPLES_MAX};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (int k = 0; k < 3; k++)
            for (uint32_t i = 0; i < 3000; i++) {
                rk_sampler sampler = sampler_of(kinds[k], counts[c]);
                uint32_t sample = i % 2 ? counts[c] - 1 - i % counts[c] : i % counts[c];
                rk_vec2 pair = rk_sample_2d(&sampler, i, sample, 2);
                check_number(pair.x, kind_names[k]);
                check_number(pair.y, kind_names[k]);
                check_number(rk_sample_1d(&sampler, i, sample, 2), kind_names[k]);
            }
}

static void a_run_of_samples_is_the_samples_one_by_one(void **state)
{
    (void)state;
    enum { n = 1000 };
    for (int k = 0; k < 3; k++) {
        rk_sampler sampler = sampler_of(kinds[k], n);
        rk_vec2 run[n];
        for (uint32_t first = 0, count; first < n; first += count) {
            count = first % 97 + 1 < n - first ? first % 97 + 1 : n - first;
            rk_sample_2d_run(&sampler, 5, first, count, 8, run);
            for (uint32_t i = 0; i < count; i++) {
                rk_vec2 one = rk_sample_2d(&sampler, 5, first + i, 8);
                rk_check(run[i].x == one.x && run[i].y == one.y, "%s: sample %u differs",
                         kind_names[k], first + i);
            }
        }
    }
}

static void the_same_place_gives_the_same_numbers_in_any_order(void **state)
{
    (void)state;
    enum { n = 100 };
    for (int k = 0; k < 3; k++) {
        rk_sampler sampler = sampler_of(kinds[k], n);
        rk_vec2 forward[n];
        for (uint32_t i = 0; i < n; i++)
            forward[i] = rk_sample_2d(&sampler, 9, i, 4);
        for (uint32_t i = n; i-- > 0;) {
            rk_sample_1d(&sampler, 8, i, 3);
            rk_vec2 again = rk_sample_2d(&sampler, 9, i, 4);
            rk_check(again.x == forward[i].x && again.y == forward[i].y,
                     "%s: sample %u has changed: there is hidden state", kind_names[k], i);
        }
    }
}

/* --- stratified ------------------------------------------------------------------------------ */

static const uint32_t cell_counts[] = {1,  2,  3,  4,  5,  6,  7,   8,   9,    10,   12,   13,   16,
                                       17, 23, 25, 31, 48, 64, 100, 101, 1000, 4096, 5003, 65536};

enum { cell_count_count = sizeof cell_counts / sizeof *cell_counts };

/* Marks a cell; in double, where a product of two 24-bit numbers is exact. */
static void mark(unsigned char *seen, uint32_t cell, uint32_t n, uint32_t sample)
{
    rk_check(cell < n, "%u samples: sample %u is in cell %u", n, sample, cell);
    rk_check(!seen[cell], "%u samples: cell %u has a second one, sample %u", n, cell, sample);
    seen[cell] = 1;
}

static void one_sample_is_in_each_of_n_intervals(void **state)
{
    (void)state;
    for (int c = 0; c < cell_count_count; c++)
        for (uint32_t pixel = 0; pixel < 3; pixel++) {
            uint32_t n = cell_counts[c];
            unsigned char *seen = calloc(n, 1);
            rk_sampler sampler = sampler_of(RK_SAMPLER_STRATIFIED, n);
            for (uint32_t i = 0; i < n; i++)
                mark(seen, (uint32_t)((double)rk_sample_1d(&sampler, pixel, i, 5) * n), n, i);
            free(seen);
        }
}

/* The layout of base/sampler.c, written once more: rows of cells, as many as the root of n rounded
 * down, row j from cell j n / r on, each height proportional to its number of cells. */
static uint32_t cell_at(rk_vec2 p, uint32_t n)
{
    uint32_t rows = 1, row = 0;
    while ((rows + 1) * (rows + 1) <= n)
        rows++;
    uint32_t starts[300];
    for (uint32_t j = 0; j <= rows; j++)
        starts[j] = j * n / rows;
    while ((double)p.y * n >= starts[row + 1])
        row++;
    return starts[row] + (uint32_t)((double)p.x * (starts[row + 1] - starts[row]));
}

static void one_sample_is_in_each_of_n_cells_of_the_square(void **state)
{
    (void)state;
    for (int c = 0; c < cell_count_count; c++)
        for (uint32_t pixel = 0; pixel < 3; pixel++) {
            uint32_t n = cell_counts[c];
            unsigned char *seen = calloc(n, 1);
            rk_sampler sampler = sampler_of(RK_SAMPLER_STRATIFIED, n);
            for (uint32_t i = 0; i < n; i++)
                mark(seen, cell_at(rk_sample_2d(&sampler, pixel, i, 5), n), n, i);
            free(seen);
        }
}

static void square_counts_make_square_cells(void **state)
{
    (void)state;
    for (uint32_t side = 1; side <= 20; side++) {
        const uint32_t n = side * side;
        unsigned char seen[400] = {0};
        rk_sampler sampler = sampler_of(RK_SAMPLER_STRATIFIED, n);
        for (uint32_t i = 0; i < n; i++) {
            rk_vec2 p = rk_sample_2d(&sampler, 1, i, 0);
            mark(seen, (uint32_t)((double)p.y * side) * side + (uint32_t)((double)p.x * side), n,
                 i);
        }
    }
}

/* Chi-squared as a normal deviate (Wilson and Hilferty, "The distribution of chi-square", 1931). */
static double deviate(const unsigned *counts, int cells, double draws)
{
    double want = draws / cells, chi = 0, f = cells - 1;
    for (int i = 0; i < cells; i++)
        chi += (counts[i] - want) * (counts[i] - want) / want;
    return (cbrt(chi / f) - (1 - 2 / (9 * f))) / sqrt(2 / (9 * f));
}

static void check_even(const unsigned *counts, int cells, double draws, const char *hint)
{
    double z = deviate(counts, cells, draws);
    /* Being too even is no fault: strata are meant to be. */
    rk_check(z <= z_limit, "z = %.2f, limit %.2f: %s", z, z_limit, hint);
}

static void cells_come_in_every_order_equally_often(void **state)
{
    (void)state;
    enum { n = 5, orders = 120, draws = 1 << 17 };
    unsigned counts[orders] = {0};
    rk_sampler sampler = sampler_of(RK_SAMPLER_STRATIFIED, n);
    for (uint32_t pixel = 0; pixel < draws; pixel++) {
        int cell[n], code = 0;
        for (uint32_t i = 0; i < n; i++)
            cell[i] = (int)(rk_sample_1d(&sampler, pixel, i, 0) * n);
        /* The permutation's number, in the factorial number system. */
        for (int i = 0; i < n; i++) {
            int smaller = 0;
            for (int j = i + 1; j < n; j++)
                smaller += cell[j] < cell[i];
            code = code * (n - i) + smaller;
        }
        counts[code]++;
    }
    check_even(counts, orders, draws, "the 120 orders of 5 cells");
}

static void two_samples_are_in_any_two_cells_equally_often(void **state)
{
    (void)state;
    enum { draws = 1 << 17, most = 37 };
    const uint32_t counts_of_cells[] = {8, 16, 25, most};
    for (int c = 0; c < 4; c++) {
        const uint32_t n = counts_of_cells[c];
        unsigned counts[most * (most - 1)] = {0};
        rk_sampler sampler = sampler_of(RK_SAMPLER_STRATIFIED, n);
        for (uint32_t pixel = 0; pixel < draws; pixel++) {
            uint32_t a = (uint32_t)((double)rk_sample_1d(&sampler, pixel, 0, 6) * n);
            uint32_t b = (uint32_t)((double)rk_sample_1d(&sampler, pixel, n / 2, 6) * n);
            counts[a * (n - 1) + b - (b > a)]++;
        }
        check_even(counts, (int)(n * (n - 1)), draws, "the cells of the first and a middle sample");
    }
}

/* --- low discrepancy ------------------------------------------------------------------------- */

/* The first 2^k samples, for every k, have one in each cell of 2^-a x 2^-b with a + b = k. */
static void every_power_of_two_is_stratified_in_all_elementary_intervals(void **state)
{
    (void)state;
    enum { k_max = 12 };
    static unsigned char seen[1 << k_max];
    static rk_vec2 points[1 << k_max];
    rk_sampler sampler = sampler_of(RK_SAMPLER_LOW_DISCREPANCY, 0);
    for (uint32_t pixel = 0; pixel < 20; pixel++) {
        for (uint32_t i = 0; i < 1 << k_max; i++)
            points[i] = rk_sample_2d(&sampler, pixel * pixel, i, 2 * pixel);
        for (uint32_t k = 0; k <= k_max; k++)
            for (uint32_t a = 0; a <= k; a++) {
                memset(seen, 0, sizeof seen);
                for (uint32_t i = 0; i < 1u << k; i++) {
                    uint32_t x = (uint32_t)ldexpf(points[i].x, (int)a);
                    uint32_t y = (uint32_t)ldexpf(points[i].y, (int)(k - a));
                    mark(seen, y << a | x, 1u << k, i);
                }
            }
    }
}

static void single_dimensions_are_stratified_for_every_power_of_two(void **state)
{
    (void)state;
    enum { k_max = 14 };
    static unsigned char seen[1 << k_max];
    rk_sampler sampler = sampler_of(RK_SAMPLER_LOW_DISCREPANCY, 0);
    for (uint32_t pixel = 0; pixel < 20; pixel++)
        for (uint32_t k = 0; k <= k_max; k++) {
            memset(seen, 0, sizeof seen);
            for (uint32_t i = 0; i < 1u << k; i++) {
                float x = rk_sample_1d(&sampler, pixel, i, 9);
                mark(seen, (uint32_t)ldexpf(x, (int)k), 1u << k, i);
            }
        }
}

/* Owen's scrambling swaps the halves of every interval by a coin of its own. These are the coins of
 * the 31 largest intervals: does the half with the lower number have the even sample? Each coin is
 * fair, and no two are correlated. */
static void halves_are_swapped_by_independent_coins(void **state)
{
    (void)state;
    enum { draws = 1 << 16, levels = 5, coins = (1 << levels) - 1, n = 1 << levels };
    static int together[coins][coins]; /* heads less tails, and equal less different */
    rk_sampler sampler = sampler_of(RK_SAMPLER_LOW_DISCREPANCY, n);
    for (uint32_t pixel = 0; pixel < draws; pixel++) {
        /* The sample in each interval of 1 / n; a parent's is the lower one of its children's. */
        uint32_t in[2 * n];
        for (uint32_t i = 0; i < n; i++)
            in[n + (uint32_t)(rk_sample_1d(&sampler, pixel, i, 1) * n)] = i;
        int coin[n];
        for (uint32_t node = n - 1; node >= 1; node--) {
            bool swapped = in[2 * node] > in[2 * node + 1];
            in[node] = swapped ? in[2 * node + 1] : in[2 * node];
            coin[node] = swapped ? 1 : -1;
        }
        for (int a = 0; a < coins; a++)
            for (int b = 0; b <= a; b++)
                together[a][b] += b == a ? coin[a + 1] : coin[a + 1] * coin[b + 1];
    }
    for (int a = 0; a < coins; a++)
        for (int b = 0; b <= a; b++)
            rk_check_close(together[a][b], 0, z_limit * sqrt(draws),
                           b == a ? "a coin is not fair" : "two coins are related");
}

/* --- all kinds: uniform and independent ------------------------------------------------------ */

enum { side = 16, draws = 1 << 16, samples = 12 };

static void fill(unsigned *counts, float x, float y)
{
    counts[(int)(y * side) * side + (int)(x * side)]++;
}

static void each_sample_alone_is_uniform_over_pixels(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++)
        for (uint32_t sample = 0; sample < samples; sample++) {
            unsigned in_square[side * side] = {0}, in_line[side * side] = {0};
            rk_sampler sampler = sampler_of(kinds[k], samples);
            for (uint32_t pixel = 0; pixel < draws; pixel++) {
                rk_vec2 p = rk_sample_2d(&sampler, pixel, sample, 4);
                fill(in_square, p.x, p.y);
                in_line[(int)(rk_sample_1d(&sampler, pixel, sample, 4) * side * side)]++;
            }
            check_even(in_square, side * side, draws, kind_names[k]);
            check_even(in_line, side * side, draws, kind_names[k]);
        }
}

/* With 7 samples, cells have unequal widths but equal areas: no point is preferred. */
static void all_samples_together_are_uniform(void **state)
{
    (void)state;
    const uint32_t counts_of_samples[] = {2, 3, 7, 11, 16};
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 5; c++) {
            unsigned counts[side * side] = {0};
            uint32_t n = counts_of_samples[c], pixels = draws / n;
            rk_sampler sampler = sampler_of(kinds[k], n);
            for (uint32_t i = 0; i < pixels * n; i++) {
                rk_vec2 p = rk_sample_2d(&sampler, i / n, i % n, 8);
                fill(counts, p.x, p.y);
            }
            check_even(counts, side * side, pixels * n, kind_names[k]);
        }
}

/* Fills the square with pairs of numbers from two dimensions or pixels, over many pixels, for the
 * first four samples, where strata would show a correlation first. */
static void check_unrelated(int kind, uint32_t pixel_offset, uint32_t dimension_offset,
                            uint32_t seed_offset)
{
    for (uint32_t sample = 0; sample < 4; sample++) {
        unsigned xx[side * side] = {0}, xy[side * side] = {0}, lines[side * side] = {0};
        rk_sampler a = sampler_of(kinds[kind], 4), b = a;
        b.seed += seed_offset;
        for (uint32_t pixel = 0; pixel < draws; pixel++) {
            rk_vec2 p = rk_sample_2d(&a, pixel, sample, 2);
            rk_vec2 q = rk_sample_2d(&b, pixel + pixel_offset, sample, 2 + dimension_offset);
            fill(xx, p.x, q.x);
            fill(xy, p.x, q.y);
            fill(lines, rk_sample_1d(&a, pixel, sample, 2),
                 rk_sample_1d(&b, pixel + pixel_offset, sample, 2 + dimension_offset));
        }
        char hint[100];
        snprintf(hint, sizeof hint, "%s, sample %u: related %u pixels, %u dimensions, %u seeds on",
                 kind_names[kind], sample, pixel_offset, dimension_offset, seed_offset);
        check_even(xx, side * side, draws, hint);
        check_even(xy, side * side, draws, hint);
        check_even(lines, side * side, draws, hint);
    }
}

static void pixels_dimensions_and_seeds_are_unrelated(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        check_unrelated(kind, 0, 2, 0);
        check_unrelated(kind, 0, 4, 0);
        check_unrelated(kind, 1, 0, 0);
        check_unrelated(kind, 800, 0, 0);
        check_unrelated(kind, 0, 0, 1);
    }
}

/* Within a pixel, the first number of one pair must be independent of that of another. The mean of
 * their products over n samples, both minus 1/2, then has the variance 1 / 144 n. Samples in the
 * same order would make it n / 4 times that, or more. Stratified samples have n / (n - 1) of it; a
 * scrambled order, which decides in blocks of 2 for the first digit, 4 for the second, and so on,
 * twice as much. */
static void dimensions_of_a_pixels_samples_are_unrelated(void **state)
{
    (void)state;
    const uint32_t n = 16, pixels = draws;
    for (int kind = 0; kind < 3; kind++) {
        double squares = 0;
        rk_sampler sampler = sampler_of(kinds[kind], n);
        for (uint32_t pixel = 0; pixel < pixels; pixel++) {
            double mean = 0;
            for (uint32_t i = 0; i < n; i++)
                mean += ((double)rk_sample_2d(&sampler, pixel, i, 0).x - 0.5) *
                        ((double)rk_sample_2d(&sampler, pixel, i, 2).x - 0.5) / n;
            squares += mean * mean / pixels;
        }
        const double limits[3] = {1, (double)n / (n - 1), 2};
        /* A variance from 65,536 nearly normal means has a relative standard error of .55 %. */
        rk_check(144 * n * squares <= limits[kind] * (1 + z_limit * 0.0055),
                 "%s: the products' variance is %.2f times that of independent numbers, limit %.2f",
                 kind_names[kind], 144 * n * squares, limits[kind]);
    }
}

/* --- errors of estimates --------------------------------------------------------------------- */

typedef double integrand(double x, double y);

static double ramp(double x, double y)
{
    return x + y;
}

static double smooth(double x, double y)
{
    return exp(-x) * sin(3 * y);
}

static double edge(double x, double y)
{
    return 2 * x + 3 * y < 2.3;
}

/* The variance of the mean of n samples, measured over 20,000 pixels. */
static double variance(integrand *f, rk_sampler_kind kind, uint32_t n)
{
    const uint32_t pixels = 20000;
    double sum = 0, squares = 0;
    rk_sampler sampler = sampler_of(kind, n);
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        double mean = 0;
        for (uint32_t i = 0; i < n; i++) {
            rk_vec2 p = rk_sample_2d(&sampler, pixel, i, 0);
            mean += f((double)p.x, (double)p.y) / n;
        }
        sum += mean, squares += mean * mean;
    }
    return squares / pixels - (sum / pixels) * (sum / pixels);
}

/* The ratio of the variance of uniform samples, 1 / n of a single sample's, to the measured one. */
static double gain(integrand *f, double variance_of_one, rk_sampler_kind kind, uint32_t n)
{
    return variance_of_one / n / variance(f, kind, n);
}

/* A variance from 20,000 nearly normal means has a relative standard error of 1 %. */
static const double of_a_variance = 4.75 * 0.01;

static void uniform_samples_have_the_error_of_independent_ones(void **state)
{
    (void)state;
    for (uint32_t n = 4; n <= 64; n *= 4)
        rk_check_close(gain(ramp, 1.0 / 6, RK_SAMPLER_UNIFORM, n), 1, of_a_variance, "1 / n");
}

static void stratified_variance_of_a_ramp_falls_as_one_over_n_squared(void **state)
{
    (void)state;
    /* In square cells of side n^-1/2 the variance of x + y is 1 / 6 n, so the mean's is 1 / 6 n^2:
     * 1 / n of the uniform one's. */
    for (uint32_t n = 4; n <= 64; n *= 4)
        rk_check_close(gain(ramp, 1.0 / 6, RK_SAMPLER_STRATIFIED, n) / n, 1, of_a_variance,
                       "the gain over n");
}

static void low_discrepancy_variance_of_a_ramp_falls_as_one_over_n_cubed(void **state)
{
    (void)state;
    /* x alone has a sample in each of n intervals: its mean's variance is 1 / 12 n^3, and so is
     * y's. Their sum is the whole only if the swaps in x and y are independent. */
    for (uint32_t n = 4; n <= 64; n *= 4)
        rk_check_close(gain(ramp, 1.0 / 6, RK_SAMPLER_LOW_DISCREPANCY, n) / (n * n), 1,
                       of_a_variance, "the gain over n^2");
}

/* In a cell of side h the variance of f is |grad f|^2 h^2 / 12, so strata divide a single sample's
 * variance by n and again by 12 var f n / mean |grad f|^2. 16 cells are small enough for an
 * accuracy of 2 %. Both means have closed forms. */
static void stratified_variance_of_a_smooth_function_follows_its_slope(void **state)
{
    (void)state;
    double exp_squared = (1 - exp(-2)) / 2, sin_squared = 0.5 - sin(6) / 12;
    double mean = (1 - exp(-1)) * (1 - cos(3)) / 3;
    double one = exp_squared * sin_squared - mean * mean;
    double slope_squared = exp_squared * (sin_squared + 9 * (1 - sin_squared));
    for (uint32_t n = 16; n <= 256; n *= 4)
        rk_check_close(gain(smooth, one, RK_SAMPLER_STRATIFIED, n) / (12 * one * n / slope_squared),
                       1, of_a_variance + 0.02, "the gain over what it should be");
}

static void check_gain(integrand *f, rk_sampler_kind kind, uint32_t n, double least)
{
    double got = gain(f, variance(f, RK_SAMPLER_UNIFORM, 1), kind, n);
    rk_check(got >= least, "%s, %u samples: the variance is 1 / %.1f of the uniform one, want %.1f",
             kind_names[kind], n, got, least);
}

/* By Owen's theorem ("Scrambled net variance for integrals of smooth functions", 1997), the
 * variance falls as n^-3 log n, so the gain grows as n^2 / log n: from 16 to 256 samples by a
 * factor of 128. The limits have that ratio; the measured gains are 36 and 5,200. */
static void low_discrepancy_beats_strata_for_a_smooth_function(void **state)
{
    (void)state;
    check_gain(smooth, RK_SAMPLER_LOW_DISCREPANCY, 16, 30);
    check_gain(smooth, RK_SAMPLER_LOW_DISCREPANCY, 256, 30 * 128);
}

/* An edge crosses about n^1/2 of n cells, and only these have errors: the gain grows with n^1/2. */
static void an_edges_variance_falls_by_the_root_of_n_for_both(void **state)
{
    (void)state;
    for (uint32_t n = 16; n <= 256; n *= 4)
        for (int k = 1; k < 3; k++)
            check_gain(edge, kinds[k], n, sqrt(n));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(uniform_samples_are_the_hash_of_their_place),
    cmocka_unit_test(numbers_are_multiples_of_2_to_the_minus_24_below_one),
    cmocka_unit_test(the_same_place_gives_the_same_numbers_in_any_order),
    cmocka_unit_test(a_run_of_samples_is_the_samples_one_by_one),
    cmocka_unit_test(one_sample_is_in_each_of_n_intervals),
    cmocka_unit_test(one_sample_is_in_each_of_n_cells_of_the_square),
    cmocka_unit_test(square_counts_make_square_cells),
    cmocka_unit_test(cells_come_in_every_order_equally_often),
    cmocka_unit_test(two_samples_are_in_any_two_cells_equally_often),
    cmocka_unit_test(every_power_of_two_is_stratified_in_all_elementary_intervals),
    cmocka_unit_test(single_dimensions_are_stratified_for_every_power_of_two),
    cmocka_unit_test(halves_are_swapped_by_independent_coins),
    cmocka_unit_test(each_sample_alone_is_uniform_over_pixels),
    cmocka_unit_test(all_samples_together_are_uniform),
    cmocka_unit_test(pixels_dimensions_and_seeds_are_unrelated),
    cmocka_unit_test(dimensions_of_a_pixels_samples_are_unrelated),
    cmocka_unit_test(uniform_samples_have_the_error_of_independent_ones),
    cmocka_unit_test(stratified_variance_of_a_ramp_falls_as_one_over_n_squared),
    cmocka_unit_test(low_discrepancy_variance_of_a_ramp_falls_as_one_over_n_cubed),
    cmocka_unit_test(stratified_variance_of_a_smooth_function_follows_its_slope),
    cmocka_unit_test(low_discrepancy_beats_strata_for_a_smooth_function),
    cmocka_unit_test(an_edges_variance_falls_by_the_root_of_n_for_both),
};

RK_SUITE("sampler", tests)
