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

/* Another order of the points of a sequence: blocks of 2^k aligned indices stay together, and each
 * is distributed as well as the first. */
static inline uint32_t rk_shuffled_index(uint32_t index, uint32_t key)
{
    return rk_reverse_bits(rk_scramble_reversed(rk_reverse_bits(index), key));
}

/* One of the 24 permutations of 0 to 3, chosen by the hash: d becomes the bits 2 d and 2 d + 1 of
 * the result. */
static inline uint32_t rk_permutation_of_4(uint32_t hash)
{
    static const uint8_t permutations[24] = {0xe4, 0xb4, 0xd8, 0x78, 0x9c, 0x6c, 0xe1, 0xb1,
                                             0xc9, 0x39, 0x8d, 0x2d, 0xd2, 0x72, 0xc6, 0x36,
                                             0x4e, 0x1e, 0x93, 0x63, 0x87, 0x27, 0x4b, 0x1b};
    return permutations[(uint64_t)hash * 24 >> 32];
}

#endif
