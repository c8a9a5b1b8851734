/* A light that is one point, without a falloff, gives the same radiance to all shading points:
 * there is nothing to sample. Each point sends one shadow ray, and without shadows none. */
#ifndef RK_RENDER_STAGES_POINT_LIGHT_STAGE_H
#define RK_RENDER_STAGES_POINT_LIGHT_STAGE_H

#include "render/film.h"
#include "render/stages/shadow_stage.h"

/* `queue` and `answers` are room to work in. */
void rk_point_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                          const rk_shading_points *points, const rk_light *light,
                          rk_shadow_queue *queue, rk_shadow_answers *answers, rk_film *film);

#endif
