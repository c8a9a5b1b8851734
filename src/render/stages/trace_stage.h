/* Trace stage: what do rays intersect, and when? It is three steps: what stands still, in which a
 * ray ends early; the time stage, which finds rays that may reach something that moves before that;
 * and what moves, at these rays' times. Without motion only the first is done. */
#ifndef RK_RENDER_STAGES_TRACE_STAGE_H
#define RK_RENDER_STAGES_TRACE_STAGE_H

#include "accel/crossings.h"
#include "accel/ray_times.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* The closest hits of the rays, and when (`times` is set only with plan.motion_blur). */
void rk_trace_closest(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                      rk_hit_batch *hits, rk_ray_times *times);

/* Is anything on the way of a ray for pixels[i]? */
void rk_trace_occlusion(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                        const uint16_t *pixels, rk_occlusion_batch *answers);

/* All that path i crosses, the nearest bounces_left + 1, and when. */
rk_ray_time rk_trace_crossings(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_path_batch *paths, uint32_t i, rk_crossing_list *list);

/* Returns the fraction of light that arrives along a shadow ray, through transparent surfaces. */
rk_vec3 rk_trace_transmittance(const rk_rendering *r, rk_sample_pass *pass, const rk_ray *ray,
                               uint32_t pixel);

#endif
