/* Which pixels does the lens blur? A ray through each pixel's centre finds the circle of confusion
 * of the surface that it hits, and where circles reach, the renderer takes lens samples.
 *
 * Nothing nearer than the focal surface is overlooked: what hides a blurred surface there is nearer
 * still, and has a larger circle. Overlooked is what no centre ray hits: surfaces smaller than a
 * pixel, and those behind the focal surface that sharper ones hide altogether, which a lens sees
 * around their edges. */
#ifndef RK_RENDER_STAGES_DEPTH_OF_FIELD_STAGE_H
#define RK_RENDER_STAGES_DEPTH_OF_FIELD_STAGE_H

#include "base/parallel.h"
#include "render/feature.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Allocates and fills r->coc_count; `counters`: one for
 * each thread of the pool. */
bool rk_depth_of_field_prepass(rk_rendering *r, rk_pool *pool, rk_counters *counters,
                               rk_error *error);

/* Is it a pass for this pixel of the picture: in or out of focus, as the pixel is? */
static inline bool rk_is_in_pass(const rk_rendering *r, const rk_sample_pass *pass, uint32_t x,
                                 uint32_t y)
{
    return !r->coc_count ||
           (r->coc_count[(size_t)y * (r->options->width + 1) + x] > 0) == pass->out_of_focus;
}

extern const rk_names rk_focal_surface_names;

#endif
