/* Points that see a whole light need no shadow rays, and far enough from it no random samples;
 * points that face away from it need nothing; not installed. */
#ifndef RK_RENDER_STAGES_UNOCCLUDED_LIGHT_STAGE_H
#define RK_RENDER_STAGES_UNOCCLUDED_LIGHT_STAGE_H

#include "render/stages/parallelogram_light_stage.h"

/* Decides about the points for which it can: sets sums->visibility, and for RK_LIGHT_SUMMED the
 * sums. Only for a light with an extent. */
void rk_unoccluded_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_shading_points *points, uint32_t light,
                               rk_light_sums *sums);

#endif
