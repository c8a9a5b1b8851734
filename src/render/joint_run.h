/* Runs of a pixel's joint numbers, many at a time; not installed. */
#ifndef RK_RENDER_JOINT_RUN_H
#define RK_RENDER_JOINT_RUN_H

#include "features/sampling.h"

enum { RK_JOINT_RUN_MAX = 64 };

typedef struct rk_joint_runs {
    bool agree; /* to the bit with the feature's, by many examples; not with a student's functions
                   that are still wrong, whose pictures show them */
    /* Of each dimension: the xor of its first columns, 1 and more; see rk_joint_run. */
    uint32_t change[RK_SOBOL_DIMENSIONS][RK_SOBOL_DIGITS];
} rk_joint_runs;

rk_joint_runs rk_joint_runs_of(void);

/* Fills in the same pairs as rk_joint_2d_run, to the bit. `count`: at most
 * RK_JOINT_RUN_MAX. */
void rk_joint_run(const rk_joint_runs *runs, const rk_sampler *sampler, uint32_t pixel,
                  uint32_t first, uint32_t count, uint32_t dimension, rk_vec2 *pairs);

/* The key that scrambles the numbers of a pixel in a dimension of the sequence, as
 * features/sampling.c. */
static inline uint32_t rk_joint_key(uint32_t seed, uint32_t pixel, uint32_t joint)
{
    return rk_hash(seed, pixel, 0u - 4, joint);
}

#endif
