/* Paths that wait to be traced, a batch per level of bounces. A level's reflections go to the next
 * deeper one, which is traced first: so there are never more batches than bounces; not installed.
 */
#ifndef RK_RENDER_PATH_QUEUE_H
#define RK_RENDER_PATH_QUEUE_H

#include "base/error.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/shade_stage.h"

/* One level. */
typedef struct rk_path_level {
    rk_path_batch paths;
    rk_shading_cursor cursor;    /* the part that is shaded */
    rk_specular_queue *specular; /* points without reflected rays yet; NULL without
                                    plan.glossy_reflection */
} rk_path_level;

typedef struct rk_path_queue {
    uint32_t depth, limit; /* levels in use, the last one the deepest; levels allocated */
    rk_path_level *levels;
    rk_specular_queue *specular;
} rk_path_queue;

/* Allocates a level for each bounce of the plan. */
bool rk_path_queue_init(rk_path_queue *queue, const rk_rendering *r, rk_error *error);
void rk_path_queue_free(rk_path_queue *queue);

/* Returns a new deepest level; the caller fills its batch. */
rk_path_level *rk_path_queue_push(rk_path_queue *queue);

#endif
