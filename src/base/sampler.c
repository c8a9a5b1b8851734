/* Uniform, stratified and low-discrepancy samples (Pharr, Jakob, Humphreys, "Physically Based
 * Rendering", chapter 8 of the fourth edition), each computed from its arguments alone. */
#include "base/sampler.h"

#include "base/scramble.h"

#include <assert.h>

RK_NAMES(rk_sampler_names, rk_sampler_kind, RK_SAMPLER_ZSOBOL, "uniform", "stratified",
         "low-discrepancy", "sobol", "zsobol");

const char *rk_sampler_name(rk_sampler_kind kind)
{
    return rk_sampler_names.items[kind];
}

/* Identifies a sequence of numbers, one for each sample. */
typedef struct place {
    uint32_t seed, pixel, dimension;
} place;

/* Hashes that all samples of a place use. They take the place of sample numbers, counted from the
 * end, where there are no samples. */
enum { first_key = 1, second_key, index_key };

static uint32_t key_of(place at, uint32_t which)
{
    return rk_hash(at.seed, at.pixel, 0u - which, at.dimension);
}

static uint32_t random_bits(place at, uint32_t sample)
{
    return rk_hash(at.seed, at.pixel, sample, at.dimension);
}

static place next_dimension(place at)
{
    at.dimension++;
    return at;
}

/* --- stratified ------------------------------------------------------------------------------ */

/* The position of i after 0 .. n - 1 are shuffled by the key: swap-or-not (Hoang, Morris, Rogaway,
 * "An enciphering scheme based on a card shuffle", CRYPTO 2012). A round pairs each i with pivot -
 * i, modulo n, and one bit, equal for both partners, decides whether they swap. A linear
 * congruential generator (Knuth's MMIX) gives each round 64 bits: the high half is the pivot, the
 * rest an odd factor that hashes the larger partner to its product's top bit. */
static uint32_t shuffled(uint32_t i, uint32_t n, uint64_t key)
{
    const int rounds = 12; /* each halves the remaining deviation from random */
    for (int round = 0; round < rounds; round++) {
        key = key * 6364136223846793005u + 1442695040888963407u;
        uint32_t pivot = (uint32_t)((key >> 32) * n >> 32);
        uint32_t partner = pivot >= i ? pivot - i : pivot + n - i;
        uint64_t larger = i > partner ? i : partner;
        if ((larger + 1) * (key << 20 | 1) >> 63)
            i = partner;
    }
    return i;
}

/* A multiple of 2^-24 in [first / n, end / n), selected by the bits. In integers, so that rounding
 * cannot carry it out of its cell, or to 1. */
static float within(uint32_t first, uint32_t end, uint32_t n, uint32_t bits)
{
    uint64_t low = (((uint64_t)first << 24) + n - 1) / n;
    uint64_t high = (((uint64_t)end << 24) + n - 1) / n;
    return (float)(low + ((high - low) * bits >> 32)) * 0x1p-24f;
}

static uint32_t cell_of(const rk_sampler *sampler, place at, uint32_t sample)
{
    assert(sampler->samples > 0 && sampler->samples <= RK_SAMPLES_MAX &&
           "a stratified sampler needs the number of samples");
    assert(sample < sampler->samples && "a stratified sampler has no samples beyond that number");
    return shuffled(sample, sampler->samples, key_of(at, first_key));
}

static float stratified_1d(const rk_sampler *sampler, place at, uint32_t sample)
{
    uint32_t cell = cell_of(sampler, at, sample);
    return within(cell, cell + 1, sampler->samples, random_bits(at, sample));
}

/* n cells, where n need not be a square, are distributed over r rows, r the root of n rounded
 * down, as evenly as integers can. A row's height is proportional to its number of cells, so all
 * cells have the area 1 / n. They are numbered row by row; row j begins with cell j n / r
 * rounded down. */
static uint32_t row_count(uint32_t n)
{
    return (uint32_t)sqrtf((float)n); /* exact for all n up to RK_SAMPLES_MAX */
}

static uint32_t row_start(uint32_t row, uint32_t rows, uint32_t n)
{
    return (uint32_t)((uint64_t)row * n / rows);
}

static rk_vec2 stratified_2d(const rk_sampler *sampler, place at, uint32_t sample)
{
    const uint32_t n = sampler->samples, cell = cell_of(sampler, at, sample), rows = row_count(n);
    /* The last row j with j n / r < cell + 1. */
    uint32_t row = (uint32_t)((((uint64_t)cell + 1) * rows - 1) / n);
    uint32_t start = row_start(row, rows, n), end = row_start(row + 1, rows, n);
    uint32_t column = cell - start;
    return (rk_vec2){within(column, column + 1, end - start, random_bits(at, sample)),
                     within(start, end, n, random_bits(next_dimension(at), sample))};
}

/* --- low discrepancy ------------------------------------------------------------------------- */

/* The digits of i, reversed behind the binary point: van der Corput's sequence, Sobol's first
 * dimension. */
static float van_der_corput(uint32_t i, uint32_t key)
{
    return rk_unit_float(rk_reverse_bits(rk_scramble_reversed(i, key)));
}

/* Sobol's second dimension: its generator matrix, which maps the digits of i to the reversed digits
 * of the number, is Pascal's triangle modulo 2. Digit j adds to digit r where all bits of r are set
 * in j; this is done for each bit of j. */
static float second_sobol(uint32_t i, uint32_t key)
{
    i ^= (i & 0xaaaaaaaau) >> 1;
    i ^= (i & 0xccccccccu) >> 2;
    i ^= (i & 0xf0f0f0f0u) >> 4;
    i ^= (i & 0xff00ff00u) >> 8;
    i ^= (i & 0xffff0000u) >> 16;
    return van_der_corput(i, key);
}

/* Every pixel and dimension reads the sequence in an order of its own. */
static float low_discrepancy_1d(place at, uint32_t sample)
{
    return van_der_corput(rk_shuffled_index(sample, key_of(at, index_key)), key_of(at, first_key));
}

static void low_discrepancy_2d(place at, uint32_t first, uint32_t count, rk_vec2 *pairs)
{
    const uint32_t of_index = key_of(at, index_key), of_x = key_of(at, first_key);
    const uint32_t of_y = key_of(at, second_key);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t index = rk_shuffled_index(first + i, of_index);
        pairs[i] = (rk_vec2){van_der_corput(index, of_x), second_sobol(index, of_y)};
    }
}

/* --- all kinds ------------------------------------------------------------------------------- */

static float uniform(place at, uint32_t sample)
{
    return rk_unit_float(random_bits(at, sample));
}

float rk_sample_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    const place at = {sampler->seed, pixel, dimension};
    switch (sampler->kind) {
    case RK_SAMPLER_STRATIFIED:
        return stratified_1d(sampler, at, sample);
    case RK_SAMPLER_LOW_DISCREPANCY:
    case RK_SAMPLER_SOBOL:
    case RK_SAMPLER_ZSOBOL:
        return low_discrepancy_1d(at, sample);
    case RK_SAMPLER_UNIFORM:
        break;
    }
    return uniform(at, sample);
}

void rk_sample_2d_run(const rk_sampler *sampler, uint32_t pixel, uint32_t first, uint32_t count,
                      uint32_t dimension, rk_vec2 *pairs)
{
    const place at = {sampler->seed, pixel, dimension};
    switch (sampler->kind) {
    case RK_SAMPLER_STRATIFIED:
        for (uint32_t i = 0; i < count; i++)
            pairs[i] = stratified_2d(sampler, at, first + i);
        return;
    case RK_SAMPLER_LOW_DISCREPANCY:
    case RK_SAMPLER_SOBOL:
    case RK_SAMPLER_ZSOBOL:
        low_discrepancy_2d(at, first, count, pairs);
        return;
    case RK_SAMPLER_UNIFORM:
        break;
    }
    for (uint32_t i = 0; i < count; i++)
        pairs[i] = (rk_vec2){uniform(at, first + i), uniform(next_dimension(at), first + i)};
}

rk_vec2 rk_sample_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension)
{
    rk_vec2 pair;
    rk_sample_2d_run(sampler, pixel, sample, 1, dimension, &pair);
    return pair;
}
