/* Point lights without falloff: the same radiance at all shading points, so there is nothing to
 * sample. One shadow ray per point, none without shadows; not installed. */
#ifndef RK_RENDER_STAGES_POINT_LIGHT_STAGE_H
#define RK_RENDER_STAGES_POINT_LIGHT_STAGE_H

#include "render/film.h"
#include "render/stages/shadow_stage.h"

/* `queue` and `answers` are scratch memory. */
void rk_point_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                          const rk_shading_points *points, const rk_light *light,
                          rk_shadow_queue *queue, rk_shadow_answers *answers, rk_film *film);

#endif
