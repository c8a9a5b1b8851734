/* The renderer: tiles of ray batches, stage by stage. */
#ifndef RK_RENDER_RENDER_H
#define RK_RENDER_RENDER_H

#include "accel/accel.h"
#include "base/counters.h"
#include "base/image.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "render/plan.h"

/* Renders into `image`, which has the options' size. Another size is an error, and so is anything
 * that rk_render_check refuses; both before the first ray. The picture is the same to the bit for
 * any number of threads. `accel` was built over the scene's mesh. `counters` receives the work
 * done; `progress` (may be NULL) advances by a step per tile, rk_render_tiles in all. */
bool rk_render(rk_image *image, const rk_scene *scene, const rk_accel *accel,
               const rk_render_options *options, rk_pool *pool, rk_counters *counters,
               rk_progress *progress, rk_error *error);

/* The number of tiles in a picture of this size. */
uint32_t rk_render_tiles(const rk_render_options *options);

#endif
