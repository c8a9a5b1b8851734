/* Bloom stage: bloom over a whole picture, with threads, and work in proportion to its bright
 * pixels. */
#ifndef RK_POST_BLOOM_STAGE_H
#define RK_POST_BLOOM_STAGE_H

#include "base/counters.h"
#include "base/image.h"
#include "base/parallel.h"
#include "features/bloom.h"
#include "render/feature.h"

/* The defaults of its options: off. */
rk_bloom_options rk_bloom_options_default(void);

/* Would bloom change a picture that is not black? */
bool rk_bloom_wanted(const rk_bloom_options *options);

/* Are the numbers in their ranges, and border and method valid enumerators? */
bool rk_bloom_check(const rk_bloom_options *options, rk_error *error);

/* Adds bloom to `image`; the result is the same to the bit for any number of threads. The work done
 * is added to `counters`: without a bright pixel each pixel is read once, and the picture stays as
 * it is. Allocates memory for the part of the picture that changes. Fails on options that
 * rk_bloom_check refuses; an error leaves the picture unchanged. */
bool rk_bloom_stage(rk_image *image, const rk_bloom_options *options, rk_pool *pool,
                    rk_counters *counters, rk_error *error);

extern const rk_names rk_bloom_border_names, rk_bloom_method_names;

#endif
