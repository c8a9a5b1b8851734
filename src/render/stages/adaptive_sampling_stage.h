/* Adaptive sampling in the renderer: rounds over all tiles, until the predicted error is the wanted
 * one; not installed.
 *
 * The first round takes the same number of samples in every pixel. Each generation then allocates
 * samples by the variance that those before estimated, and theirs are thrown away: no sample
 * decides on its own number, and the mean is unbiased. The last generation has two rounds. The
 * second one adds to the first, for each colour of a chessboard as many samples as the other one
 * asks for. */
#ifndef RK_RENDER_STAGES_ADAPTIVE_SAMPLING_STAGE_H
#define RK_RENDER_STAGES_ADAPTIVE_SAMPLING_STAGE_H

#include "base/parallel.h"
#include "features/adaptive_sampling.h"
#include "render/feature.h"
#include "render/paths.h"

extern const rk_names rk_adaptive_shown_names;

/* Returns the options with which rounds are rendered; the same if there is no adaptive sampling.
 * The number of samples is not known beforehand, so stratified ones become low-discrepancy ones. */
rk_render_options rk_adaptive_sampling_options_of(const rk_render_options *options);

/* Renders into `image`. `workspaces`, `counters`: one per thread of the pool. */
bool rk_adaptive_sampling_stage(const rk_rendering *r, rk_path_workspace *workspaces,
                                rk_counters *counters, rk_image *image, rk_pool *pool,
                                rk_error *error);

#endif
