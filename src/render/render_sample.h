/* One sample of each pixel of a tile; not installed. */
#ifndef RK_RENDER_RENDER_SAMPLE_H
#define RK_RENDER_RENDER_SAMPLE_H

#include "render/paths.h"

/* Adds the radiance of the next sample of each of the pass's pixels to the film. False if no pixel
 * of the tile belongs to the pass. */
bool rk_render_sample(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                      rk_film *film);

#endif
