/* Fog in the renderer; not installed. */
#ifndef RK_RENDER_STAGES_FOG_STAGE_H
#define RK_RENDER_STAGES_FOG_STAGE_H

#include "features/fog.h"

#include <stdbool.h>

/* Does it change anything? */
bool rk_fog_wanted(const rk_fog_options *options);

#endif
