/* A light with an extent, or with a falloff, sends samples to all shading points, one after the
 * other for the whole batch: their contributions, and shadow rays for these. A point whose first
 * shadow rays agree, all or none occluded, is decided, and sends no more. */
#ifndef RK_RENDER_STAGES_PARALLELOGRAM_LIGHT_STAGE_H
#define RK_RENDER_STAGES_PARALLELOGRAM_LIGHT_STAGE_H

#include "render/feature.h"
#include "render/film.h"
#include "render/stages/shadow_stage.h"

/* Would more shadow rays from a point tell more? They would not where all or none were occluded;
 * through transparent surfaces a point stays undecided. */
typedef enum rk_light_visibility {
    RK_LIGHT_UNDECIDED,
    RK_LIGHT_ATTENUATED,
    RK_LIGHT_UNOCCLUDED,
    RK_LIGHT_OCCLUDED
} rk_light_visibility;

/* What one light does at each shading point: sums over its samples. */
typedef struct rk_light_sums {
    rk_vec3 shadowed[RK_BATCH_MAX];   /* radiance, as far as it arrives */
    rk_vec3 unshadowed[RK_BATCH_MAX]; /* as if nothing were occluded */
    uint32_t traced[RK_BATCH_MAX];    /* shadow rays */
    uint32_t unoccluded[RK_BATCH_MAX];
    rk_light_visibility visibility[RK_BATCH_MAX];
} rk_light_sums;

/* Adds the light of the scene with this index; `queue` and `answers` are room to work in. */
void rk_parallelogram_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                                  const rk_shading_points *points, uint32_t light,
                                  rk_shadow_queue *queue, rk_shadow_answers *answers,
                                  rk_light_sums *sums, rk_film *film);

extern const rk_names rk_light_domain_names, rk_light_falloff_names;

#endif
