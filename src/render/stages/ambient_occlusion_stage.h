/* Ambient occlusion stage: traces shadow rays from each shading point into random directions
 * above it, as far as the ambient distance; not installed. */
#ifndef RK_RENDER_STAGES_AMBIENT_OCCLUSION_STAGE_H
#define RK_RENDER_STAGES_AMBIENT_OCCLUSION_STAGE_H

#include "render/rendering.h"
#include "render/sample_pass.h"
#include "render/shading_point.h"

enum { RK_AMBIENT_DRAWN = 64 }; /* samples drawn at once */

/* The samples of one shading point. */
typedef struct rk_ambient_samples {
    rk_ambient_frame frame;
    rk_ambient_map map;
    float distance;
    rk_sampler sampler;
    uint32_t pixel, dimension;
    uint32_t first, count; /* samples of the pixel */
    rk_vec2 drawn[RK_AMBIENT_DRAWN];
    rk_spawner spawner;
} rk_ambient_samples;

/* `point` must stay as long as the samples. */
void rk_ambient_samples_start(rk_ambient_samples *samples, const rk_rendering *r,
                              const rk_sample_pass *pass, const rk_shading_point *point);

/* Ray i of the point, from t = 0 to the ambient distance at t = 1, and its weight. Call with
 * i = 0, 1, ... in this order. False if the surface itself occludes the ray. */
bool rk_ambient_ray(rk_ambient_samples *samples, uint32_t i, rk_ray *ray, float *weight);

extern const rk_names rk_ambient_map_names;

#endif
