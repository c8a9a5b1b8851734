/* Sharp highlights of a parallelogram: beside the light's samples, directions of the lobe. Both are
 * weighted by the balance heuristic: with n samples of density p and m directions of density q, a
 * highlight f counts f / (n p + m q), whichever of them found it. So no sample counts much, where
 * the light's samples alone would rarely hit the lobe, and count 1 / p;
 * not installed. */
#ifndef RK_RENDER_STAGES_HIGHLIGHT_STAGE_H
#define RK_RENDER_STAGES_HIGHLIGHT_STAGE_H

#include "render/stages/parallelogram_light_stage.h"

/* For the plan: may a highlight be sharp compared with a light? */
bool rk_highlights_may_be_sharp(const rk_scene *scene, const rk_render_options *options);

/* Fills in sums->solid_angle: of the light, at points whose lobe is sharp compared with the light
 * and therefore takes directions; else 0. Returns their number for each, half as many as samples on
 * the light, or 0 if no point takes any. */
uint32_t rk_highlight_start(const rk_rendering *r, const rk_shading_points *points,
                            const rk_light *light, rk_light_sums *sums);

/* Returns the reflected radiance of a sample of the light, with the highlight's part weighted. */
rk_vec3 rk_highlight_of_light_sample(const rk_rendering *r, const rk_shading_point *point,
                                     const rk_light *light, double solid_angle,
                                     const rk_light_sample *sample);

/* Queues the shadow rays of the lobes' directions that hit the light, for one direction of each
 * sharp point; adds contributions to `sums` as if they were a sample of the light. */
void rk_highlight_stage(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_shading_points *points, uint32_t light, uint32_t sample,
                        rk_light_sums *sums, rk_shadow_queue *queue);

#endif
