/* The lens stage, run by itself: a view that shows its decisions computes none of its own. */
#include "render/blurred_pixels.h"

#include "render/feature_hooks.h"
#include "render/rendering.h"
#include "render/stages/adaptive_sampling_stage.h"

#include <stdlib.h>

/* There is one number more in each row, see rk_lens_coc. */
static void mark(bool *blurred, const rk_rendering *r)
{
    const size_t width = r->options->width, pixels = width * r->options->height;
    for (size_t i = 0; i < pixels; i++)
        blurred[i] = r->coc_count && r->coc_count[i / width * (width + 1) + i % width] > 0;
}

bool rk_blurred_pixels(bool *blurred, const rk_scene *scene, const rk_accel *accel,
                       const rk_render_options *options, rk_pool *pool, rk_error *error)
{
    if (!rk_render_check(scene, options, error))
        return false;
    const rk_render_options adapted = rk_adaptive_sampling_options_of(options);
    rk_rendering r = rk_rendering_of(scene, accel, &adapted);
    rk_counters *counters = rk_allocate(rk_pool_threads(pool), sizeof *counters, "counters", error);
    const bool ok = counters && rk_features_prepare(&r, error) &&
                    rk_features_prepass(&r, pool, counters, error);
    if (ok)
        mark(blurred, &r);
    rk_features_release(&r);
    free(counters);
    return ok;
}
