/* The data of bloom's passes, and the two ways to blur; not installed. */
#ifndef RK_POST_BLOOM_PASSES_H
#define RK_POST_BLOOM_PASSES_H

#include "post/bloom_stage.h"

typedef struct rk_bloom_work {
    rk_image *image, *to; /* bright pixels are read from `image`, their blur is added to `to` */
    const rk_bloom_options *options;
    rk_bloom_filter filter;
    float *weights;                            /* the filter's */
    rk_bloom_span *bright;                     /* the bright span of each row */
    rk_bloom_span rows, columns;               /* from the first to the last with a bright pixel */
    rk_bloom_span target_rows, target_columns; /* that the blur changes */
    float *gains_across, *gains_down;          /* of renormalized columns and rows; NULL: 1 */
    rk_counters *counters;                     /* one for each thread */
} rk_bloom_work;

/* Blurs the bright pixels by the filter's weights, rows before columns, and adds them. */
bool rk_bloom_by_taps(rk_bloom_work *work, rk_pool *pool, rk_error *error);

/* Copies the bright pixels into a picture of their own, blurs it by a method of post/blur.h, and
 * adds it. */
bool rk_bloom_whole(rk_bloom_work *work, rk_pool *pool, rk_error *error);

#endif
