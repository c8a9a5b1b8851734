/* Fog over a picture, when all tiles are rendered. */
#ifndef RK_RENDER_STAGES_FOG_STAGE_H
#define RK_RENDER_STAGES_FOG_STAGE_H

#include "base/image.h"
#include "features/fog.h"

/* Does it change anything? Where it does not, no pixel is read. */
bool rk_fog_wanted(const rk_fog_options *options);

void rk_fog_stage(rk_image *image, const rk_fog_options *options);

#endif
