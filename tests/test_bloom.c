/* Bloom: weights against rows of Pascal's triangle in big integers, the separable filter against
 * the full one in double, borders against sums worked out by hand. */
#include "test.h"

#include "base/random.h"
#include "features/bloom.h"

/* --- What is tried ---------------------------------------------------------------------------- */

static const rk_vec3 white = {1, 1, 1};

/* Roundings of a few operations on numbers of order one, each 2^-24. */
static const double few_roundings = 8 * 0x1p-24;

static rk_vec3 random_colour(uint32_t i)
{
    return rk_vec(rk_unit_float(rk_hash(i, 0, 0, 1)), rk_unit_float(rk_hash(i, 1, 0, 1)),
                  rk_unit_float(rk_hash(i, 2, 0, 1)));
}

static rk_bloom_filter filter_of(const float *weights, uint32_t reach, rk_bloom_border border)
{
    return (rk_bloom_filter){reach, weights, border};
}

/* --- Luminance and threshold ------------------------------------------------------------------ */

static void luminance_weighs_green_most(void **state)
{
    (void)state;
    rk_check_close(rk_bloom_luminance(rk_vec(1, 0, 0)), 0.2126, few_roundings, "red");
    rk_check_close(rk_bloom_luminance(rk_vec(0, 1, 0)), 0.7152, few_roundings, "green");
    rk_check_close(rk_bloom_luminance(rk_vec(0, 0, 1)), 0.0722, few_roundings, "blue");
    rk_check_close(rk_bloom_luminance(rk_vec(3, 2, 1)), 3 * 0.2126 + 2 * 0.7152 + 0.0722,
                   3 * few_roundings, "and their sum");
}

static void the_luminance_of_a_grey_is_the_grey(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        float grey = i == 0 ? 1 : 2 * rk_unit_float(rk_hash(i, 0, 0, 2));
        float got = rk_bloom_luminance(rk_vec(grey, grey, grey));
        rk_check(got == grey,
                 "grey %.9g has the luminance %.9g: roundings must not push it below "
                 "a threshold that it meets",
                 (double)grey, (double)got);
    }
}

static void a_pixel_at_the_threshold_glows(void **state)
{
    (void)state;
    rk_check(rk_bloom_glows(white, 1), "white at a threshold of 1: only what is below goes dark");
    rk_check(!rk_bloom_glows(white, nextafterf(1, 2)), "white just below the threshold");
    rk_check(rk_bloom_glows(white, 0.5f) && !rk_bloom_glows(rk_vec(0.49f, 0.49f, 0.49f), 0.5f),
             "above and below a threshold of .5");
    rk_check(rk_bloom_glows(rk_vec(0, 0.75f, 0), 0.5f), "green of .75 has a luminance of .536");
    rk_check(!rk_bloom_glows(rk_vec(1, 0, 1), 0.5f), "magenta has a luminance of .285");
}

static void what_is_not_finite_never_glows(void **state)
{
    (void)state;
    const rk_vec3 odd[] = {{NAN, NAN, NAN},
                           {NAN, 1, 1},
                           {1, 1, NAN},
                           {INFINITY, 1, 1},
                           {1, INFINITY, 1},
                           {0, 0, INFINITY},
                           {1, NAN, 1},
                           {INFINITY, -INFINITY, 0},
                           {INFINITY, INFINITY, INFINITY}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
        rk_check(!rk_bloom_glows(odd[i], 0.5f),
                 "(%g, %g, %g) would make all pixels around it infinite, or NaN", (double)odd[i].x,
                 (double)odd[i].y, (double)odd[i].z);
}

static void check_lit(const rk_vec3 *row, size_t width, size_t first, size_t end, const char *hint)
{
    rk_bloom_span lit = rk_bloom_lit(row, width, 0.5f);
    if (first == end)
        rk_check_equal(lit.end - lit.first, 0, hint);
    else
        rk_check(lit.first == first && lit.end == end, "from %zu to %zu, want %zu to %zu: %s",
                 lit.first, lit.end, first, end, hint);
}

static void lit_is_from_the_first_to_the_last_pixel_that_glows(void **state)
{
    (void)state;
    rk_vec3 row[9] = {{0, 0, 0}};
    check_lit(row, 9, 0, 0, "nothing glows");
    row[3] = white;
    check_lit(row, 9, 3, 4, "one pixel");
    row[6] = white;
    check_lit(row, 9, 3, 7, "two, and what is between");
    row[0] = row[8] = white;
    check_lit(row, 9, 0, 9, "the ends belong to the row");
    check_lit(row + 8, 1, 0, 1, "a row of one");
    check_lit(row, 0, 0, 0, "a row of none");
}

/* --- The mask --------------------------------------------------------------------------------- */

static void the_mask_keeps_what_glows_and_nothing_else(void **state)
{
    (void)state;
    enum { width = 50 };
    const rk_bloom_filter alone = filter_of((const float[]){1}, 0, RK_BLOOM_ZERO);
    rk_vec3 row[width], masked[width];
    for (uint32_t x = 0; x < width; x++)
        row[x] = random_colour(x);
    memset(masked, 0x55, sizeof masked);
    rk_bloom_mask(&alone, row, width, 0.5f, rk_bloom_lit(row, width, 0.5f), 0, width, masked);
    for (uint32_t x = 0; x < width; x++) {
        double luminance =
            0.2126 * (double)row[x].x + 0.7152 * (double)row[x].y + 0.0722 * (double)row[x].z;
        rk_vec3 want = luminance >= 0.5 ? row[x] : rk_vec(0, 0, 0);
        rk_check(memcmp(&masked[x], &want, sizeof want) == 0,
                 "pixel %u: (%g, %g, %g), want (%g, %g, %g): colours that glow stay as they are", x,
                 (double)masked[x].x, (double)masked[x].y, (double)masked[x].z, (double)want.x,
                 (double)want.y, (double)want.z);
    }
}

/* A row of ten greys, of which those from 6 on glow, seen by a filter that reaches 4 pixels. */
static void check_mask(rk_bloom_border border, size_t from, size_t count, const float *want,
                       const char *hint)
{
    const float weights[5] = {1, 0, 0, 0, 0};
    const rk_bloom_filter filter = filter_of(weights, 4, border);
    rk_vec3 row[10], masked[32];
    for (int x = 0; x < 10; x++)
        row[x] = rk_scale(white, (float)x);
    memset(masked, 0x55, sizeof masked);
    rk_bloom_mask(&filter, row, 10, 6, rk_bloom_lit(row, 10, 6), from, count, masked);
    for (size_t i = 0; i < count + 8; i++)
        rk_check(masked[i].x == want[i] && masked[i].z == want[i],
                 "from %zu, %zu pixels: entry %zu is %g, want %g: %s", from, count, i,
                 (double)masked[i].x, (double)want[i], hint);
    rk_check(memcmp(&masked[count + 8], &masked[31], sizeof *masked) == 0,
             "the mask is count + 2 reach pixels long");
}

static void beyond_the_border_the_mask_is_zero(void **state)
{
    (void)state;
    const float all[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 7, 8, 9, 0, 0, 0, 0};
    check_mask(RK_BLOOM_ZERO, 0, 10, all, "4 beyond each border");
    check_mask(RK_BLOOM_RENORMALIZE, 0, 10, all, "renormalising does not change the mask");
    check_mask(RK_BLOOM_ZERO, 5, 2, all + 5, "a part of the row");
    check_mask(RK_BLOOM_ZERO, 4, 3, all + 4, "a part whose mask begins at the border");
    check_mask(RK_BLOOM_ZERO, 8, 2, all + 8, "a part at the right border");
}

static void clamping_repeats_the_borders_own_pixel(void **state)
{
    (void)state;
    const float all[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 7, 8, 9, 9, 9, 9, 9};
    check_mask(RK_BLOOM_CLAMP, 0, 10, all, "the left border is dark, the right one is 9");
    check_mask(RK_BLOOM_CLAMP, 8, 2, all + 8, "a part at the right border");
    check_mask(RK_BLOOM_CLAMP, 3, 4, all + 3, "a part that sees one pixel beyond the left border");
    const float weights[5] = {1, 0, 0, 0, 0};
    const rk_bloom_filter filter = filter_of(weights, 4, RK_BLOOM_CLAMP);
    rk_vec3 pixel = white, masked[9];
    rk_bloom_mask(&filter, &pixel, 1, 0.5f, (rk_bloom_span){0, 1}, 0, 1, masked);
    for (int i = 0; i < 9; i++)
        rk_check_equal(masked[i].y, 1, "a row of one pixel is all border");
}

/* --- Weights ---------------------------------------------------------------------------------- */

static void small_filters_are_those_of_pascals_triangle(void **state)
{
    (void)state;
    const float want[4][4] = {{1},
                              {2 / 4.0f, 1 / 4.0f},
                              {6 / 16.0f, 4 / 16.0f, 1 / 16.0f},
                              {20 / 64.0f, 15 / 64.0f, 6 / 64.0f, 1 / 64.0f}};
    for (uint32_t radius = 0; radius < 4; radius++) {
        float weights[4];
        rk_bloom_weights(radius, weights);
        for (uint32_t k = 0; k <= radius; k++)
            rk_check(weights[k] == want[radius][k], "radius %u, weight %u: got %.9g, want %.9g",
                     radius, k, (double)weights[k], (double)want[radius][k]);
    }
}

enum { big_words = 64 }; /* of 32 bits: C(2000, 1000) has 1995 bits */

typedef struct big {
    uint32_t words[big_words]; /* the lowest first */
} big;

static void add_to(big *sum, const big *part, int words)
{
    uint64_t carry = 0;
    for (int i = 0; i < words; i++) {
        carry += (uint64_t)sum->words[i] + part->words[i];
        sum->words[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

static int bit_of(const big *b, int i)
{
    return i < 0 ? 0 : (int)(b->words[i / 32] >> (i % 32) & 1);
}

/* The float nearest to b / 4^radius, ties to the even one. */
static float nearest_float(const big *b, int radius)
{
    int top = 32 * big_words - 1;
    while (!bit_of(b, top))
        top--;
    /* The unit in the last place is 2^exponent, or 2^lowest bits of b. */
    int exponent = top - 2 * radius - 23 > -149 ? top - 2 * radius - 23 : -149;
    int lowest = exponent + 2 * radius;
    uint32_t digits = 0;
    for (int i = top; i >= lowest; i--)
        digits = 2 * digits + (uint32_t)bit_of(b, i);
    bool more_than_half = false;
    for (int i = lowest - 2; i >= 0; i--)
        more_than_half |= bit_of(b, i);
    if (lowest - 1 <= top && bit_of(b, lowest - 1) && (more_than_half || digits % 2))
        digits++;
    return ldexpf((float)digits, exponent);
}

/* Goes down Pascal's triangle, in place, and compares rows 2 r. Half of each row is enough. */
static void weights_are_pascals_rows_to_the_last_bit(void **state)
{
    (void)state;
    static big row[1001]; /* C(n, 0) .. C(n, n / 2) */
    memset(row, 0, sizeof row);
    row[0].words[0] = 1;
    float weights[1001];
    for (uint32_t n = 1; n <= 2000; n++) {
        if (n % 2 == 0) /* the middle has grown on both sides alike */
            row[n / 2] = row[n / 2 - 1];
        for (uint32_t k = n / 2; k > 0; k--)
            add_to(&row[k], &row[k - 1], (int)(n / 32) + 1);
        uint32_t radius = n / 2;
        if (n % 2 || (radius > 60 && radius != 100 && radius != 250 && radius != 1000))
            continue;
        rk_bloom_weights(radius, weights);
        for (uint32_t k = 0; k <= radius; k++) {
            float want = nearest_float(&row[radius - k], (int)radius);
            rk_check(weights[k] == want, "radius %u, weight %u: got %a, want C(%u, %u) / 4^%u = %a",
                     radius, k, (double)weights[k], n, radius - k, radius, (double)want);
        }
    }
}

static void the_weights_of_any_radius_sum_to_one(void **state)
{
    (void)state;
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    const uint32_t radii[] = {0, 1, 2, 15, 60, 100, 500, 513, 537, 538, 1000, RK_BLOOM_RADIUS_MAX};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++) {
        rk_bloom_weights(radii[i], weights);
        double sum = (double)weights[0];
        for (uint32_t k = 1; k <= radii[i]; k++)
            sum += 2 * (double)weights[k];
        /* Each is rounded by at most 2^-24 of itself; those too small for a float are no loss. */
        rk_check(fabs(sum - 1) <= 0x1p-24 + 1e-30, "radius %u: the weights sum to %.12g", radii[i],
                 sum);
    }
}

static void the_variance_is_half_the_radius(void **state)
{
    (void)state;
    const uint32_t radii[] = {1, 15, 100, 1000};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++) {
        float weights[1001];
        rk_bloom_weights(radii[i], weights);
        double sum = 0;
        for (uint32_t k = 1; k <= radii[i]; k++)
            sum += 2 * (double)weights[k] * k * k;
        rk_check_close(sum, 0.5 * radii[i], 0x1p-23 * radii[i], "the sum of 2 r coins' variances");
    }
}

/* --- The weights that matter ------------------------------------------------------------------ */

static double left_out(const float *weights, uint32_t reach, uint32_t radius)
{
    double sum = 0;
    for (uint32_t k = radius; k > reach; k--)
        sum += 2 * (double)weights[k];
    return sum;
}

static void what_the_reach_leaves_out_is_half_an_ulp_at_most(void **state)
{
    (void)state;
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    for (uint32_t radius = 0; radius <= RK_BLOOM_RADIUS_MAX; radius += 1 + radius / 8) {
        rk_bloom_weights(radius, weights);
        uint32_t reach = rk_bloom_reach(radius, weights);
        rk_check(reach <= radius, "radius %u: a reach of %u", radius, reach);
        rk_check(left_out(weights, reach, radius) <= 0x1p-25,
                 "radius %u, reach %u: the weights beyond sum to %.3g, more than 2^-25", radius,
                 reach, left_out(weights, reach, radius));
    }
}

static void the_reach_is_as_short_as_it_can_be(void **state)
{
    (void)state;
    static float weights[RK_BLOOM_RADIUS_MAX + 1];
    for (uint32_t radius = 1; radius <= RK_BLOOM_RADIUS_MAX; radius += 1 + radius / 8) {
        rk_bloom_weights(radius, weights);
        uint32_t reach = rk_bloom_reach(radius, weights);
        rk_check(reach > 0 && left_out(weights, reach - 1, radius) > 0x1p-25,
                 "radius %u: a reach of %u would do, not %u", radius, reach - 1, reach);
    }
    rk_bloom_weights(1000, weights);
    uint32_t reach = rk_bloom_reach(1000, weights);
    rk_check(reach < 130, "radius 1000: the reach is %u, about 3.9 sqrt(1000) is enough", reach);
}

/* --- Sums of lines ---------------------------------------------------------------------------- */

enum { line_length = 3 * RK_BLOOM_BLOCK };

/* Lines of one number each, of which some are missing, against the sum in double. */
static void check_sum(uint32_t reach, uint32_t present, const char *hint)
{
    static float storage[33][line_length], sum[line_length];
    const float *lines[33];
    float weights[17];
    double want = 0, want_last = 0, size = 0;
    uint32_t taps = 0;
    for (uint32_t k = 0; k <= reach; k++)
        weights[k] = 1 + rk_unit_float(rk_hash(k, reach, 0, 3));
    for (uint32_t k = 0; k <= 2 * reach; k++) {
        bool there = present >> k % 32 & 1;
        uint32_t away = k < reach ? reach - k : k - reach;
        float value = rk_unit_float(rk_hash(k, reach, 1, 3));
        for (size_t i = 0; i < line_length; i++)
            storage[k][i] = i == line_length - 1 ? 2 * value : value;
        lines[k] = there ? storage[k] : NULL;
        taps += there;
        want += there ? (double)weights[away] * (double)value : 0;
        want_last += there ? (double)weights[away] * 2 * (double)value : 0;
        size += 2 * (double)weights[away];
    }
    const rk_bloom_filter filter = filter_of(weights, reach, RK_BLOOM_ZERO);
    memset(sum, 0x55, sizeof sum);
    uint32_t got = rk_bloom_weigh(&filter, lines, line_length, sum);
    /* Each term is rounded three times, and the sum once a term. */
    double tolerance = (2 * reach + 4) * 0x1p-24 * size;
    rk_check_close(sum[0], want, tolerance, hint);
    rk_check_close(sum[RK_BLOOM_BLOCK], want, tolerance, "the second block of the lines");
    rk_check_close(sum[line_length - 1], want_last, 2 * tolerance, "the last float of the lines");
    rk_check_equal(got, taps, "the lines that are not NULL are counted");
}

static void a_line_alone_is_weighed_by_its_distance(void **state)
{
    (void)state;
    for (uint32_t k = 0; k <= 8; k++)
        check_sum(4, 1u << k, "one line of nine");
    check_sum(0, 1, "a filter that sees nothing but the pixel itself");
}

static void all_lines_are_summed(void **state)
{
    (void)state;
    for (uint32_t reach = 0; reach <= 15; reach++)
        check_sum(reach, UINT32_MAX, "all lines");
}

static void lines_that_are_null_are_zeros(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 200; i++)
        check_sum(i % 16, rk_hash(i, 0, 0, 4), "some lines");
    check_sum(7, 0, "no line at all");
}

static void weighing_asks_for_no_memory(void **state)
{
    (void)state;
    size_t before = rk_allocations;
    check_sum(15, UINT32_MAX, "all lines");
    rk_check(!rk_allocations_are_counted || rk_allocations == before,
             "a sum of lines stands in the innermost loop");
}

static void the_glow_is_added_times_its_gain(void **state)
{
    (void)state;
    for (size_t count = 0; count <= 100; count++) {
        float pixels[101], glow[101];
        for (size_t i = 0; i <= 100; i++) {
            pixels[i] = (float)i;
            glow[i] = 1;
        }
        rk_bloom_add(pixels, glow, count, 0.5f);
        for (size_t i = 0; i <= 100; i++)
            rk_check(pixels[i] == (float)i + (i < count ? 0.5f : 0),
                     "float %zu of %zu: got %g, want %g + .5 x 1 before the end", i, count,
                     (double)pixels[i], (double)i);
    }
}

/* --- Whole pictures --------------------------------------------------------------------------- */

enum { width = 37, height = 29, room = 144 }; /* 3 * 37 floats, in whole blocks */

typedef struct picture {
    rk_vec3 pixels[height][width];
} picture;

/* The plainest use of the unit: every row, then every column, with all their taps. */
static void bloom(picture *p, const rk_bloom_filter *filter, float threshold, float intensity)
{
    static float across[height][room], masked[3 * (48 + 2 * 64)];
    const float *lines[129];
    int reach = (int)filter->reach;
    for (int y = 0; y < height; y++) {
        rk_bloom_span lit = rk_bloom_lit(p->pixels[y], width, threshold);
        memset(masked, 0, sizeof masked);
        rk_bloom_mask(filter, p->pixels[y], width, threshold, lit, 0, width, (rk_vec3 *)masked);
        for (int k = 0; k <= 2 * reach; k++)
            lines[k] = masked + 3 * k;
        rk_bloom_weigh(filter, lines, room, across[y]);
    }
    for (int y = 0; y < height; y++) {
        float sum[room];
        for (int k = 0; k <= 2 * reach; k++) {
            int row = y + k - reach, inside = row < 0 ? 0 : row < height ? row : height - 1;
            bool there = row == inside || filter->border == RK_BLOOM_CLAMP;
            lines[k] = there ? across[inside] : NULL;
        }
        rk_bloom_weigh(filter, lines, room, sum);
        for (int x = 0; x < width; x++) {
            float share = filter->border != RK_BLOOM_RENORMALIZE
                              ? 1
                              : rk_bloom_share(filter, (size_t)x, width) *
                                    rk_bloom_share(filter, (size_t)y, height);
            rk_bloom_add(&p->pixels[y][x].x, sum + 3 * x, 3, intensity / share);
        }
    }
}

static void bloom_of_radius(picture *p, uint32_t radius, rk_bloom_border border, float threshold,
                            float intensity)
{
    float weights[65];
    rk_bloom_weights(radius, weights);
    const rk_bloom_filter filter = filter_of(weights, rk_bloom_reach(radius, weights), border);
    bloom(p, &filter, threshold, intensity);
}

/* C(2r, r + k) / 4^r by halves of neighbours' sums, each exact to a rounding. */
static void weights_in_double(int radius, double *weights)
{
    double row[130] = {1};
    for (int n = 1; n <= 2 * radius; n++)
        for (int k = n; k >= 0; k--)
            row[k] = (row[k] + (k ? row[k - 1] : 0)) / 2;
    for (int k = 0; k <= radius; k++)
        weights[k] = row[radius + k];
}

static double full_filter(const picture *p, int x, int y, int axis, int radius,
                          rk_bloom_border border, double threshold)
{
    double weights[65], sum = 0, share = 0;
    weights_in_double(radius, weights);
    for (int dy = -radius; dy <= radius; dy++)
        for (int dx = -radius; dx <= radius; dx++) {
            int i = x + dx, j = y + dy;
            int ci = i < 0 ? 0 : i < width ? i : width - 1;
            int cj = j < 0 ? 0 : j < height ? j : height - 1;
            double weight = weights[abs(dx)] * weights[abs(dy)];
            if ((ci != i || cj != j) && border != RK_BLOOM_CLAMP)
                continue;
            rk_vec3 c = p->pixels[cj][ci];
            double luminance = 0.2126 * (double)c.x + 0.7152 * (double)c.y + 0.0722 * (double)c.z;
            share += weight;
            sum += luminance >= threshold ? weight * (double)rk_axis(c, axis) : 0;
        }
    return border == RK_BLOOM_RENORMALIZE ? sum / share : sum;
}

/* Pixels of at most 1: each of up to 2 x 65 sums and products a pass is rounded by 2^-24 of a
 * result of at most 1, weights are off by another, and each pass leaves out up to 2^-25. */
static double pass_tolerance(uint32_t radius)
{
    return 2 * (2 * radius + 4) * 0x1p-24;
}

static picture random_picture(uint32_t seed)
{
    picture p;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            p.pixels[y][x] = random_colour(rk_hash(x, y, seed, 5));
    return p;
}

static void rows_then_columns_are_the_full_filter(void **state)
{
    (void)state;
    const uint32_t radii[] = {0, 1, 4, 15, 40};
    for (uint32_t i = 0; i < 5; i++)
        for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++) {
            picture before = random_picture(i), after = before;
            bloom_of_radius(&after, radii[i], (rk_bloom_border)border, 0.5f, 0.8f);
            for (int y = 0; y < height; y += 4)
                for (int x = 0; x < width; x += 4)
                    for (int axis = 0; axis < 3; axis++) {
                        double want = (double)rk_axis(before.pixels[y][x], axis) +
                                      0.8 * full_filter(&before, x, y, axis, (int)radii[i],
                                                        (rk_bloom_border)border, 0.5);
                        double got = (double)rk_axis(after.pixels[y][x], axis);
                        rk_check(fabs(got - want) <= 4 * pass_tolerance(radii[i]),
                                 "radius %u, border %d, pixel (%d, %d): got %.9g, want %.9g",
                                 radii[i], border, x, y, got, want);
                    }
        }
}

static void a_point_of_light_becomes_the_filter(void **state)
{
    (void)state;
    picture p = {{{{0, 0, 0}}}};
    p.pixels[14][18] = rk_vec(1, 2, 4);
    bloom_of_radius(&p, 8, RK_BLOOM_ZERO, 0.5f, 1);
    p.pixels[14][18] = rk_sub(p.pixels[14][18], rk_vec(1, 2, 4));
    double weights[9];
    weights_in_double(8, weights);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int dx = abs(x - 18), dy = abs(y - 14);
            double want = dx > 8 || dy > 8 ? 0 : weights[dx] * weights[dy];
            for (int axis = 0; axis < 3; axis++)
                rk_check_close(rk_axis(p.pixels[y][x], axis), (1 << axis) * want,
                               (1 << axis) * pass_tolerance(8), "the weights' product, by colour");
        }
}

/* All of one colour, which the filter at a place sees whole, or in part. */
static void check_constant(rk_bloom_border border, int x, int y, double want, const char *hint)
{
    picture p;
    for (int i = 0; i < width * height; i++)
        p.pixels[i / width][i % width] = rk_vec(0.5f, 1, 0.75f);
    bloom_of_radius(&p, 4, border, 0.5f, 1);
    rk_check_close(p.pixels[y][x].y - 1, want, pass_tolerance(4), hint);
    rk_check_close(p.pixels[y][x].x - 0.5f, want / 2, pass_tolerance(4), hint);
}

static void an_even_picture_glows_evenly_far_from_borders(void **state)
{
    (void)state;
    for (int border = RK_BLOOM_ZERO; border <= RK_BLOOM_RENORMALIZE; border++)
        check_constant((rk_bloom_border)border, 18, 14, 1, "the weights sum to one");
}

static void at_a_border_of_zeros_light_is_lost(void **state)
{
    (void)state;
    const double side = (70 + 56 + 28 + 8 + 1) / 256.0; /* of C(8, k): the middle and four more */
    check_constant(RK_BLOOM_ZERO, 0, 14, side, "at the left border a half, and the middle");
    check_constant(RK_BLOOM_ZERO, width - 1, 14, side, "at the right border");
    check_constant(RK_BLOOM_ZERO, 18, 0, side, "at the top");
    check_constant(RK_BLOOM_ZERO, 0, height - 1, side * side, "in a corner");
}

static void clamped_or_renormalised_an_even_picture_stays_even(void **state)
{
    (void)state;
    for (int border = RK_BLOOM_CLAMP; border <= RK_BLOOM_RENORMALIZE; border++)
        for (int i = 0; i < 6; i++) {
            check_constant((rk_bloom_border)border, i, 14, 1, "towards the left border");
            check_constant((rk_bloom_border)border, width - 1 - i, height - 1, 1, "at the bottom");
        }
}

static void the_share_is_the_weights_inside(void **state)
{
    (void)state;
    const float weights[] = {0.375f, 0.25f, 0.0625f};
    const rk_bloom_filter filter = filter_of(weights, 2, RK_BLOOM_RENORMALIZE);
    rk_check_close(rk_bloom_share(&filter, 5, 11), 1, 0, "all of them");
    rk_check_close(rk_bloom_share(&filter, 2, 5), 1, 0, "just all of them");
    rk_check_close(rk_bloom_share(&filter, 0, 11), 0.6875, 0, "the left ones lost");
    rk_check_close(rk_bloom_share(&filter, 9, 11), 0.9375, 0, "the last one lost");
    rk_check_close(rk_bloom_share(&filter, 0, 1), 0.375, 0, "a picture of one pixel");
}

static void nothing_above_the_threshold_changes_nothing(void **state)
{
    (void)state;
    picture before = random_picture(7), after = before;
    bloom_of_radius(&after, 15, RK_BLOOM_CLAMP, 1.5f, 0.8f);
    rk_check(memcmp(&before, &after, sizeof before) == 0, "no pixel is brighter than one");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(luminance_weighs_green_most),
    cmocka_unit_test(the_luminance_of_a_grey_is_the_grey),
    cmocka_unit_test(a_pixel_at_the_threshold_glows),
    cmocka_unit_test(what_is_not_finite_never_glows),
    cmocka_unit_test(lit_is_from_the_first_to_the_last_pixel_that_glows),
    cmocka_unit_test(the_mask_keeps_what_glows_and_nothing_else),
    cmocka_unit_test(beyond_the_border_the_mask_is_zero),
    cmocka_unit_test(small_filters_are_those_of_pascals_triangle),
    cmocka_unit_test(weights_are_pascals_rows_to_the_last_bit),
    cmocka_unit_test(the_weights_of_any_radius_sum_to_one),
    cmocka_unit_test(the_variance_is_half_the_radius),
    cmocka_unit_test(a_line_alone_is_weighed_by_its_distance),
    cmocka_unit_test(all_lines_are_summed),
    cmocka_unit_test(lines_that_are_null_are_zeros),
    cmocka_unit_test(weighing_asks_for_no_memory),
    cmocka_unit_test(the_glow_is_added_times_its_gain),
    cmocka_unit_test(a_point_of_light_becomes_the_filter),
    cmocka_unit_test(an_even_picture_glows_evenly_far_from_borders),
    cmocka_unit_test(at_a_border_of_zeros_light_is_lost),
    cmocka_unit_test(clamping_repeats_the_borders_own_pixel),
    cmocka_unit_test(the_share_is_the_weights_inside),
    cmocka_unit_test(clamped_or_renormalised_an_even_picture_stays_even),
    cmocka_unit_test(rows_then_columns_are_the_full_filter),
    cmocka_unit_test(what_the_reach_leaves_out_is_half_an_ulp_at_most),
    cmocka_unit_test(the_reach_is_as_short_as_it_can_be),
    cmocka_unit_test(nothing_above_the_threshold_changes_nothing),
};

RK_SUITE("bloom", tests)
