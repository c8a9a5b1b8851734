/* Samples from one Owen-scrambled Sobol' sequence. Its points have a dimension for each random
 * decision of a path: so the positions within the pixel, on the lens, on the light and at the
 * mirror are evenly distributed together, and not only each for itself.
 *
 *   x_d(i) = i_0 v_d0 xor i_1 v_d1 xor ...     digit j of i selects the direction number v_dj
 *
 * I. M. Sobol', "On the distribution of points in a cube and the approximate evaluation of
 * integrals", 1967; A. B. Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995; B.
 * Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020; A. Ahmed, P. Wonka,
 * "Screen-space blue-noise diffusion of Monte Carlo sampling error via hierarchical ordering of
 * pixels", ACM Transactions on Graphics 39(6), 2020. */
#ifndef RK_FEATURES_SAMPLING_H
#define RK_FEATURES_SAMPLING_H

#include "base/sampler.h"
#include "base/sobol_table.h"

#include <stdbool.h>

/* The direction numbers of a dimension below RK_SOBOL_DIMENSIONS: v[j] = m_j / 2^(j + 1), as a
 * fraction of 2^32. The first m are those of rk_sobol_initials; with the degree s and the inner
 * coefficients c of its polynomial,
 *
 *   m_j = 2 c_1 m_(j-1) xor 4 c_2 m_(j-2) xor ... xor 2^s m_(j-s) xor m_(j-s).
 *
 * All m of degree 0 are 1. */
void rk_sobol_directions(uint32_t dimension, uint32_t v[RK_SOBOL_DIGITS]);

/* The coordinate of point `index`, a fraction of 2^32: the numbers selected by the index's digits,
 * combined by xor. */
uint32_t rk_sobol_bits(const uint32_t v[RK_SOBOL_DIGITS], uint32_t index);

/* Owen scrambling by its definition. Each binary digit is flipped, or not: a fair coin that depends
 * on the key and on the digits before it, as they were. The coin is a bit of a hash, of rk_hash one
 * of the upper 16. */
uint32_t rk_owen_scramble(uint32_t bits, uint32_t key);

/* The sequence's dimension for one of the renderer's (base/sampler.h), the first of two where these
 * are a pair: RK_DIMENSION_PIXEL 0, RK_DIMENSION_LENS 2, RK_DIMENSION_TIME 4; RK_DIMENSION_LIGHT,
 * of the first light, 5, and RK_DIMENSION_GLOSSY, of the first mirror, 7. -1 for all others. */
int rk_joint_dimension(uint32_t dimension);

enum { RK_MORTON_DIGITS = 6 };

/* The place of pixel (x, y), both below 2^16, in Z order (G. M. Morton, 1966): the binary digits of
 * x are those at even places, counted from the lowest, which is place 0, those of y at odd ones. So
 * each square of 2^k x 2^k pixels, at multiples of 2^k, has 4^k consecutive indices. */
uint32_t rk_morton_index(uint32_t x, uint32_t y);

/* The index, below 4^RK_MORTON_DIGITS, with its digits in base 4 permuted: each by one of the 24
 * permutations (rk_permutation_of_4), chosen by a hash of the key and the digits before it, as they
 * were. Squares still have consecutive indices, but in random orders (A. Ahmed, P. Wonka, 2020). */
uint32_t rk_permute_digits(uint32_t index, uint32_t key);

/* Numbers of all kinds. RK_SAMPLER_SOBOL: for joint dimensions, sample i of each pixel is point i,
 * scrambled by a key of its own for each seed, pixel and dimension. Numbers of all other dimensions
 * and kinds are those of rk_sample_1d, rk_sample_2d and rk_sample_2d_run.
 *
 * RK_SAMPLER_ZSOBOL: pixels share a sequence, and a key for each seed and dimension: of the pixel
 * at place z in Z order, sample i of N is point z N + i. A square of 2^RK_MORTON_DIGITS pixels on a
 * side has a sequence of its own; z is the permuted Morton index within it. Points are counted in
 * 32 bits: with more than 2^20 samples, pixels whose z N are equal in these share points.
 * Dimensions that are not joint take the first two of the same points, in an order and with a key
 * of their own for each. */
float rk_joint_1d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension);
rk_vec2 rk_joint_2d(const rk_sampler *sampler, uint32_t pixel, uint32_t sample, uint32_t dimension);
void rk_joint_2d_run(const rk_sampler *sampler, uint32_t pixel, uint32_t first, uint32_t count,
                     uint32_t dimension, rk_vec2 *pairs);

#endif
