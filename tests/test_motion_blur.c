/* Motion blur: paths and times against formulas, swept boxes against dense trials and exact
 * extremes, and blurred edges and disks against the share of time in closed form. */
#include "test.h"

#include "base/random.h"
#include "base/triangle.h"
#include "features/motion_blur.h"

static float random_float(uint32_t i, uint32_t what, float low, float high)
{
    return low + (high - low) * rk_unit_float(rk_hash(i, what, 10, 0));
}

/* --- Where it is ------------------------------------------------------------------------------ */

static void at_time_zero_everything_rests(void **state)
{
    (void)state;
    const rk_motion paths[] = {rk_motion_default(), {1, 2, 3}, {-1e6f, 0, 1e6f}};
    for (int i = 0; i < 3; i++) {
        rk_vec3 offset = rk_motion_offset(&paths[i], 0);
        rk_check(offset.x == 0 && offset.y == 0 && offset.z == 0, "path %d begins at (%g, %g, %g)",
                 i, (double)offset.x, (double)offset.y, (double)offset.z);
    }
}

static void check_offset(rk_motion motion, float x, double y)
{
    rk_vec3 got = rk_motion_offset(&motion, x);
    rk_check_close(got.x, x, 0, "along x the path goes evenly");
    rk_check_close(got.y, y, 0, "a x^3 + b x^2 + c x: these numbers need no rounding");
    rk_check_close(got.z, 0, 0, "nothing moves along z");
}

static void the_offset_is_x_and_a_cubic_of_x(void **state)
{
    (void)state;
    check_offset((rk_motion){1, 0, 0}, 2, 8);
    check_offset((rk_motion){0, 1, 0}, 3, 9);
    check_offset((rk_motion){0, 0, 1}, 5, 5);
    check_offset((rk_motion){2, -3, 4}, -2, -36);
    check_offset(rk_motion_default(), 0.5f, 0.375);
    check_offset(rk_motion_default(), 1, -2);
}

static void the_offset_is_rounded_once(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        /* Near a root of y, where the terms cancel. */
        float root = random_float(i, 0, 0.5f, 2), x = root * random_float(i, 1, 0.9999f, 1.0001f);
        float a = random_float(i, 2, -4, 4), b = random_float(i, 3, -4, 4);
        const rk_motion motion = {a, b, -(a * root + b) * root};
        double exact =
            (((double)motion.a * (double)x + (double)motion.b) * (double)x + (double)motion.c) *
            (double)x;
        float got = rk_motion_offset(&motion, x).y;
        /* Half of a float's last place, and what the double on either side rounds. */
        double tolerance = fabs(exact) * 0x1p-24 + 1e-13;
        rk_check(
            fabs((double)got - exact) <= tolerance,
            "y(%.9g) of (%g, %g, %g): got %.9g, want %.9g: compute in double, round at the end",
            (double)x, (double)motion.a, (double)motion.b, (double)motion.c, (double)got, exact);
    }
}

static void the_ray_moves_the_other_way(void **state)
{
    (void)state;
    const rk_ray ray = {{1, 2, 3}, {0.5f, 0.25f, -1}, 7};
    rk_ray moved = rk_motion_ray(rk_vec(0.5f, -1, 0), &ray);
    rk_check(moved.origin.x == 0.5f && moved.origin.y == 3 && moved.origin.z == 3,
             "got the origin (%g, %g, %g), want (0.5, 3, 3): the origin less the offset",
             (double)moved.origin.x, (double)moved.origin.y, (double)moved.origin.z);
    rk_check(memcmp(&moved.direction, &ray.direction, sizeof ray.direction) == 0,
             "the direction stays");
    rk_check_close(moved.t_max, 7, 0, "and so does the end");
}

static rk_triangle triangle_at(rk_vec3 offset)
{
    return (rk_triangle){rk_add(rk_vec(-1, -1, 0), offset), {4, 0, 0}, {0, 4, 0}, 0};
}

static void a_moved_ray_meets_the_object_where_it_has_gone(void **state)
{
    (void)state;
    const rk_motion motion = {1, 0, -1};
    uint32_t met = 0;
    for (int i = -64; i <= 64; i++) {
        float x = (float)i / 16;
        rk_vec3 offset = rk_motion_offset(&motion, x);
        const rk_ray ray = {{0.25f, 0.5f, -2}, {0, 0, 1}, INFINITY};
        const rk_ray moved = rk_motion_ray(offset, &ray);
        const rk_triangle rest = triangle_at(rk_vec(0, 0, 0)), gone = triangle_at(offset);
        rk_hit want = {0}, got = {0};
        bool should = rk_triangle_cross(&gone, &ray, &want);
        rk_check(rk_triangle_cross(&rest, &moved, &got) == should,
                 "x = %g: the moved ray should %s the triangle at rest", (double)x,
                 should ? "meet" : "miss");
        if (should)
            rk_check_close(got.t, want.t, 0, "t is the same in both frames");
        met += should;
    }
    rk_check(met > 10 && met < 100, "some should meet and some miss: %u met", met);
}

/* --- When ------------------------------------------------------------------------------------- */

static void equidistant_times_are_the_middles_of_equal_parts(void **state)
{
    (void)state;
    const rk_shutter shutter = {-1, 7};
    for (uint32_t k = 1; k <= 4; k++)
        rk_check_close(rk_shutter_equidistant(&shutter, (float)k, 4), 2 * (double)k - 2, 0,
                       "four parts of length 2 from -1 on: 0, 2, 4, 6, and neither end");
    rk_check_close(rk_shutter_equidistant(&shutter, 1, 1), 3, 0, "one time: the middle");
}

static void times_before_and_after_the_shutter_continue_the_row(void **state)
{
    (void)state;
    const rk_shutter shutter = {-1, 7};
    rk_check_close(rk_shutter_equidistant(&shutter, 0, 4), -2, 0, "one before the first");
    rk_check_close(rk_shutter_equidistant(&shutter, -3, 4), -8, 0, "four before the first");
    rk_check_close(rk_shutter_equidistant(&shutter, 5, 4), 8, 0, "one behind the last");
    rk_check_close(rk_shutter_equidistant(&shutter, 500, 4), 998, 0, "far behind the last");
}

static void equidistant_times_are_the_same_for_all_pixels(void **state)
{
    (void)state;
    const rk_shutter shutter = {0, 0.25f};
    for (uint32_t pixel = 0; pixel < 100; pixel++)
        for (uint32_t i = 0; i < 20; i++)
            rk_check_close(rk_shutter_time(&shutter, RK_TIME_EQUIDISTANT, pixel, pixel, i, 20),
                           (i + 0.5) / 80, 0x1p-24,
                           "sample 0 is the time 1, whatever pixel and seed");
}

/* Is there one time in each of as many equal parts as there are samples? */
static void check_one_in_each_part(rk_time_sampling sampling, uint32_t pixel, uint32_t samples)
{
    const rk_shutter shutter = {0, 1};
    uint32_t taken[64] = {0};
    for (uint32_t i = 0; i < samples; i++) {
        float x = rk_shutter_time(&shutter, sampling, 3, pixel, i, samples);
        /* In whole numbers of 2^-24: a product in float may round up into the next part. */
        uint32_t part = (uint32_t)((double)x * samples);
        rk_check(part < samples && !taken[part]++, "pixel %u, %u samples: part %u has two times",
                 pixel, samples, part);
    }
}

static void stratified_times_lie_one_in_each_part(void **state)
{
    (void)state;
    for (uint32_t pixel = 0; pixel < 50; pixel++)
        for (uint32_t samples = 1; samples <= 64; samples++)
            check_one_in_each_part(RK_TIME_STRATIFIED, pixel, samples);
    /* In order, so that sample i of neighbouring pixels sees nearly the same scene. */
    const rk_shutter shutter = {0, 1};
    for (uint32_t i = 0; i < 64; i++) {
        double x = (double)rk_shutter_time(&shutter, RK_TIME_STRATIFIED, 3, 7, i, 64);
        rk_check(x >= i / 64.0 && x <= (i + 1) / 64.0, "sample %u of 64: the time %.6f", i, x);
    }
}

static void low_discrepancy_times_do_so_for_each_power_of_two(void **state)
{
    (void)state;
    for (uint32_t pixel = 0; pixel < 50; pixel++)
        for (uint32_t samples = 1; samples <= 64; samples *= 2)
            check_one_in_each_part(RK_TIME_LOW_DISCREPANCY, pixel, samples);
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
        rk_check(same <= 1, "%u times of 400 are those of the neighbour or of another seed", same);
    }
}

static void times_fill_the_shutter_and_never_leave_it(void **state)
{
    (void)state;
    const rk_shutter shutters[] = {{0, 0.05f}, {-3, 11}, {0.1f, 0.1000001f}, {7, 7}};
    for (int s = 0; s < 4; s++)
        for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++) {
            double open = (double)shutters[s].open, close = (double)shutters[s].close, sum = 0;
            for (uint32_t i = 0; i < 64; i++) {
                double x =
                    (double)rk_shutter_time(&shutters[s], (rk_time_sampling)sampling, 9, 5, i, 64);
                rk_check(x >= open && x <= close, "%.9g is not in [%.9g, %.9g]", x, open, close);
                sum += x;
            }
            /* Each is at most a 64th of the shutter away from the middle of its part; and floats
             * round. */
            double tolerance = (close - open) / 64 + 0x1p-24 * fabs(close);
            rk_check_close(sum / 64, (open + close) / 2, tolerance, "the mean is the middle");
        }
}

/* --- Where it may be -------------------------------------------------------------------------- */

/* What the header allows: 2^-19 of corner and offset, and the floats that are rounded. */
static double leave(double corner, double offset)
{
    return (fabs(corner) + fabs(offset)) * (0x1p-19 + 2 * 0x1p-24);
}

static void check_heights(rk_motion motion, rk_shutter shutter, double low, double high,
                          const char *hint)
{
    const rk_box rest = {{{-1, -0.5f, 2}, {3, 0.5f, 4}}};
    rk_box swept = rk_motion_sweep(&motion, &shutter, &rest);
    double open = (double)shutter.open, close = (double)shutter.close;
    double leave_x = leave(3, fmax(fabs(open), fabs(close)));
    double leave_y = leave(0.5, fmax(fabs(low), fabs(high)));
    rk_check_close(swept.corner[0].x, -1 + open, leave_x, "x, from where the shutter opens");
    rk_check_close(swept.corner[1].x, 3 + close, leave_x, "x, to where it closes");
    rk_check_close(swept.corner[0].y, low - 0.5, leave_y, hint);
    rk_check_close(swept.corner[1].y, high + 0.5, leave_y, hint);
    rk_check_close(swept.corner[0].z, 2, leave(4, 0), "z stays");
    rk_check_close(swept.corner[1].z, 4, leave(4, 0), "z stays");
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
    check_heights((rk_motion){0, 1, 0}, (rk_shutter){-2, 1}, 0, 4, "x^2: lowest at 0");
    check_heights((rk_motion){0, -4, 4}, (rk_shutter){0, 1}, 0, 1, "4 x - 4 x^2: highest at 1/2");
    check_heights((rk_motion){0, -4, 4}, (rk_shutter){0.75f, 1}, 0, 0.75, "beyond the vertex");
}

static void a_cubic_turns_twice(void **state)
{
    (void)state;
    const double third = 2 / (3 * sqrt(3)); /* x^3 - x turns at 1 / sqrt(3) */
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-1, 1}, -third, third, "both within");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){0, 1}, -third, 0, "the second alone");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-1, 0}, 0, third, "the first alone");
    check_heights((rk_motion){-1, 0, 1}, (rk_shutter){-1, 1}, -third, third, "the other way up");
    check_heights((rk_motion){1, 0, -1}, (rk_shutter){-0.5f, 0.5f}, -0.375, 0.375,
                  "it turns before and after the shutter: that does not count");
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
    /* With a tiny a the second turn is far out; the first is the parabola's, all but unchanged. */
    for (float a = 1; a > 1e-30f; a /= 16) {
        const rk_motion motion = {a * 1e-3f, -4, 4};
        /* 4 x - 4 x^2 turns at 1/2; a x^3 adds a / 8 there, and moves the turn in second order. */
        double y = 1 + (double)motion.a / 8;
        rk_box swept = rk_motion_sweep(&motion, &(rk_shutter){0.25f, 0.75f},
                                       &(rk_box){{{0, 0, 0}, {0, 0, 0}}});
        double tolerance = leave(0, y) + (double)motion.a * (double)motion.a;
        rk_check_close(swept.corner[1].y, y, tolerance, "the difference of two near numbers?");
    }
}

/* A random path that turns, as most do, somewhere near the shutter. */
static rk_motion random_path(uint32_t i)
{
    float size = exp2f(random_float(i, 20, -10, 10));
    rk_motion motion = {random_float(i, 21, -size, size), random_float(i, 22, -size, size),
                        random_float(i, 23, -size, size)};
    if (i % 4 == 1)
        motion.a = 0;
    if (i % 4 == 2) /* all but a double root of y' */
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

/* The path, worked out here. */
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
        const rk_box rest = random_box(i), swept = rk_motion_sweep(&motion, &shutter, &rest);
        for (uint32_t k = 0; k <= 1000; k++) {
            rk_vec3 offset = true_offset(&motion, time_in(&shutter, k, 1000));
            rk_vec3 low = rk_add(rest.corner[0], offset), high = rk_add(rest.corner[1], offset);
            for (int axis = 0; axis < 3; axis++)
                rk_check(rk_axis(swept.corner[0], axis) <= rk_axis(low, axis) &&
                             rk_axis(swept.corner[1], axis) >= rk_axis(high, axis),
                         "path (%g, %g, %g): at x = %.9g the box sticks out on axis %d",
                         (double)motion.a, (double)motion.b, (double)motion.c,
                         (double)time_in(&shutter, k, 1000), axis);
        }
    }
}

static void a_swept_box_is_no_larger_than_the_way(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 2000; i++) {
        const rk_motion motion = random_path(i);
        const rk_shutter shutter = random_shutter(i);
        const rk_box point = {{{0, 0, 0}, {0, 0, 0}}};
        const rk_box swept = rk_motion_sweep(&motion, &shutter, &point);
        double low = INFINITY, high = -INFINITY;
        for (uint32_t k = 0; k <= 1000; k++) {
            double y = (double)true_offset(&motion, time_in(&shutter, k, 1000)).y;
            low = fmin(low, y);
            high = fmax(high, y);
        }
        /* Between two tries the extreme may be h^2 / 8 max |y''| higher. */
        double h = (double)(shutter.close - shutter.open) / 1000, size = 4;
        double bend = 6 * fabs((double)motion.a) * size + 2 * fabs((double)motion.b);
        double tolerance = h * h / 8 * bend + leave(0, fmax(fabs(low), fabs(high))) + 1e-10;
        rk_check_close(swept.corner[0].y, low, tolerance, "the lowest point of the way");
        rk_check_close(swept.corner[1].y, high, tolerance, "the highest point of the way");
    }
}

/* --- Which rays need a time ------------------------------------------------------------------- */

static void a_ray_reaches_what_its_way_to_t_max_enters(void **state)
{
    (void)state;
    const rk_box swept = {{{-1, -1, 4}, {1, 1, 5}}};
    const rk_ray towards = {{0, 0, 0}, {0, 0, 1}, INFINITY}, away = {{0, 0, 0}, {0, 0, -1}, 9};
    const rk_ray beside = {{2, 0, 0}, {0, 0, 1}, INFINITY};
    const rk_slabs slabs[] = {rk_slabs_of(&towards), rk_slabs_of(&away), rk_slabs_of(&beside)};
    rk_check(rk_motion_reaches(&swept, &slabs[0], INFINITY), "straight into it");
    rk_check(rk_motion_reaches(&swept, &slabs[0], 4.5f), "it is stopped inside");
    rk_check(!rk_motion_reaches(&swept, &slabs[0], 3.5f), "it is stopped before");
    rk_check(!rk_motion_reaches(&swept, &slabs[1], INFINITY), "the box is behind it");
    rk_check(!rk_motion_reaches(&swept, &slabs[2], INFINITY), "past it");
}

/* A ray from near or far that passes an edge along z of the box, moved to `offset`, within some
 * dozens of roundings, on either side. */
static rk_ray grazing_ray(uint32_t i, const rk_box *rest, rk_vec3 offset)
{
    bool right = i & 1, top = i & 2;
    float far = exp2f(random_float(i, 50, 0, 12)), aside = far * 0x1p-24f;
    rk_vec3 at = rk_vec(rest->corner[right].x + random_float(i, 51, -64, 64) * aside,
                        rest->corner[top].y + random_float(i, 52, -64, 64) * aside,
                        random_float(i, 53, rest->corner[0].z, rest->corner[1].z));
    float x = random_float(i, 54, 0, 1), y = random_float(i, 55, 0, right == top ? -1 : 1);
    rk_vec3 direction = rk_vec(x, y, random_float(i, 56, -1, 1));
    return (rk_ray){rk_madd(rk_add(at, offset), direction, -far), direction, INFINITY};
}

static void a_ray_that_does_not_reach_the_swept_box_never_meets_the_object(void **state)
{
    (void)state;
    uint32_t met = 0, missed = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        const rk_motion motion = random_path(i);
        const rk_shutter shutter = random_shutter(i / 2);
        const rk_box rest = random_box(i / 2);
        /* Grazing at one end of the way, where the swept box is no wider than the object. */
        rk_vec3 offset = rk_motion_offset(&motion, i & 4 ? shutter.open : shutter.close);
        const rk_ray ray = grazing_ray(i, &rest, offset), moved = rk_motion_ray(offset, &ray);
        const rk_slabs slabs = rk_slabs_of(&ray), moved_slabs = rk_slabs_of(&moved);
        const rk_box swept = rk_motion_sweep(&motion, &shutter, &rest);
        bool meets = rk_box_enter(&rest, &moved_slabs, INFINITY) < INFINITY;
        rk_check(!meets || rk_motion_reaches(&swept, &slabs, INFINITY),
                 "ray %u enters the object's own box, but is said never to reach it", i);
        met += meets;
        missed += !rk_motion_reaches(&swept, &slabs, INFINITY);
    }
    rk_check(met > 1000 && missed > 1000, "%u rays met the box and %u missed the swept one", met,
             missed);
}

/* Two leaves and their root. */
typedef struct small_tree {
    rk_bvh_node nodes[4];
    rk_bvh bvh;
} small_tree;

static void grow(small_tree *tree, rk_box left, rk_box right)
{
    tree->nodes[0] = (rk_bvh_node){rk_box_merge(left, right), 2, 0};
    tree->nodes[2] = (rk_bvh_node){left, 0, 1};
    tree->nodes[3] = (rk_bvh_node){right, 1, 1};
    tree->bvh = (rk_bvh){.node_count = 4, .triangle_count = 2, .nodes = tree->nodes};
}

static void check_leaf(float x, float close, float t_max, bool want, const char *hint)
{
    small_tree tree;
    grow(&tree, (rk_box){{{-4, -1, 4}, {-2, 1, 5}}}, (rk_box){{{2, -1, 4}, {4, 1, 5}}});
    const rk_motion level = {0, 0, 0};
    const rk_shutter shutter = {0, close};
    const rk_box swept = rk_motion_sweep(&level, &shutter, &tree.nodes[0].box);
    const rk_ray ray = {{x, 0, 0}, {0, 0, 1}, INFINITY};
    const rk_slabs slabs = rk_slabs_of(&ray);
    rk_check(rk_motion_reaches(&swept, &slabs, INFINITY), "the root's box holds all of it");
    rk_check(rk_motion_reaches_leaf(&tree.bvh, &swept, &slabs, t_max) == want,
             "a ray at x = %g to t = %g should %s a leaf: %s", (double)x, (double)t_max,
             want ? "reach" : "not reach", hint);
}

static void a_ray_between_the_leaves_reaches_none(void **state)
{
    (void)state;
    check_leaf(-3, 1, INFINITY, true, "straight into the left one");
    check_leaf(3, 1, INFINITY, true, "straight into the right one");
    check_leaf(3, 1, 3.5f, false, "it is stopped before");
    check_leaf(0, 1, INFINITY, false, "the left one comes as far as -1");
    check_leaf(-1.5f, 1, INFINITY, true, "the left one comes there");
    check_leaf(1.5f, 1, INFINITY, false, "the right one moves away");
    check_leaf(0, 3, INFINITY, true, "the left one comes as far as 1");
}

static void a_ray_that_reaches_no_leaf_never_meets_one(void **state)
{
    (void)state;
    uint32_t met = 0, missed = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        const rk_motion motion = random_path(i);
        const rk_shutter shutter = random_shutter(i / 2);
        small_tree tree;
        grow(&tree, random_box(i / 2), random_box(i / 2 + 200000));
        const rk_box *leaf = &tree.nodes[2 + i % 2].box;
        rk_vec3 offset = rk_motion_offset(&motion, i & 4 ? shutter.open : shutter.close);
        const rk_ray ray = grazing_ray(i, leaf, offset), moved = rk_motion_ray(offset, &ray);
        const rk_slabs slabs = rk_slabs_of(&ray), moved_slabs = rk_slabs_of(&moved);
        const rk_box swept = rk_motion_sweep(&motion, &shutter, &tree.nodes[0].box);
        bool meets = rk_box_enter(leaf, &moved_slabs, INFINITY) < INFINITY;
        bool reaches = rk_motion_reaches_leaf(&tree.bvh, &swept, &slabs, INFINITY);
        rk_check(!meets || reaches, "ray %u enters a leaf, but is said never to reach one", i);
        met += meets;
        missed += !reaches;
    }
    rk_check(met > 1000 && missed > 1000, "%u rays met a leaf and %u reached none", met, missed);
}

/* --- Coverage --------------------------------------------------------------------------------- */

static bool covers_edge(rk_vec3 offset, float point, float start)
{
    /* What is left of x = start when at rest. */
    const rk_ray ray = {{point, 0, -1}, {0, 0, 1}, INFINITY}, moved = rk_motion_ray(offset, &ray);
    return moved.origin.x < start;
}

static double disk_radius = 0.5;

static bool covers_disk(rk_vec3 offset, float x, float y)
{
    const rk_ray ray = {{x, y, -1}, {0, 0, 1}, INFINITY}, moved = rk_motion_ray(offset, &ray);
    return hypot((double)moved.origin.x, (double)moved.origin.y) < disk_radius;
}

/* The share of the shutter during which the edge, moving along x, is beyond the point. */
static double edge_coverage(const rk_shutter *shutter, double point)
{
    double from = fmax((double)shutter->open, point), close = (double)shutter->close;
    return fmin(1, fmax(0, (close - from) / (close - (double)shutter->open)));
}

static void a_moving_edge_covers_a_point_for_its_share_of_the_time(void **state)
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
                /* The edge passes once: one part of the shutter is in doubt, half of it where times
                 * are the middles. A float's rounding may tip one time more. */
                double doubt = sampling == RK_TIME_EQUIDISTANT ? 0.5 : 1;
                rk_check_close((double)covered / samples, edge_coverage(&shutter, (double)point),
                               doubt / samples + 1e-6, "share of the times");
            }
}

/* The share of the shutter during which a disk around (x, c x) holds the point: the chord of its
 * straight way, |p - v x| < r, over the length of the shutter. */
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

static void a_moving_disk_covers_a_point_for_its_chord_of_the_way(void **state)
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
            /* It comes and goes: two parts of the shutter are in doubt. */
            rk_check_close((double)covered / samples, want, 2.0 / samples + 1e-6,
                           "the chord over the way");
        }
    rk_check(partly > 300, "only %u points are covered at all", partly);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(at_time_zero_everything_rests),
    cmocka_unit_test(the_offset_is_x_and_a_cubic_of_x),
    cmocka_unit_test(the_offset_is_rounded_once),
    cmocka_unit_test(the_ray_moves_the_other_way),
    cmocka_unit_test(a_moved_ray_meets_the_object_where_it_has_gone),
    cmocka_unit_test(equidistant_times_are_the_middles_of_equal_parts),
    cmocka_unit_test(times_before_and_after_the_shutter_continue_the_row),
    cmocka_unit_test(equidistant_times_are_the_same_for_all_pixels),
    cmocka_unit_test(stratified_times_lie_one_in_each_part),
    cmocka_unit_test(low_discrepancy_times_do_so_for_each_power_of_two),
    cmocka_unit_test(pixels_and_seeds_have_random_times_of_their_own),
    cmocka_unit_test(times_fill_the_shutter_and_never_leave_it),
    cmocka_unit_test(a_straight_path_sweeps_from_its_beginning_to_its_end),
    cmocka_unit_test(a_parabola_turns_at_its_vertex),
    cmocka_unit_test(a_cubic_turns_twice),
    cmocka_unit_test(a_level_point_is_no_turning_point),
    cmocka_unit_test(turning_points_keep_their_digits_when_one_is_far_away),
    cmocka_unit_test(a_swept_box_holds_the_box_at_every_time),
    cmocka_unit_test(a_swept_box_is_no_larger_than_the_way),
    cmocka_unit_test(a_ray_reaches_what_its_way_to_t_max_enters),
    cmocka_unit_test(a_ray_that_does_not_reach_the_swept_box_never_meets_the_object),
    cmocka_unit_test(a_ray_between_the_leaves_reaches_none),
    cmocka_unit_test(a_ray_that_reaches_no_leaf_never_meets_one),
    cmocka_unit_test(a_moving_edge_covers_a_point_for_its_share_of_the_time),
    cmocka_unit_test(a_moving_disk_covers_a_point_for_its_chord_of_the_way),
};

RK_SUITE("motion_blur", tests)
