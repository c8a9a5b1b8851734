/* Time stage: which rays need a time, and which. A sample of a pixel has one time for all its rays,
 * from the camera's to the last shadow ray, and it is drawn when the first of them may reach
 * something that moves. Until then nothing depends on the time: so a sample none of whose rays does
 * so is the same at all times, and taken once. Others are taken in several time passes, each at a
 * time of its own, and count for their mean. */
#ifndef RK_RENDER_STAGES_MOTION_BLUR_STAGE_H
#define RK_RENDER_STAGES_MOTION_BLUR_STAGE_H

#include "accel/ray_times.h"
#include "render/feature.h"
#include "render/film.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Works out the boxes that moving objects sweep. */
void rk_motion_blur_prepare(rk_rendering *r);

/* Returns how often each of a pixel's samples is taken if it needs a time: so that together they
 * are taken at as many times as the options ask for. */
uint32_t rk_time_passes(const rk_plan *plan, const rk_render_options *options, uint32_t samples);

/* Before each pass of a sample: no time is drawn; before the first, no ray is known to need one. */
void rk_motion_blur_start_pass(rk_sample_pass *pass);

/* May ray i, for pixels[i], intersect a moving object before t_max[i]? If so its pixel's sample has
 * a time, which is drawn if none of its rays needed it before. Where t_max[i] is 0, none may. */
void rk_motion_blur_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                          const uint16_t *pixels, bool from_camera, const float *t_max,
                          rk_ray_times *times);
/* The same for one ray. */
rk_ray_time rk_motion_blur_ray_time(const rk_rendering *r, rk_sample_pass *pass, uint32_t pixel,
                                    bool from_camera, const rk_ray *ray, float t_max);

/* Takes a surface that a ray intersected at this time to where its object stands then. */
void rk_motion_blur_move(const rk_rendering *r, float time, uint32_t triangle, rk_surface *surface);

/* After a sample's last pass: of what its time passes added to `before`, the mean counts. */
void rk_motion_blur_average(const rk_sample_pass *pass, const rk_film *before, rk_film *film);

extern const rk_names rk_time_sampling_names;

#endif
