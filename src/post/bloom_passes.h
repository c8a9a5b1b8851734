/* What the passes of a bloom hand to each other, and the two ways to filter; not installed. */
#ifndef RK_POST_BLOOM_PASSES_H
#define RK_POST_BLOOM_PASSES_H

#include "post/bloom_stage.h"

typedef struct rk_bloom_work {
    rk_image *image, *to; /* the light is taken from the one and added to the other */
    const rk_bloom_options *options;
    rk_bloom_filter filter;
    float *weights;                            /* the filter's */
    rk_bloom_span *lit;                        /* of each row */
    rk_bloom_span rows, columns;               /* that glow, from the first to the last */
    rk_bloom_span target_rows, target_columns; /* that their light reaches */
    float *gains_across, *gains_down;          /* of columns and rows; NULL: 1 */
    rk_counters *counters;                     /* one for each thread */
} rk_bloom_work;

/* Filters the light by the filter's weights, and adds it. */
bool rk_bloom_by_taps(rk_bloom_work *g, rk_pool *pool, rk_error *error);

/* Masks into a picture of its own, blurs that by one of the methods of post/blur.h, and adds it.
 */
bool rk_bloom_whole(rk_bloom_work *g, rk_pool *pool, rk_error *error);

#endif
