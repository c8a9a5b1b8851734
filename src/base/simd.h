/* Vectors of 8 and 16 floats and of 4 and 8 doubles, made of the widest registers that the file is
 * compiled for: AVX-512, AVX2, SSE2, or plain numbers (RK_SIMD_SCALAR, or any other machine). Each
 * lane is rounded like a single number, so results are the same to the bit. Comparisons return a
 * bit for each lane; not installed. */
#ifndef RK_BASE_SIMD_H
#define RK_BASE_SIMD_H

#include "base/sanitized.h"
#include "base/simd4.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Inlined even into large functions: a call would spill the registers. Plain numbers have none to
 * spill, and there are sixteen times as many of them to compile. With sanitizers compilers would
 * take minutes: there each function stays by itself. */
#ifdef RK_SANITIZED
#define RK_INLINE __attribute__((noinline, unused)) static
#elif defined RK_SIMD_SCALAR || !defined __SSE2__
#define RK_INLINE static inline
#else
#define RK_INLINE __attribute__((always_inline)) static inline
#endif

#ifdef RK_SANITIZED
#define RK_SIMD_UNROLL
#else
#define RK_SIMD_UNROLL _Pragma("GCC unroll 16")
#endif

/* A vector of `lanes` numbers, `name`, made of `parts` registers, with its functions. */
#define RK_SIMD_TYPE(name, number, lanes, native)                                                  \
    typedef struct name {                                                                          \
        native##_register part[(lanes) / native##_lanes];                                          \
    } name;                                                                                        \
    RK_SIMD_EACH(name, name##_all, (number x), native##_all(x))                                    \
    RK_SIMD_EACH(name, name##_load, (const number *x), native##_load(&x[i * native##_lanes]))      \
    RK_SIMD_EACH(name, name##_add, (name a, name b), a.part[i] + b.part[i])                        \
    RK_SIMD_EACH(name, name##_sub, (name a, name b), a.part[i] - b.part[i])                        \
    RK_SIMD_EACH(name, name##_mul, (name a, name b), a.part[i] * b.part[i])                        \
    RK_SIMD_EACH(name, name##_div, (name a, name b), a.part[i] / b.part[i])                        \
    RK_SIMD_EACH(name, name##_min, (name a, name b), native##_min(a.part[i], b.part[i]))           \
    RK_SIMD_EACH(name, name##_max, (name a, name b), native##_max(a.part[i], b.part[i]))           \
    RK_SIMD_EACH(name, name##_abs, (name a), native##_abs(a.part[i]))                              \
    RK_SIMD_BITS(name, name##_le, native##_le, native##_lanes)                                     \
    RK_SIMD_BITS(name, name##_lt, native##_lt, native##_lanes)                                     \
    RK_INLINE void name##_store(number *to, name a)                                                \
    {                                                                                              \
        for (int i = 0; i < (int)(sizeof a.part / sizeof *a.part); i++)                            \
            memcpy(&to[i * native##_lanes], &a.part[i], sizeof a.part[i]);                         \
    }

#define RK_SIMD_EACH(name, function, arguments, value)                                             \
    RK_INLINE name function arguments                                                              \
    {                                                                                              \
        name result;                                                                               \
        RK_SIMD_UNROLL for (int i = 0; i < (int)(sizeof result.part / sizeof *result.part); i++)   \
            result.part[i] = value;                                                                \
        return result;                                                                             \
    }

#define RK_SIMD_BITS(name, function, compare, lanes)                                               \
    RK_INLINE uint32_t function(name a, name b)                                                    \
    {                                                                                              \
        uint32_t bits = 0;                                                                         \
        RK_SIMD_UNROLL for (int i = 0; i < (int)(sizeof a.part / sizeof *a.part); i++) bits |=     \
            compare(a.part[i], b.part[i]) << (i * lanes);                                          \
        return bits;                                                                               \
    }

/* --- Registers -------------------------------------------------------------------------------- */

#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
#include <immintrin.h>
#define RK_SIMD_ISA "avx512"
#define RK_SIMD_SIXTEEN /* floats in a register */

enum { rk_n16_lanes = 16 };
typedef __m512 rk_n16_register;

RK_INLINE __m512 rk_n16_all(float x)
{
    return _mm512_set1_ps(x);
}

RK_INLINE __m512 rk_n16_load(const float *x)
{
    return _mm512_loadu_ps(x);
}

RK_INLINE __m512 rk_n16_min(__m512 a, __m512 b)
{
    return _mm512_min_ps(a, b);
}

RK_INLINE __m512 rk_n16_max(__m512 a, __m512 b)
{
    return _mm512_max_ps(a, b);
}

RK_INLINE __m512 rk_n16_abs(__m512 a)
{
    return _mm512_abs_ps(a);
}

RK_INLINE uint32_t rk_n16_le(__m512 a, __m512 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}

RK_INLINE uint32_t rk_n16_lt(__m512 a, __m512 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}

enum { rk_n8_lanes = 8 };
typedef __m256 rk_n8_register;

RK_INLINE __m256 rk_n8_all(float x)
{
    return _mm256_set1_ps(x);
}

RK_INLINE __m256 rk_n8_load(const float *x)
{
    return _mm256_loadu_ps(x);
}

RK_INLINE __m256 rk_n8_min(__m256 a, __m256 b)
{
    return _mm256_min_ps(a, b);
}

RK_INLINE __m256 rk_n8_max(__m256 a, __m256 b)
{
    return _mm256_max_ps(a, b);
}

RK_INLINE __m256 rk_n8_abs(__m256 a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}

RK_INLINE uint32_t rk_n8_le(__m256 a, __m256 b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_LE_OQ);
}

RK_INLINE uint32_t rk_n8_lt(__m256 a, __m256 b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_LT_OQ);
}

enum { rk_nd8_lanes = 8 };
typedef __m512d rk_nd8_register;

RK_INLINE __m512d rk_nd8_all(double x)
{
    return _mm512_set1_pd(x);
}

RK_INLINE __m512d rk_nd8_load(const double *x)
{
    return _mm512_loadu_pd(x);
}

RK_INLINE __m512d rk_nd8_min(__m512d a, __m512d b)
{
    return _mm512_min_pd(a, b);
}

RK_INLINE __m512d rk_nd8_max(__m512d a, __m512d b)
{
    return _mm512_max_pd(a, b);
}

RK_INLINE __m512d rk_nd8_abs(__m512d a)
{
    return _mm512_abs_pd(a);
}

RK_INLINE uint32_t rk_nd8_le(__m512d a, __m512d b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ);
}

RK_INLINE uint32_t rk_nd8_lt(__m512d a, __m512d b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
}

enum { rk_nd4_lanes = 4 };
typedef __m256d rk_nd4_register;

RK_INLINE __m256d rk_nd4_all(double x)
{
    return _mm256_set1_pd(x);
}

RK_INLINE __m256d rk_nd4_load(const double *x)
{
    return _mm256_loadu_pd(x);
}

RK_INLINE __m256d rk_nd4_min(__m256d a, __m256d b)
{
    return _mm256_min_pd(a, b);
}

RK_INLINE __m256d rk_nd4_max(__m256d a, __m256d b)
{
    return _mm256_max_pd(a, b);
}

RK_INLINE __m256d rk_nd4_abs(__m256d a)
{
    return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a);
}

RK_INLINE uint32_t rk_nd4_le(__m256d a, __m256d b)
{
    return _mm256_cmp_pd_mask(a, b, _CMP_LE_OQ);
}

RK_INLINE uint32_t rk_nd4_lt(__m256d a, __m256d b)
{
    return _mm256_cmp_pd_mask(a, b, _CMP_LT_OQ);
}

RK_SIMD_TYPE(rk_f8, float, 8, rk_n8)
RK_SIMD_TYPE(rk_f16, float, 16, rk_n16)
RK_SIMD_TYPE(rk_d4, double, 4, rk_nd4)
RK_SIMD_TYPE(rk_d8, double, 8, rk_nd8)

#elif defined __AVX2__ && !defined RK_SIMD_SCALAR
#include <immintrin.h>
#define RK_SIMD_ISA "avx2"

enum { rk_n_lanes = 8 };
typedef __m256 rk_n_register;

RK_INLINE __m256 rk_n_all(float x)
{
    return _mm256_set1_ps(x);
}

RK_INLINE __m256 rk_n_load(const float *x)
{
    return _mm256_loadu_ps(x);
}

RK_INLINE __m256 rk_n_min(__m256 a, __m256 b)
{
    return _mm256_min_ps(a, b);
}

RK_INLINE __m256 rk_n_max(__m256 a, __m256 b)
{
    return _mm256_max_ps(a, b);
}

RK_INLINE __m256 rk_n_abs(__m256 a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}

RK_INLINE uint32_t rk_n_le(__m256 a, __m256 b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LE_OQ));
}

RK_INLINE uint32_t rk_n_lt(__m256 a, __m256 b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

enum { rk_nd_lanes = 4 };
typedef __m256d rk_nd_register;

RK_INLINE __m256d rk_nd_all(double x)
{
    return _mm256_set1_pd(x);
}

RK_INLINE __m256d rk_nd_load(const double *x)
{
    return _mm256_loadu_pd(x);
}

RK_INLINE __m256d rk_nd_min(__m256d a, __m256d b)
{
    return _mm256_min_pd(a, b);
}

RK_INLINE __m256d rk_nd_max(__m256d a, __m256d b)
{
    return _mm256_max_pd(a, b);
}

RK_INLINE __m256d rk_nd_abs(__m256d a)
{
    return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a);
}

RK_INLINE uint32_t rk_nd_le(__m256d a, __m256d b)
{
    return (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LE_OQ));
}

RK_INLINE uint32_t rk_nd_lt(__m256d a, __m256d b)
{
    return (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ));
}

RK_SIMD_TYPE(rk_f8, float, 8, rk_n)
RK_SIMD_TYPE(rk_f16, float, 16, rk_n)
RK_SIMD_TYPE(rk_d4, double, 4, rk_nd)
RK_SIMD_TYPE(rk_d8, double, 8, rk_nd)

#elif defined __SSE2__ && !defined RK_SIMD_SCALAR
#include <emmintrin.h>
#define RK_SIMD_ISA "sse2"

enum { rk_n_lanes = 4 };
typedef __m128 rk_n_register;

RK_INLINE __m128 rk_n_all(float x)
{
    return _mm_set1_ps(x);
}

RK_INLINE __m128 rk_n_load(const float *x)
{
    return _mm_loadu_ps(x);
}

RK_INLINE __m128 rk_n_min(__m128 a, __m128 b)
{
    return _mm_min_ps(a, b);
}

RK_INLINE __m128 rk_n_max(__m128 a, __m128 b)
{
    return _mm_max_ps(a, b);
}

RK_INLINE __m128 rk_n_abs(__m128 a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}

RK_INLINE uint32_t rk_n_le(__m128 a, __m128 b)
{
    return (uint32_t)_mm_movemask_ps(_mm_cmple_ps(a, b));
}

RK_INLINE uint32_t rk_n_lt(__m128 a, __m128 b)
{
    return (uint32_t)_mm_movemask_ps(_mm_cmplt_ps(a, b));
}

enum { rk_nd_lanes = 2 };
typedef __m128d rk_nd_register;

RK_INLINE __m128d rk_nd_all(double x)
{
    return _mm_set1_pd(x);
}

RK_INLINE __m128d rk_nd_load(const double *x)
{
    return _mm_loadu_pd(x);
}

RK_INLINE __m128d rk_nd_min(__m128d a, __m128d b)
{
    return _mm_min_pd(a, b);
}

RK_INLINE __m128d rk_nd_max(__m128d a, __m128d b)
{
    return _mm_max_pd(a, b);
}

RK_INLINE __m128d rk_nd_abs(__m128d a)
{
    return _mm_andnot_pd(_mm_set1_pd(-0.0), a);
}

RK_INLINE uint32_t rk_nd_le(__m128d a, __m128d b)
{
    return (uint32_t)_mm_movemask_pd(_mm_cmple_pd(a, b));
}

RK_INLINE uint32_t rk_nd_lt(__m128d a, __m128d b)
{
    return (uint32_t)_mm_movemask_pd(_mm_cmplt_pd(a, b));
}

RK_SIMD_TYPE(rk_f8, float, 8, rk_n)
RK_SIMD_TYPE(rk_f16, float, 16, rk_n)
RK_SIMD_TYPE(rk_d4, double, 4, rk_nd)
RK_SIMD_TYPE(rk_d8, double, 8, rk_nd)

#else
#define RK_SIMD_ISA "scalar"

enum { rk_n_lanes = 1 };
typedef float rk_n_register;

RK_INLINE float rk_n_all(float x)
{
    return x;
}

RK_INLINE float rk_n_load(const float *x)
{
    return *x;
}

RK_INLINE float rk_n_min(float a, float b)
{
    return a < b ? a : b;
}

RK_INLINE float rk_n_max(float a, float b)
{
    return a > b ? a : b;
}

RK_INLINE float rk_n_abs(float a)
{
    return fabsf(a);
}

RK_INLINE uint32_t rk_n_le(float a, float b)
{
    return a <= b;
}

RK_INLINE uint32_t rk_n_lt(float a, float b)
{
    return a < b;
}

enum { rk_nd_lanes = 1 };
typedef double rk_nd_register;

RK_INLINE double rk_nd_all(double x)
{
    return x;
}

RK_INLINE double rk_nd_load(const double *x)
{
    return *x;
}

RK_INLINE double rk_nd_min(double a, double b)
{
    return a < b ? a : b;
}

RK_INLINE double rk_nd_max(double a, double b)
{
    return a > b ? a : b;
}

RK_INLINE double rk_nd_abs(double a)
{
    return fabs(a);
}

RK_INLINE uint32_t rk_nd_le(double a, double b)
{
    return a <= b;
}

RK_INLINE uint32_t rk_nd_lt(double a, double b)
{
    return a < b;
}

RK_SIMD_TYPE(rk_f8, float, 8, rk_n)
RK_SIMD_TYPE(rk_f16, float, 16, rk_n)
RK_SIMD_TYPE(rk_d4, double, 4, rk_nd)
RK_SIMD_TYPE(rk_d8, double, 8, rk_nd)

#endif

/* --- Between types ---------------------------------------------------------------------------- */

/* Four and eight floats as doubles. */
RK_INLINE rk_d4 rk_d4_widen(const float *x)
{
#if defined __AVX2__ && !defined RK_SIMD_SCALAR
    return (rk_d4){{_mm256_cvtps_pd(_mm_loadu_ps(x))}};
#else
    double wide[4];
    for (int i = 0; i < 4; i++)
        wide[i] = (double)x[i];
    return rk_d4_load(wide);
#endif
}

RK_INLINE rk_d8 rk_d8_widen(const float *x)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    return (rk_d8){{_mm512_cvtps_pd(_mm256_loadu_ps(x))}};
#elif defined __AVX2__ && !defined RK_SIMD_SCALAR
    return (rk_d8){{_mm256_cvtps_pd(_mm_loadu_ps(x)), _mm256_cvtps_pd(_mm_loadu_ps(&x[4]))}};
#else
    double wide[8];
    for (int i = 0; i < 8; i++)
        wide[i] = (double)x[i];
    return rk_d8_load(wide);
#endif
}

/* Rounds eight doubles to floats, and stores those whose bit is set. */
RK_INLINE void rk_d8_narrow(float *to, rk_d8 a, uint32_t bits)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    _mm256_mask_storeu_ps(to, (__mmask8)bits, _mm512_cvtpd_ps(a.part[0]));
#else
    double wide[8];
    rk_d8_store(wide, a);
    for (int i = 0; i < 8; i++)
        to[i] = bits >> i & 1 ? (float)wide[i] : to[i];
#endif
}

/* a where the bit is set, else b. */
RK_INLINE rk_f16 rk_f16_select(uint32_t bits, rk_f16 a, rk_f16 b)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    return (rk_f16){{_mm512_mask_blend_ps((__mmask16)bits, b.part[0], a.part[0])}};
#elif defined __AVX2__ && !defined RK_SIMD_SCALAR
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    for (int i = 0; i < 2; i++) {
        const __m256i mine = _mm256_and_si256(_mm256_set1_epi32((int)(bits >> 8 * i)), bit);
        const __m256 mask = _mm256_castsi256_ps(_mm256_cmpeq_epi32(mine, bit));
        a.part[i] = _mm256_blendv_ps(b.part[i], a.part[i], mask);
    }
    return a;
#elif defined __SSE2__ && !defined RK_SIMD_SCALAR
    const rk_simd4_mask bit = {1, 2, 4, 8};
    for (int i = 0; i < 4; i++)
        a.part[i] = rk_simd4_select(((int32_t)(bits >> 4 * i) & bit) != 0, a.part[i], b.part[i]);
    return a;
#else
    for (int i = 0; i < 16; i++)
        a.part[i] = bits >> i & 1 ? a.part[i] : b.part[i];
    return a;
#endif
}

/* a b + c, rounded once or twice: for bounds, which leave room for either. */
RK_INLINE rk_f8 rk_f8_madd(rk_f8 a, rk_f8 b, rk_f8 c)
{
#if defined __AVX2__ && defined __FMA__ && !defined RK_SIMD_SCALAR
    return (rk_f8){{_mm256_fmadd_ps(a.part[0], b.part[0], c.part[0])}};
#else
    return rk_f8_add(rk_f8_mul(a, b), c);
#endif
}

RK_INLINE rk_f16 rk_f16_madd(rk_f16 a, rk_f16 b, rk_f16 c)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    return (rk_f16){{_mm512_fmadd_ps(a.part[0], b.part[0], c.part[0])}};
#elif defined __AVX2__ && defined __FMA__ && !defined RK_SIMD_SCALAR
    return (rk_f16){{_mm256_fmadd_ps(a.part[0], b.part[0], c.part[0]),
                     _mm256_fmadd_ps(a.part[1], b.part[1], c.part[1])}};
#else
    return rk_f16_add(rk_f16_mul(a, b), c);
#endif
}

RK_INLINE float rk_f16_lane(rk_f16 a, int lane)
{
    float lanes[16];
    rk_f16_store(lanes, a);
    return lanes[lane];
}

/* The same of four, and a b - c. */
RK_INLINE rk_simd4 rk_simd4_madd(rk_simd4 a, rk_simd4 b, rk_simd4 c)
{
#if defined __AVX2__ && defined __FMA__ && !defined RK_SIMD_SCALAR
    return _mm_fmadd_ps(a, b, c);
#else
    return a * b + c;
#endif
}

RK_INLINE rk_simd4 rk_simd4_msub(rk_simd4 a, rk_simd4 b, rk_simd4 c)
{
#if defined __AVX2__ && defined __FMA__ && !defined RK_SIMD_SCALAR
    return _mm_fmsub_ps(a, b, c);
#else
    return a * b - c;
#endif
}

/* Stores the lanes whose bit is set. */
RK_INLINE void rk_f16_put(float *to, rk_f16 a, uint32_t bits)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    _mm512_mask_storeu_ps(to, (__mmask16)bits, a.part[0]);
#else
    rk_f16_store(to, rk_f16_select(bits, a, rk_f16_load(to)));
#endif
}

/* Stores x sixteen times, where the bit is set. */
RK_INLINE void rk_put_words(uint32_t *to, uint32_t x, uint32_t bits)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    _mm512_mask_storeu_epi32(to, (__mmask16)bits, _mm512_set1_epi32((int)x));
#else
    for (int i = 0; i < 16; i++)
        to[i] = bits >> i & 1 ? x : to[i];
#endif
}

/* Copies the words whose bit is set. */
RK_INLINE void rk_put_each(uint32_t *to, const uint32_t *from, uint32_t bits)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    _mm512_mask_storeu_epi32(to, (__mmask16)bits, _mm512_loadu_si512(from));
#else
    for (int i = 0; i < 16; i++)
        to[i] = bits >> i & 1 ? from[i] : to[i];
#endif
}

/* The largest lane; no NaN. */
RK_INLINE float rk_f16_largest(rk_f16 a)
{
#if defined __AVX512VL__ && !defined RK_SIMD_SCALAR
    return _mm512_reduce_max_ps(a.part[0]);
#else
    float lane[16];
    rk_f16_store(lane, a);
    const rk_simd4 low = rk_simd4_max(rk_simd4_load(&lane[0]), rk_simd4_load(&lane[4]));
    return rk_simd4_largest(
        rk_simd4_max(low, rk_simd4_max(rk_simd4_load(&lane[8]), rk_simd4_load(&lane[12]))));
#endif
}

#endif
