/* How many samples each pixel takes in the rounds of adaptive sampling, from the samples so far;
 * not installed.
 *
 * No sample decides on its own number, and the mean is unbiased:
 *  - Samples that decide are thrown away. A generation is one or more rounds that share their
 *    samples; each is allocated by the variances that those before estimated.
 *  - Of the first ones a pixel keeps its samples if its neighbours, without it, say that these are
 *    enough.
 *  - The last generation has two rounds. Pixels are coloured like a chessboard, and the second
 *    round gives each colour as many samples as the first round's samples of the other one ask for.
 */
#ifndef RK_RENDER_STAGES_ADAPTIVE_PLAN_H
#define RK_RENDER_STAGES_ADAPTIVE_PLAN_H

#include "base/error.h"
#include "features/adaptive_sampling.h"

/* Sums over pixels. */
typedef struct rk_adaptive_sums {
    double samples, variance, squares; /* see rk_adaptive_error */
    rk_adaptive_differences differences;
} rk_adaptive_sums;

typedef struct rk_adaptive_plan {
    uint32_t width, height;
    size_t pixels;
    rk_adaptive_sampling_options options;
    rk_pixel_samples *samples;    /* of the present generation, or kept from an earlier one */
    uint32_t *counts;             /* that the pixels have after the next round */
    bool *is_kept;                /* are the samples those of an earlier generation? */
    rk_adaptive_sums colours[2];  /* of the chessboard, after a round */
    double thrown_away;           /* samples of earlier generations */
    rk_adaptive_estimate *pilots; /* by the generations before: of the pixel by itself */
    rk_adaptive_estimate *estimates, *of_colour;
    float *variances; /* of each pixel by itself, for pooling */
} rk_adaptive_plan;

/* Plans the first round. */
bool rk_adaptive_plan_init(rk_adaptive_plan *plan, const rk_adaptive_sampling_options *options,
                           uint32_t width, uint32_t height, rk_error *error);

void rk_adaptive_plan_free(rk_adaptive_plan *plan);

/* Sums up the samples after a round. */
void rk_adaptive_plan_measure(rk_adaptive_plan *plan);

/* Of both colours. */
rk_adaptive_sums rk_adaptive_plan_sums(const rk_adaptive_plan *plan);

typedef enum rk_adaptive_generation {
    RK_ADAPTIVE_NO_GENERATION, /* all pixels keep their samples */
    RK_ADAPTIVE_EARLIER_GENERATION,
    RK_ADAPTIVE_LAST_GENERATION,
} rk_adaptive_generation;

/* Plans the first round of the next generation; throws samples away. */
rk_adaptive_generation rk_adaptive_plan_generation(rk_adaptive_plan *plan);

/* Plans the second round of the last generation. */
void rk_adaptive_plan_second_round(rk_adaptive_plan *plan);

#endif
