/* Tracing with plan.transparency: the crossings of view rays, and the transmittance of shadow rays.
 * The steps are those of the trace stage; not installed. */
#ifndef RK_RENDER_STAGES_TRACE_TRANSPARENT_H
#define RK_RENDER_STAGES_TRACE_TRANSPARENT_H

#include "accel/query/crossings.h"
#include "accel/query/ray_times.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* The crossings of path i, the nearest bounces_left + 1. Returns the ray's time. */
rk_ray_time rk_trace_crossings(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_path_batch *paths, uint32_t i, rk_crossing_list *list);

/* Returns the transmittance along a shadow ray, and its crossings: those found before an opaque
 * one, and that one. */
rk_vec3 rk_trace_transmittance(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                               uint32_t pixel, rk_crossing_list *list);

#endif
