/* Light stage: adds the light of all lights at a batch of shading points; not installed. */
#ifndef RK_RENDER_STAGES_LIGHT_STAGE_H
#define RK_RENDER_STAGES_LIGHT_STAGE_H

#include "render/stages/parallelogram_light_stage.h"

/* Scratch memory, per thread. */
typedef struct rk_light_workspace {
    rk_shadow_queue queue;
    rk_shadow_answers answers;
    rk_light_sums sums;
} rk_light_workspace;

void rk_light_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_shading_points *points,
                    rk_light_workspace *workspace, rk_film *film);

#endif
