/* Motion blur: paths and times against formulas, swept boxes against dense sampling and exact
 * extremes, and the coverage by moving edges and disks against closed forms. */
#include "test.h"

#include "base/random.h"
#include "base/sampler.h"
#include "features/motion_blur.h"
#include "features/watertight.h"

static float random_float(uint32_t i, uint32_t key, float low, float high)
{
    return low + (high - low) * rk_unit_float(rk_case(i, key, 10, 0));
}

/* --- Paths and moved rays --------------------------------------------------------------------- */

static void at_time_zero_everything_rests(void **state)
{
    (void)state;
    const rk_motion paths[] = {rk_motion_default(), {1, 2, 3}, {-1e6f, 0, 1e6f}};
    for (int i = 0; i < 3; i++) {
        rk_vec3 offset = rk_motion_offset(&paths[i], 0);
        rk_check(offset.x == 0 && offset.y == 0 && offset.z == 0,
                 "the path (%g, %g, %g) at x = 0: got the offset (%g, %g, %g), want (0, 0, 0)",
                 (double)paths[i].a, (double)paths[i].b, (double)paths[i].c, (double)offset.x,
                 (double)offset.y, (double)offset.z);
    }
}

static const char *mistake_of_offset(rk_motion motion, float x, rk_vec3 got, double y)
{
    const double a = (double)motion.a, b = (double)motion.b, c = (double)motion.c, k = (double)x;
    return rk_mistake_in_vector(
        RK_XYZ(got), (const double[]){k, y, 0}, 0,
        RK_VECTOR_MISTAKES(
            {{k, (c * k + b) * k * k + a * k, 0}, "a and c are exchanged: a belongs to x^3"},
            {{k, (a * k + b) * k + c, 0}, "the last factor x is missing: a x^2 + b x + c"},
            {{k, (a + b) * k * k + c * k, 0}, "the first term is a x^2, not a x^3"},
            {{0, y, 0}, "nothing moves along x"}, {{y, k, 0}, "x and y are exchanged"},
            {{-k, -y, 0}, "the offset has the other sign"}));
}

static void check_offset(rk_motion motion, float x, double y)
{
    rk_vec3 got = rk_motion_offset(&motion, x);
    rk_check(got.x == x && (double)got.y == y && got.z == 0,
             "the path (a, b, c) = (%g, %g, %g) at x = %g: got the offset (%g, %g, %g), want (%g, "
             "%g, 0): (x, a x^3 + b x^2 + c x, 0), which needs no rounding here%s",
             (double)motion.a, (double)motion.b, (double)motion.c, (double)x, (double)got.x,
             (double)got.y, (double)got.z, (double)x, y, mistake_of_offset(motion, x, got, y));
}

static void the_offset_is_x_and_a_cubic_of_x(void **state)
{
    (void)state;
    check_offset((rk_motion){2, -3, 5}, 3, 42); /* in which no two mistakes look alike */
    check_offset((rk_motion){1, 0, 0}, 2, 8);
    check_offset((rk_motion){0, 1, 0}, 3, 9);
    check_offset((rk_motion){0, 0, 1}, 5, 5);
    check_offset((rk_motion){2, -3, 4}, -2, -36);
    check_offset(rk_motion_default(), 0.5f, 0.375);
    check_offset(rk_motion_default(), 1, -2);
}

/* Motions are read by several threads at once. */
static void check_constant_motion(void)
{
    const rk_motion motion = rk_motion_default();
    rk_motion_offset(rk_read_only(&motion, sizeof motion, "motion"), 0.5f);
    rk_read_only_free();
}

static void the_offset_is_rounded_once(void **state)
{
    (void)state;
    check_constant_motion();
    for (uint32_t i = 0; i < 10000; i++) {
        /* Near a root of y, where the terms cancel. */
        float root = random_float(i, 0, 0.5f, 2), x = root * random_float(i, 1, 0.9999f, 1.0001f);
        float a = random_float(i, 2, -4, 4), b = random_float(i, 3, -4, 4);
        const rk_motion motion = {a, b, -(a * root + b) * root};
        double exact =
            (((double)motion.a * (double)x + (double)motion.b) * (double)x + (double)motion.c) *
            (double)x;
        float got = rk_motion_offset(&motion, x).y;
        /* Half a unit in a float's last place, and the roundings of both doubles. */
        double tolerance = fabs(exact) * 0x1p-24 + 1e-13;
        rk_check(
            fabs((double)got - exact) <= tolerance,
            "y(%.9g) of (%g, %g, %g): got %.9g, want %.9g: compute in double, round at the end",
            (double)x, (double)motion.a, (double)motion.b, (double)motion.c, (double)got, exact);
    }
}

/* Rays are read by several threads at once. */
static void check_constant_ray(void)
{
    const rk_ray ray = {{1, 2, 3}, {0.5f, 0.25f, -1}, 7};
    rk_motion_ray(rk_vec(0.5f, -1, 0), rk_read_only(&ray, sizeof ray, "ray"));
    rk_read_only_free();
}

static void the_ray_moves_the_other_way(void **state)
{
    (void)state;
    check_constant_ray();
    const rk_ray ray = {{1, 2, 3}, {0.5f, 0.25f, -1}, 7};
    rk_ray moved = rk_motion_ray(rk_vec(0.5f, -1, 0), &ray);
    rk_check(moved.origin.x == 0.5f && moved.origin.y == 3 && moved.origin.z == 3,
             "got the origin (%g, %g, %g), want (0.5, 3, 3): the origin minus the offset%s",
             (double)moved.origin.x, (double)moved.origin.y, (double)moved.origin.z,
             rk_mistake_in_vector(RK_XYZ(moved.origin), (const double[]){0.5, 3, 3}, 0,
                                  RK_VECTOR_MISTAKES({{1.5, 1, 3}, "the offset is added"},
                                                     {{1, 2, 3}, "the ray is not moved"})));
    const rk_vec3 deep = rk_motion_ray(rk_vec(0.5f, -1, 2), &ray).origin;
    rk_check(deep.x == 0.5f && deep.y == 3 && deep.z == 1,
             "offset (0.5, -1, 2): got the origin (%g, %g, %g), want (0.5, 3, 1)", (double)deep.x,
             (double)deep.y, (double)deep.z);
    rk_check(
        memcmp(&moved.direction, &ray.direction, sizeof ray.direction) == 0,
        "got the direction (%g, %g, %g), want (0.5, 0.25, -1): a direction has no position to move",
        (double)moved.direction.x, (double)moved.direction.y, (double)moved.direction.z);
    rk_check(moved.t_max == 7, "got t_max %g, want 7: the ray ends where it did",
             (double)moved.t_max);
}

static rk_triangle triangle_at(rk_vec3 offset)
{
    return (rk_triangle){rk_add(rk_vec(-1, -1, 0), offset), rk_add(rk_vec(3, -1, 0), offset),
                         rk_add(rk_vec(-1, 3, 0), offset), 0};
}

static void a_moved_ray_hits_the_object_at_rest_at_the_same_t(void **state)
{
    (void)state;
    const rk_motion motion = {1, 0, -1};
    uint32_t hits = 0;
    for (int i = -64; i <= 64; i++) {
        float x = (float)i / 16;
        rk_vec3 offset = rk_motion_offset(&motion, x);
        const rk_ray ray = {{0.25f, 0.5f, -2}, {0, 0, 1}, INFINITY};
        const rk_ray moved = rk_motion_ray(offset, &ray);
        const rk_triangle rest = triangle_at(rk_vec(0, 0, 0)), gone = triangle_at(offset);
        rk_hit want = rk_watertight_intersect(&gone, &ray);
        rk_hit got = rk_watertight_intersect(&rest, &moved);
        bool should = want.triangle != RK_MISS;
        rk_check(
            (got.triangle != RK_MISS) == should,
            "offset (%g, %g, 0): the moved ray should %s the triangle at rest, because the ray "
            "itself does so with the moved triangle",
            (double)offset.x, (double)offset.y, should ? "hit" : "miss");
        rk_check(!should || got.t == want.t,
                 "offset (%g, %g, 0): got t %g, want %g: t is the same in both frames",
                 (double)offset.x, (double)offset.y, (double)got.t, (double)want.t);
        hits += should;
    }
    rk_check(hits > 10 && hits < 100, "some should hit and some miss: %u hits", hits);
}

/* --- Times ------------------------------------------------------------------------------------ */

/* At time 1.375 of 2, which each mistake changes in another way. */
static const char *mistake_of_times(void)
{
    const rk_shutter shutter = {-1, 7};
    const double k = 1.375;
    return rk_mistake_in(
        (double)rk_shutter_equidistant(&shutter, (float)k, 2), -1 + 4 * (k - 0.5), 0,
        RK_MISTAKES({4 * (k - 0.5), "the shutter is taken to open at 0, not at -1"},
                    {-1 + 7 * (k - 0.5) / 2, "the fraction is multiplied by the end of the "
                                             "shutter, not by its length"},
                    {-1 + 4 * k, "times are at the ends of the parts, not in their middles"},
                    {-1 + 4 * (k - 1), "times are where the parts begin, not in their middles"},
                    {-1 + 4 * (k + 0.5), "times are counted from 0, but the first has k = 1"},
                    {-1 + 8 * (k - 1), "the first and the last time are the shutter's two ends"},
                    {-1 + 4 * 0.5, "k is truncated to a whole number"}));
}

static void check_equidistant(float k, uint32_t samples, double want, const char *hint)
{
    const rk_shutter shutter = {-1, 7};
    double got = (double)rk_shutter_equidistant(&shutter, k, samples);
    rk_check(got == want, "shutter [-1, 7], time %g of %u: got %.9g, want %.9g: %s%s", (double)k,
             samples, got, want, hint, mistake_of_times());
}

static void equidistant_times_are_the_middles_of_equal_parts(void **state)
{
    (void)state;
    for (uint32_t k = 1; k <= 4; k++)
        check_equidistant((float)k, 4, 2 * (double)k - 2,
                          "four parts of length 2 have their middles at 0, 2, 4, 6");
    check_equidistant(1, 1, 3, "the middle of the shutter");
    check_equidistant(2e9f, 4000000000u, 3, "half of so many parts have passed");
    const rk_shutter shutter = {-1, 0};
    double got = (double)rk_shutter_equidistant(&shutter, 0x1p24f, RK_SAMPLES_MAX);
    rk_check(got == -0x1p-25,
             "shutter [-1, 0], the last of 2^24 times: got %.9g, want -2^-25 = %.9g, the middle of "
             "the last part: k - 1/2 takes 25 digits, and a float has 24",
             got, -0x1p-25);
}

static void times_before_and_after_the_shutter_continue_the_sequence(void **state)
{
    (void)state;
    check_equidistant(0, 4, -2, "one part before the first time");
    check_equidistant(-3, 4, -8, "four parts before the first time");
    check_equidistant(5, 4, 8, "one part after the last time");
    check_equidistant(500, 4, 998, "far after the last time");
    check_equidistant(1.75f, 4, 1.5, "three quarters of the way from the first to the second");
}

static const char *const names[] = {"equidistant", "stratified", "low-discrepancy"};

static void equidistant_times_are_the_same_for_all_pixels(void **state)
{
    (void)state;
    const rk_shutter shutter = {0, 0.25f};
    for (uint32_t pixel = 0; pixel < 100; pixel++)
        for (uint32_t i = 0; i < 20; i++) {
            double got =
                (double)rk_shutter_time(&shutter, RK_TIME_EQUIDISTANT, pixel, pixel, i, 20);
            /* A float's rounding, below 1/4. */
            rk_check(fabs(got - (i + 0.5) / 80) <= 0x1p-26,
                     "shutter [0, 0.25], pixel %u, seed %u, sample %u of 20: got %.9g, want %.9g: "
                     "sample 0 is the time k = 1, whatever pixel and seed",
                     pixel, pixel, i, got, (i + 0.5) / 80);
        }
}

/* A sampler's number for the time of a sample. */
static double number_of(rk_sampler_kind kind, uint32_t seed, uint32_t pixel, uint32_t sample,
                        uint32_t samples)
{
    const rk_sampler sampler = {kind, seed, samples, 0};
    return (double)rk_sample_1d(&sampler, pixel, sample, RK_DIMENSION_TIME);
}

/* Do the first `parts` of `samples` times lie one in each of as many equal parts? */
static void check_one_in_each_part(rk_time_sampling sampling, uint32_t pixel, uint32_t parts,
                                   uint32_t samples)
{
    const rk_shutter shutter = {0, 1};
    uint32_t first_in[64];
    memset(first_in, 0xff, sizeof first_in);
    for (uint32_t i = 0; i < parts; i++) {
        double x = (double)rk_shutter_time(&shutter, sampling, 3, pixel, i, samples);
        rk_check(x >= 0 && x < 1, "shutter [0, 1], pixel %u, sample %u of %u: got the %s time %.9g",
                 pixel, i, samples, names[sampling], x);
        /* In double: a product in float may round up into the next part. */
        uint32_t part = (uint32_t)(x * parts);
        rk_check(
            first_in[part] == UINT32_MAX,
            "shutter [0, 1], pixel %u, the first %u of %u %s times: samples %u and %u are both "
            "in [%g, %g), want one time in each of %u equal parts",
            pixel, parts, samples, names[sampling], first_in[part], i, part / (double)parts,
            (part + 1) / (double)parts, parts);
        first_in[part] = i;
    }
}

/* Near time 0, where floats are fine, the last of the most parts that there can be. */
static void check_last_of_most_parts(void)
{
    const rk_shutter shutter = {-1, 0};
    for (uint32_t pixel = 0; pixel < 100; pixel++) {
        double x = (double)rk_shutter_time(&shutter, RK_TIME_STRATIFIED, 5, pixel,
                                           RK_SAMPLES_MAX - 1, RK_SAMPLES_MAX);
        rk_check(x >= -0x1p-24 && x < 0,
                 "shutter [-1, 0], pixel %u, the last of 2^24 stratified times: got %.9g, want one "
                 "in the last part, from -2^-24 = %.9g to before 0: a part and a position in it "
                 "take more digits than a float has",
                 pixel, x, -0x1p-24);
    }
}

static void stratified_times_lie_one_in_each_part(void **state)
{
    (void)state;
    const rk_shutter shutter = {0, 1};
    /* In order, so that neighbouring pixels see nearly the same scene in sample i. */
    for (uint32_t i = 0; i < 64; i++) {
        double x = (double)rk_shutter_time(&shutter, RK_TIME_STRATIFIED, 3, 7, i, 64);
        rk_check(
            x >= i / 64.0 && x <= (i + 1) / 64.0,
            "shutter [0, 1], pixel 7, sample %u of 64: got the time %.6f, want one in [%.6f, "
            "%.6f]: sample i lies in part i, at a random position there%s",
            i, x, i / 64.0, (i + 1) / 64.0,
            rk_mistake_in(
                x, (i + 0.5) / 64, 0x1p-24,
                RK_MISTAKES(
                    {number_of(RK_SAMPLER_STRATIFIED, 3, 7, i, 64),
                     "RK_SAMPLER_STRATIFIED draws it, which shuffles its parts"},
                    {number_of(RK_SAMPLER_UNIFORM, 3, 7, i, 64),
                     "the random number is the position in the whole shutter, not in part i"})));
    }
    for (uint32_t pixel = 0; pixel < 50; pixel++)
        for (uint32_t samples = 1; samples <= 64; samples++)
            check_one_in_each_part(RK_TIME_STRATIFIED, pixel, samples, samples);
    check_last_of_most_parts();
}

static void low_discrepancy_times_are_stratified_for_each_power_of_two(void **state)
{
    (void)state;
    for (uint32_t pixel = 0; pixel < 50; pixel++)
        for (uint32_t parts = 1; parts <= 64; parts *= 2) {
            check_one_in_each_part(RK_TIME_LOW_DISCREPANCY, pixel, parts, parts);
            check_one_in_each_part(RK_TIME_LOW_DISCREPANCY, pixel, parts, 100);
        }
}

/* Other dimensions are for positions in the pixel, on the lens, on a light: with one of these,
 * times would depend on positions, and pictures have dark dashes along edges. */
static void random_times_are_drawn_from_the_dimension_of_time(void **state)
{
    (void)state;
    const rk_shutter shutter = {0, 1};
    const uint32_t numbers[] = {16, 1000, 1, 2, 33};
    for (uint32_t n = 0; n < 2000; n++) {
        /* Every seventh time with numbers of more than 16 bits. */
        bool large = n % 7 == 6;
        uint32_t samples = numbers[n % 5];
        uint32_t seed = large ? 0xabcd0003 + n : 3, pixel = large ? 0x80010000 + n : n / 16;
        uint32_t i = n * 7 % samples;
        double low =
            (double)rk_shutter_time(&shutter, RK_TIME_LOW_DISCREPANCY, seed, pixel, i, samples);
        double want = number_of(RK_SAMPLER_LOW_DISCREPANCY, seed, pixel, i, samples);
        rk_check(fabs(low - want) <= 0x1p-24,
                 "shutter [0, 1], seed %u, pixel %u, sample %u of %u: got the low-discrepancy "
                 "time %.7f, want %.7f: rk_sample_1d's number of that kind, seed, pixel, "
                 "sample and RK_DIMENSION_TIME",
                 seed, pixel, i, samples, low, want);
        double x = (double)rk_shutter_time(&shutter, RK_TIME_STRATIFIED, seed, pixel, i, samples);
        /* Any kind of sampler will do for the position in the part. */
        double off = INFINITY;
        for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_LOW_DISCREPANCY; kind++)
            off = fmin(off, fabs(x * samples - i -
                                 number_of((rk_sampler_kind)kind, seed, pixel, i, samples)));
        want = (i + number_of(RK_SAMPLER_UNIFORM, seed, pixel, i, samples)) / samples;
        /* Of times up to 1, rounded to floats twice: part and position together, and the time. */
        rk_check(off <= 2 * samples * 0x1p-24,
                 "shutter [0, 1], seed %u, pixel %u, sample %u of %u: got the stratified time "
                 "%.9g, want %.9g: its position in its part is rk_sample_1d's number of that "
                 "seed, pixel, sample and RK_DIMENSION_TIME (here the uniform one; other "
                 "kinds pass)",
                 seed, pixel, i, samples, x, want);
    }
}

static void pixels_and_seeds_have_random_times_of_their_own(void **state)
{
    (void)state;
    const rk_shutter shutter = {0, 1};
    for (int sampling = RK_TIME_STRATIFIED; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++) {
        uint32_t same = 0;
        for (uint32_t i = 0; i < 200; i++) {
            float x = rk_shutter_time(&shutter, (rk_time_sampling)sampling, 1, i, 2, 8);
            same += x == rk_shutter_time(&shutter, (rk_time_sampling)sampling, 1, i + 1, 2, 8);
            same += x == rk_shutter_time(&shutter, (rk_time_sampling)sampling, 2, i, 2, 8);
        }
        /* Of 400 pairs of 24 random bits. */
        rk_check(same <= 1,
                 "%s: %u of 400 times equal the neighbouring pixel's, or seed 2's instead of 1's; "
                 "want at most 1, by chance",
                 names[sampling], same);
    }
}

static void times_fill_the_shutter_and_never_leave_it(void **state)
{
    (void)state;
    const rk_shutter shutters[] = {{0, 0.05f},      {-3, 11},       {0.1f, 0.1000001f}, {7, 7},
                                   {-3e38f, 3e38f}, {1e20f, 3e38f}, {-1e-30f, 1e-30f},  {-5, -4}};
    for (size_t s = 0; s < sizeof shutters / sizeof *shutters; s++)
        for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++) {
            double open = (double)shutters[s].open, close = (double)shutters[s].close, sum = 0;
            for (uint32_t i = 0; i < 64; i++) {
                double x =
                    (double)rk_shutter_time(&shutters[s], (rk_time_sampling)sampling, 9, 5, i, 64);
                rk_check(x >= open && x <= close,
                         "%s, pixel 5, seed 9, sample %u of 64: got the time %.9g, want one in the "
                         "shutter [%.9g, %.9g]",
                         names[sampling], i, x, open, close);
                sum += x;
            }
            /* Each is at most a 64th of the shutter away from the middle of its part, apart from
             * rounding. */
            double tolerance = (close - open) / 64 + 0x1p-24 * fmax(fabs(open), fabs(close));
            rk_check(
                fabs(sum / 64 - (open + close) / 2) <= tolerance,
                "%s, pixel 5, seed 9: got %.9g for the mean of 64 times, want %.9g within %.3g: "
                "the middle of the shutter [%.9g, %.9g], which the times should fill",
                names[sampling], sum / 64, (open + close) / 2, tolerance, open, close);
        }
}

static void the_last_of_the_most_samples_is_within_the_shutter(void **state)
{
    (void)state;
    /* In floats -0.5 + (0.1 + 0.5) is more than 0.1. */
    const rk_shutter shutters[] = {{-0.5f, 0.1f}, {0, 0.05f}, {-3, 11}, {1, 1.1f}};
    for (int s = 0; s < 4; s++)
        for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++)
            for (uint32_t pixel = 0; pixel < 2000; pixel++) {
                uint32_t i = pixel % 2 ? RK_SAMPLES_MAX - 1 : RK_SAMPLES_MAX - 1 - pixel;
                float x = rk_shutter_time(&shutters[s], (rk_time_sampling)sampling, 9, pixel, i,
                                          RK_SAMPLES_MAX);
                rk_check(
                    x >= shutters[s].open && x <= shutters[s].close,
                    "%s, pixel %u, sample %u of %u: got the time %.9g, want one in the shutter "
                    "[%.9g, %.9g]: in floats, a fraction near 1 is 1, and sums exceed their end",
                    names[sampling], pixel, i, RK_SAMPLES_MAX, (double)x, (double)shutters[s].open,
                    (double)shutters[s].close);
                double open = (double)shutters[s].open, close = (double)shutters[s].close;
                rk_check(
                    sampling == RK_TIME_LOW_DISCREPANCY ||
                        (double)x >= open + 0.99 * (close - open),
                    "%s, pixel %u, sample %u of %u: got the time %.9g, want one at the end of the "
                    "shutter [%.9g, %.9g]",
                    names[sampling], pixel, i, RK_SAMPLES_MAX, (double)x, open, close);
            }
}

/* --- Swept boxes ------------------------------------------------------------------------------ */

static rk_box sweep(const rk_motion *motion, const rk_shutter *shutter, const rk_box *rest)
{
    rk_motion path = *motion;
    rk_shutter interval = *shutter;
    rk_box box = *rest;
    rk_box swept = rk_motion_sweep(&path, &interval, &box);
    rk_check(
        memcmp(&path, motion, sizeof path) == 0 &&
            memcmp(&interval, shutter, sizeof interval) == 0 && memcmp(&box, rest, sizeof box) == 0,
        "rk_motion_sweep changed the caller's path, shutter or box at rest, which are constant");
    return swept;
}

/* The header allows 2^-19 of corner and offset; and floats are rounded. */
static double slack(double corner, double offset)
{
    return (fabs(corner) + fabs(offset)) * (0x1p-19 + 2 * 0x1p-24);
}

static void check_swept(rk_motion motion, rk_shutter shutter, const char *side, float got,
                        double want, double tolerance, const char *hint)
{
    rk_check(
        fabs((double)got - want) <= tolerance,
        "the path (a, b, c) = (%g, %g, %g), shutter [%g, %g]: got %.9g for the swept box's %s, "
        "want %.9g within %.3g: %s",
        (double)motion.a, (double)motion.b, (double)motion.c, (double)shutter.open,
        (double)shutter.close, (double)got, side, want, tolerance, hint);
}

/* One axis of a swept box, where the offset goes from `low` to `high`. */
static void check_swept_axis(rk_motion motion, rk_shutter shutter, int axis, const rk_box *rest,
                             const rk_box *swept, double low, double high, const char *hint)
{
    double at_rest[] = {(double)rk_axis(rest->corner[0], axis),
                        (double)rk_axis(rest->corner[1], axis)};
    const double offset[] = {low, high};
    double size = fmax(fabs(at_rest[0]), fabs(at_rest[1])) + fmax(fabs(offset[0]), fabs(offset[1]));
    for (int end = 0; end < 2; end++) {
        const char *side = end ? "highest" : "lowest";
        double got = (double)rk_axis(swept->corner[end], axis), want = at_rest[end] + offset[end];
        double margin = (end ? 1 : -1) * 0x1p-19 * size;
        const bool rests = offset[end] == 0;
        /* The result is rounded to a float, so to a sixteenth of the margin. */
        rk_check_near_or(
            got, want + margin, 2 * 0x1p-24 * size,
            RK_MISTAKES({at_rest[end], rests ? "the margin is missing, or the whole sweep"
                                             : "the box is not swept on this axis"},
                        {at_rest[end] + offset[!end] + margin,
                         end ? "the lowest offset is added to the highest end"
                             : "the highest offset is added to the lowest end"},
                        {rests ? NAN : want, "the margin is missing"},
                        {want - margin, "the margin makes the box smaller"}),
            "the path (a, b, c) = (%g, %g, %g), shutter [%g, %g]: the swept box's %s "
            "%c: %.9g at rest, plus the %s of the offsets from %.9g to %.9g (%s), %s "
            "a margin of 2^-19 of the terms, %.3g",
            (double)motion.a, (double)motion.b, (double)motion.c, (double)shutter.open,
            (double)shutter.close, side, "xyz"[axis], at_rest[end], side, low, high, hint,
            end ? "plus" : "less", fabs(margin));
    }
}

static void check_heights(rk_motion motion, rk_shutter shutter, double low, double high,
                          const char *hint)
{
    const rk_box rests[] = {{{{-1, -0.5f, 2}, {3, 0.5f, 4}}},
                            {{{-4, -3, -9}, {-2, -2.5f, -8}}},
                            {{{0, 0, 0}, {0, 0, 0}}},
                            {{{3, -2, 5}, {3, -2, 5}}},
                            {{{2, 1, -0x1p-60f}, {2, 3, 0x1p-60f}}},
                            {{{-1e30f, 1e20f, -1e37f}, {-1e25f, 1e30f, -1e36f}}}};
    for (size_t i = 0; i < sizeof rests / sizeof *rests; i++) {
        const rk_box swept = sweep(&motion, &shutter, &rests[i]);
        check_swept_axis(motion, shutter, 0, &rests[i], &swept, (double)shutter.open,
                         (double)shutter.close, "x where the shutter opens and closes");
        check_swept_axis(motion, shutter, 1, &rests[i], &swept, low, high, hint);
        check_swept_axis(motion, shutter, 2, &rests[i], &swept, 0, 0, "nothing moves along z");
    }
}

static void a_straight_path_sweeps_from_its_beginning_to_its_end(void **state)
{
    (void)state;
    check_heights((rk_motion){0, 0, 0}, (rk_shutter){0, 1}, 0, 0, "a level path");
    check_heights((rk_motion){0, 0, 2}, (rk_shutter){0, 1}, 0, 2, "it rises");
    check_heights((rk_motion){0, 0, -2}, (rk_shutter){-1, 1}, -2, 2, "it falls");
    check_heights((rk_motion){0, 0, 2}, (rk_shutter){3, 3}, 6, 6, "a shutter of no length");
}

static void a_parabola_turns_at_its_vertex(void **state)
{
    (void)state;
    check_heights((rk_motion){0, 1, 0}, (rk_shutter){-2, 1}, 0, 4, "x^2 is lowest at 0");
    check_heights((rk_motion){0, -4, 4}, (rk_shutter){0, 1}, 0, 1, "4 x - 4 x^2 is highest at 1/2");
    check_heights((rk_motion){0, -4, 4}, (rk_shutter){0.75f, 1}, 0, 0.75, "beyond the vertex");
}

static void a_cubic_turns_twice(void **state)
{
    (void)state;
    const double third = 2 / (3 * sqrt(3)); /* x^3 - x turns at 1 / sqrt(3) */
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-1, 1}, -third, third,
                  "it turns twice within; with b = 0, does your q become 0? then both roots are "
                  "lost: the sign of 0 has to be 1 or -1");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){0, 1}, -third, 0,
                  "it turns once within, at its minimum");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-1, 0}, 0, third,
                  "it turns once within, at its maximum");
    check_heights((rk_motion){-1, 0, 1}, (rk_shutter){-1, 1}, -third, third,
                  "it turns twice within, upside down");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-0.5f, 0.5f}, -0.375, 0.375,
                  "it turns before and after the shutter, which does not count");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-2, 2}, -6, 6, "the ends are farther out");
    /* y' = -12 x^2 + x + 1.5 is 0 at (1 + sqrt(73)) / 24. */
    double x = (1 + sqrt(73)) / 24;
    check_heights(rk_motion_default(), (rk_shutter){0, 1}, -2, ((-4 * x + 0.5) * x + 1.5) * x,
                  "the classic path over [0, 1]");
}

static void a_level_point_is_no_turning_point(void **state)
{
    (void)state;
    check_heights((rk_motion){1, 0, 0}, (rk_shutter){-1, 2}, -1, 8, "x^3 is level at 0");
    /* (x - 1)^3 + 1 */
    check_heights((rk_motion){1, -3, 3}, (rk_shutter){0, 3}, 0, 9, "a double root of y', at 1");
    check_heights((rk_motion){1, 0, 1}, (rk_shutter){-1, 1}, -2, 2, "y' has no root at all");
}

static void turning_points_keep_their_digits_when_one_is_far_away(void **state)
{
    (void)state;
    /* With a tiny a the second turning point is far away; the first is nearly the parabola's. */
    for (float a = 1; a > 1e-30f; a /= 16) {
        const rk_motion motion = {a * 1e-3f, -4, 4};
        /* 4 x - 4 x^2 turns at 1/2; a x^3 adds a / 8 there, plus terms of second order. */
        double y = 1 + (double)motion.a / 8;
        const rk_shutter shutter = {0.25f, 0.75f};
        rk_box swept = sweep(&motion, &shutter, &(rk_box){{{0, 0, 0}, {0, 0, 0}}});
        double tolerance = slack(0, y) + (double)motion.a * (double)motion.a;
        check_swept(motion, shutter, "highest y", swept.corner[1].y, y, tolerance,
                    "is a root computed as the difference of two nearly equal numbers?");
    }
}

static void steep_and_flat_paths_turn_like_others(void **state)
{
    (void)state;
    /* Squares of floats may be too large or too small for floats, but not for doubles. */
    const double third = 2 / (3 * sqrt(3)), turn = 1 / sqrt(3);
    for (int e = -100; e <= 100; e += 20) {
        float size = ldexpf(1, e);
        const rk_motion motions[] = {{0, -size, size}, {size, 0, -size}, {-size, 0, size}};
        const double lowest[] = {0, -third, 0}, highest[] = {0.25, 0, third};
        const rk_shutter shutter = {0, 1};
        for (int i = 0; i < 3; i++) {
            rk_box swept = sweep(&motions[i], &shutter, &(rk_box){0});
            double tolerance = (double)size * slack(0, 0.5);
            check_swept(motions[i], shutter, "lowest y", swept.corner[0].y,
                        (double)size * lowest[i], tolerance,
                        i ? "it may turn at 1 / sqrt(3)" : "at both ends");
            check_swept(motions[i], shutter, "highest y", swept.corner[1].y,
                        (double)size * highest[i], tolerance,
                        i ? "it may turn at 1 / sqrt(3)" : "it turns at 1/2");
        }
    }
    rk_check_near(turn * turn * turn - turn, -third, 1e-15, "x^3 - x at 1 / sqrt(3)");
    /* u^3 - 1.5 u^2 turns at u = 0 and 1. With x = u s the cubic term may seem negligible, but in a
     * shutter of 2 s it is not; and turning points may be very close to each other. */
    for (int e = -40; e <= 40; e += 5) {
        float s = ldexpf(1, e);
        const rk_motion motion = {1 / s / s / s, -1.5f / s / s, 0};
        const float open[] = {-1, -1, 0.5f, -0.5f}, close[] = {2, 0.5f, 1.5f, 0};
        const double lowest[] = {-2.5, -2.5, -0.5, -0.5}, highest[] = {2, 0, 0, 0};
        for (int i = 0; i < 4; i++) {
            const rk_shutter shutter = {open[i] * s, close[i] * s};
            rk_box swept = sweep(&motion, &shutter, &(rk_box){0});
            const char *hint = "u^3 - 1.5 u^2 with u = x / s turns at u = 0 and 1";
            check_swept(motion, shutter, "lowest y", swept.corner[0].y, lowest[i], slack(0, 2.5),
                        hint);
            check_swept(motion, shutter, "highest y", swept.corner[1].y, highest[i], slack(0, 2.5),
                        hint);
        }
    }
}

/* A random path; most turn somewhere near the shutter. */
static rk_motion random_path(uint32_t i)
{
    float size = exp2f(random_float(i, 20, -10, 10));
    rk_motion motion = {random_float(i, 21, -size, size), random_float(i, 22, -size, size),
                        random_float(i, 23, -size, size)};
    if (i % 4 == 1)
        motion.a = 0;
    if (i % 4 == 2) /* nearly a double root of y' */
        motion.c = motion.b * motion.b / (3 * motion.a) * random_float(i, 24, 0.999999f, 1);
    return motion;
}

static rk_shutter random_shutter(uint32_t i)
{
    float open = random_float(i, 30, -2, 2);
    return (rk_shutter){open, open + random_float(i, 31, 0, 2)};
}

static rk_box random_box(uint32_t i)
{
    rk_vec3 corner =
        rk_vec(random_float(i, 40, -2, 2), random_float(i, 41, -2, 2), random_float(i, 42, -2, 2));
    rk_vec3 size =
        rk_vec(random_float(i, 43, 0, 1), random_float(i, 44, 0, 1), random_float(i, 45, 0, 1));
    return (rk_box){{corner, rk_add(corner, size)}};
}

/* The same scene in another unit of length, a power of two: x is a length, too. */
static float unit_of(uint32_t i)
{
    return ldexpf(1, (int)(i / 8 % 3) * 40 - 40);
}

static rk_motion path_in(float unit, rk_motion path)
{
    return (rk_motion){path.a / unit / unit, path.b / unit, path.c};
}

static rk_shutter shutter_in(float unit, rk_shutter shutter)
{
    return (rk_shutter){shutter.open * unit, shutter.close * unit};
}

static rk_box box_in(float unit, rk_box box)
{
    return (rk_box){{rk_scale(box.corner[0], unit), rk_scale(box.corner[1], unit)}};
}

/* The path, without the unit. */
static rk_vec3 true_offset(const rk_motion *motion, float x)
{
    double a = (double)motion->a, b = (double)motion->b, c = (double)motion->c, t = (double)x;
    return rk_vec(x, (float)(((a * t + b) * t + c) * t), 0);
}

static float time_in(const rk_shutter *shutter, uint32_t i, uint32_t of)
{
    float x = shutter->open + (shutter->close - shutter->open) * ((float)i / (float)of);
    return x > shutter->close ? shutter->close : x;
}

static void a_swept_box_holds_the_box_at_every_time(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 2000; i++) {
        const rk_motion motion = random_path(i);
        const rk_shutter shutter = random_shutter(i);
        const rk_box rest = random_box(i), swept = sweep(&motion, &shutter, &rest);
        for (uint32_t k = 0; k <= 1000; k++) {
            rk_vec3 offset = true_offset(&motion, time_in(&shutter, k, 1000));
            rk_vec3 low = rk_add(rest.corner[0], offset), high = rk_add(rest.corner[1], offset);
            for (int axis = 0; axis < 3; axis++)
                rk_check(rk_axis(swept.corner[0], axis) <= rk_axis(low, axis) &&
                             rk_axis(swept.corner[1], axis) >= rk_axis(high, axis),
                         "the path (a, b, c) = (%.9g, %.9g, %.9g), shutter [%.9g, %.9g]: at x = "
                         "%.9g the box is at %.9g .. %.9g on the axis %c, and the swept box, %.9g "
                         ".. %.9g, does not contain it",
                         (double)motion.a, (double)motion.b, (double)motion.c, (double)shutter.open,
                         (double)shutter.close, (double)time_in(&shutter, k, 1000),
                         (double)rk_axis(low, axis), (double)rk_axis(high, axis), "xyz"[axis],
                         (double)rk_axis(swept.corner[0], axis),
                         (double)rk_axis(swept.corner[1], axis));
        }
    }
}

static void check_holds_every_float(rk_motion path, float root, float unit)
{
    const rk_motion motion = path_in(unit, path);
    const rk_shutter shutter = shutter_in(unit, (rk_shutter){root - 1e-6f, root + 1e-6f});
    const float half = 1e-6f * unit;
    const rk_box rest = {{{-half, -half, -half}, {half, half, half}}};
    const rk_box swept = sweep(&motion, &shutter, &rest);
    for (float x = shutter.open; x <= shutter.close; x = nextafterf(x, INFINITY)) {
        double y = (double)rk_motion_offset(&motion, x).y;
        rk_check(
            (double)swept.corner[0].y <= y - (double)half &&
                (double)swept.corner[1].y >= y + (double)half &&
                (double)swept.corner[0].x <= (double)x - (double)half &&
                (double)swept.corner[1].x >= (double)x + (double)half,
            "the path (a, b, c) = (%.9g, %.9g, %.9g), shutter [%.9g, %.9g]: at x = %.9g the unit "
            "moves the box, +- %.3g, to y = %.9g, and the swept box goes from %.9g to %.9g on y: "
            "its terms cancel, so the roundings of a double count",
            (double)motion.a, (double)motion.b, (double)motion.c, (double)shutter.open,
            (double)shutter.close, (double)x, (double)half, y, (double)swept.corner[0].y,
            (double)swept.corner[1].y);
    }
}

static void a_swept_box_holds_paths_whose_terms_cancel(void **state)
{
    (void)state;
    check_holds_every_float((rk_motion){1e12f, -1.16777026e12f, 3.40921844e11f}, 0.583885133f, 1);
    for (uint32_t i = 0; i < 3000; i++) {
        /* a x (x - root)^2, so that the path is nearly level where it is nearly 0. */
        float root = random_float(i, 60, 0.25f, 2), a = exp2f(random_float(i, 61, 20, 45));
        check_holds_every_float((rk_motion){a, -2 * a * root, a * root * root}, root,
                                unit_of(i * 8));
    }
}

static void a_swept_box_is_no_larger_than_the_path(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 2000; i++) {
        const rk_motion motion = random_path(i);
        const rk_shutter shutter = random_shutter(i);
        const rk_box point = {{{0, 0, 0}, {0, 0, 0}}};
        const rk_box swept = sweep(&motion, &shutter, &point);
        double low = INFINITY, high = -INFINITY;
        for (uint32_t k = 0; k <= 1000; k++) {
            double y = (double)true_offset(&motion, time_in(&shutter, k, 1000)).y;
            low = fmin(low, y);
            high = fmax(high, y);
        }
        /* Between two samples the extreme may be h^2 / 8 max |y''| higher. */
        double h = (double)(shutter.close - shutter.open) / 1000, size = 4;
        double bend = 6 * fabs((double)motion.a) * size + 2 * fabs((double)motion.b);
        double tolerance = h * h / 8 * bend + slack(0, fmax(fabs(low), fabs(high))) + 1e-10;
        check_swept(motion, shutter, "lowest y", swept.corner[0].y, low, tolerance,
                    "the lowest of 1001 points of the path; turning points count only within the "
                    "shutter");
        check_swept(motion, shutter, "highest y", swept.corner[1].y, high, tolerance,
                    "the highest of 1001 points of the path; turning points count only within the "
                    "shutter");
    }
}

/* --- Which rays need a time ------------------------------------------------------------------- */

static void check_may_intersect(rk_ray ray, float t_max, bool want, const char *hint)
{
    const rk_box swept = {{{-1, -1, 4}, {1, 1, 5}}};
    const rk_slabs slabs = rk_slabs_of(&ray);
    rk_check(rk_motion_may_intersect(&swept, &slabs, t_max) == want,
             "a ray from x = %g along (0, 0, %g) to t = %g, the box (-1, -1, 4) .. (1, 1, 5): "
             "got %s, want %s: %s",
             (double)ray.origin.x, (double)ray.direction.z, (double)t_max, want ? "false" : "true",
             want ? "true" : "false", hint);
}

static void a_ray_may_hit_a_box_that_it_enters_before_t_max(void **state)
{
    (void)state;
    const rk_ray towards = {{0, 0, 0}, {0, 0, 1}, INFINITY}, away = {{0, 0, 0}, {0, 0, -1}, 9};
    const rk_ray beside = {{2, 0, 0}, {0, 0, 1}, INFINITY};
    const rk_ray within = {{0, 0, 4.5f}, {0, 0, 1}, INFINITY};
    check_may_intersect(towards, INFINITY, true, "straight into it");
    check_may_intersect(towards, 4.5f, true, "it ends inside");
    check_may_intersect(towards, 3.5f, false, "it ends before the box, by the argument t_max");
    check_may_intersect(away, INFINITY, false, "the box is behind it");
    check_may_intersect(beside, INFINITY, false, "it passes the box");
    check_may_intersect(within, INFINITY, true, "it starts inside, at z = 4.5");
    check_may_intersect(within, 0, true, "it starts inside, at z = 4.5, and t = 0 counts");
    const rk_ray along = {{1, 1, 0}, {0, -0.0f, 1}, INFINITY};
    check_may_intersect(along, INFINITY, true, "it runs along an edge, x = y = 1");
    check_may_intersect(towards, 4, true, "it ends on the box, and t = t_max counts");
}

/* A ray from near or far that grazes an edge along z of the box, moved to `offset`: it passes
 * within some dozens of roundings, on either side. */
static rk_ray grazing_ray(uint32_t i, float unit, const rk_box *rest, rk_vec3 offset)
{
    bool right = i & 1, top = i & 2;
    float far = unit * exp2f(random_float(i, 50, 0, 12)), aside = far * 0x1p-24f;
    rk_vec3 at = rk_vec(rest->corner[right].x + random_float(i, 51, -64, 64) * aside,
                        rest->corner[top].y + random_float(i, 52, -64, 64) * aside,
                        random_float(i, 53, rest->corner[0].z, rest->corner[1].z));
    float x = random_float(i, 54, 0, 1), y = random_float(i, 55, 0, right == top ? -1 : 1);
    rk_vec3 direction = rk_vec(x, y, random_float(i, 56, -1, 1));
    /* In large units a short direction makes t as large as 2^112. */
    float speed = i / 24 % 2 ? 0x1p-60f : 1;
    return (rk_ray){rk_madd(rk_add(at, offset), direction, -far), rk_scale(direction, speed),
                    INFINITY};
}

static void fail_lost_ray(uint32_t i, const rk_ray *ray, float t_max, rk_vec3 offset)
{
    rk_check(false,
             "ray %u, from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g) to t = %.9g: got false, "
             "want true: at the offset (%.9g, %.9g, 0) the moved ray enters the box at rest; is "
             "the tested box enlarged by rounding_margin(ray)?",
             i, (double)ray->origin.x, (double)ray->origin.y, (double)ray->origin.z,
             (double)ray->direction.x, (double)ray->direction.y, (double)ray->direction.z,
             (double)t_max, (double)offset.x, (double)offset.y);
}

/* Each ray is asked about twice, without an end and with one: where it enters the box or, if it
 * misses, comes near. A unit that is asked a second time only after a hit would see that in time.
 */
static float end_of(const rk_ray *moved, const rk_box *box, float enter)
{
    const rk_vec3 middle = rk_scale(rk_add(box->corner[0], box->corner[1]), 0.5f);
    const float near = rk_dot(rk_sub(middle, moved->origin), moved->direction) /
                       rk_dot(moved->direction, moved->direction);
    return enter < INFINITY ? enter : fabsf(near);
}

static void a_ray_that_misses_the_swept_box_never_hits_the_object(void **state)
{
    (void)state;
    uint32_t hits = 0, missed = 0;
    for (uint32_t i = 0; i < 50000; i++) {
        /* In smaller and larger units, too. */
        float unit = unit_of(i);
        const rk_motion motion = path_in(unit, random_path(i));
        const rk_shutter shutter = shutter_in(unit, random_shutter(i / 2));
        const rk_box rest = box_in(unit, random_box(i / 2));
        /* Grazing at one end of the path, where the swept box is no wider than the object. */
        rk_vec3 offset = rk_motion_offset(&motion, i & 4 ? shutter.open : shutter.close);
        const rk_ray ray = grazing_ray(i, unit, &rest, offset), moved = rk_motion_ray(offset, &ray);
        const rk_slabs slabs = rk_slabs_of(&ray), moved_slabs = rk_slabs_of(&moved);
        const rk_box swept = sweep(&motion, &shutter, &rest);
        float enter = rk_box_enter(&rest, &moved_slabs, INFINITY);
        bool hit = enter < INFINITY;
        const float ends[] = {INFINITY, end_of(&moved, &rest, enter)};
        bool may_hit[2];
        for (int end = 0; end < 2; end++)
            may_hit[end] = rk_motion_may_intersect(&swept, &slabs, ends[end]);
        for (int end = 0; end < 2; end++)
            if (hit && !may_hit[end])
                fail_lost_ray(i, &ray, ends[end], offset);
        hits += hit;
        missed += !may_hit[0];
    }
    rk_check(hits > 1000 && missed > 1000,
             "of 50000 rays along edges %u enter the box and %u miss the swept box; want more "
             "than 1000 of each: is the swept box too large?",
             hits, missed);
}

static rk_bvh empty_tree(uint32_t node_count)
{
    rk_bvh bvh = {.node_count = 1, .nodes = malloc(node_count * sizeof(rk_bvh_node))};
    rk_check(bvh.nodes, "no memory for %u nodes", node_count);
    return bvh;
}

static void make_leaf(rk_bvh *bvh, uint32_t node, rk_box box)
{
    uint32_t triangles = 1 + bvh->triangle_count % RK_BVH_LEAF_MAX;
    bvh->nodes[node] = (rk_bvh_node){box, bvh->triangle_count, triangles};
    bvh->triangle_count += triangles;
}

/* Returns the left child. nodes[1] is unused: a traversal that reads it finds a leaf that every ray
 * enters. */
static uint32_t make_inner(rk_bvh *bvh, uint32_t node, rk_box box)
{
    const rk_box everything = {{{-1e9f, -1e9f, -1e9f}, {1e9f, 1e9f, 1e9f}}};
    bvh->nodes[1] = (rk_bvh_node){everything, 0, 1};
    uint32_t left = bvh->node_count == 1 ? 2 : bvh->node_count;
    bvh->nodes[node] = (rk_bvh_node){box, left, 0};
    bvh->node_count = left + 2;
    return left;
}

/* In place of what is in a tree of 4 nodes. */
static void make_two_leaves(rk_bvh *bvh, rk_box left, rk_box right)
{
    bvh->node_count = 1;
    bvh->triangle_count = 0;
    uint32_t child = make_inner(bvh, 0, rk_box_merge(left, right));
    make_leaf(bvh, child, left);
    make_leaf(bvh, child + 1, right);
}

static rk_bvh two_leaves(rk_box left, rk_box right)
{
    rk_bvh bvh = empty_tree(4);
    make_two_leaves(&bvh, left, right);
    return bvh;
}

/* Tests a ray from (x, 0, 0) along z. The tree moves along x, from its rest position by `close`. */
static bool may_intersect_leaf(const rk_bvh *bvh, float x, float close, float t_max)
{
    const rk_motion level = {0, 0, 0};
    const rk_shutter shutter = {0, close};
    const rk_box swept = sweep(&level, &shutter, &bvh->nodes[0].box);
    const rk_ray ray = {{x, 0, 0}, {0, 0, 1}, INFINITY};
    const rk_slabs slabs = rk_slabs_of(&ray);
    rk_check(rk_motion_may_intersect(&swept, &slabs, INFINITY),
             "rk_motion_may_intersect is false for a ray at x = %g and the root's swept box, from "
             "%g to %g on x: step 7 comes first",
             (double)x, (double)swept.corner[0].x, (double)swept.corner[1].x);
    rk_bvh_node *nodes = malloc(bvh->node_count * sizeof *nodes);
    rk_check(nodes, "no memory for %u nodes", bvh->node_count);
    memcpy(nodes, bvh->nodes, bvh->node_count * sizeof *nodes);
    bool may = rk_motion_may_intersect_leaf(bvh, &swept, &slabs, t_max);
    rk_check(memcmp(nodes, bvh->nodes, bvh->node_count * sizeof *nodes) == 0,
             "the search changed a node of the caller's tree, which is constant");
    free(nodes);
    return may;
}

static void check_leaf(float x, float close, float t_max, bool want, const char *hint)
{
    rk_bvh bvh = two_leaves((rk_box){{{-4, -1, 4}, {-2, 1, 5}}}, (rk_box){{{2, -1, 4}, {4, 1, 5}}});
    rk_check(
        may_intersect_leaf(&bvh, x, close, t_max) == want,
        "a root and two leaves, x in [-4, -2] and [2, 4], z in [4, 5], which move to x + %g: a "
        "ray from (%g, 0, 0) along z to t = %g should %s a leaf: %s",
        (double)close, (double)x, (double)t_max, want ? "hit" : "not hit", hint);
    rk_bvh_free(&bvh);
}

static void a_ray_between_the_leaves_hits_none(void **state)
{
    (void)state;
    check_leaf(-3, 1, INFINITY, true, "straight into the left one");
    check_leaf(3, 1, INFINITY, true, "straight into the right one");
    check_leaf(3, 1, 3.5f, false, "it ends before the leaf");
    check_leaf(0, 1, INFINITY, false, "the left one moves only to -1");
    check_leaf(-1.5f, 1, INFINITY, true, "the left one moves there");
    check_leaf(1.5f, 1, INFINITY, false, "the right one moves away");
    check_leaf(0, 3, INFINITY, true, "the left one moves to 1");
}

/* A tree of three levels; the far leaf is the last, or the first. */
static rk_bvh three_leaves(rk_box beside, rk_box too, rk_box far, bool first)
{
    rk_bvh bvh = empty_tree(6);
    uint32_t inner = make_inner(&bvh, 0, rk_box_merge(beside, rk_box_merge(too, far))) + !first;
    uint32_t left = make_inner(&bvh, inner, rk_box_merge(too, far));
    make_leaf(&bvh, 2 + first, beside);
    make_leaf(&bvh, left + first, too);
    make_leaf(&bvh, left + !first, far);
    return bvh;
}

static void check_reach(const rk_bvh *bvh, bool first, float t_max, bool want, const char *hint)
{
    rk_check(may_intersect_leaf(bvh, 0, 0.5f, t_max) == want,
             "a tree of three levels, %s child first, whose boxes above the leaves the ray enters: "
             "two leaves beside the ray, and one on it; to t = %g it should %s a leaf: %s",
             first ? "the inner" : "the leaf", (double)t_max, want ? "hit" : "not hit", hint);
}

static void leaves_behind_a_ray_or_beyond_its_end_do_not_count(void **state)
{
    (void)state;
    /* Beside the ray before it and behind its origin, so that all boxes above are entered. */
    const rk_box beside = {{{-4, -1, -9}, {-2, 1, 5}}}, too = {{{2, -1, -8}, {4, 1, 6}}};
    const rk_box far = {{{-1, -1, 9}, {1, 1, 10}}}, behind = {{{-1, -1, -8}, {1, 1, -1}}},
                 around = {{{-1, -1, -1}, {1, 1, 1}}};
    for (int first = 0; first < 2; first++) {
        rk_bvh bvh = three_leaves(beside, too, far, first);
        check_reach(&bvh, first, 7, false, "the one on it is at z = 9 to 10, beyond t_max");
        check_reach(&bvh, first, 9.5f, true, "the one on it is at z = 9 to 10");
        rk_bvh_free(&bvh);
        bvh = three_leaves(beside, too, behind, first);
        check_reach(&bvh, first, INFINITY, false, "the one on its line is behind its origin");
        rk_bvh_free(&bvh);
        bvh = three_leaves(beside, too, around, first);
        check_reach(&bvh, first, 0, true, "it starts in the one on it, and t = 0 counts");
        rk_bvh_free(&bvh);
    }
}

static void a_ray_between_leaves_that_rise_hits_none(void **state)
{
    (void)state;
    const rk_motion rising = {0, 0, 1};
    const rk_shutter shutter = {0, 1};
    const rk_box low = {{{-1, -4, 4}, {1, -2, 5}}}, high = {{{-1, 2, 4}, {1, 4, 5}}};
    rk_bvh bvh = two_leaves(low, high);
    const rk_box swept = sweep(&rising, &shutter, &bvh.nodes[0].box);
    const float heights[] = {-1.5f, -0.5f, 1.5f, 4.5f};
    const bool wanted[] = {true, false, false, true};
    for (int i = 0; i < 4; i++) {
        const rk_ray ray = {{0, heights[i], 0}, {0, 0, 1}, INFINITY};
        const rk_slabs slabs = rk_slabs_of(&ray);
        rk_check(
            rk_motion_may_intersect_leaf(&bvh, &swept, &slabs, INFINITY) == wanted[i],
            "two leaves, y in [-4, -2] and [2, 4], which move to y + 1: a ray at y = %g should "
            "%s a leaf: boxes grow at the end to which they move",
            (double)heights[i], wanted[i] ? "hit" : "not hit");
    }
    /* From 2 to 3 later they are far from where they rest: y in [-2, 1] and [4, 7], or mirrored. */
    const rk_shutter late = {2, 3};
    const float later[] = {-1, 2.5f, 5};
    for (int sign = -1; sign <= 1; sign += 2) {
        const rk_motion path = {0, 0, (float)sign};
        const rk_box far = sweep(&path, &late, &bvh.nodes[0].box);
        for (int i = 0; i < 3; i++) {
            float y = later[i] * (float)sign;
            const rk_ray ray = {{2.5f, y, 0}, {0, 0, 1}, INFINITY};
            const rk_slabs slabs = rk_slabs_of(&ray);
            rk_check(rk_motion_may_intersect_leaf(&bvh, &far, &slabs, INFINITY) == (i != 1),
                     "two leaves, y in [-4, -2] and [2, 4], which move by %d to %d: a ray at y = "
                     "%g should %s a leaf: a swept box need not contain the box at rest",
                     2 * sign, 3 * sign, (double)y, i == 1 ? "not hit" : "hit");
        }
    }
    rk_bvh_free(&bvh);
}

static void subtrees_that_the_ray_misses_are_not_visited(void **state)
{
    (void)state;
    const rk_box left = {{{-4, -1, 4}, {-2, 1, 5}}}, right = {{{2, -1, 4}, {4, 1, 5}}};
    for (int side = 0; side < 2; side++) {
        rk_bvh bvh = empty_tree(6);
        uint32_t child = make_inner(&bvh, 0, rk_box_merge(left, right));
        make_leaf(&bvh, child + (uint32_t)side, side ? right : left);
        uint32_t below = make_inner(&bvh, child + !side, side ? left : right);
        /* Wrong boxes, which tell whether they were tested. */
        make_leaf(&bvh, below, (rk_box){{{-1, -1, 4}, {1, 1, 5}}});
        make_leaf(&bvh, below + 1, (rk_box){{{-1, -1, 4}, {1, 1, 5}}});
        rk_check(!may_intersect_leaf(&bvh, 0, 0.5f, INFINITY),
                 "the leaves below the root's %s child, which the ray misses, were visited: "
                 "without it the test costs as much as all leaves",
                 side ? "left" : "right");
        rk_bvh_free(&bvh);
    }
}

static void a_tree_may_be_a_single_leaf(void **state)
{
    (void)state;
    rk_bvh bvh = empty_tree(1);
    make_leaf(&bvh, 0, (rk_box){{{-4, -1, 4}, {-2, 1, 5}}});
    rk_check(
        may_intersect_leaf(&bvh, -3, 1, INFINITY),
        "a root that is a leaf, x in [-4, -2], z in [4, 5]: got false, want true for a ray from "
        "(-3, 0, 0) along z: it has no children to visit");
    rk_check(
        !may_intersect_leaf(&bvh, -3, 1, 3.5f),
        "a root that is a leaf, x in [-4, -2], z in [4, 5]: got true, want false for a ray from "
        "(-3, 0, 0) along z to t = 3.5: it ends before the leaf");
    rk_bvh_free(&bvh);
}

/* The deepest and most lopsided tree that builders may make: a chain of nodes, with a pair of
 * leaves beside each. A ray at x = 0 enters all inner nodes and no leaf, because leaves are to its
 * left and right; so every node of the chain, and every pair, has to be pushed or visited. */
enum {
    chain_length = RK_BVH_LEVELS_MAX - 2, /* below it are a pair's node, and its leaves */
    deep_leaves = 2 * (chain_length + 1),
    deep_nodes = 2 * deep_leaves, /* one inner node fewer than leaves, and nodes[1] */
    no_leaf = deep_leaves,
};

static const rk_box left_box = {{{-4, -1, 4}, {-2, 1, 5}}}, right_box = {{{2, -1, 4}, {4, 1, 5}}};

static void make_pair(rk_bvh *bvh, uint32_t node, uint32_t pair, uint32_t hit_leaf)
{
    /* It moves by 1 to the right, onto the ray. */
    const rk_box near = {{{-1, -1, 4}, {-0.5f, 1, 5}}};
    uint32_t child = make_inner(bvh, node, rk_box_merge(left_box, right_box));
    make_leaf(bvh, child, hit_leaf == 2 * pair ? near : left_box);
    make_leaf(bvh, child + 1, hit_leaf == 2 * pair + 1 ? near : right_box);
}

/* The chain continues to the left, to the right, or alternates; the ray may hit one leaf. */
enum { to_the_left, to_the_right, alternating, shapes };

static rk_bvh deep_tree(int shape, uint32_t hit_leaf)
{
    rk_bvh bvh = empty_tree(deep_nodes);
    uint32_t node = 0;
    for (uint32_t level = 0; level < chain_length; level++) {
        uint32_t side = shape == alternating ? level & 1 : shape == to_the_right;
        uint32_t left = make_inner(&bvh, node, rk_box_merge(left_box, right_box));
        make_pair(&bvh, left + 1 - side, level, hit_leaf);
        node = left + side;
    }
    make_pair(&bvh, node, chain_length, hit_leaf);
    return bvh;
}

static void traversal_reaches_the_leaves_of_deep_trees(void **state)
{
    (void)state;
    static const char *const shape_names[] = {"left", "right", "left and right alternately"};
    for (int shape = 0; shape < shapes; shape++)
        for (uint32_t leaf = 0; leaf <= no_leaf; leaf++) {
            rk_bvh bvh = deep_tree(shape, leaf);
            rk_check_equal(bvh.node_count, deep_nodes, "nodes of the test's own tree");
            bool got = may_intersect_leaf(&bvh, 0, 1, INFINITY);
            rk_check(got || leaf == no_leaf,
                     "a tree of %d levels whose chain goes %s: got false, want true, because leaf "
                     "%u of %d, on level %u, moves onto the ray: visit the children of every box "
                     "that is entered, down to the leaves",
                     RK_BVH_LEVELS_MAX, shape_names[shape], leaf, deep_leaves,
                     leaf / 2 < chain_length ? leaf / 2 + 2 : chain_length + 1);
            rk_check(
                !got || leaf < no_leaf,
                "a tree of %d levels whose chain goes %s: got true, want false: the ray enters "
                "all inner nodes, but passes between the leaves; only a node whose count is not "
                "0 is a leaf, and nodes[1] is no node",
                RK_BVH_LEVELS_MAX, shape_names[shape]);
            rk_bvh_free(&bvh);
        }
}

/* All inner boxes are entered, and no leaf, or the last one alone. */
static void traversal_reaches_the_last_of_many_nodes(void **state)
{
    (void)state;
    const uint32_t nodes = 1 << 17, leaves = nodes / 2;
    const rk_box near = {{{-1, -1, 4}, {-0.5f, 1, 5}}};
    for (int hit = 0; hit < 2; hit++) {
        rk_bvh bvh = empty_tree(nodes);
        /* Level by level: the children of node k are 2k and 2k + 1. */
        make_inner(&bvh, 0, rk_box_merge(left_box, right_box));
        for (uint32_t k = 2; k < leaves; k++)
            make_inner(&bvh, k, rk_box_merge(left_box, right_box));
        for (uint32_t k = leaves; k < nodes; k++)
            make_leaf(&bvh, k, k % 2 ? right_box : left_box);
        if (hit)
            bvh.nodes[nodes - 1].box = near;
        rk_check_equal(bvh.node_count, nodes, "nodes of the test's own tree");
        rk_check(may_intersect_leaf(&bvh, 0, 1, INFINITY) == hit,
                 "a tree of %u nodes: got %s, want %s, because %s: a node's index takes 32 bits",
                 nodes, hit ? "false" : "true", hit ? "true" : "false",
                 hit ? "the last leaf moves onto the ray" : "the ray passes between all leaves");
        rk_bvh_free(&bvh);
    }
}

static void a_ray_that_misses_all_swept_leaves_never_hits_a_leaf(void **state)
{
    (void)state;
    uint32_t hits = 0, missed = 0;
    rk_bvh bvh = empty_tree(4); /* one for all rays: the sanitizer makes allocations slow */
    for (uint32_t i = 0; i < 50000; i++) {
        uint32_t tree = i / 64;
        float unit = unit_of(tree);
        const rk_motion motion = path_in(unit, random_path(i));
        const rk_shutter shutter = shutter_in(unit, random_shutter(i / 2));
        if (i % 64 == 0)
            make_two_leaves(&bvh, box_in(unit, random_box(tree)),
                            box_in(unit, random_box(tree + 200000)));
        const rk_box *leaf = &bvh.nodes[2 + i % 2].box;
        rk_vec3 offset = rk_motion_offset(&motion, i & 4 ? shutter.open : shutter.close);
        const rk_ray ray = grazing_ray(i, unit, leaf, offset), moved = rk_motion_ray(offset, &ray);
        const rk_slabs slabs = rk_slabs_of(&ray), moved_slabs = rk_slabs_of(&moved);
        const rk_box swept = sweep(&motion, &shutter, &bvh.nodes[0].box);
        float enter = rk_box_enter(leaf, &moved_slabs, INFINITY);
        bool hit = enter < INFINITY;
        const float ends[] = {INFINITY, end_of(&moved, leaf, enter)};
        bool may_hit[2];
        for (int end = 0; end < 2; end++)
            may_hit[end] = rk_motion_may_intersect_leaf(&bvh, &swept, &slabs, ends[end]);
        for (int end = 0; end < 2; end++)
            if (hit && !may_hit[end])
                fail_lost_ray(i, &ray, ends[end], offset);
        hits += hit;
        missed += !may_hit[0];
    }
    rk_bvh_free(&bvh);
    rk_check(hits > 1000 && missed > 1000,
             "of 50000 rays along edges of leaves %u enter the leaf and %u miss all leaves; want "
             "more than 1000 of each: are boxes below the root enlarged by more than the root's?",
             hits, missed);
}

/* --- Coverage --------------------------------------------------------------------------------- */

static bool covers_edge(rk_vec3 offset, float point, float start)
{
    /* At rest the object is the half-plane left of x = start. */
    const rk_ray ray = {{point, 0, -1}, {0, 0, 1}, INFINITY}, moved = rk_motion_ray(offset, &ray);
    return moved.origin.x < start;
}

static double disk_radius = 0.5;

static bool covers_disk(rk_vec3 offset, float x, float y)
{
    const rk_ray ray = {{x, y, -1}, {0, 0, 1}, INFINITY}, moved = rk_motion_ray(offset, &ray);
    return hypot((double)moved.origin.x, (double)moved.origin.y) < disk_radius;
}

/* The fraction of the shutter during which the edge, moving along x, is beyond the point. */
static double edge_coverage(const rk_shutter *shutter, double point)
{
    double from = fmax((double)shutter->open, point), close = (double)shutter->close;
    return fmin(1, fmax(0, (close - from) / (close - (double)shutter->open)));
}

static void a_moving_edge_covers_a_point_for_the_expected_time(void **state)
{
    (void)state;
    const rk_shutter shutter = {0.25f, 2};
    const rk_motion motion = {0, 0, 0};
    for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++)
        for (uint32_t samples = 4; samples <= 256; samples *= 4)
            for (uint32_t i = 0; i <= 100; i++) {
                float point = (float)i * 0.025f;
                uint32_t covered = 0;
                for (uint32_t k = 0; k < samples; k++) {
                    float x =
                        rk_shutter_time(&shutter, (rk_time_sampling)sampling, 1, i, k, samples);
                    covered += covers_edge(rk_motion_offset(&motion, x), point, 0);
                }
                /* The edge passes once: one part of the shutter is uncertain, or half of it where
                 * times are the middles. A float's rounding may flip one more time. */
                double uncertain = sampling == RK_TIME_EQUIDISTANT ? 0.5 : 1;
                double got = (double)covered / samples;
                double want = edge_coverage(&shutter, (double)point);
                rk_check(
                    fabs(got - want) <= uncertain / samples + 1e-6,
                    "%s, shutter [0.25, 2], pixel %u: at %g of %u times the edge is beyond x = "
                    "%g, a fraction of %.4f, want %.4f within %.4f, as in the shutter interval",
                    names[sampling], i, (double)covered, samples, (double)point, got, want,
                    uncertain / samples);
            }
}

/* The fraction of the shutter during which a disk around (x, c x) covers the point: the chord of
 * its straight path, |p - v x| < r, over the length of the shutter. */
static double disk_coverage(const rk_shutter *shutter, double c, double px, double py)
{
    double along = 1 + c * c, b = px + c * py, rest = px * px + py * py - disk_radius * disk_radius;
    double discriminant = b * b - along * rest;
    if (discriminant <= 0)
        return 0;
    double open = (double)shutter->open, close = (double)shutter->close;
    double from = fmax(open, (b - sqrt(discriminant)) / along);
    double to = fmin(close, (b + sqrt(discriminant)) / along);
    return fmax(0, to - from) / (close - open);
}

static void a_moving_disk_covers_a_point_along_a_chord_of_its_path(void **state)
{
    (void)state;
    const rk_shutter shutter = {-1, 2};
    const rk_motion motion = {0, 0, 0.75f};
    const uint32_t samples = 64;
    uint32_t partly = 0;
    for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++)
        for (uint32_t i = 0; i < 1000; i++) {
            float px = random_float(i, 60, -1.5f, 2.5f), py = random_float(i, 61, -1.5f, 2.5f);
            uint32_t covered = 0;
            for (uint32_t k = 0; k < samples; k++) {
                float x = rk_shutter_time(&shutter, (rk_time_sampling)sampling, 1, i, k, samples);
                covered += covers_disk(rk_motion_offset(&motion, x), px, py);
            }
            double want = disk_coverage(&shutter, 0.75, (double)px, (double)py);
            partly += want > 0;
            /* It comes and goes: two parts of the shutter are uncertain. */
            rk_check(fabs((double)covered / samples - want) <= 2.0 / samples + 1e-6,
                     "%s, shutter [-1, 2], pixel %u: at %u of %u times the disk covers (%g, %g), a "
                     "fraction of %.4f, want %.4f within %.4f: the chord over the path",
                     names[sampling], i, covered, samples, (double)px, (double)py,
                     (double)covered / samples, want, 2.0 / samples);
        }
    rk_check(partly > 300, "only %u points are covered at all", partly);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(at_time_zero_everything_rests),
    cmocka_unit_test(the_offset_is_x_and_a_cubic_of_x),
    cmocka_unit_test(the_offset_is_rounded_once),
    cmocka_unit_test(the_ray_moves_the_other_way),
    cmocka_unit_test(a_moved_ray_hits_the_object_at_rest_at_the_same_t),
    cmocka_unit_test(equidistant_times_are_the_middles_of_equal_parts),
    cmocka_unit_test(times_before_and_after_the_shutter_continue_the_sequence),
    cmocka_unit_test(equidistant_times_are_the_same_for_all_pixels),
    cmocka_unit_test(stratified_times_lie_one_in_each_part),
    cmocka_unit_test(low_discrepancy_times_are_stratified_for_each_power_of_two),
    cmocka_unit_test(pixels_and_seeds_have_random_times_of_their_own),
    cmocka_unit_test(random_times_are_drawn_from_the_dimension_of_time),
    cmocka_unit_test(times_fill_the_shutter_and_never_leave_it),
    cmocka_unit_test(the_last_of_the_most_samples_is_within_the_shutter),
    cmocka_unit_test(a_straight_path_sweeps_from_its_beginning_to_its_end),
    cmocka_unit_test(a_parabola_turns_at_its_vertex),
    cmocka_unit_test(a_cubic_turns_twice),
    cmocka_unit_test(a_level_point_is_no_turning_point),
    cmocka_unit_test(turning_points_keep_their_digits_when_one_is_far_away),
    cmocka_unit_test(steep_and_flat_paths_turn_like_others),
    cmocka_unit_test(a_swept_box_holds_the_box_at_every_time),
    cmocka_unit_test(a_swept_box_holds_paths_whose_terms_cancel),
    cmocka_unit_test(a_swept_box_is_no_larger_than_the_path),
    cmocka_unit_test(a_ray_may_hit_a_box_that_it_enters_before_t_max),
    cmocka_unit_test(a_ray_that_misses_the_swept_box_never_hits_the_object),
    cmocka_unit_test(a_ray_between_the_leaves_hits_none),
    cmocka_unit_test(a_ray_between_leaves_that_rise_hits_none),
    cmocka_unit_test(leaves_behind_a_ray_or_beyond_its_end_do_not_count),
    cmocka_unit_test(subtrees_that_the_ray_misses_are_not_visited),
    cmocka_unit_test(a_tree_may_be_a_single_leaf),
    cmocka_unit_test(traversal_reaches_the_leaves_of_deep_trees),
    cmocka_unit_test(traversal_reaches_the_last_of_many_nodes),
    cmocka_unit_test(a_ray_that_misses_all_swept_leaves_never_hits_a_leaf),
    cmocka_unit_test(a_moving_edge_covers_a_point_for_the_expected_time),
    cmocka_unit_test(a_moving_disk_covers_a_point_along_a_chord_of_its_path),
};

RK_SUITE("motion_blur", tests)
