/* A stack of batches, one for each level of bounces, allocated once. */
#include "render/path_queue.h"

#include <stdlib.h>

bool rk_path_queue_init(rk_path_queue *queue, const rk_rendering *r, rk_error *error)
{
    uint32_t levels = r->plan.reflections ? r->options->max_depth + 1 : 1;
    *queue = (rk_path_queue){.limit = levels};
    queue->levels = rk_allocate_unset(levels, sizeof *queue->levels, "paths", error);
    if (r->plan.glossy_reflection)
        queue->specular = rk_allocate_unset(levels, sizeof *queue->specular, "paths", error);
    if (!queue->levels || (r->plan.glossy_reflection && !queue->specular)) {
        rk_path_queue_free(queue);
        return false;
    }
    for (uint32_t i = 0; i < levels; i++)
        queue->levels[i].specular = r->plan.glossy_reflection ? &queue->specular[i] : NULL;
    return true;
}

void rk_path_queue_free(rk_path_queue *queue)
{
    free(queue->levels);
    free(queue->specular);
    *queue = (rk_path_queue){0};
}

rk_path_level *rk_path_queue_push(rk_path_queue *queue)
{
    rk_path_level *level = &queue->levels[queue->depth++];
    level->paths.rays.count = 0;
    level->cursor.path = level->cursor.hit = level->cursor.visible.count = 0;
    if (level->specular)
        level->specular->next = level->specular->waiting.count = 0;
    return level;
}
