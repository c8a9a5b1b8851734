/* The ratio of two renderers' pictures in the regions of a scene, with the noise of both. */
#ifndef RK_DRIVER_REGION_RATIO_H
#define RK_DRIVER_REGION_RATIO_H

#include "base/image.h"
#include "base/names.h"

#include <stdint.h>

/* Two pictures of one scene by one renderer, with independent noise. */
typedef struct rk_picture_pair {
    rk_image first, second;
} rk_picture_pair;

typedef struct rk_region_ratio {
    size_t pixels;
    double ratio;          /* of the sums over the region's pixels and channels */
    double standard_error; /* of the ratio */
} rk_region_ratio;

enum { RK_REGION_ALL = 256 };

/* The ratio of the mean of the pair `ours` to the mean of the pair `theirs`, all four pictures of
 * one size, over the pixels whose region is `region`, or over all of them: RK_REGION_ALL. The
 * standard error follows from the differences within the pairs, if the noise of pixels is
 * independent: half the difference of two pictures deviates as their mean does. NaN where there are
 * no pixels, or where theirs are black. */
rk_region_ratio rk_region_ratio_of(const rk_picture_pair *ours, const rk_picture_pair *theirs,
                                   const uint8_t *regions, unsigned region);

/* Do the two renderers agree there? */
typedef enum rk_agreement {
    RK_AGREE,
    RK_DISAGREE, /* the ratio is off by more than RK_RATIO_TOLERANCE and three standard errors */
    RK_TOO_NOISY /* the standard error is above RK_RATIO_NOISE_MAX: take more samples */
} rk_agreement;

/* Renderers round in different places and approximate differently: 1e-4 and below. A wrong formula,
 * say of a cosine or of a lens's size, shifts a region by several per cent. */
#define RK_RATIO_TOLERANCE 2e-3
#define RK_RATIO_NOISE_MAX 2e-3

extern const rk_names rk_agreement_names;

rk_agreement rk_region_ratio_agreement(const rk_region_ratio *ratio);

/* The mean of the pair. */
void rk_picture_pair_mean(rk_image *mean, const rk_picture_pair *pair);

/* `scale` times the absolute difference of the means. */
void rk_picture_pair_difference(rk_image *shown, const rk_picture_pair *a, const rk_picture_pair *b,
                                float scale);

#endif
