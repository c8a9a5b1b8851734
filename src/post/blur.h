/* Cheaper blurs, close to bloom's binomial filter, whose variance is radius / 2; not installed. */
#ifndef RK_POST_BLUR_H
#define RK_POST_BLUR_H

#include "base/image.h"
#include "base/parallel.h"
#include "features/bloom.h"

enum { RK_BLUR_GAUSSIAN_MORE = 2 };

/* Weights of a Gaussian of this variance, up to three standard deviations away, which sum to 1.
 * Returns its reach, ceil(3 sqrt(variance)); with variance = radius / 2 that is at most radius +
 * RK_BLUR_GAUSSIAN_MORE. */
uint32_t rk_blur_gaussian(double variance, float *weights);

/* Blurs an image whose width is a multiple of RK_BLOOM_BLOCK / 3, in a time that does not depend on
 * the variance: each result is a weighted sum of the pixel and the three results before it, from
 * the left and then from the right, from above and then from below. I. Young, L. van Vliet,
 * "Recursive implementation of the Gaussian filter", Signal Processing 44, 1995; for a standard
 * deviation of half a pixel or more. */
void rk_blur_recursive(rk_image *image, double variance, rk_pool *pool);

/* Blurs an image like a binomial filter of this radius: halves it as often as the radius allows,
 * blurs the coarsest level by a small Gaussian, and doubles it again. P. Burt, E. Adelson, "The
 * Laplacian pyramid as a compact image code", IEEE Transactions on Communications 31, 1983. */
bool rk_blur_pyramid(rk_image *image, uint32_t radius, rk_pool *pool, rk_error *error);

#endif
