/* The few instructions of SSE2 that base/simd.h and simd4.h use, by WebAssembly's: so the
 * renderer's tree is traced with registers of four floats there, too. */
#ifndef LIVE_EMMINTRIN_H
#define LIVE_EMMINTRIN_H

#include <wasm_simd128.h>

typedef float __m128 __attribute__((vector_size(16)));
typedef double __m128d __attribute__((vector_size(16)));

/* clang 14 makes a load and a splat of it one instruction, which it then moves behind later stores
 * to the same place, so that lanes get others' numbers. */
#define LIVE_IN_REGISTER(x) __asm__("" : "+r"(x))

#define LIVE_SSE2(type, suffix, number, lanes)                                                     \
    static inline type _mm_set1_##suffix(number x)                                                 \
    {                                                                                              \
        LIVE_IN_REGISTER(x);                                                                       \
        return (type)wasm_##lanes##_splat(x);                                                      \
    }                                                                                              \
    static inline type _mm_loadu_##suffix(const number *x)                                         \
    {                                                                                              \
        return (type)wasm_v128_load(x);                                                            \
    }                                                                                              \
    /* b where a is NaN, as in SSE2 */                                                             \
    static inline type _mm_min_##suffix(type a, type b)                                            \
    {                                                                                              \
        return (type)wasm_##lanes##_pmin((v128_t)b, (v128_t)a);                                    \
    }                                                                                              \
    static inline type _mm_max_##suffix(type a, type b)                                            \
    {                                                                                              \
        return (type)wasm_##lanes##_pmax((v128_t)b, (v128_t)a);                                    \
    }                                                                                              \
    static inline type _mm_sqrt_##suffix(type a)                                                   \
    {                                                                                              \
        return (type)wasm_##lanes##_sqrt((v128_t)a);                                               \
    }                                                                                              \
    static inline type _mm_andnot_##suffix(type a, type b)                                         \
    {                                                                                              \
        return (type)wasm_v128_andnot((v128_t)b, (v128_t)a);                                       \
    }                                                                                              \
    static inline type _mm_cmple_##suffix(type a, type b)                                          \
    {                                                                                              \
        return (type)wasm_##lanes##_le((v128_t)a, (v128_t)b);                                      \
    }                                                                                              \
    static inline type _mm_cmplt_##suffix(type a, type b)                                          \
    {                                                                                              \
        return (type)wasm_##lanes##_lt((v128_t)a, (v128_t)b);                                      \
    }

LIVE_SSE2(__m128, ps, float, f32x4)
LIVE_SSE2(__m128d, pd, double, f64x2)

static inline int _mm_movemask_ps(__m128 a)
{
    return (int)wasm_i32x4_bitmask((v128_t)a);
}

static inline int _mm_movemask_pd(__m128d a)
{
    return (int)wasm_i64x2_bitmask((v128_t)a);
}

#endif
