/* Transparency stage: the visible hits of a path, one behind the other; not installed. */
#ifndef RK_RENDER_STAGES_TRANSPARENCY_STAGE_H
#define RK_RENDER_STAGES_TRANSPARENCY_STAGE_H

#include "render/feature.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Nearest first: hit k is behind k transparent surfaces. */
typedef struct rk_visible_hits {
    uint32_t count;
    rk_hit hits[RK_MAX_DEPTH + 1];
    float weights[RK_MAX_DEPTH +
                  1]; /* fraction of the radiance that reaches the ray's origin; may be 0 */
    float behind; /* fraction of the environment; 0 behind an opaque surface or beyond max_depth */
    float time;   /* see rk_ray_times */
} rk_visible_hits;

/* Traces path i. */
void rk_transparency_stage(const rk_rendering *r, rk_sample_pass *pass, const rk_path_batch *paths,
                           uint32_t i, rk_visible_hits *visible);

extern const rk_names rk_glass_model_names;

#endif
