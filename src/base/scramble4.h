/* base/scramble.h for four numbers at once, each the same to the bit; not installed. */
#ifndef RK_BASE_SCRAMBLE4_H
#define RK_BASE_SCRAMBLE4_H

#include "base/simd4.h"

typedef uint32_t rk_simd4_bits __attribute__((vector_size(16)));

static inline rk_simd4_bits rk_simd4_bits_all(uint32_t x)
{
    return (rk_simd4_bits){x, x, x, x};
}

static inline rk_simd4_bits rk_simd4_bits_load(const uint32_t *four)
{
    rk_simd4_bits x;
    memcpy(&x, four, sizeof x);
    return x;
}

/* As rk_scramble_reversed. */
static inline rk_simd4_bits rk_simd4_scramble_reversed(rk_simd4_bits x, rk_simd4_bits key)
{
    x ^= x * 0x3d20adeau;
    x += key;
    x *= key >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* As rk_unit_float of rk_reverse_bits. */
static inline rk_simd4 rk_simd4_unit_float_reversed(rk_simd4_bits x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = x >> 16 | x << 16;
    return __builtin_convertvector((rk_simd4_mask)(x >> 8), rk_simd4) * 0x1p-24f;
}

#endif
