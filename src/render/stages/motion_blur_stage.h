/* Time stage: finds the rays that may hit moving objects, and their time. A sample of a pixel has
 * one time for all its rays, from the camera ray to the last shadow ray. It is drawn when the first
 * of them may hit a moving object. A sample without such a ray is the same at all times, and taken
 * once; others are taken in several time passes (render/time_passes.h); not installed. */
#ifndef RK_RENDER_STAGES_MOTION_BLUR_STAGE_H
#define RK_RENDER_STAGES_MOTION_BLUR_STAGE_H

#include "accel/query/ray_times.h"
#include "render/feature.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* May ray i, of pixels[i], hit a moving object before t_max[i]? If so, `times` receives these
 * objects and the time of the pixel's sample, which is drawn if this is the first such ray. A
 * t_max[i] of 0 skips the ray. */
void rk_motion_blur_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                          const uint16_t *pixels, bool from_camera, const float *t_max,
                          rk_ray_times *times);
/* For one ray. */
rk_ray_time rk_motion_blur_ray_time(const rk_rendering *r, rk_sample_pass *pass, uint32_t pixel,
                                    bool from_camera, const rk_ray *ray, float t_max);

extern const rk_names rk_time_sampling_names;

#endif
