/* Camera stage: the rays that a pass sends through its pixels. */
#ifndef RK_RENDER_STAGES_CAMERA_STAGE_H
#define RK_RENDER_STAGES_CAMERA_STAGE_H

#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Fills `paths` with a ray for each pixel that the pass samples: through its centre, or a random
 * place of it; from the camera's position, or, out of focus, a random place of the lens. */
void rk_camera_stage(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths);

#endif
