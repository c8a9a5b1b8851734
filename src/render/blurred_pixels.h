/* The pixels that take lens samples, told before a picture or beside it; not installed. */
#ifndef RK_RENDER_BLURRED_PIXELS_H
#define RK_RENDER_BLURRED_PIXELS_H

#include "accel/accel.h"
#include "base/parallel.h"
#include "render/plan.h"

/* Sets blurred[y * width + x] for all pixels: does rk_render take the options' lens samples there?
 * Nowhere without a lens. `blurred` has room for a picture of the options' size. False, with the
 * reason, for what rk_render refuses, and without memory. */
bool rk_blurred_pixels(bool *blurred, const rk_scene *scene, const rk_accel *accel,
                       const rk_render_options *options, rk_pool *pool, rk_error *error);

#endif
