/* Points of Sobol' sequences: direction numbers from a recurrence, coordinates by xor, digits
 * flipped by Owen's scrambling, and dimensions that paths share. Sources: see features/sampling.h.
 */
#include "features/sampling.h"

#include "base/scramble.h"

#include <assert.h>

/* The points that a pixel's samples take: of which sequence, from which index on. */
typedef struct points {
    uint32_t sequence, first;
    uint32_t dimension; /* the first of the two that are read */
    bool is_padded;     /* in an order of their own, by this key */
    uint32_t order;
} points;

/* Contents, in the order of the chapter. */
static float joint_number(uint32_t seed, uint32_t sequence, uint32_t bits, uint32_t dimension);
static points points_of(const rk_sampler *sampler, uint32_t pixel);
static points padded(points p, uint32_t dimension);
static bool find_points(const rk_sampler *sampler, uint32_t pixel, uint32_t dimension, points *p);
static uint32_t index_of(const points *p, uint32_t sample);
static uint32_t next_bits(const uint32_t *columns, uint32_t bits, uint32_t index);
static void find_coordinates(const points *p, uint32_t dimension, uint32_t first, uint32_t count,
                             uint32_t *bits);

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

/* From the coordinate's bits, reversed. */
static inline float joint_number(uint32_t seed, uint32_t sequence, uint32_t bits,
                                 uint32_t dimension)
{
    /* solution */
    /* The place of a sample number that there is not: see sampler.c, which has keys of its own. */
    uint32_t key = rk_hash(seed, sequence, 0u - 4, dimension);
    return rk_unit_float(rk_reverse_bits(rk_scramble_reversed(bits, key)));
    /* starter
    // Fifth step: the coordinate, scrambled; until then an independent number.
    return rk_unit_float(rk_hash(seed, sequence, bits, dimension));
    end */
}

/* --- Z order ---------------------------------------------------------------------------------- */

uint32_t rk_morton_index(uint32_t x, uint32_t y)
{
    /* solution */
    uint32_t spread[2] = {x, y};
    for (int axis = 0; axis < 2; axis++) { /* halves move apart, then their halves, and so on */
        uint32_t digits = spread[axis];
        digits = (digits | digits << 8) & 0x00ff00ffu;
        digits = (digits | digits << 4) & 0x0f0f0f0fu;
        digits = (digits | digits << 2) & 0x33333333u;
        spread[axis] = (digits | digits << 1) & 0x55555555u;
    }
    return spread[0] | spread[1] << 1;
    /* starter
    // Sixth step: the binary digits of x at the even places, those of y at the odd ones.
    return x + y;
    end */
}

uint32_t rk_permute_digits(uint32_t index, uint32_t key)
{
    /* solution */
    uint32_t permuted = 0;
    for (uint32_t place = 2 * RK_MORTON_DIGITS; place > 0;) {
        /* The digits before it, behind a 1, as in rk_owen_scramble. */
        uint32_t before = (1u << 2 * RK_MORTON_DIGITS | index) >> place;
        uint32_t permutation = rk_permutation_of_4(rk_hash(key, before, 1, 0));
        place -= 2;
        uint32_t digit = index >> place & 3;
        permuted |= (permutation >> 2 * digit & 3) << place;
    }
    return permuted;
    /* starter
    // Seventh step: for each digit in base 4, the highest first, a permutation chosen by rk_hash of
    // the key and the digits before it.
    return index;
    end */
}

static points points_of(const rk_sampler *sampler, uint32_t pixel)
{
    /* solution */
    assert(sampler->width > 0 && sampler->samples > 0 &&
           "zsobol needs the picture's width and the number of samples");
    const uint32_t x = pixel % sampler->width, y = pixel / sampler->width;
    const uint32_t side = 1u << RK_MORTON_DIGITS;
    uint32_t key = rk_hash(sampler->seed, rk_morton_index(x / side, y / side), 0u - 5, 0);
    uint32_t place = rk_permute_digits(rk_morton_index(x % side, y % side), key);
    return (points){.sequence = key, .first = place * sampler->samples};
    /* starter
    // Eighth step: a sequence for each square of 2^RK_MORTON_DIGITS pixels on a side, and the
    // pixel's place in it; until then a sequence for each pixel.
    return (points){.sequence = pixel, .first = 0};
    end */
}

/* --- All kinds -------------------------------------------------------------------------------- */

/* Other dimensions take the first two, of a sequence of their own, in an order of their own. */
static points padded(points p, uint32_t dimension)
{
    p.sequence = p.order = rk_hash(p.sequence, dimension, 0u - 6, 0);
    p.is_padded = true;
    return p;
}

/* False if the numbers are no points of a sequence. */
static inline bool find_points(const rk_sampler *sampler, uint32_t pixel, uint32_t dimension,
                               points *p)
{
    const int joint = rk_joint_dimension(dimension);
    if (sampler->kind == RK_SAMPLER_ZSOBOL)
        *p = joint >= 0 ? points_of(sampler, pixel) : padded(points_of(sampler, pixel), dimension);
    else if (sampler->kind == RK_SAMPLER_SOBOL && joint >= 0)
        *p = (points){.sequence = pixel};
    else
        return false;
    p->dimension = joint >= 0 ? (uint32_t)joint : 0;
    return true;
}

static inline uint32_t index_of(const points *p, uint32_t sample)
{
    uint32_t index = p->first + sample;
    return p->is_padded ? rk_shuffled_index(index, p->order) : index;
}

/* The bits of the next coordinate. Of a sum with 1 the digits change that are 1, from the lowest
 * on, and the first that is 0; each change is an xor with its number. */
static inline uint32_t next_bits(const uint32_t *columns, uint32_t bits, uint32_t index)
{
    for (uint32_t changes = index ^ (index + 1); changes; changes >>= 1)
        bits ^= *columns++;
    return bits;
}

/* The coordinates of samples `first` to `first + count - 1`, their bits reversed. */
static void find_coordinates(const points *p, uint32_t dimension, uint32_t first, uint32_t count,
                             uint32_t *bits)
{
    const uint32_t *columns = rk_sobol_columns[dimension];
    bits[0] = rk_sobol_bits(columns, index_of(p, first));
    for (uint32_t i = 1; i < count; i++)
        bits[i] = p->is_padded ? rk_sobol_bits(columns, index_of(p, first + i))
                               : next_bits(columns, bits[i - 1], p->first + first + i - 1);
}

float rk_joint_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    points p;
    if (!find_points(sampler, pixel, dimension, &p))
        return rk_sample_1d(sampler, pixel, sample, dimension);
    uint32_t bits = rk_sobol_bits(rk_sobol_columns[p.dimension], index_of(&p, sample));
    return joint_number(sampler->seed, p.sequence, bits, p.dimension);
}

void rk_joint_2d_run(const rk_sampler *sampler, uint32_t pixel, uint32_t first, uint32_t count,
                     uint32_t dimension, rk_vec2 *pairs)
{
    points p;
    if (!find_points(sampler, pixel, dimension, &p)) {
        rk_sample_2d_run(sampler, pixel, first, count, dimension, pairs);
        return;
    }
    enum { at_once = 64 };
    uint32_t x[at_once], y[at_once];
    for (uint32_t done = 0; done < count; done += at_once) {
        const uint32_t n = count - done < at_once ? count - done : at_once;
        find_coordinates(&p, p.dimension, first + done, n, x);
        find_coordinates(&p, p.dimension + 1, first + done, n, y);
        for (uint32_t i = 0; i < n; i++)
            pairs[done + i] =
                (rk_vec2){joint_number(sampler->seed, p.sequence, x[i], p.dimension),
                          joint_number(sampler->seed, p.sequence, y[i], p.dimension + 1)};
    }
}

rk_vec2 rk_joint_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    rk_vec2 pair;
    rk_joint_2d_run(sampler, pixel, sample, 1, dimension, &pair);
    return pair;
}
