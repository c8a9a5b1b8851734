/* Eight numbers in a vector of the compiler's. AVX2 multiplies eight at a time; SSE2, which every
 * x86-64 has, cannot multiply 32-bit numbers, and takes about as long as plain numbers. */
#include "base/scramble_run.h"

#include <string.h>

typedef uint32_t eight __attribute__((vector_size(32)));
typedef int32_t eight_signed __attribute__((vector_size(32)));
typedef float eight_floats __attribute__((vector_size(32)));

/* The operations of base/scramble.h. Vectors stay inside, because how they are passed depends on
 * the instruction set. */
__attribute__((always_inline)) static inline void run(uint32_t count, const uint32_t *bits,
                                                      const uint32_t *keys, float *numbers)
{
    for (uint32_t i = 0; i < count; i += RK_SCRAMBLE_EIGHT) {
        eight x, key;
        memcpy(&x, &bits[i], sizeof x);
        memcpy(&key, &keys[i], sizeof key);
        x ^= x * 0x3d20adeau;
        x += key;
        x *= key >> 16 | 1;
        x ^= x * 0x05526c56u;
        x ^= x * 0x53a22864u;
        x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
        x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
        x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
        x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
        x = x >> 16 | x << 16;
        const eight_signed digits = (eight_signed)(x >> 8);
        const eight_floats result = __builtin_convertvector(digits, eight_floats) * 0x1p-24f;
        memcpy(&numbers[i], &result, sizeof result);
    }
}

void rk_scramble_run_plain(uint32_t count, const uint32_t *bits, const uint32_t *keys,
                           float *numbers)
{
    run(count, bits, keys, numbers);
}

#if defined __x86_64__ || defined __i386__

__attribute__((target("avx2"))) static void run_avx2(uint32_t count, const uint32_t *bits,
                                                     const uint32_t *keys, float *numbers)
{
    run(count, bits, keys, numbers);
}

bool rk_scramble_run_avx2(uint32_t count, const uint32_t *bits, const uint32_t *keys,
                          float *numbers)
{
    if (!__builtin_cpu_supports("avx2"))
        return false;
    run_avx2(count, bits, keys, numbers);
    return true;
}

#else

bool rk_scramble_run_avx2(uint32_t count, const uint32_t *bits, const uint32_t *keys,
                          float *numbers)
{
    (void)count, (void)bits, (void)keys, (void)numbers;
    return false;
}

#endif

void rk_scramble_run(uint32_t count, const uint32_t *bits, const uint32_t *keys, float *numbers)
{
    if (!rk_scramble_run_avx2(count, bits, keys, numbers))
        rk_scramble_run_plain(count, bits, keys, numbers);
}
