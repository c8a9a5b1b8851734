/* Shadow stage: traces shadow rays to points of lights, or to the end of another distance;
 * not installed. */
#ifndef RK_RENDER_STAGES_SHADOW_STAGE_H
#define RK_RENDER_STAGES_SHADOW_STAGE_H

#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"

/* Shadow rays of a batch of shading points, with these data for each: */
typedef struct rk_shadow_queue {
    rk_ray_batch rays;                  /* from the point, t = 0, to the light, t = 1 */
    uint16_t point[RK_BATCH_MAX];       /* index among the shading points */
    uint16_t pixel[RK_BATCH_MAX];       /* of the tile */
    rk_vec3 contribution[RK_BATCH_MAX]; /* radiance to the pixel if unoccluded */
} rk_shadow_queue;

/* The results, entry for entry. */
typedef struct rk_shadow_answers {
    rk_occlusion_batch occlusion;
    rk_vec3 transmittance[RK_BATCH_MAX]; /* set only with plan.transparency */
} rk_shadow_answers;

/* The data of the next ray; rk_queue_shadow_ray follows. `i`: the point's index. */
static inline void rk_queue_contribution(rk_shadow_queue *queue, const rk_shading_point *point,
                                         uint32_t i, rk_vec3 contribution)
{
    queue->point[queue->rays.count] = (uint16_t)i;
    queue->pixel[queue->rays.count] = point->pixel;
    queue->contribution[queue->rays.count] = contribution;
}

/* `start`: spawned from the point. */
static inline void rk_queue_shadow_ray(rk_shadow_queue *queue, rk_vec3 start, rk_vec3 light)
{
    rk_ray ray = {start, rk_sub(light, start), 1};
    rk_batch_push(&queue->rays, &ray);
}

void rk_shadow_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                     rk_shadow_answers *answers);

/* Returns the contribution of ray k, which is not occluded, times its transmittance. */
static inline rk_vec3 rk_unoccluded(const rk_rendering *r, const rk_shadow_queue *queue,
                                    const rk_shadow_answers *answers, uint32_t k)
{
    return r->plan.transparency ? rk_mul(queue->contribution[k], answers->transmittance[k])
                                : queue->contribution[k];
}

#endif
