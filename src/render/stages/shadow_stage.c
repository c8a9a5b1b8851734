#include "render/stages/shadow_stage.h"

#include "render/stages/trace_stage.h"

static void attenuate(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                      rk_shadow_answers *answers)
{
    for (uint32_t k = 0; k < queue->rays.count; k++) {
        rk_ray ray = rk_batch_ray(&queue->rays, k);
        answers->transmittance[k] = rk_trace_transmittance(r, pass, &ray, queue->pixel[k]);
        answers->occlusion.occluded[k] = rk_is_black(answers->transmittance[k]);
    }
}

void rk_shadow_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                     rk_shadow_answers *answers)
{
    pass->counters->shadow_rays += queue->rays.count;
    if (r->plan.transparency)
        attenuate(r, pass, queue, answers);
    else
        rk_trace_occlusion(r, pass, &queue->rays, queue->pixel, &answers->occlusion);
}
