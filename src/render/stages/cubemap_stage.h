/* Environment stage: adds radiance from infinitely far; not installed. */
#ifndef RK_RENDER_STAGES_CUBEMAP_STAGE_H
#define RK_RENDER_STAGES_CUBEMAP_STAGE_H

#include "base/counters.h"
#include "render/feature.h"
#include "render/film.h"
#include "render/path_batch.h"
#include "render/rendering.h"

/* For all paths of the batch that hit nothing. */
void rk_cubemap_stage(const rk_rendering *r, const rk_path_batch *paths, const rk_hit_batch *hits,
                      rk_film *film, rk_counters *counters);

/* Returns the contribution of the environment, or else of the background, to the pixel of path i;
 * `fraction`: of the transparent surfaces in front of it. */
rk_vec3 rk_environment_radiance(const rk_rendering *r, const rk_path_batch *paths, uint32_t i,
                                float fraction, rk_counters *counters);

extern const rk_names rk_cubemap_filter_names;

#endif
