/* Camera stage: the primary rays of a pass; not installed. */
#ifndef RK_RENDER_STAGES_CAMERA_STAGE_H
#define RK_RENDER_STAGES_CAMERA_STAGE_H

#include "render/lens_rays.h"
#include "render/path_batch.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Fills `paths` with a ray per pixel of the pass: through its centre or a random point of it; from
 * the camera's position or, out of focus, a random point of the lens. */
void rk_camera_stage(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths);

/* Finds the pixels of a pass out of focus, for all of its samples. */
void rk_camera_lens_pixels(const rk_rendering *r, const rk_sample_pass *pass, rk_lens_pixels *lens);

#endif
