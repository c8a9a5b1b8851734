/* Mirror reflection: examples by hand, and the laws of any mirror. */
#include "test.h"

#include "base/random.h"
#include "base/reflect.h"

static rk_vec3 unit_vector(uint32_t i, uint32_t which)
{
    rk_vec3 v;
    uint32_t attempt = 0;
    do {
        v = rk_vec(2 * rk_unit_float(rk_hash(i, which, attempt, 0)) - 1,
                   2 * rk_unit_float(rk_hash(i, which, attempt, 1)) - 1,
                   2 * rk_unit_float(rk_hash(i, which, attempt, 2)) - 1);
        attempt++;
    } while (!(rk_dot(v, v) > 0.01f && rk_dot(v, v) < 1));
    return rk_normalize(v);
}

static void check_vector(rk_vec3 got, rk_vec3 want, double tolerance, const char *hint)
{
    for (int axis = 0; axis < 3; axis++)
        rk_check_close(rk_axis(got, axis), rk_axis(want, axis), tolerance, hint);
}

static void a_floor_turns_downwards_into_upwards(void **state)
{
    (void)state;
    const rk_vec3 up = {0, 1, 0};
    check_vector(rk_reflect(rk_vec(3, -4, 5), up), rk_vec(3, 4, 5), 0, "only y turns");
    check_vector(rk_reflect(rk_vec(0, -1, 0), up), up, 0, "straight down comes straight back");
    check_vector(rk_reflect(rk_vec(1, 0, 2), up), rk_vec(1, 0, 2), 0, "along the floor goes on");
    check_vector(rk_reflect(rk_vec(-8, -1, 0), rk_vec(0.6f, 0.8f, 0)), rk_vec(-1.28f, 7.96f, 0),
                 2e-6, "d.n = -5.6, so d + 11.2 n; six roundings of numbers up to 8.96");
}

/* Bounds: n.n is 1 within 4 roundings; d.n and each component of the result take three or four
 * more, of numbers up to 2. */
static const double few_roundings = 16 * 0x1p-24;

static void the_angle_out_is_the_angle_in(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec3 d = unit_vector(i, 0), n = unit_vector(i, 1), r = rk_reflect(d, n);
        rk_check_close(rk_dot(r, n), -rk_dot(d, n), few_roundings, "the same cosine, turned");
        rk_check_close(rk_dot(r, rk_cross(d, n)), 0, few_roundings, "in the plane of d and n");
        rk_check_close(rk_length(r), 1, few_roundings, "a unit direction stays unit");
    }
}

static void the_side_of_the_normal_does_not_matter(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 d = unit_vector(i, 0), n = unit_vector(i, 1);
        check_vector(rk_reflect(d, rk_negate(n)), rk_reflect(d, n), 0, "-n is the same mirror");
    }
}

static void reflecting_twice_gives_the_direction_back(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec3 d = unit_vector(i, 0), n = unit_vector(i, 1);
        check_vector(rk_reflect(rk_reflect(d, n), n), d, 2 * few_roundings, "there and back");
    }
}

static void the_length_is_kept(void **state)
{
    (void)state;
    rk_vec3 n = unit_vector(1, 1);
    for (int exponent = -30; exponent <= 30; exponent += 10) {
        rk_vec3 d = unit_vector(1, 0), r = rk_reflect(d, n);
        float scale = ldexpf(1, exponent);
        check_vector(rk_reflect(rk_scale(d, scale), n), rk_scale(r, scale), 0,
                     "powers of two change no digit");
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_floor_turns_downwards_into_upwards),
    cmocka_unit_test(the_angle_out_is_the_angle_in),
    cmocka_unit_test(the_side_of_the_normal_does_not_matter),
    cmocka_unit_test(reflecting_twice_gives_the_direction_back),
    cmocka_unit_test(the_length_is_kept),
};

RK_SUITE("reflect", tests)
