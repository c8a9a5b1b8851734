/* Random numbers without state: a value is a hash of its use (pixel, sample, dimension), so that
 * pictures depend neither on threads nor on the order of work. Hash: pcg4d (Jarzynski and Olano,
 * "Hash functions for GPU rendering", JCGT 9(3), 2020). */
#ifndef RK_BASE_RANDOM_H
#define RK_BASE_RANDOM_H

#include <stdint.h>

/* Returns 32 random bits of the four numbers. The upper 16 depend on all bits of each, bit k of the
 * lower ones on no bit of theirs above k + 16: as a coin take the highest. In some orders of small
 * numbers a few results are related; rk_hash(result, 0, 0, 0) separates them. */
static inline uint32_t rk_hash(uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    a = a * 1664525u + 1013904223u;
    b = b * 1664525u + 1013904223u;
    c = c * 1664525u + 1013904223u;
    d = d * 1664525u + 1013904223u;
    a += b * d, b += c * a, c += a * b, d += b * c;
    a ^= a >> 16, b ^= b >> 16, c ^= c >> 16, d ^= d >> 16;
    a += b * d, b += c * a, c += a * b, d += b * c;
    return a ^ d;
}

/* Returns a multiple of 2^-24 in [0, 1): the finest even spacing that a float can represent, and
 * never 1. */
static inline float rk_unit_float(uint32_t bits)
{
    return (float)(bits >> 8) * 0x1p-24f;
}

#endif
