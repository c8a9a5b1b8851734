/* Points that see a whole light, and points that see nothing of it: the first need no shadow rays,
 * and where the light is small enough for them no random samples either; the second need nothing;
 * not installed. */
#ifndef RK_RENDER_STAGES_UNOCCLUDED_LIGHT_STAGE_H
#define RK_RENDER_STAGES_UNOCCLUDED_LIGHT_STAGE_H

#include "render/stages/parallelogram_light_stage.h"

/* Decides about the points for which it can: sets sums->visibility, and for RK_LIGHT_SUMMED the
 * sums. Only for a light with an extent. */
void rk_unoccluded_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_shading_points *points, uint32_t light,
                               rk_light_sums *sums);

#endif
