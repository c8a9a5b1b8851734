/* Direction numbers of Sobol' sequences: the numbers that the sequence of a dimension begins with,
 * and what follows from them (features/sampling.h). */
#ifndef RK_BASE_SOBOL_TABLE_H
#define RK_BASE_SOBOL_TABLE_H

#include <stdint.h>

enum { RK_SOBOL_DIMENSIONS = 9, RK_SOBOL_DIGITS = 32, RK_SOBOL_DEGREE_MAX = 5 };

/* A primitive polynomial modulo 2, x^degree + c_1 x^(degree - 1) + ... + c_(degree - 1) x + 1,
 * whose inner coefficients are the bits of `inner`, c_1 the highest; and the first `degree` numbers
 * m: m[k] is odd and below 2^(k + 1). Degree 0: van der Corput's sequence, all m are 1. */
typedef struct rk_sobol_initial {
    uint32_t degree, inner, m[RK_SOBOL_DEGREE_MAX];
} rk_sobol_initial;

/* The polynomials are among the first of S. Joe, F. Kuo, "Constructing Sobol sequences with better
 * two-dimensional projections", SIAM Journal on Scientific Computing 30(5), 2008; so are the
 * numbers of dimensions 0, 1, 3 and 4. The others were searched, as Joe and Kuo did for all pairs,
 * but for those dimensions that pictures need together: pixel and lens, lens and light, light alone
 * and so on (rk_joint_dimension), with up to 256 points. */
extern const rk_sobol_initial rk_sobol_initials[RK_SOBOL_DIMENSIONS];

/* rk_sobol_directions of each dimension, with the bits reversed: bit r, counted from the lowest, is
 * the number's digit r behind the binary point, as base/scramble.h wants it. */
extern const uint32_t rk_sobol_columns[RK_SOBOL_DIMENSIONS][RK_SOBOL_DIGITS];

#endif
