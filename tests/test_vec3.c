/* Vectors: the formulas, and results for zero, infinity and NaN. */
#include "test.h"

#include "base/random.h"
#include "base/vec3.h"

static void check_vector(rk_vec3 got, float x, float y, float z, const char *hint)
{
    rk_check(got.x == x && got.y == y && got.z == z,
             "got (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g): %s", (double)got.x, (double)got.y,
             (double)got.z, (double)x, (double)y, (double)z, hint);
}

static const rk_vec3 a = {1, 2, 3}, b = {5, -7, 11};

static void sums_and_products_go_by_component(void **state)
{
    (void)state;
    check_vector(rk_add(a, b), 6, -5, 14, "a + b");
    check_vector(rk_sub(a, b), -4, 9, -8, "a - b");
    check_vector(rk_mul(a, b), 5, -14, 33, "a filtered by b");
    check_vector(rk_scale(a, 3), 3, 6, 9, "3 a");
    check_vector(rk_madd(a, b, 2), 11, -12, 25, "a + 2 b");
    check_vector(rk_negate(b), -5, 7, -11, "-b");
    check_vector(rk_abs3(b), 5, 7, 11, "|b|");
    check_vector(rk_min3(a, b), 1, -7, 3, "the smaller of each pair");
    check_vector(rk_max3(a, b), 5, 2, 11, "the larger of each pair");
}

static void dot_and_cross_follow_their_formulas(void **state)
{
    (void)state;
    rk_check_close(rk_dot(a, b), 24, 0, "5 - 14 + 33");
    check_vector(rk_cross(rk_vec(1, 0, 0), rk_vec(0, 1, 0)), 0, 0, 1, "x cross y is z");
    check_vector(rk_cross(a, b), 43, 4, -17, "small integers are exact");
    rk_check_close(rk_dot(rk_cross(a, b), a), 0, 0, "the product is orthogonal to its factors");
    rk_check_close(rk_dot(rk_cross(a, b), b), 0, 0, "the product is orthogonal to its factors");
}

static void axes_are_x_y_z(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++)
        rk_check_close(rk_axis(a, axis), axis + 1, 0, "a = (1, 2, 3)");
}

static void mixing_is_exact_at_both_ends(void **state)
{
    (void)state;
    check_vector(rk_mix(a, b, 0), a.x, a.y, a.z, "all a");
    check_vector(rk_mix(a, b, 1), b.x, b.y, b.z, "all b");
    check_vector(rk_mix(a, b, 0.25f), 2, -0.25f, 5, "three parts a, one part b");
}

static void a_normalized_vector_has_length_one(void **state)
{
    (void)state;
    check_vector(rk_normalize(rk_vec(0, -4, 0)), 0, -1, 0, "an axis is exact");
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 v =
            rk_vec(rk_unit_float(rk_hash(i, 0, 0, 1)) - 0.5f, rk_unit_float(rk_hash(i, 1, 0, 1)),
                   rk_unit_float(rk_hash(i, 2, 0, 1)) + 0.1f);
        rk_vec3 n = rk_normalize(v);
        double length =
            sqrt((double)n.x * (double)n.x + (double)n.y * (double)n.y + (double)n.z * (double)n.z);
        /* Relative roundings: 3 in |v|^2, halved by the root, which adds one; 1 / |v|; the scaling.
         */
        rk_check_close(length, 1, 4.5 * 0x1p-24, "|v / |v||");
        rk_check_close(n.x / n.z, v.x / v.z, 1e-6 * fabs((double)(v.x / v.z)),
                       "the direction stays");
    }
}

static void the_zero_vector_normalizes_to_itself(void **state)
{
    (void)state;
    check_vector(rk_normalize(rk_vec(0, 0, 0)), 0, 0, 0, "it has no direction, and gives no NaN");
}

/* Neither infinite nor NaN, and never a direction of any other length. */
static void lengths_whose_square_is_no_float_give_zero_or_themselves(void **state)
{
    (void)state;
    for (int exponent = 65; exponent < 128; exponent++) {
        float size = ldexpf(1, exponent);
        check_vector(rk_normalize(rk_vec(size, -size, 0)), 0, 0, 0, "too long");
    }
    for (int exponent = -149; exponent < -76; exponent++) {
        float size = ldexpf(1, exponent);
        check_vector(rk_normalize(rk_vec(size, -size, 0)), size, -size, 0, "too short");
    }
}

static void min_and_max_ignore_nan_in_their_first_argument(void **state)
{
    (void)state;
    rk_check_close(rk_min(NAN, 2), 2, 0, "the box test relies on it");
    rk_check_close(rk_max(NAN, 2), 2, 0, "the box test relies on it");
    rk_check(isnan(rk_min(2, NAN)) && isnan(rk_max(2, NAN)),
             "a NaN in the second argument comes back");
    rk_check(rk_min(-INFINITY, 2) < 0 && rk_max(INFINITY, 2) > 2, "infinities are ordered");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(sums_and_products_go_by_component),
    cmocka_unit_test(dot_and_cross_follow_their_formulas),
    cmocka_unit_test(axes_are_x_y_z),
    cmocka_unit_test(mixing_is_exact_at_both_ends),
    cmocka_unit_test(a_normalized_vector_has_length_one),
    cmocka_unit_test(the_zero_vector_normalizes_to_itself),
    cmocka_unit_test(lengths_whose_square_is_no_float_give_zero_or_themselves),
    cmocka_unit_test(min_and_max_ignore_nan_in_their_first_argument),
};

RK_SUITE("vec3", tests)
