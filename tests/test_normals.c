/* Colours of normals, and normals of triangles: their claims, simplest first. */
#include "test.h"

#include "base/random.h"
#include "features/normals.h"

static void check_vec3(rk_vec3 got, rk_vec3 want, float tolerance, const char *hint)
{
    rk_vec3 off = rk_abs3(rk_sub(got, want));
    rk_check(off.x <= tolerance && off.y <= tolerance && off.z <= tolerance,
             "got (%g, %g, %g), want (%g, %g, %g): %s", (double)got.x, (double)got.y, (double)got.z,
             (double)want.x, (double)want.y, (double)want.z, hint);
}

/* Coordinates from -1 to 1. */
static rk_vec3 random_point(uint32_t i, uint32_t k)
{
    return rk_vec(2 * rk_unit_float(rk_hash(i, k, 0, 0)) - 1,
                  2 * rk_unit_float(rk_hash(i, k, 1, 0)) - 1,
                  2 * rk_unit_float(rk_hash(i, k, 2, 0)) - 1);
}

/* --- Colours ---------------------------------------------------------------------------------- */

static void each_axis_has_a_colour_of_its_own(void **state)
{
    (void)state;
    /* Halves and sums of 0 and 1 are exact. */
    check_vec3(rk_normals_colour(rk_vec(1, 0, 0)), rk_vec(1, 0.5f, 0.5f), 0,
               "the colour of the normal (1, 0, 0): x is red, and 0 is half of the way");
    check_vec3(rk_normals_colour(rk_vec(0, 1, 0)), rk_vec(0.5f, 1, 0.5f), 0,
               "the colour of the normal (0, 1, 0): y is green");
    check_vec3(rk_normals_colour(rk_vec(0, 0, 1)), rk_vec(0.5f, 0.5f, 1), 0,
               "the colour of the normal (0, 0, 1): z is blue");
    check_vec3(rk_normals_colour(rk_vec(-1, 0, 0)), rk_vec(0, 0.5f, 0.5f), 0,
               "the colour of the normal (-1, 0, 0): -1 becomes 0");
}

static void from_minus_1_to_1_becomes_from_0_to_1(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 n = rk_normalize(random_point(i, 0));
        rk_vec3 want = rk_scale(rk_add(n, rk_vec(1, 1, 1)), 0.5f);
        /* Two orders of computing it differ by a rounding of a number up to 1. */
        check_vec3(rk_normals_colour(n), want, 0x1p-23f,
                   "-1 becomes 0, 0 becomes 1/2 and 1 becomes 1, in each channel");
    }
}

static void opposite_normals_have_complementary_colours(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 n = rk_normalize(random_point(i, 1));
        rk_vec3 sum = rk_add(rk_normals_colour(n), rk_normals_colour(rk_negate(n)));
        check_vec3(sum, rk_vec(1, 1, 1), 0x1p-22f, "the colours of n and -n add up to white");
    }
}

/* --- Triangles -------------------------------------------------------------------------------- */

static void a_triangle_along_two_axes_has_the_third_as_its_normal(void **state)
{
    (void)state;
    const rk_vec3 o = {0, 0, 0}, x = {2, 0, 0}, y = {0, 3, 0}, z = {0, 0, 4};
    check_vec3(rk_normals_of_triangle(o, x, y), rk_vec(0, 0, 1), 0,
               "the triangle (0, 0, 0), (2, 0, 0), (0, 3, 0): a normal has length 1, and from its "
               "tip the corners run counterclockwise");
    check_vec3(rk_normals_of_triangle(o, y, z), rk_vec(1, 0, 0), 0,
               "the triangle (0, 0, 0), (0, 3, 0), (0, 0, 4)");
    check_vec3(rk_normals_of_triangle(o, z, x), rk_vec(0, 1, 0), 0,
               "the triangle (0, 0, 0), (0, 0, 4), (2, 0, 0)");
}

static void a_moved_triangle_has_the_same_normal(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        /* Whole numbers up to 2^6 and steps of up to 2^22 move without rounding, and so do the
         * differences of the corners. Products of the corners are rounded by 2^20. */
        rk_vec3 corner[3];
        for (uint32_t k = 0; k < 3; k++) {
            rk_vec3 p = rk_scale(random_point(i, 2 + k), 64);
            corner[k] = rk_vec(rintf(p.x), rintf(p.y), rintf(p.z));
        }
        const rk_vec3 by = {0x1p20f, -0x1p21f, 0x1p22f};
        rk_vec3 there = rk_normals_of_triangle(rk_add(corner[0], by), rk_add(corner[1], by),
                                               rk_add(corner[2], by));
        check_vec3(there, rk_normals_of_triangle(corner[0], corner[1], corner[2]), 0,
                   "a triangle and the same one elsewhere: are edges differences of corners?");
    }
}

static void a_scaled_triangle_has_the_same_normal(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 a = {0, 0, 0}, b = random_point(i, 9), c = random_point(i, 10);
        rk_vec3 want = rk_normals_of_triangle(a, b, c);
        rk_check(rk_length(want) > 0, "the normal of a triangle with an area is (0, 0, 0)");
        for (int exponent = -20; exponent <= 20; exponent += 5) {
            /* Powers of two: nothing is rounded otherwise, but for the last bit of 1 / length. */
            float by = ldexpf(1, exponent);
            check_vec3(rk_normals_of_triangle(rk_scale(a, by), rk_scale(b, by), rk_scale(c, by)),
                       want, 0x1p-22f,
                       "a triangle and the same one larger or smaller: no area is too small but 0");
        }
    }
}

static void a_normal_is_unit_and_at_right_angles_to_all_edges(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 a = random_point(i, 5), b = random_point(i, 6), c = random_point(i, 7);
        rk_vec3 n = rk_normals_of_triangle(a, b, c);
        double area = (double)rk_length(rk_cross(rk_sub(b, a), rk_sub(c, a)));
        /* The cross product of edges up to 3.5 long has errors of a few roundings of 12; a normal's
         * direction is off by them over the product's length. */
        double tolerance = 0x1p-23 * (4 + 48 / area);
        rk_check_near(rk_length(n), 1, 0x1p-21, "triangle %u: the normal's length", i);
        rk_check_near(rk_dot(n, rk_sub(b, a)), 0, tolerance, "triangle %u: n.(b - a)", i);
        rk_check_near(rk_dot(n, rk_sub(c, a)), 0, tolerance, "triangle %u: n.(c - a)", i);
    }
}

static void two_swapped_corners_turn_the_normal_around(void **state)
{
    (void)state;
    const rk_vec3 a = {1, 2, 3}, b = {4, -1, 2}, c = {0, 5, 7};
    rk_vec3 n = rk_normals_of_triangle(a, b, c);
    rk_check(rk_length(n) > 0, "the normal of a triangle with an area is (0, 0, 0)");
    check_vec3(rk_normals_of_triangle(a, c, b), rk_negate(n), 0x1p-22f,
               "the triangle a, c, b is seen from behind");
}

static void a_triangle_without_area_has_the_normal_0(void **state)
{
    (void)state;
    const rk_vec3 a = {1, 2, 3}, b = {2, 4, 6}, c = {3, 6, 9};
    check_vec3(rk_normals_of_triangle(a, a, a), rk_vec(0, 0, 0), 0, "all corners in one point");
    check_vec3(rk_normals_of_triangle(a, b, c), rk_vec(0, 0, 0), 0, "all corners on one line");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(each_axis_has_a_colour_of_its_own),
    cmocka_unit_test(from_minus_1_to_1_becomes_from_0_to_1),
    cmocka_unit_test(opposite_normals_have_complementary_colours),
    cmocka_unit_test(a_triangle_along_two_axes_has_the_third_as_its_normal),
    cmocka_unit_test(a_moved_triangle_has_the_same_normal),
    cmocka_unit_test(a_scaled_triangle_has_the_same_normal),
    cmocka_unit_test(a_normal_is_unit_and_at_right_angles_to_all_edges),
    cmocka_unit_test(two_swapped_corners_turn_the_normal_around),
    cmocka_unit_test(a_triangle_without_area_has_the_normal_0),
};

RK_SUITE("normals", tests)
