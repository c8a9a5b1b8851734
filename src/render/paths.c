/* Each round takes the deepest level of the queue. If specular points wait there, it spawns a batch
 * of their reflections. Else it traces and shades the level's paths, adds their light, and spawns
 * reflections or lets them wait. A level with nothing left is removed. Deepest first keeps the
 * queue small, and fixes the order in which radiance is added, to the bit. */
#include "render/paths.h"

#include "render/feature_hooks.h"
#include "render/stages/cubemap_stage.h"
#include "render/stages/reflection_stage.h"
#include "render/stages/trace_stage.h"

static void trace_and_shade(const rk_rendering *r, rk_sample_pass *pass, rk_path_level *level,
                            rk_path_workspace *w, rk_film *film)
{
    if (r->plan.transparency) {
        rk_shade_transparent_stage(r, pass, &level->paths, &level->cursor, &w->points, film);
        return;
    }
    rk_trace_closest(r, pass, &level->paths, &w->hits, &w->times);
    if (r->plan.background)
        rk_cubemap_stage(r, &level->paths, &w->hits, film, pass->counters);
    rk_shade_stage(r, &level->paths, &w->hits, &w->times, &w->points);
    level->cursor.path = level->paths.rays.count;
}

static bool is_shaded(const rk_path_level *level)
{
    return level->cursor.path == level->paths.rays.count &&
           level->cursor.hit == level->cursor.visible.count;
}

/* Perfect mirrors spawn at most one ray per point, which fits a batch; rough ones need several
 * batches, so their points wait. */
static void spawn(const rk_rendering *r, const rk_sample_pass *pass, rk_path_level *level,
                  const rk_shading_points *points, rk_path_queue *queue)
{
    if (r->plan.glossy_reflection)
        rk_specular_queue_fill(level->specular, points);
    else if (r->plan.reflections && queue->depth < queue->limit)
        rk_reflection_stage(pass, points, &rk_path_queue_push(queue)->paths);
}

static bool has_specular(const rk_path_level *level)
{
    return level->specular && level->specular->next < level->specular->waiting.count;
}

void rk_trace_paths(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *w,
                    rk_film *film)
{
    rk_path_queue *queue = &w->queue;
    while (queue->depth > 0) {
        rk_path_level *level = &queue->levels[queue->depth - 1];
        pass->bounce = queue->depth - 1;
        if (has_specular(level)) {
            rk_glossy_reflection_stage(r, pass, level->specular, &rk_path_queue_push(queue)->paths);
        } else if (!is_shaded(level)) {
            trace_and_shade(r, pass, level, w, film);
            rk_features_shade(r, pass, &w->points, film);
            rk_light_stage(r, pass, &w->points, &w->lights, film);
            spawn(r, pass, level, &w->points, queue);
        } else {
            queue->depth--;
        }
    }
}
