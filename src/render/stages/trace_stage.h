/* Trace stage, in three steps: the hits on static surfaces, which end rays early; the time stage,
 * which finds the rays that may hit a moving object before that; the hits of these rays on moving
 * objects, at their times. Without motion blur, moving objects are traced at rest; not installed.
 */
#ifndef RK_RENDER_STAGES_TRACE_STAGE_H
#define RK_RENDER_STAGES_TRACE_STAGE_H

#include "accel/batch.h"
#include "accel/query/ray_times.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* The closest hits, and the rays' times, which are set only with plan.motion_blur. */
void rk_trace_closest(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                      rk_hit_batch *hits, rk_ray_times *times);

#endif
