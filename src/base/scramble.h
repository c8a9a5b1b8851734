/* Owen scrambling of 32-bit numbers in a few operations. */
#ifndef RK_BASE_SCRAMBLE_H
#define RK_BASE_SCRAMBLE_H

#include <stdint.h>

static inline uint32_t rk_reverse_bits(uint32_t x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    return x >> 16 | x << 16;
}

/* Flips each bit or not, depending only on the key and the lower bits: Owen scrambling of a number
 * whose bits are reversed (Laine and Karras, "Stratified sampling for stochastic transparency",
 * EGSR 2011; Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020). Operations that obey
 * this rule are sums, odd factors, and xor with an even multiple. These are the last ones of N.
 * Vegdahl, "Building a better LK hash" (psychopath.io, 2021, as corrected in May): with the
 * constants of Laine and Karras, which Burley uses, the flips of neighbouring intervals are not
 * independent. */
static inline uint32_t rk_scramble_reversed(uint32_t x, uint32_t key)
{
    x ^= x * 0x3d20adeau;
    x += key;
    x *= key >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

#endif
