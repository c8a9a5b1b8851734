/* Shade stage: hits become shading points. */
#ifndef RK_RENDER_STAGES_SHADE_STAGE_H
#define RK_RENDER_STAGES_SHADE_STAGE_H

#include "accel/ray_times.h"
#include "render/film.h"
#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"
#include "render/stages/transparency_stage.h"

/* One shading point for each hit of the batch. */
void rk_shade_stage(const rk_rendering *r, const rk_path_batch *paths, const rk_hit_batch *hits,
                    const rk_ray_times *times, rk_shading_points *points);

/* How far a batch with transparent surfaces is shaded. */
typedef struct rk_shading_cursor {
    uint32_t path;           /* the next one to be traced */
    uint32_t hit;            /* the next one of those below to be shaded */
    rk_visible_hits visible; /* of the path before */
} rk_shading_cursor;

/* The next RK_BATCH_MAX shading points of the batch, or all that are left: a path passes several
 * transparent surfaces. Each path is traced when its first point is due, and what the environment
 * adds behind them all goes to the film. */
void rk_shade_transparent_stage(const rk_rendering *r, rk_sample_pass *pass,
                                const rk_path_batch *paths, rk_shading_cursor *cursor,
                                rk_shading_points *points, rk_film *film);

/* The point where path i hits at `time` (which counts only with plan.motion_blur); */
void rk_shading_point_at(rk_shading_point *point, const rk_rendering *r, const rk_path_batch *paths,
                         uint32_t i, const rk_hit *hit, float time);
/* or at hit k of those that show. */
void rk_shading_point_behind(rk_shading_point *point, const rk_rendering *r,
                             const rk_path_batch *paths, uint32_t i, const rk_visible_hits *visible,
                             uint32_t k);

#endif
