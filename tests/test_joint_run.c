/* Runs of joint numbers are the feature's to the bit, from any index on, for all kinds and
 * dimensions. */
#include "test.h"

#include "render/joint_run.h"

static void check(const rk_joint_runs *runs, const rk_sampler *sampler, uint32_t pixel,
                  uint32_t first, uint32_t count, uint32_t dimension)
{
    rk_vec2 got[RK_JOINT_RUN_MAX], want[RK_JOINT_RUN_MAX];
    rk_joint_run(runs, sampler, pixel, first, count, dimension, got);
    rk_joint_2d_run(sampler, pixel, first, count, dimension, want);
    for (uint32_t i = 0; i < count; i++)
        rk_check(memcmp(&got[i], &want[i], sizeof want[i]) == 0,
                 "%s, dimension %u: pair %u of %u from %u on is (%.9g, %.9g), not (%.9g, %.9g)",
                 rk_sampler_name(sampler->kind), dimension, i, count, first, (double)got[i].x,
                 (double)got[i].y, (double)want[i].x, (double)want[i].y);
}

static void runs_are_the_features_to_the_bit(void **state)
{
    const uint32_t dimensions[] = {RK_DIMENSION_PIXEL, RK_DIMENSION_LIGHT, RK_DIMENSION_LENS,
                                   RK_DIMENSION_GLOSSY, RK_DIMENSION_GLOSSY + 2};
    const uint32_t starts[] = {0, 1, 63, 64, 100, 65535, 1000000};
    const rk_joint_runs runs = rk_joint_runs_of();
    (void)state;
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_ZSOBOL; kind++)
        for (size_t d = 0; d < sizeof dimensions / sizeof *dimensions; d++)
            for (size_t s = 0; s < sizeof starts / sizeof *starts; s++)
                for (uint32_t count = 1; count <= RK_JOINT_RUN_MAX; count += 7) {
                    const rk_sampler sampler = {(rk_sampler_kind)kind, 3, 1 << 20, 100};
                    check(&runs, &sampler, 1234 + count, starts[s], count, dimensions[d]);
                }
}

static void equal_numbers_are_taken_for_equal(void **state)
{
    (void)state;
    rk_check(rk_joint_runs_of().agree, "the feature is asked for each number");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(runs_are_the_features_to_the_bit),
    cmocka_unit_test(equal_numbers_are_taken_for_equal),
};

RK_SUITE("joint_run", tests)
