/* Colours of normals, and normals of triangles: their claims, simplest first. */
#include "test.h"

#include "base/random.h"
#include "features/normals.h"

static void check_vec3_or(rk_vec3 got, rk_vec3 want, float tolerance,
                          const rk_vector_mistake *known, const char *hint)
{
    rk_vec3 off = rk_abs3(rk_sub(got, want));
    rk_check(off.x <= tolerance && off.y <= tolerance && off.z <= tolerance,
             "got (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g): %s%s", (double)got.x, (double)got.y,
             (double)got.z, (double)want.x, (double)want.y, (double)want.z, hint,
             rk_mistake_in_vector(RK_XYZ(got), RK_XYZ(want), (double)tolerance, known));
}

static void check_vec3(rk_vec3 got, rk_vec3 want, float tolerance, const char *hint)
{
    check_vec3_or(got, want, tolerance, NULL, hint);
}

static void check_colour(rk_vec3 n, rk_vec3 want, float tolerance, const char *hint)
{
    const double x = (double)n.x, y = (double)n.y, z = (double)n.z;
    check_vec3_or(rk_normals_colour(n), want, tolerance,
                  RK_VECTOR_MISTAKES(
                      {{x + 1, y + 1, z + 1}, "1 is added, but the sum is not halved"},
                      {{x / 2, y / 2, z / 2}, "coordinates are halved, but 1 is not added before"},
                      {{fabs(x), fabs(y), fabs(z)}, "the absolute value is taken"},
                      {{fmax(x, 0), fmax(y, 0), fmax(z, 0)}, "what is below 0 is cut off"},
                      {{(z + 1) / 2, (y + 1) / 2, (x + 1) / 2}, "red and blue are exchanged"},
                      {{(x + 1) / 2, (y + 1) / 2, (1 - z) / 2}, "z has the other sign"}),
                  hint);
}

/* The cross product of edges along axes is exact, or off by three roundings if edges are made unit
 * first; its length, one over it, and the product by that are rounded. */
static const float length_rounding = 0x1p-22f;

/* The normal of the triangle abc. */
static void check_normal(rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 want, const char *hint)
{
    const rk_vec3 cross = rk_cross(rk_sub(b, a), rk_sub(c, a));
    const double *w = RK_XYZ(want), *all = RK_XYZ(cross);
    check_vec3_or(
        rk_normals_of_triangle(a, b, c), want, length_rounding,
        RK_VECTOR_MISTAKES({{-w[0], -w[1], -w[2]},
                            "the edges are multiplied in the other order, not (b - a) x (c - a)"},
                           {{all[0], all[1], all[2]},
                            "the cross product is not normalized: it is as long as the "
                            "parallelogram's area"}),
        hint);
}

/* Coordinates from -1 to 1. */
static rk_vec3 random_point(uint32_t i, uint32_t k)
{
    return rk_vec(2 * rk_unit_float(rk_case(i, k, 0, 0)) - 1,
                  2 * rk_unit_float(rk_case(i, k, 1, 0)) - 1,
                  2 * rk_unit_float(rk_case(i, k, 2, 0)) - 1);
}

/* Whole numbers up to 64. */
static rk_vec3 random_whole(uint32_t i, uint32_t k)
{
    rk_vec3 p = rk_scale(random_point(i, k), 64);
    return rk_vec(rintf(p.x), rintf(p.y), rintf(p.z));
}

/* --- Colours ---------------------------------------------------------------------------------- */

static void each_axis_has_a_colour_of_its_own(void **state)
{
    (void)state;
    /* Halves and sums of 0 and 1 are exact. */
    const struct {
        rk_vec3 normal, colour;
        const char *hint;
    } axes[] = {
        {{-1, 0, 0}, {0, 0.5f, 0.5f}, "of the normal (-1, 0, 0): -1 becomes 0"},
        {{1, 0, 0}, {1, 0.5f, 0.5f}, "of the normal (1, 0, 0): x is red, 0 is half of the way"},
        {{0, 1, 0}, {0.5f, 1, 0.5f}, "of the normal (0, 1, 0): y is green"},
        {{0, -1, 0}, {0.5f, 0, 0.5f}, "of the normal (0, -1, 0)"},
        {{0, 0, 1}, {0.5f, 0.5f, 1}, "of the normal (0, 0, 1): z is blue"},
        {{0, 0, -1}, {0.5f, 0.5f, 0}, "of the normal (0, 0, -1)"},
    };
    for (size_t i = 0; i < sizeof axes / sizeof *axes; i++)
        check_colour(axes[i].normal, axes[i].colour, 0, axes[i].hint);
}

static void from_minus_1_to_1_becomes_from_0_to_1(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 n = rk_normalize(random_point(i, 0));
        rk_vec3 want = rk_scale(rk_add(n, rk_vec(1, 1, 1)), 0.5f);
        /* Two orders of computing it differ by a rounding of a number up to 1. */
        check_colour(n, want, 0x1p-23f,
                     "-1 becomes 0, 0 becomes 1/2 and 1 becomes 1, in each channel");
    }
    for (int e = 1; e <= 21; e++) {
        float s = ldexpf(1, -e), c = sqrtf(1 - 2 * s * s), half = 0.5f;
        const char *hint = "a coordinate near 0 is not quite 1/2";
        check_vec3(rk_normals_colour(rk_vec(s, c, -s)),
                   rk_vec(half + s / 2, half + c / 2, half - s / 2), 0x1p-23f, hint);
        check_vec3(rk_normals_colour(rk_vec(-s, -s, c)),
                   rk_vec(half - s / 2, half - s / 2, half + c / 2), 0x1p-23f, hint);
        check_vec3(rk_normals_colour(rk_vec(-c, s, s)),
                   rk_vec(half - c / 2, half + s / 2, half + s / 2), 0x1p-23f, hint);
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

/* Facing each way along each axis, and with each of the corners first. */
static void check_triangles_along_axes(void)
{
    const rk_vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 18; i++) {
        int axis = i % 3, first = i / 3 % 3;
        bool backward = i >= 9;
        rk_vec3 u = axes[(axis + 1) % 3], v = axes[(axis + 2) % 3];
        const rk_vec3 corner[] = {{0, 0, 0}, backward ? v : u, backward ? u : v};
        rk_vec3 a = corner[first], b = corner[(first + 1) % 3], c = corner[(first + 2) % 3];
        char hint[300];
        snprintf(hint, sizeof hint,
                 "the triangle (%g, %g, %g), (%g, %g, %g), (%g, %g, %g), which faces along %s%c",
                 (double)a.x, (double)a.y, (double)a.z, (double)b.x, (double)b.y, (double)b.z,
                 (double)c.x, (double)c.y, (double)c.z, backward ? "-" : "", "xyz"[axis]);
        rk_vec3 none = {0, 0, 0}, want = backward ? rk_sub(none, axes[axis]) : axes[axis];
        check_vec3(rk_normals_of_triangle(a, b, c), want, length_rounding, hint);
    }
}

static void a_triangle_along_two_axes_has_the_third_as_its_normal(void **state)
{
    (void)state;
    const rk_vec3 o = {0, 0, 0}, x = {2, 0, 0}, y = {0, 3, 0}, z = {0, 0, 4};
    check_normal(
        o, x, y, rk_vec(0, 0, 1),
        "the triangle (0, 0, 0), (2, 0, 0), (0, 3, 0): a normal has length 1, and from its "
        "tip the corners run counterclockwise");
    check_normal(o, y, z, rk_vec(1, 0, 0), "the triangle (0, 0, 0), (0, 3, 0), (0, 0, 4)");
    check_normal(o, z, x, rk_vec(0, 1, 0), "the triangle (0, 0, 0), (0, 0, 4), (2, 0, 0)");
    check_normal(o, z, y, rk_vec(-1, 0, 0), "the triangle (0, 0, 0), (0, 0, 4), (0, 3, 0)");
    check_normal(o, x, y, rk_vec(0, 0, 1),
                 "the triangle (0, 0, 0), (2, 0, 0), (0, 3, 0) once more");
    check_normal(rk_vec(2, 3, 0), x, y, rk_vec(0, 0, -1),
                 "the triangle (2, 3, 0), (2, 0, 0), (0, 3, 0)");
    check_triangles_along_axes();
}

/* What is always the same is no normal. */
/* So that what two normals have in common is worth a comparison. */
static void check_right_angle(rk_vec3 n, rk_vec3 edge)
{
    rk_check(fabsf(rk_dot(n, edge)) < 0.1f * rk_length(n) * rk_length(edge),
             "the normal (%g, %g, %g) is not at right angles to the edge (%g, %g, %g)", (double)n.x,
             (double)n.y, (double)n.z, (double)edge.x, (double)edge.y, (double)edge.z);
}

static void check_that_normals_differ(void)
{
    const rk_vec3 o = {0, 0, 0}, x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    rk_vec3 of_xy = rk_normals_of_triangle(o, x, y), of_yz = rk_normals_of_triangle(o, y, z);
    rk_check(rk_length(rk_sub(of_xy, of_yz)) > 0.1f,
             "two triangles at right angles to each other have the same normal (%g, %g, %g)",
             (double)of_xy.x, (double)of_xy.y, (double)of_xy.z);
    check_right_angle(of_xy, x);
    check_right_angle(of_xy, y);
}

static void a_moved_triangle_has_the_same_normal(void **state)
{
    (void)state;
    check_that_normals_differ();
    for (uint32_t i = 0; i < 1000; i++) {
        /* Whole numbers up to 2^6 and steps of up to 2^22 move without rounding, and so do the
         * differences of the corners. Products of the corners are rounded by 2^20. */
        rk_vec3 corner[3];
        for (uint32_t k = 0; k < 3; k++)
            corner[k] = random_whole(i, 2 + k);
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
        for (int exponent = -24; exponent <= 28; exponent += 4) {
            /* Powers of two: nothing is rounded otherwise, but for the last bit of 1 / length. */
            float by = ldexpf(1, exponent);
            check_vec3(rk_normals_of_triangle(rk_scale(a, by), rk_scale(b, by), rk_scale(c, by)),
                       want, 0x1p-22f,
                       "a triangle and the same one larger or smaller: areas from 2^-60 to 2^60 "
                       "are neither too small nor too large");
        }
    }
    for (int e = -60; e <= 60; e++) {
        float x = ldexpf(1, e / 2), y = ldexpf(1, e - e / 2 + 1);
        check_vec3(rk_normals_of_triangle(rk_vec(0, 0, 0), rk_vec(x, 0, 0), rk_vec(0, y, 0)),
                   rk_vec(0, 0, 1), 0x1p-22f, "a triangle with an area from 2^-60 to 2^60");
    }
}

/* Triangles with small angles, and with edges of very different lengths. */
static void check_thin_triangles(void)
{
    const rk_vec3 o = {0, 0, 0}, z = {0, 0, 1};
    for (int k = 2; k <= 4096; k++) {
        float m = (float)k; /* m (m - 2) - (m - 1)^2 = -1, of products that floats can hold */
        check_vec3(rk_normals_of_triangle(o, rk_vec(m - 1, m - 2, 0), rk_vec(m, m - 1, 0)), z,
                   0x1p-22f, "a triangle with a small angle: its area is 1/2");
    }
    for (int e = -40; e <= 40; e++)
        check_vec3(
            rk_normals_of_triangle(o, rk_vec(ldexpf(1, e), 0, 0), rk_vec(0, ldexpf(1, -e), 0)), z,
            0x1p-22f, "one edge is much shorter than the other, and the area is 1/2");
}

static void a_normal_is_unit_and_at_right_angles_to_all_edges(void **state)
{
    (void)state;
    check_thin_triangles();
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
        rk_check(area < 0.01 || rk_dot(n, rk_cross(rk_sub(b, a), rk_sub(c, a))) > 0,
                 "triangle %u: got a normal (%g, %g, %g) on the side from which a, b, c run "
                 "clockwise, want the other side",
                 i, (double)n.x, (double)n.y, (double)n.z);
    }
}

static void two_swapped_corners_turn_the_normal_around(void **state)
{
    (void)state;
    const rk_vec3 a = {1, 2, 3}, b = {4, -1, 2}, c = {0, 5, 7};
    rk_vec3 n = rk_normals_of_triangle(a, b, c);
    rk_check(rk_length(n) > 0, "the normal of a triangle with an area is (0, 0, 0)");
    check_right_angle(n, rk_sub(b, a));
    check_right_angle(n, rk_sub(c, a));
    check_vec3(rk_normals_of_triangle(a, c, b), rk_negate(n), 0x1p-22f,
               "the triangle a, c, b is seen from behind");
}

static void a_triangle_without_area_has_the_normal_0(void **state)
{
    (void)state;
    const rk_vec3 a = {1, 2, 3}, b = {2, 4, 6}, c = {3, 6, 9};
    check_that_normals_differ();
    check_vec3(rk_normals_of_triangle(a, a, a), rk_vec(0, 0, 0), 0, "all corners in one point");
    check_vec3(rk_normals_of_triangle(a, b, c), rk_vec(0, 0, 0), 0, "all corners on one line");
    check_vec3(rk_normals_of_triangle(b, a, c), rk_vec(0, 0, 0), 0, "a between b and c on a line");
    check_vec3(rk_normals_of_triangle(a, a, c), rk_vec(0, 0, 0), 0, "a and b in one point");
    check_vec3(rk_normals_of_triangle(a, c, a), rk_vec(0, 0, 0), 0, "a and c in one point");
    check_vec3(rk_normals_of_triangle(a, c, c), rk_vec(0, 0, 0), 0, "b and c in one point");
    for (uint32_t i = 0; i < 10000; i++) { /* whole numbers, whose products floats can hold */
        rk_vec3 from = random_whole(i, 11), along = random_whole(i, 12);
        along = rk_scale(along, ldexpf(1, (int)(i % 3) * 20 - 20));
        from = rk_scale(from, ldexpf(1, (int)(i % 3) * 20 - 20));
        float s = (float)(rk_case(i, 13, 0, 0) % 31) - 15,
              t = (float)(rk_case(i, 13, 1, 0) % 31) - 15;
        check_vec3(rk_normals_of_triangle(from, rk_madd(from, along, s), rk_madd(from, along, t)),
                   rk_vec(0, 0, 0), 0, "all corners on one line through a");
    }
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
