/* Shade stage: from hits to shading points; not installed. */
#ifndef RK_RENDER_STAGES_SHADE_STAGE_H
#define RK_RENDER_STAGES_SHADE_STAGE_H

#include "accel/query/ray_times.h"
#include "render/film.h"
#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"
#include "render/stages/transparency_stage.h"

/* One shading point per hit of the batch. */
void rk_shade_stage(const rk_rendering *r, const rk_path_batch *paths, const rk_hit_batch *hits,
                    const rk_ray_times *times, rk_shading_points *points);

/* Position in a batch that is shaded in several rounds, because of transparent surfaces. */
typedef struct rk_shading_cursor {
    uint32_t path;           /* next path to be traced */
    uint32_t hit;            /* next of the visible hits to be shaded */
    rk_visible_hits visible; /* of path - 1 */
} rk_shading_cursor;

/* The next shading points of the batch, up to RK_BATCH_MAX: a path may have one on each of several
 * transparent surfaces. Traces each path when its first point is due, and adds the environment
 * behind all surfaces to the film. */
void rk_shade_transparent_stage(const rk_rendering *r, rk_sample_pass *pass,
                                const rk_path_batch *paths, rk_shading_cursor *cursor,
                                rk_shading_points *points, rk_film *film);

/* The shading point of a hit of path i at `time`, which is read only with plan.motion_blur. */
void rk_shading_point_at(rk_shading_point *point, const rk_rendering *r, const rk_path_batch *paths,
                         uint32_t i, const rk_hit *hit, float time);
/* The same for visible hit k, with its part of the throughput. */
void rk_shading_point_behind(rk_shading_point *point, const rk_rendering *r,
                             const rk_path_batch *paths, uint32_t i, const rk_visible_hits *visible,
                             uint32_t k);

#endif
