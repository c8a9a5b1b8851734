/* All tiles of a picture, by the threads of a pool and by all processes of its team; not installed.
 */
#ifndef RK_RENDER_TILE_RUN_H
#define RK_RENDER_TILE_RUN_H

#include "base/counters.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "render/plan.h"

typedef struct rk_tile_run {
    const rk_render_options *options; /* of the picture */
    void *pixels;                     /* what a task changes: those of its tile, row by row */
    size_t pixel_size;                /* bytes */
    rk_counters *counters;            /* one per thread of the pool */
    rk_progress *progress;            /* a step for each tile of any process; may be NULL */
} rk_tile_run;

/* Runs the task for each tile once. Afterwards every process of the team has all pixels and the
 * same sums of counters, if they were the same before. False with an error if memory is short. */
bool rk_tile_run_all(const rk_tile_run *run, rk_pool *pool, rk_task *task, void *context,
                     rk_error *error);

#endif
