/* Lens stage: finds the pixels that the lens blurs. A ray through each pixel's centre finds the
 * circle of confusion of the surface that it hits; pixels within a circle take lens samples. So do
 * rays through a margin around the picture, from where circles may reach into it.
 *
 * No surface in front of the focal surface is missed there: anything that hides it is nearer still,
 * and has a larger circle. Surfaces that no centre ray hits are missed: those smaller than a pixel,
 * those behind the focal surface that are hidden by sharper ones but visible from parts of the
 * lens, and those so near the lens that they are blurred into the picture from beyond the margin,
 * which is at most half as wide as the picture; not installed. */
#ifndef RK_RENDER_STAGES_DEPTH_OF_FIELD_STAGE_H
#define RK_RENDER_STAGES_DEPTH_OF_FIELD_STAGE_H

#include "base/parallel.h"
#include "render/feature.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Allocates and fills r->coc_count; `counters`: one per thread of the pool. */
bool rk_depth_of_field_prepass(rk_rendering *r, rk_pool *pool, rk_counters *counters,
                               rk_error *error);

/* Does the pass take this pixel of the picture: both in focus, or both out of focus? */
static inline bool rk_is_in_pass(const rk_rendering *r, const rk_sample_pass *pass, uint32_t x,
                                 uint32_t y)
{
    return !r->coc_count ||
           (r->coc_count[(size_t)y * (r->options->width + 1) + x] > 0) == pass->out_of_focus;
}

extern const rk_names rk_focal_surface_names;

#endif
