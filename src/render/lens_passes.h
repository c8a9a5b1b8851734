/* The passes over a tile's pixels out of focus, if its rays are made four at a time; not installed.
 */
#ifndef RK_RENDER_LENS_PASSES_H
#define RK_RENDER_LENS_PASSES_H

#include "render/film.h"
#include "render/paths.h"
#include "render/sample_pass.h"

/* Adds all samples of the pass to the film, those of pass->lens. Where a sample adds to its pixel
 * only once, they are traced in the order of their places on the lens; the sum is the same. */
void rk_lens_passes(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                    rk_film *film);

#endif
