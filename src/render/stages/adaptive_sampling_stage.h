/* Adaptive sampling in the renderer: rounds over all tiles, until the predicted error is the wanted
 * one; not installed. */
#ifndef RK_RENDER_STAGES_ADAPTIVE_SAMPLING_STAGE_H
#define RK_RENDER_STAGES_ADAPTIVE_SAMPLING_STAGE_H

#include "base/parallel.h"
#include "features/adaptive_sampling.h"
#include "render/feature.h"
#include "render/paths.h"

extern const rk_names rk_adaptive_shown_names;

/* Returns the options with which rounds are rendered; the same if there is no adaptive sampling.
 * The number of samples is not known beforehand, so times are those of Sobol's sequence, which goes
 * on with any number, evenly distributed together with the pixel. */
rk_render_options rk_adaptive_sampling_options_of(const rk_render_options *options);

/* Renders into `image`. `workspaces`, `counters`: one per thread of the pool. */
bool rk_adaptive_sampling_stage(const rk_rendering *r, rk_path_workspace *workspaces,
                                rk_counters *counters, rk_image *image, rk_pool *pool,
                                rk_error *error);

#endif
