/* From an index to the next a few digits change, and a sample's bits follow from the last one's by
 * a single xor. Used only if examples give the numbers of the feature's own functions to the bit.
 * */
#include "render/joint_run.h"

#include "base/scramble_run.h"

#include <string.h>

enum { least_count = 4 }; /* of fewer numbers the feature's functions are as fast */

static uint32_t lowest_zero(uint32_t x)
{
    return x == UINT32_MAX ? 0 : (uint32_t)__builtin_ctz(~x);
}

/* From an index to the next one, the digits up to the lowest 0 change. */
static void find_bits(const rk_joint_runs *runs, uint32_t joint, uint32_t first, uint32_t count,
                      uint32_t *bits)
{
    const uint32_t *change = runs->change[joint];
    bits[0] = rk_sobol_bits(rk_sobol_columns[joint], first);
    for (uint32_t i = 1; i < count; i++)
        bits[i] = bits[i - 1] ^ change[lowest_zero(first + i - 1)];
}

static void draw(const rk_joint_runs *runs, uint32_t seed, uint32_t pixel, uint32_t first,
                 uint32_t count, uint32_t joint, float *numbers)
{
    const uint32_t key = rk_joint_key(seed, pixel, joint);
    uint32_t bits[RK_JOINT_RUN_MAX], keys[RK_JOINT_RUN_MAX];
    find_bits(runs, joint, first, count, bits);
    for (uint32_t i = 0; i < RK_JOINT_RUN_MAX; i++) /* a fixed number is filled faster */
        keys[i] = key;
    rk_scramble_run(count, bits, keys, numbers);
}

static void draw_pairs(const rk_joint_runs *runs, uint32_t seed, uint32_t pixel, uint32_t first,
                       uint32_t count, uint32_t joint, rk_vec2 *pairs)
{
    float x[RK_JOINT_RUN_MAX], y[RK_JOINT_RUN_MAX];
    draw(runs, seed, pixel, first, count, joint, x);
    draw(runs, seed, pixel, first, count, joint + 1, y);
    for (uint32_t i = 0; i < count; i++)
        pairs[i] = (rk_vec2){x[i], y[i]};
}

/* A student's table may name dimensions that there are not. */
static bool is_joint(int joint)
{
    return joint >= 0 && joint + 1 < RK_SOBOL_DIMENSIONS;
}

void rk_joint_run(const rk_joint_runs *runs, const rk_sampler *sampler, uint32_t pixel,
                  uint32_t first, uint32_t count, uint32_t dimension, rk_vec2 *pairs)
{
    const int joint = rk_joint_dimension(dimension);
    if (runs->agree && sampler->kind == RK_SAMPLER_SOBOL && is_joint(joint) && count >= least_count)
        draw_pairs(runs, sampler->seed, pixel, first, count, (uint32_t)joint, pairs);
    else
        rk_joint_2d_run(sampler, pixel, first, count, dimension, pairs);
}

/* --- Are they the feature's numbers? ---------------------------------------------------------- */

static bool run_agrees(const rk_joint_runs *runs, uint32_t key, uint32_t dimension)
{
    const rk_sampler sampler = {.kind = RK_SAMPLER_SOBOL, .seed = key, .samples = RK_SAMPLES_MAX};
    const uint32_t pixel = rk_hash(key, 0, 0, 0), first = rk_hash(key, 1, 0, 0) % RK_SAMPLES_MAX;
    const int joint = rk_joint_dimension(dimension);
    rk_vec2 one[RK_JOINT_RUN_MAX], four[RK_JOINT_RUN_MAX];
    if (!is_joint(joint))
        return false;
    draw_pairs(runs, key, pixel, first, RK_JOINT_RUN_MAX, (uint32_t)joint, four);
    rk_joint_2d_run(&sampler, pixel, first, RK_JOINT_RUN_MAX, dimension, one);
    return memcmp(one, four, sizeof one) == 0;
}

rk_joint_runs rk_joint_runs_of(void)
{
    enum { examples = 4 };
    rk_joint_runs runs = {.agree = true};
    for (uint32_t joint = 0; joint < RK_SOBOL_DIMENSIONS; joint++)
        for (uint32_t k = 0; k < RK_SOBOL_DIGITS; k++)
            runs.change[joint][k] =
                (k > 0 ? runs.change[joint][k - 1] : 0) ^ rk_sobol_columns[joint][k];
    for (uint32_t i = 0; i < examples; i++)
        runs.agree = runs.agree && run_agrees(&runs, i, RK_DIMENSION_LIGHT) &&
                     run_agrees(&runs, i, RK_DIMENSION_GLOSSY);
    return runs;
}
