/* Paths that wait to be traced, by bounces: what one level spawns waits on the level above it,
 * which is taken first. So there are never more batches than bounces. */
#ifndef RK_RENDER_PATH_QUEUE_H
#define RK_RENDER_PATH_QUEUE_H

#include "base/error.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/shade_stage.h"

/* One level. */
typedef struct rk_path_level {
    rk_path_batch paths;
    rk_shading_cursor cursor; /* those up to here are shaded */
    rk_specular_queue
        *specular; /* with plan.glossy_reflection: points whose rays are still to be spawned */
} rk_path_level;

typedef struct rk_path_queue {
    uint32_t depth, limit; /* levels in use, of which the last is the deepest; and of all */
    rk_path_level *levels;
    rk_specular_queue *specular;
} rk_path_queue;

/* Room for all bounces that the plan has. */
bool rk_path_queue_init(rk_path_queue *queue, const rk_rendering *r, rk_error *error);
void rk_path_queue_free(rk_path_queue *queue);

/* Returns the new deepest level, whose batch is the caller's to fill. */
rk_path_level *rk_path_queue_push(rk_path_queue *queue);

#endif
