/* The names of the shading models; not installed. */
#ifndef RK_RENDER_STAGES_SHADING_STAGE_H
#define RK_RENDER_STAGES_SHADING_STAGE_H

#include "render/feature.h"

extern const rk_names rk_shading_model_names;

#endif
