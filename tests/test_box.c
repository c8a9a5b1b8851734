/* Boxes: extents, and the slab test against exact arithmetic. A box that the ray touches is never
 * lost; a box that it does not touch is hit only if the ray passes within a few roundings. */
#include "test.h"

#include "base/box.h"
#include "base/random.h"

static rk_box box_of(rk_vec3 low, rk_vec3 high)
{
    return (rk_box){{low, high}};
}

static float enter(rk_box box, rk_vec3 origin, rk_vec3 direction, float t_max)
{
    rk_ray ray = {origin, direction, t_max};
    rk_slabs slabs = rk_slabs_of(&ray);
    return rk_box_enter(&box, &slabs, t_max);
}

/* --- boxes ----------------------------------------------------------------------------------- */

static void an_empty_box_takes_the_shape_of_what_is_added(void **state)
{
    (void)state;
    rk_box box = rk_box_add(rk_box_empty(), rk_vec(1, -2, 3));
    rk_check(memcmp(&box, &(rk_box){{{1, -2, 3}, {1, -2, 3}}}, sizeof box) == 0, "one point");
    box = rk_box_add(box, rk_vec(0, 5, 3));
    rk_check(memcmp(&box, &(rk_box){{{0, -2, 3}, {1, 5, 3}}}, sizeof box) == 0, "two points");
    rk_box merged = rk_box_merge(rk_box_empty(), box);
    rk_check(memcmp(&box, &merged, sizeof box) == 0, "nothing merged with a box is the box");
    merged = rk_box_merge(box, box_of(rk_vec(0.5f, -3, 2), rk_vec(0.75f, 0, 9)));
    rk_check(memcmp(&merged, &(rk_box){{{0, -3, 2}, {1, 5, 9}}}, sizeof box) == 0, "two boxes");
}

static void the_area_counts_six_faces(void **state)
{
    (void)state;
    rk_check_close(rk_box_area(box_of(rk_vec(1, 1, 1), rk_vec(2, 3, 4))), 22, 0, "2 (2 + 6 + 3)");
    rk_check_close(rk_box_area(box_of(rk_vec(0, 0, 0), rk_vec(0, 3, 4))), 24, 0, "flat: two faces");
    rk_check_close(rk_box_area(rk_box_empty()), 0, 0, "an empty box has no faces");
}

static void the_longest_axis_prefers_x_then_y_among_equals(void **state)
{
    (void)state;
    const struct {
        rk_vec3 extent;
        int axis;
    } cases[] = {{{1, 1, 1}, 0}, {{2, 2, 1}, 0}, {{2, 1, 2}, 0}, {{1, 2, 2}, 1}, {{3, 2, 1}, 0},
                 {{1, 2, 1}, 1}, {{1, 1, 2}, 2}, {{0, 0, 0}, 0}, {{1, 2, 3}, 2}, {{2, 3, 1}, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        rk_check_equal(rk_box_longest_axis(box_of(rk_vec(0, 0, 0), cases[i].extent)), cases[i].axis,
                       "x before y before z");
    /* Differences that overflow a float, all to the same infinity. */
    for (int axis = 0; axis < 3; axis++) {
        rk_vec3 half =
            rk_vec(axis == 0 ? 3e38f : 2e38f, axis == 1 ? 3e38f : 2e38f, axis == 2 ? 3e38f : 2e38f);
        rk_check_equal(rk_box_longest_axis(box_of(rk_negate(half), half)), axis,
                       "extents too large for a float still differ");
    }
}

/* --- the slab test by hand ------------------------------------------------------------------- */

static const rk_box unit = {{{0, 0, 0}, {1, 1, 1}}};

/* Relative slack of a slab's t: 6 units of 2^-24 by which the reciprocals are pushed apart, and
 * four roundings (reciprocal, pushing, difference, product). */
#define SLACK (10.5 * 0x1p-24)

static void a_ray_enters_at_the_nearest_face(void **state)
{
    (void)state;
    rk_check_close(enter(unit, rk_vec(-2, 0.5f, 0.5f), rk_vec(1, 0, 0), INFINITY), 2, 2 * SLACK,
                   "x = 0");
    rk_check_close(enter(unit, rk_vec(0.5f, 3, 0.5f), rk_vec(0, -2, 0), INFINITY), 1, SLACK,
                   "y = 1");
    rk_check_close(enter(unit, rk_vec(-1, -1, -1), rk_vec(1, 1, 1), INFINITY), 1, SLACK,
                   "a corner");
}

static void a_ray_that_starts_inside_enters_at_zero(void **state)
{
    (void)state;
    rk_check_close(enter(unit, rk_vec(0.5f, 0.5f, 0.5f), rk_vec(1, 2, 3), INFINITY), 0, 0,
                   "inside");
    rk_check_close(enter(unit, rk_vec(1, 0.5f, 0.5f), rk_vec(1, 0, 0), INFINITY), 0, 0,
                   "on a face");
    rk_check_close(enter(unit, rk_vec(1, 1, 0.5f), rk_vec(1, 1, 0), INFINITY), 0, 0, "on an edge");
}

static void a_ray_leaves_at_the_farthest_face_or_at_its_end(void **state)
{
    (void)state;
    rk_ray ray = {rk_vec(-2, 0.5f, 0.5f), rk_vec(1, 0, -0.0f), INFINITY};
    rk_slabs slabs = rk_slabs_of(&ray);
    rk_check_close(rk_box_leave(&unit, &slabs, INFINITY), 3, 3 * SLACK, "x = 1");
    rk_check(rk_box_leave(&unit, &slabs, INFINITY) >= 3, "never before the exact ray leaves");
    rk_check_close(rk_box_leave(&unit, &slabs, 2.5f), 2.5, 0, "t_max");
}

static void a_ray_beside_behind_or_too_short_misses(void **state)
{
    (void)state;
    rk_check(isinf(enter(unit, rk_vec(-2, 1.5f, 0.5f), rk_vec(1, 0, 0), INFINITY)), "beside");
    rk_check(isinf(enter(unit, rk_vec(2, 0.5f, 0.5f), rk_vec(1, 0, 0), INFINITY)), "behind");
    rk_check(isinf(enter(unit, rk_vec(-2, 0.5f, 0.5f), rk_vec(1, 0, 0), 1.99f)), "beyond t_max");
    rk_check(isfinite(enter(unit, rk_vec(-2, 0.5f, 0.5f), rk_vec(1, 0, 0), 2)), "just at t_max");
}

static void zeros_of_both_signs_stay_between_their_faces(void **state)
{
    (void)state;
    const float zeros[] = {0.0f, -0.0f};
    for (int i = 0; i < 4; i++) {
        float p = zeros[i & 1], q = zeros[i >> 1];
        rk_vec3 direction = rk_vec(1, p, q);
        rk_check(isfinite(enter(unit, rk_vec(-1, 0, 1), direction, INFINITY)),
                 "in two faces' planes");
        rk_check(isfinite(enter(unit, rk_vec(-1, 1, 0), direction, INFINITY)),
                 "in two faces' planes");
        rk_check(isinf(enter(unit, rk_vec(-1, -1e-30f, 0), direction, INFINITY)),
                 "just below y = 0");
        rk_check(isinf(enter(unit, rk_vec(-1, 1, 1.0000001f), direction, INFINITY)),
                 "just above z = 1");
        rk_check(isinf(enter(unit, rk_vec(-1, -1e-40f, 0), direction, INFINITY)),
                 "below by a denormal");
        rk_check(isfinite(enter(unit, rk_vec(0, -1, 1), rk_vec(p, 1, q), INFINITY)), "along y");
        rk_check(isfinite(enter(unit, rk_vec(1, 0, -1), rk_vec(p, q, 1), INFINITY)), "along z");
        rk_check(isinf(enter(unit, rk_vec(-1e-40f, -1, 1), rk_vec(p, 1, q), INFINITY)), "along y");
        rk_check(isinf(enter(unit, rk_vec(1.0000001f, 0, -1), rk_vec(p, q, 1), INFINITY)),
                 "along z");
    }
}

static void an_empty_box_is_always_missed(void **state)
{
    (void)state;
    const float components[] = {0.0f, -0.0f, 1, -1, 1e-40f, -1e-40f, 1e30f};
    for (int i = 0; i < 7 * 7 * 7; i++) {
        rk_vec3 direction = rk_vec(components[i % 7], components[i / 7 % 7], components[i / 49]);
        rk_check(isinf(enter(rk_box_empty(), rk_vec(1, -2, 3), direction, INFINITY)),
                 "direction (%g, %g, %g)", (double)direction.x, (double)direction.y,
                 (double)direction.z);
    }
}

static void nan_directions_give_a_number(void **state)
{
    (void)state;
    for (int i = 1; i < 8; i++) {
        float t = enter(unit, rk_vec(-1, 0.5f, 0.5f),
                        rk_vec(i & 1 ? NAN : 1, i & 2 ? NAN : 0, i & 4 ? NAN : 0), INFINITY);
        rk_check(!isnan(t), "components %d are NaN", i);
    }
}

/* --- against exact integers ------------------------------------------------------------------ */

/* A ray and a box of small integers: t in [0, t_max] is a fourth slab. The slab test compares
 * quotients; here they are compared as products, which are exact in 64 bits. */
typedef struct exact_case {
    int64_t origin[4], direction[4], low[4], high[4];
} exact_case;

enum { endless = 1 << 30 };

/* Does the ray touch the box if each slab is widened by a relative `slack`? */
static bool touches(const exact_case *c, long double slack)
{
    long double near[4], far[4], step[4];
    for (int i = 0; i < 4; i++) {
        int64_t to_low = c->low[i] - c->origin[i], to_high = c->high[i] - c->origin[i];
        if (c->direction[i] == 0 && (to_low > 0 || to_high < 0))
            return false;
        step[i] = (long double)llabs(c->direction[i]);
        near[i] = (long double)(c->direction[i] < 0 ? -to_high : to_low) * (1 - slack);
        far[i] = (long double)(c->direction[i] < 0 ? -to_low : to_high) * (1 + slack);
    }
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            if (step[i] > 0 && step[k] > 0 && near[i] * step[k] > far[k] * step[i])
                return false;
    return true;
}

static int64_t pick(uint32_t i, uint32_t dimension, int64_t low, int64_t high)
{
    return low + (int64_t)(rk_hash(7, i, 0, dimension) % (uint64_t)(high - low + 1));
}

/* Aims at a corner, an edge, a face or the inside of the box, or one step beside it, from any
 * number of steps away, forward or backward; box sizes from 0 to `size`. */
static exact_case make_case(uint32_t i, int64_t size)
{
    exact_case c = {{0, 0, 0, 0}, {0, 0, 0, 1}, {0, 0, 0, 0}, {0, 0, 0, endless}};
    int64_t steps = pick(i, 0, -2, 9);
    for (uint32_t k = 0; k < 3; k++) {
        c.low[k] = pick(i, 8 * k + 1, -size, size);
        c.high[k] = c.low[k] + (pick(i, 8 * k + 2, 0, 3) ? pick(i, 8 * k + 3, 0, size) : 0);
        c.direction[k] = pick(i, 8 * k + 4, 0, 3) ? pick(i, 8 * k + 5, -size, size) : 0;
        int64_t targets[] = {c.low[k], c.high[k], pick(i, 8 * k + 6, c.low[k], c.high[k]),
                             c.high[k] + pick(i, 8 * k + 7, 0, 1)};
        c.origin[k] = targets[pick(i, 8 * k + 8, 0, 3)] - steps * c.direction[k];
    }
    if (pick(i, 40, 0, 3) == 0)
        c.high[3] = pick(i, 41, 0, 9);
    return c;
}

/* Passes the case to the slab test, each axis scaled by a power of two of its own, which changes
 * neither t nor any rounding. */
static float enter_scaled(const exact_case *c, const int exponent[3])
{
    rk_vec3 origin, direction, low, high;
    float *const to[] = {&origin.x, &origin.y, &origin.z, &direction.x, &direction.y, &direction.z,
                         &low.x,    &low.y,    &low.z,    &high.x,      &high.y,      &high.z};
    const int64_t *const from[] = {c->origin, c->direction, c->low, c->high};
    for (int i = 0; i < 12; i++)
        *to[i] = ldexpf((float)from[i / 3][i % 3], exponent[i % 3]);
    return enter(box_of(low, high), origin, direction,
                 c->high[3] == endless ? INFINITY : (float)c->high[3]);
}

static void check_against_exact(int64_t size, int lowest_exponent, int highest_exponent, bool tight)
{
    unsigned hit_count = 0, miss_count = 0;
    for (uint32_t i = 0; i < 60000; i++) {
        exact_case c = make_case(i, size);
        int exponent[3];
        for (uint32_t k = 0; k < 3; k++)
            exponent[k] = (int)pick(i, 50 + k, lowest_exponent, highest_exponent);
        float t = enter_scaled(&c, exponent);
        bool exact = touches(&c, 0);
        rk_check(!exact || isfinite(t),
                 "ray %u of size %lld touches the box and misses it: o = (%lld, %lld, %lld), d = "
                 "(%lld, %lld, %lld)",
                 i, (long long)size, (long long)c.origin[0], (long long)c.origin[1],
                 (long long)c.origin[2], (long long)c.direction[0], (long long)c.direction[1],
                 (long long)c.direction[2]);
        rk_check(!tight || isinf(t) || touches(&c, SLACK),
                 "ray %u of size %lld passes by, but hits the box", i, (long long)size);
        hit_count += exact, miss_count += !exact;
    }
    rk_check(hit_count > 6000 && miss_count > 6000, "the rays should be mixed: %u hit, %u miss",
             hit_count, miss_count);
}

static void rays_through_corners_edges_and_faces_agree_with_integers(void **state)
{
    (void)state;
    check_against_exact(3, 0, 0, true);
    check_against_exact(100, 0, 0, true);
}

static void long_mantissas_agree_with_integers(void **state)
{
    (void)state;
    /* 10 * size is below 2^24, so all inputs are exact floats. */
    check_against_exact(1600000, 0, 0, true);
}

static void tiny_and_huge_boxes_agree_with_integers(void **state)
{
    (void)state;
    check_against_exact(1000, -110, 90, true);
}

static void denormal_directions_lose_no_box(void **state)
{
    (void)state;
    check_against_exact(3, -149, -120, false);
    check_against_exact(1000, -149, 0, false);
}

/* --- against long double --------------------------------------------------------------------- */

/* Relative error of a t in long double: difference, quotient; doubled for the comparison's sides.
 */
#define ORACLE_SLACK (4 * (long double)LDBL_EPSILON)

typedef struct interval {
    long double near, far;
} interval;

static interval interval_of(const rk_box *box, const rk_ray *ray, long double slack)
{
    interval t = {0, (long double)ray->t_max};
    for (int k = 0; k < 3; k++) {
        long double d = (long double)rk_axis(ray->direction, k);
        long double to_low =
            (long double)rk_axis(box->corner[0], k) - (long double)rk_axis(ray->origin, k);
        long double to_high =
            (long double)rk_axis(box->corner[1], k) - (long double)rk_axis(ray->origin, k);
        if (d == 0 && (to_low > 0 || to_high < 0))
            return (interval){1, 0};
        if (d == 0)
            continue;
        long double near = (d < 0 ? to_high : to_low) / d, far = (d < 0 ? to_low : to_high) / d;
        t.near = fmaxl(t.near, near * (1 - slack));
        t.far = fminl(t.far, far * (1 + slack));
    }
    return t;
}

static float spread(uint32_t i, uint32_t dimension, int exponent)
{
    return ldexpf(2 * rk_unit_float(rk_hash(11, i, 0, dimension)) - 1, exponent);
}

/* Boxes of size 2^-60 to 2^60 at a distance of up to 2^100; rays aim at their surface, their
 * inside, or slightly beside them. */
static rk_ray aim(uint32_t i, rk_box *box)
{
    int size = (int)pick(i, 60, -60, 60), away = size + (int)pick(i, 61, 0, 40);
    float corner[2][3], origin[3], direction[3];
    for (uint32_t k = 0; k < 3; k++) {
        float p = spread(i, 8 * k, size),
              q = pick(i, 62 + k, 0, 7) ? spread(i, 8 * k + 1, size) : p;
        float along = 1.5f * rk_unit_float(rk_hash(5, i, k, 0)) - 0.25f;
        float target = pick(i, 66 + k, 0, 1) ? p : p + (q - p) * along;
        corner[0][k] = fminf(p, q), corner[1][k] = fmaxf(p, q);
        origin[k] = spread(i, 8 * k + 2, away);
        direction[k] = target - origin[k];
    }
    *box = box_of(rk_vec(corner[0][0], corner[0][1], corner[0][2]),
                  rk_vec(corner[1][0], corner[1][1], corner[1][2]));
    return (rk_ray){rk_vec(origin[0], origin[1], origin[2]),
                    rk_vec(direction[0], direction[1], direction[2]), INFINITY};
}

static void any_scale_and_distance_agrees_with_long_double(void **state)
{
    (void)state;
    unsigned hit_count = 0, miss_count = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        rk_box box;
        rk_ray ray = aim(i, &box);
        float t = enter(box, ray.origin, ray.direction, ray.t_max);
        interval sure = interval_of(&box, &ray, -ORACLE_SLACK);
        interval possible = interval_of(&box, &ray, (long double)SLACK);
        if (sure.near <= sure.far) {
            rk_check(isfinite(t), "ray %u surely touches the box and misses it", i);
            rk_check((long double)t <= sure.near && (long double)t >= possible.near,
                     "ray %u: enters at %.9g, want %.9Lg or a few roundings less", i, (double)t,
                     sure.near);
            rk_slabs slabs = rk_slabs_of(&ray);
            long double leave = (long double)rk_box_leave(&box, &slabs, INFINITY);
            rk_check(leave >= sure.far && leave <= possible.far,
                     "ray %u: leaves at %.9Lg, want %.9Lg or a few roundings more", i, leave,
                     sure.far);
            hit_count++;
        } else if (possible.near > possible.far) {
            rk_check(isinf(t), "ray %u surely passes by, but hits the box", i);
            miss_count++;
        }
    }
    rk_check(hit_count > 20000 && miss_count > 20000, "the rays should be mixed: %u hit, %u miss",
             hit_count, miss_count);
}

static void a_distant_ray_hits_a_box_of_no_thickness(void **state)
{
    (void)state;
    const float far[] = {1e6f, 1e30f};
    for (int i = 0; i < 2; i++) {
        rk_box plate = box_of(rk_vec(-1, -1, 0), rk_vec(1, 1, 0));
        rk_check(isfinite(enter(plate, rk_vec(0, 0, far[i]), rk_vec(0, 0, -1), INFINITY)),
                 "head-on");
        rk_check(isfinite(enter(plate, rk_vec(far[i], 0, 0), rk_vec(-1, 0, 0), INFINITY)),
                 "in its plane");
        rk_check(isinf(enter(plate, rk_vec(far[i], 0, 1e-30f), rk_vec(-1, 0, 0), INFINITY)),
                 "beside it");
        rk_box point = box_of(rk_vec(1, 1, 1), rk_vec(1, 1, 1));
        rk_check(
            isfinite(enter(point, rk_vec(far[i], far[i], far[i]), rk_vec(-1, -1, -1), INFINITY)),
            "a single point is hit along the diagonal");
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(an_empty_box_takes_the_shape_of_what_is_added),
    cmocka_unit_test(the_area_counts_six_faces),
    cmocka_unit_test(the_longest_axis_prefers_x_then_y_among_equals),
    cmocka_unit_test(a_ray_enters_at_the_nearest_face),
    cmocka_unit_test(a_ray_that_starts_inside_enters_at_zero),
    cmocka_unit_test(a_ray_leaves_at_the_farthest_face_or_at_its_end),
    cmocka_unit_test(a_ray_beside_behind_or_too_short_misses),
    cmocka_unit_test(zeros_of_both_signs_stay_between_their_faces),
    cmocka_unit_test(an_empty_box_is_always_missed),
    cmocka_unit_test(nan_directions_give_a_number),
    cmocka_unit_test(rays_through_corners_edges_and_faces_agree_with_integers),
    cmocka_unit_test(long_mantissas_agree_with_integers),
    cmocka_unit_test(tiny_and_huge_boxes_agree_with_integers),
    cmocka_unit_test(denormal_directions_lose_no_box),
    cmocka_unit_test(any_scale_and_distance_agrees_with_long_double),
    cmocka_unit_test(a_distant_ray_hits_a_box_of_no_thickness),
};

RK_SUITE("box", tests)
