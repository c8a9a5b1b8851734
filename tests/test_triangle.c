/* Rays and triangles: by hand, then against long double with rigorous error bounds, then at every
 * scale, then cases that must never hit. */
#include "test.h"

#include "base/random.h"
#include "features/watertight.h"

#include <float.h>

static rk_triangle triangle_of(rk_vec3 a, rk_vec3 b, rk_vec3 c, uint32_t index)
{
    return (rk_triangle){a, b, c, index};
}

static rk_hit closest(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    bool replaced = rk_triangle_closest(triangle, ray, &hit);
    rk_check(replaced == (hit.triangle != RK_MISS),
             "the result should say whether the hit changed");
    return hit;
}

static bool hits(const rk_triangle *triangle, const rk_ray *ray)
{
    return closest(triangle, ray).triangle != RK_MISS;
}

/* (0,0) (1,0) (0,1) in the plane z = 0, seen from z = -2. */
static rk_triangle corner_triangle(void)
{
    return triangle_of(rk_vec(0, 0, 0), rk_vec(1, 0, 0), rk_vec(0, 1, 0), 5);
}

static rk_ray ray_at(float x, float y)
{
    return (rk_ray){rk_vec(x, y, -2), rk_vec(0, 0, 1), INFINITY};
}

/* --- by hand --------------------------------------------------------------------------------- */

static void a_ray_through_the_middle_hits_with_its_coordinates(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    rk_ray ray = ray_at(0.5f, 0.25f);
    rk_hit hit = closest(&triangle, &ray);
    rk_check_equal(hit.triangle, 5, "the triangle's index in its mesh");
    rk_check_close(hit.t, 2, 0, "all numbers here are exact");
    rk_check_close(hit.u, 0.5, 0, "u belongs to b");
    rk_check_close(hit.v, 0.25, 0, "v belongs to c");
}

static void t_is_in_multiples_of_the_direction(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    rk_ray ray = ray_at(0.25f, 0.25f);
    ray.direction = rk_vec(0, 0, 4);
    rk_check_close(closest(&triangle, &ray).t, 0.5, 0, "2 / 4");
}

static void a_ray_beside_an_edge_or_behind_misses(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    const float outside[][2] = {{-0.01f, 0.5f}, {0.5f, -0.01f}, {0.51f, 0.5f}, {2, 2}, {-1, -1}};
    for (int i = 0; i < 5; i++) {
        rk_ray ray = ray_at(outside[i][0], outside[i][1]);
        rk_check(!hits(&triangle, &ray), "(%g, %g) is outside", (double)outside[i][0],
                 (double)outside[i][1]);
    }
    rk_ray away = ray_at(0.25f, 0.25f);
    away.direction.z = -1;
    rk_check(!hits(&triangle, &away), "the triangle is behind the ray");
    rk_ray on = ray_at(0.25f, 0.25f);
    on.origin.z = 0;
    rk_check(!hits(&triangle, &on), "t = 0 is no hit");
}

static void edges_and_corners_belong_to_the_triangle(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    const float on_edge[][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5f, 0}, {0, 0.5f}, {0.5f, 0.5f}};
    for (int i = 0; i < 6; i++) {
        rk_ray ray = ray_at(on_edge[i][0], on_edge[i][1]);
        rk_check(hits(&triangle, &ray), "(%g, %g) is on the edge", (double)on_edge[i][0],
                 (double)on_edge[i][1]);
    }
}

static void both_sides_hit_with_the_same_coordinates(void **state)
{
    (void)state;
    rk_triangle front = corner_triangle();
    rk_ray ray = ray_at(0.5f, 0.25f);
    rk_hit from_below = closest(&front, &ray);
    ray.origin.z = 2, ray.direction.z = -1;
    rk_hit from_above = closest(&front, &ray);
    rk_check(memcmp(&from_below, &from_above, sizeof from_below) == 0, "the sides are alike");
}

static void t_max_is_the_last_t_that_counts(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    rk_ray ray = ray_at(0.25f, 0.25f);
    ray.t_max = 2;
    rk_check(hits(&triangle, &ray) && rk_triangle_occludes(&triangle, &ray), "t = t_max counts");
    ray.t_max = nextafterf(2, 0);
    rk_check(!hits(&triangle, &ray) && !rk_triangle_occludes(&triangle, &ray),
             "t > t_max does not");
}

static void a_nearer_hit_replaces_and_a_farther_one_does_not(void **state)
{
    (void)state;
    rk_triangle near = corner_triangle(), far = corner_triangle();
    far.a.z = far.b.z = far.c.z = 1, far.index = 1;
    rk_ray ray = ray_at(0.25f, 0.25f);
    rk_hit hit = closest(&far, &ray);
    rk_check(rk_triangle_closest(&near, &ray, &hit) && hit.triangle == 5, "t = 2 before t = 3");
    rk_check(!rk_triangle_closest(&far, &ray, &hit) && hit.triangle == 5, "t = 3 after t = 2");
    rk_check_close(hit.t, 2, 0, "a hit that is not replaced stays whole");
}

static void equal_distances_prefer_the_smaller_index_in_any_order(void **state)
{
    (void)state;
    rk_triangle low = corner_triangle(), high = corner_triangle();
    low.index = 3, high.index = 4;
    rk_ray ray = ray_at(0.25f, 0.25f);
    rk_hit hit = closest(&low, &ray);
    rk_check(!rk_triangle_closest(&high, &ray, &hit) && hit.triangle == 3, "3 before 4");
    hit = closest(&high, &ray);
    rk_check(rk_triangle_closest(&low, &ray, &hit) && hit.triangle == 3, "3 before 4");
}

/* --- against long double --------------------------------------------------------------------- */

typedef struct wide3 {
    long double x, y, z;
} wide3;

static wide3 widen(rk_vec3 v)
{
    return (wide3){(long double)v.x, (long double)v.y, (long double)v.z};
}

static wide3 minus(wide3 a, wide3 b)
{
    return (wide3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static wide3 magnitude(wide3 v)
{
    return (wide3){fabsl(v.x), fabsl(v.y), fabsl(v.z)};
}

/* a . (b x c); with `sign` 1, the sum of its terms' magnitudes, for magnitudes a, b, c. */
static long double triple(wide3 a, wide3 b, wide3 c, long double sign)
{
    return a.x * (b.y * c.z + sign * b.z * c.y) + a.y * (b.z * c.x + sign * b.x * c.z) +
           a.z * (b.x * c.y + sign * b.y * c.x);
}

/* A value, and a bound of float arithmetic's error. */
typedef struct bounded {
    long double value, error;
} bounded;

/* Every term of a float triple product is rounded at most 6 times (difference of points, product,
 * difference, product, two sums): an error of at most gamma_6 of the sum of magnitudes (Higham,
 * "Accuracy and Stability of Numerical Algorithms", section 3.1). */
static bounded triple_bounded(wide3 a, wide3 b, wide3 c)
{
    long double gamma_6 = 6 * 0x1p-24L / (1 - 6 * 0x1p-24L);
    return (bounded){triple(a, b, c, -1),
                     gamma_6 * triple(magnitude(a), magnitude(b), magnitude(c), 1)};
}

typedef struct oracle {
    bounded det, u_det, v_det, t_det;
} oracle;

static oracle solve(const rk_triangle *triangle, const rk_ray *ray)
{
    wide3 o = widen(ray->origin), d = widen(ray->direction), a = widen(triangle->a);
    wide3 s = minus(o, a), ab = minus(widen(triangle->b), a), ac = minus(widen(triangle->c), a);
    oracle answer = {triple_bounded(ab, d, ac), triple_bounded(s, d, ac), triple_bounded(d, s, ab),
                     triple_bounded(ac, s, ab)};
    if (answer.det.value < 0) {
        answer.det.value *= -1, answer.u_det.value *= -1;
        answer.v_det.value *= -1, answer.t_det.value *= -1;
    }
    return answer;
}

/* The third barycentric coordinate, 1 - u - v; its sum and comparison round once. */
static bounded rest(const oracle *o)
{
    long double value = o->det.value - o->u_det.value - o->v_det.value;
    long double sum = fabsl(o->u_det.value) + fabsl(o->v_det.value);
    return (bounded){value, o->det.error + o->u_det.error + o->v_det.error + 0x1p-23L * sum};
}

static bool surely_positive(bounded b)
{
    return b.value > b.error;
}

static bool surely_negative(bounded b)
{
    return b.value < -b.error;
}

/* The quotient's error: from numerator, denominator, and its own rounding. */
static long double quotient_error(bounded part, bounded det)
{
    long double quotient = part.value / det.value;
    return (part.error + fabsl(quotient) * det.error) / (det.value - det.error) +
           fabsl(quotient) * 0x1p-23L;
}

static float noise(uint32_t i, uint32_t dimension)
{
    return 2 * rk_unit_float(rk_hash(3, i, 0, dimension)) - 1;
}

static rk_vec3 noise3(uint32_t i, uint32_t dimension)
{
    return rk_vec(noise(i, dimension), noise(i, dimension + 1), noise(i, dimension + 2));
}

/* Triangles of all shapes, including needles; rays that hit inside, near an edge or beside it, near
 * and far, head-on and grazing. */
static void make_pair(uint32_t i, rk_triangle *triangle, rk_ray *ray)
{
    rk_vec3 a = noise3(i, 0), b = noise3(i, 3), c = noise3(i, 6);
    if (i % 4 == 1)
        c = rk_madd(rk_mix(a, b, noise(i, 9)), noise3(i, 10), 1e-4f);
    *triangle = triangle_of(a, b, c, i);
    float u = 0.75f * noise(i, 13) + 0.5f, v = 0.75f * noise(i, 14) + 0.5f;
    if (i % 8 == 2)
        v = 1e-5f * noise(i, 15);
    rk_vec3 ab = rk_sub(b, a), target = rk_madd(rk_madd(a, ab, u), rk_sub(c, a), v);
    rk_vec3 origin = rk_scale(noise3(i, 16), i % 3 == 1 ? 1000 : 3);
    if (i % 8 == 3) /* from within a thousandth of the triangle's plane */
        origin = rk_madd(rk_madd(target, ab, 3 * noise(i, 19)), origin, 1e-3f);
    float reach = 1.5f + noise(i, 20); /* t is around 1 / reach */
    *ray = (rk_ray){origin, rk_scale(rk_sub(target, origin), reach), INFINITY};
}

enum { pairs = 200000 };

static void clear_hits_hit_and_clear_misses_miss(void **state)
{
    (void)state;
    unsigned hit = 0, missed = 0;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle;
        rk_ray ray;
        make_pair(i, &triangle, &ray);
        oracle want = solve(&triangle, &ray);
        bounded third = rest(&want);
        if (surely_positive(want.det) && surely_positive(want.u_det) &&
            surely_positive(want.v_det) && surely_positive(third) && surely_positive(want.t_det)) {
            rk_check(hits(&triangle, &ray), "pair %u surely hits", i);
            hit++;
        } else if (surely_positive(want.det) &&
                   (surely_negative(want.u_det) || surely_negative(want.v_det) ||
                    surely_negative(third) || surely_negative(want.t_det))) {
            rk_check(!hits(&triangle, &ray), "pair %u surely misses", i);
            missed++;
        }
    }
    rk_check(hit > pairs / 10 && missed > pairs / 4 && hit + missed > pairs * 4 / 5,
             "most pairs should be clear: %u hit, %u miss of %d", hit, missed, pairs);
}

static void t_u_and_v_stay_within_their_error_bounds(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle;
        rk_ray ray;
        make_pair(i, &triangle, &ray);
        rk_hit hit = closest(&triangle, &ray);
        oracle want = solve(&triangle, &ray);
        if (hit.triangle == RK_MISS || !surely_positive(want.det))
            continue;
        long double det = want.det.value;
        rk_check_close(hit.t, want.t_det.value / det, quotient_error(want.t_det, want.det), "t");
        rk_check_close(hit.u, want.u_det.value / det, quotient_error(want.u_det, want.det), "u");
        rk_check_close(hit.v, want.v_det.value / det, quotient_error(want.v_det, want.det), "v");
    }
}

static void barycentric_coordinates_give_the_point_back(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle;
        rk_ray ray;
        make_pair(i, &triangle, &ray);
        rk_hit hit = closest(&triangle, &ray);
        oracle want = solve(&triangle, &ray);
        if (hit.triangle == RK_MISS || !surely_positive(want.det))
            continue;
        for (int k = 0; k < 3; k++) {
            double d = (double)rk_axis(ray.direction, k), a = (double)rk_axis(triangle.a, k);
            double ab = (double)rk_axis(triangle.b, k) - a, ac = (double)rk_axis(triangle.c, k) - a;
            double along = (double)rk_axis(ray.origin, k) + (double)hit.t * d;
            double across = a + (double)hit.u * ab + (double)hit.v * ac;
            double tolerance = (double)quotient_error(want.t_det, want.det) * fabs(d) +
                               (double)quotient_error(want.u_det, want.det) * fabs(ab) +
                               (double)quotient_error(want.v_det, want.det) * fabs(ac);
            rk_check_close(along, across, tolerance + 1e-12 * fabs(along),
                           "the errors of t, u and v, and of these sums in double");
        }
    }
}

static void both_tests_agree_to_the_bit_at_every_t_max(void **state)
{
    (void)state;
    unsigned hit_count = 0;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle;
        rk_ray ray;
        make_pair(i, &triangle, &ray);
        rk_hit hit = closest(&triangle, &ray);
        const float limits[] = {
            INFINITY, hit.t, nextafterf(hit.t, 0), nextafterf(hit.t, INFINITY), 0, -1, 0.5f};
        for (int k = 0; k < 7; k++) {
            ray.t_max = limits[k];
            rk_check(rk_triangle_occludes(&triangle, &ray) == hits(&triangle, &ray),
                     "pair %u at t_max %.9g", i, (double)limits[k]);
        }
        hit_count += hit.triangle != RK_MISS;
    }
    rk_check(hit_count > pairs / 10, "only %u hits were compared", hit_count);
}

/* --- scales ---------------------------------------------------------------------------------- */

static void scale_pair(rk_triangle *triangle, rk_ray *ray, float points, float direction)
{
    triangle->a = rk_scale(triangle->a, points);
    triangle->b = rk_scale(triangle->b, points);
    triangle->c = rk_scale(triangle->c, points);
    ray->origin = rk_scale(ray->origin, points);
    ray->direction = rk_scale(ray->direction, direction);
}

static bool has_bits(rk_hit got, rk_hit want)
{
    return got.triangle == want.triangle && got.t == want.t && got.u == want.u && got.v == want.v;
}

static void powers_of_two_change_no_bit_of_a_hit(void **state)
{
    (void)state;
    unsigned hit_count = 0;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle, scaled;
        rk_ray ray, scaled_ray;
        make_pair(i, &triangle, &ray);
        rk_hit want = closest(&triangle, &ray);
        /* Lengths are within 2^-14 .. 2^11 (a needle's height, a distant origin); products of three
         * stay in range, and cancelled digits are too small to matter, from 2^-28 to 2^30. */
        int exponent = (int)(rk_hash(i, 1, 1, 1) % 59) - 28;
        scaled = triangle, scaled_ray = ray;
        scale_pair(&scaled, &scaled_ray, ldexpf(1, exponent), 1);
        rk_hit moved = want;
        moved.t = ldexpf(want.t, exponent);
        rk_check(has_bits(closest(&scaled, &scaled_ray), moved), "pair %u, all points times 2^%d",
                 i, exponent);
        scaled = triangle, scaled_ray = ray;
        scale_pair(&scaled, &scaled_ray, ldexpf(1, exponent), ldexpf(1, exponent));
        rk_check(has_bits(closest(&scaled, &scaled_ray), want), "pair %u, everything times 2^%d", i,
                 exponent);
        scaled = triangle, scaled_ray = ray;
        scale_pair(&scaled, &scaled_ray, 1, ldexpf(1, exponent));
        moved.t = ldexpf(want.t, -exponent);
        rk_check(has_bits(closest(&scaled, &scaled_ray), moved),
                 "pair %u, the direction times 2^%d", i, exponent);
        hit_count += want.triangle != RK_MISS;
    }
    rk_check(hit_count > pairs / 10, "only %u hits were compared", hit_count);
}

static void a_hit_at_any_scale_is_finite_and_in_range(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < pairs; i++) {
        rk_triangle triangle;
        rk_ray ray;
        make_pair(i, &triangle, &ray);
        int points = (int)(rk_hash(i, 2, 1, 1) % 251) - 125,
            direction = (int)(rk_hash(i, 2, 2, 1) % 251) - 125;
        scale_pair(&triangle, &ray, ldexpf(1, points), ldexpf(1, direction));
        rk_hit hit = closest(&triangle, &ray);
        rk_check(rk_triangle_occludes(&triangle, &ray) == (hit.triangle != RK_MISS),
                 "pair %u disagrees", i);
        if (hit.triangle == RK_MISS)
            continue;
        rk_check(hit.t > 0 && hit.t <= FLT_MAX, "pair %u at 2^%d, 2^%d: t = %g", i, points,
                 direction, (double)hit.t);
        rk_check(hit.u >= 0 && hit.u <= 1 && hit.v >= 0 && hit.v <= 1, "pair %u: u = %g, v = %g", i,
                 (double)hit.u, (double)hit.v);
    }
}

/* --- cases that never hit -------------------------------------------------------------------- */

static void an_edge_on_triangle_is_missed(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    for (int i = 0; i < 8; i++) {
        float angle = (float)i * 0.7f;
        rk_ray ray = {rk_vec(-3 * cosf(angle), -3 * sinf(angle), 0),
                      rk_vec(cosf(angle), sinf(angle), 0), INFINITY};
        rk_check(!hits(&triangle, &ray) && !rk_triangle_occludes(&triangle, &ray), "in its plane");
    }
}

static void a_grazing_ray_hits_only_from_outside_the_plane(void **state)
{
    (void)state;
    rk_triangle triangle = corner_triangle();
    /* From 2^-20 above the plane to 2^-20 below it over 8 lengths: crosses in the middle. */
    rk_ray ray = {rk_vec(-3.75f, 0.25f, 0x1p-20f), rk_vec(8, 0, -0x1p-19f), INFINITY};
    rk_check_close(closest(&triangle, &ray).u, 0.25, 0, "exact numbers");
    ray.direction.z = 0;
    rk_check(!hits(&triangle, &ray), "parallel to the plane");
}

static void degenerate_triangles_are_missed(void **state)
{
    (void)state;
    const rk_vec3 corners[][3] = {
        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {1, 1, 0}, {1, 1, 0}},
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{-1, -1, 0}, {1, 1, 0}, {3, 3, 0}},
    };
    for (int i = 0; i < 6; i++) {
        rk_triangle triangle = triangle_of(corners[i][0], corners[i][1], corners[i][2], 0);
        for (int k = 0; k < 3; k++) {
            rk_ray ray = ray_at((float)k * 0.5f, (float)(k % 2) * 0.5f);
            rk_check(!hits(&triangle, &ray) && !rk_triangle_occludes(&triangle, &ray),
                     "triangle %d has no area", i);
        }
    }
}

static void nan_and_infinity_in_any_input_miss(void **state)
{
    (void)state;
    const float broken[] = {NAN, INFINITY, -INFINITY};
    for (int place = 0; place < 15; place++)
        for (int i = 0; i < 3; i++) {
            rk_triangle triangle =
                triangle_of(rk_vec(-1, -1, 0.5f), rk_vec(2, -1, 0), rk_vec(-1, 3, 1), 0);
            rk_ray ray = {rk_vec(0.1f, 0.2f, -2), rk_vec(0.1f, 0.2f, 1), INFINITY};
            rk_check(hits(&triangle, &ray), "the valid pair hits");
            float *places[] = {&triangle.a.x, &triangle.b.x, &triangle.c.x, &ray.origin.x,
                               &ray.direction.x};
            places[place / 3][place % 3] = broken[i];
            rk_check(!hits(&triangle, &ray) && !rk_triangle_occludes(&triangle, &ray),
                     "%g at place %d", (double)broken[i], place);
        }
    rk_triangle triangle = corner_triangle();
    rk_ray ray = ray_at(0.25f, 0.25f);
    ray.t_max = NAN;
    rk_check(!hits(&triangle, &ray) && !rk_triangle_occludes(&triangle, &ray), "t_max is NaN");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_ray_through_the_middle_hits_with_its_coordinates),
    cmocka_unit_test(t_is_in_multiples_of_the_direction),
    cmocka_unit_test(a_ray_beside_an_edge_or_behind_misses),
    cmocka_unit_test(edges_and_corners_belong_to_the_triangle),
    cmocka_unit_test(both_sides_hit_with_the_same_coordinates),
    cmocka_unit_test(t_max_is_the_last_t_that_counts),
    cmocka_unit_test(a_nearer_hit_replaces_and_a_farther_one_does_not),
    cmocka_unit_test(equal_distances_prefer_the_smaller_index_in_any_order),
    cmocka_unit_test(clear_hits_hit_and_clear_misses_miss),
    cmocka_unit_test(t_u_and_v_stay_within_their_error_bounds),
    cmocka_unit_test(barycentric_coordinates_give_the_point_back),
    cmocka_unit_test(both_tests_agree_to_the_bit_at_every_t_max),
    cmocka_unit_test(powers_of_two_change_no_bit_of_a_hit),
    cmocka_unit_test(a_hit_at_any_scale_is_finite_and_in_range),
    cmocka_unit_test(an_edge_on_triangle_is_missed),
    cmocka_unit_test(a_grazing_ray_hits_only_from_outside_the_plane),
    cmocka_unit_test(degenerate_triangles_are_missed),
    cmocka_unit_test(nan_and_infinity_in_any_input_miss),
};

RK_SUITE("triangle", tests)
