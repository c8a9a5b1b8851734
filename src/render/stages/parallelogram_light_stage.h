/* Lights with an extent or a falloff: point by point, a shadow ray and its contribution for each
 * sample of the light. A point's rays make a narrow bundle, from one origin to one light, so they
 * are traced together. If its first shadow rays agree, all or none of them occluded, a point may
 * trace only a few of the others (--early-out); not installed. */
#ifndef RK_RENDER_STAGES_PARALLELOGRAM_LIGHT_STAGE_H
#define RK_RENDER_STAGES_PARALLELOGRAM_LIGHT_STAGE_H

#include "render/feature.h"
#include "render/film.h"
#include "render/stages/shadow_stage.h"

/* The result of a point's first shadow rays, until one disagrees. Attenuated ones differ in
 * transmittance, so they never agree. */
typedef enum rk_light_visibility {
    RK_LIGHT_UNDECIDED,
    RK_LIGHT_ATTENUATED,
    RK_LIGHT_UNOCCLUDED,
    RK_LIGHT_OCCLUDED,
    RK_LIGHT_CLEAR,  /* certainly unoccluded, without any ray */
    RK_LIGHT_SUMMED, /* and its sums are complete */
} rk_light_visibility;

/* One light at each shading point: sums over its samples. */
typedef struct rk_light_sums {
    rk_vec3 shadowed[RK_BATCH_MAX];   /* radiance, times visibility */
    rk_vec3 unshadowed[RK_BATCH_MAX]; /* radiance without occlusion */
    uint32_t traced[RK_BATCH_MAX];    /* shadow rays */
    uint32_t unoccluded[RK_BATCH_MAX];
    rk_light_visibility visibility[RK_BATCH_MAX];
    double solid_angle[RK_BATCH_MAX]; /* see rk_highlight_start; set only with
                                         plan.sharp_highlights */
} rk_light_sums;

/* Adds the light of the scene with this index; `queue`, `answers` and `sums` are scratch memory. */
void rk_parallelogram_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                                  const rk_shading_points *points, uint32_t light,
                                  rk_shadow_queue *queue, rk_shadow_answers *answers,
                                  rk_light_sums *sums, rk_film *film);

enum { RK_LIGHT_RUN_MAX = 64 };

/* The contributions of a point's samples, at most RK_LIGHT_RUN_MAX, if not occluded. `solid_angle`:
 * see rk_highlight_start; 0 without sharp highlights. */
void rk_light_contributions(const rk_rendering *r, const rk_shading_point *point,
                            const rk_light *light, double solid_angle, uint32_t count,
                            const rk_light_sample *samples, rk_vec3 *contributions);

/* The random numbers, from this and the next of the dimensions, for `count` of `samples` samples of
 * the light at a shading point, from sample `first` on. */
void rk_light_random(const rk_rendering *r, const rk_sample_pass *pass,
                     const rk_shading_point *point, uint32_t light, uint32_t dimension,
                     uint32_t samples, uint32_t first, uint32_t count, rk_vec2 *numbers);

/* Of the directions in lobes: beyond those of all lights' samples at all bounces. */
enum { RK_DIMENSION_LOBE = RK_DIMENSION_LIGHT + (1 << 15) };
_Static_assert(2 * (RK_MAX_DEPTH + 1) * RK_LIGHTS_MAX <= 1 << 15,
               "a pair for each light and bounce");

extern const rk_names rk_light_domain_names, rk_light_falloff_names, rk_light_visibility_names,
    rk_highlight_names;

#endif
