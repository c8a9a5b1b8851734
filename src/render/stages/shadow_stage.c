/* Without transparency, batches of rays are tested for any hit; with it, each ray gathers its
 * crossings, and their transmittance is its answer. */
#include "render/stages/shadow_stage.h"

#include "accel/query/trace.h"
#include "accel/query/trace_moving.h"
#include "render/ray_record.h"
#include "render/stages/motion_blur_stage.h"
#include "render/stages/trace_transparent.h"

static void trace_occlusion(const rk_rendering *r, rk_sample_pass *pass, const rk_ray_batch *rays,
                            const uint16_t *pixels, rk_occlusion_batch *answers)
{
    if (!r->plan.motion_blur) {
        rk_accel_occluded(r->accel, rays, answers, pass->counters);
        return;
    }
    float t_max[RK_BATCH_MAX];
    rk_ray_times times;
    rk_accel_occluded_static(r->accel, rays, answers, pass->counters);
    for (uint32_t i = 0; i < rays->count; i++)
        t_max[i] = answers->occluded[i] ? 0 : rays->t_max[i];
    rk_motion_blur_stage(r, pass, rays, pixels, false, t_max, &times);
    rk_accel_occluded_moving(r->accel, rays, &times, answers, pass->counters);
}

static void attenuate(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                      rk_shadow_answers *answers)
{
    for (uint32_t k = 0; k < queue->rays.count; k++) {
        const rk_ray ray = rk_batch_ray(&queue->rays, k);
        rk_crossing_list list;
        answers->transmittance[k] = rk_trace_transmittance(r, pass, &ray, queue->pixel[k], &list);
        const bool occluded = rk_is_black(answers->transmittance[k]);
        answers->occlusion.occluded[k] = occluded;
        if (r->record)
            rk_ray_record_shadow_ray(r, pass, &ray, queue->pixel[k], occluded, &list);
    }
}

void rk_shadow_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                     rk_shadow_answers *answers)
{
    pass->counters->shadow_rays += queue->rays.count;
    if (r->plan.transparency)
        attenuate(r, pass, queue, answers);
    else
        trace_occlusion(r, pass, &queue->rays, queue->pixel, &answers->occlusion);
    if (r->record && !r->plan.transparency)
        rk_ray_record_shadow_rays(r, pass, &queue->rays, queue->pixel, answers->occlusion.occluded);
}
