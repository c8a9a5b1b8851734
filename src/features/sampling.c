/* Points of Sobol' sequences: direction numbers from a recurrence, coordinates by xor, digits
 * flipped by Owen's scrambling, and dimensions that paths share. Sources: see features/sampling.h.
 */
#include "features/sampling.h"

#include "base/scramble.h"

/* Contents, in the order of the chapter. */
static float joint_number(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                          uint32_t dimension);
static bool is_joint(const rk_sampler *sampler, uint32_t dimension);

/* --- The sequence ----------------------------------------------------------------------------- */

uint32_t rk_sobol_bits(const uint32_t v[RK_SOBOL_DIGITS], uint32_t index)
{
    /* solution */
    uint32_t bits = 0;
    for (; index; index >>= 1, v++)
        bits ^= (0u - (index & 1)) & *v; /* without a branch that is hard to predict */
    return bits;
    /* starter
    // First step: for each digit of the index that is 1, the lowest first, xor with its number.
    return 0;
    end */
}

void rk_sobol_directions(uint32_t dimension, uint32_t v[RK_SOBOL_DIGITS])
{
    const rk_sobol_initial *p = &rk_sobol_initials[dimension];
    /* solution */
    uint32_t m[RK_SOBOL_DIGITS];
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++) {
        if (j < p->degree || p->degree == 0) {
            m[j] = p->degree ? p->m[j] : 1;
        } else {
            m[j] = m[j - p->degree] ^ m[j - p->degree] << p->degree;
            for (uint32_t k = 1; k < p->degree; k++)
                if (p->inner >> (p->degree - 1 - k) & 1)
                    m[j] ^= m[j - k] << k;
        }
        v[j] = m[j] << (RK_SOBOL_DIGITS - 1 - j);
    }
    /* starter
    // Second step: the numbers m[j], given or by the recurrence, and v[j] from m[j].
    for (uint32_t j = 0; j < RK_SOBOL_DIGITS; j++)
        v[j] = p->m[0];
    end */
}

/* --- Scrambling ------------------------------------------------------------------------------- */

uint32_t rk_owen_scramble(uint32_t bits, uint32_t key)
{
    /* solution */
    uint32_t scrambled = bits;
    for (uint32_t digit = 0; digit < 32; digit++) {
        /* The digits before it, behind a 1: so no two of any length are the same number. */
        uint32_t before = (uint32_t)((UINT64_C(1) << 32 | bits) >> (32 - digit));
        scrambled ^= rk_hash(key, before, 0, 0) >> 31 << (31 - digit);
    }
    return scrambled;
    /* starter
    // Third step: for each digit, the highest first, a coin: rk_hash of the key and the digits
    // before it.
    return bits;
    end */
}

/* --- Joint dimensions ------------------------------------------------------------------------- */

int rk_joint_dimension(uint32_t dimension)
{
    /* solution */
    switch (dimension) {
    case RK_DIMENSION_PIXEL:
        return 0;
    case RK_DIMENSION_LENS:
        return 2;
    case RK_DIMENSION_TIME:
        return 4;
    case RK_DIMENSION_LIGHT:
        return 5;
    case RK_DIMENSION_GLOSSY:
        return 7;
    default:
        return -1;
    }
    /* starter
    // Fourth step: the table in sampling.h.
    return -1;
    end */
}

static float joint_number(const rk_sampler *sampler, uint32_t pixel, uint32_t sample,
                          uint32_t dimension)
{
    /* solution */
    /* The place of a sample number that there is not: see sampler.c, which has keys of its own. */
    uint32_t key = rk_hash(sampler->seed, pixel, 0u - 4, dimension);
    uint32_t reversed = rk_sobol_bits(rk_sobol_columns[dimension], sample);
    return rk_unit_float(rk_reverse_bits(rk_scramble_reversed(reversed, key)));
    /* starter
    // Fifth step: the point's coordinate, scrambled; until then an independent number.
    return rk_unit_float(rk_hash(sampler->seed, pixel, sample, dimension));
    end */
}

static bool is_joint(const rk_sampler *sampler, uint32_t dimension)
{
    return sampler->kind == RK_SAMPLER_SOBOL && rk_joint_dimension(dimension) >= 0;
}

float rk_joint_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    return is_joint(sampler, dimension)
               ? joint_number(sampler, pixel, sample, (uint32_t)rk_joint_dimension(dimension))
               : rk_sample_1d(sampler, pixel, sample, dimension);
}

void rk_joint_2d_run(const rk_sampler *sampler, uint32_t pixel, uint32_t first, uint32_t count,
                     uint32_t dimension, rk_vec2 *pairs)
{
    if (!is_joint(sampler, dimension)) {
        rk_sample_2d_run(sampler, pixel, first, count, dimension, pairs);
        return;
    }
    uint32_t joint = (uint32_t)rk_joint_dimension(dimension);
    for (uint32_t i = 0; i < count; i++)
        pairs[i] = (rk_vec2){joint_number(sampler, pixel, first + i, joint),
                             joint_number(sampler, pixel, first + i, joint + 1)};
}

rk_vec2 rk_joint_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    rk_vec2 pair;
    rk_joint_2d_run(sampler, pixel, sample, 1, dimension, &pair);
    return pair;
}
