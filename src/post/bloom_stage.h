/* Bloom over a whole picture: memory, threads, and as little work as the light allows. */
#ifndef RK_POST_BLOOM_STAGE_H
#define RK_POST_BLOOM_STAGE_H

#include "base/counters.h"
#include "base/image.h"
#include "base/parallel.h"
#include "features/bloom.h"

/* Radius 15, threshold .5, intensity .8, a border of zeros, the filter itself; not on. */
rk_bloom_options rk_bloom_options_default(void);

/* Would it change a picture that has light? */
bool rk_bloom_wanted(const rk_bloom_options *options);

/* Are the numbers in their ranges, and border and method among those that there are? */
bool rk_bloom_check(const rk_bloom_options *options, rk_error *error);

/* Lets what is bright in `image` glow. The picture is the same to the bit for any number of
 * threads. What is done is added to `counters`; where nothing glows, that is one look at each
 * pixel, and the picture is untouched. Takes memory for the part of the picture that changes. What
 * rk_bloom_check refuses is an error; an error leaves the picture as it was. */
bool rk_bloom_stage(rk_image *image, const rk_bloom_options *options, rk_pool *pool,
                    rk_counters *counters, rk_error *error);

#endif
