/* Interpolation: exact at corners, linear between them. */
#include "test.h"

#include "base/interpolate.h"
#include "base/random.h"

static float noise(uint32_t i, uint32_t which)
{
    return 2 * rk_unit_float(rk_hash(i, which, 11, 12)) - 1;
}

static rk_vec3 weights_at(uint32_t i)
{
    float u = rk_unit_float(rk_hash(i, 0, 13, 14)),
          v = (1 - u) * rk_unit_float(rk_hash(i, 1, 13, 14));
    return rk_vec(1 - u - v, u, v);
}

static void corners_are_reproduced_to_the_bit(void **state)
{
    (void)state;
    const rk_vec3 at[3] = {{0.1f, 0.2f, 0.3f}, {1e30f, -7, 1e-30f}, {-3.3f, 0, 5.5f}};
    for (int corner = 0; corner < 3; corner++) {
        rk_vec3 weights = rk_vec(corner == 0, corner == 1, corner == 2);
        rk_vec3 got = rk_interpolate3(at[0], at[1], at[2], weights);
        for (int axis = 0; axis < 3; axis++)
            rk_check_close(rk_axis(got, axis), rk_axis(at[corner], axis), 0, "weight 1, others 0");
        rk_vec2 pair = rk_interpolate2((rk_vec2){at[0].x, at[0].y}, (rk_vec2){at[1].x, at[1].y},
                                       (rk_vec2){at[2].x, at[2].y}, weights);
        rk_check_close(pair.x, at[corner].x, 0, "weight 1, others 0");
        rk_check_close(pair.y, at[corner].y, 0, "weight 1, others 0");
    }
}

static void each_corner_has_its_own_weight(void **state)
{
    (void)state;
    rk_vec3 weights = rk_vec(0.5f, 0.375f, 0.125f);
    rk_vec3 got = rk_interpolate3(rk_vec(1, 0, 0), rk_vec(0, 1, 0), rk_vec(0, 0, 1), weights);
    rk_check_close(got.x, 0.5, 0, "of a");
    rk_check_close(got.y, 0.375, 0, "of b");
    rk_check_close(got.z, 0.125, 0, "of c");
    rk_vec2 pair = rk_interpolate2((rk_vec2){8, 0}, (rk_vec2){16, 0}, (rk_vec2){0, 64}, weights);
    rk_check_close(pair.x, 10, 0, "4 + 6");
    rk_check_close(pair.y, 8, 0, "64 / 8");
}

/* Interpolating values of a linear function gives its value at the point. */
static void linear_functions_are_reproduced(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec3 corner[3], w = weights_at(i), of;
        float value[3];
        for (uint32_t k = 0; k < 3; k++) {
            corner[k] = rk_vec(noise(i, 3 * k), noise(i, 3 * k + 1), noise(i, 3 * k + 2));
            value[k] = 2 * corner[k].x - 3 * corner[k].y + 0.5f * corner[k].z + 1;
        }
        rk_vec3 point = rk_interpolate3(corner[0], corner[1], corner[2], w);
        of = rk_interpolate3(rk_vec(value[0], 0, 0), rk_vec(value[1], 0, 0), rk_vec(value[2], 0, 0),
                             w);
        double want = 2 * (double)point.x - 3 * (double)point.y + 0.5 * (double)point.z + 1;
        /* Values are up to 6.5: about five roundings of 2^-24 each, and one of the weights' sum. */
        rk_check_close(of.x, want, 6.5 * 8 * 0x1p-24, "linear in the point");
        rk_vec2 pair = rk_interpolate2((rk_vec2){value[0], 1}, (rk_vec2){value[1], 1},
                                       (rk_vec2){value[2], 1}, w);
        rk_check_close(pair.x, of.x, 0, "pairs as triples");
        rk_check_close(pair.y, 1, 3 * 0x1p-24, "a constant stays: three roundings");
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(corners_are_reproduced_to_the_bit),
    cmocka_unit_test(each_corner_has_its_own_weight),
    cmocka_unit_test(linear_functions_are_reproduced),
};

RK_SUITE("interpolate", tests)
