/* Explains a pixel: prints its rays, their hits, the lights and their contributions. */
#ifndef RK_DRIVER_EXPLAIN_PIXEL_H
#define RK_DRIVER_EXPLAIN_PIXEL_H

#include "accel/accel.h"
#include "render/plan.h"

#include <stdio.h>

/* Prints how the renderer traces and shades the ray through the centre of pixel (x, y); with_code:
 * with lines that name the C which does each step (driver/pixel_code.h); with_rays: in the end with
 * lines that say where the rays are in the picture (driver/pixel_rays.h). */
void rk_explain_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y, bool with_code,
                      bool with_rays);

#endif
