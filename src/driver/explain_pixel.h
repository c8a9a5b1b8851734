/* A pixel's story in words: its ray, what it met, and where its light came from. */
#ifndef RK_DRIVER_EXPLAIN_PIXEL_H
#define RK_DRIVER_EXPLAIN_PIXEL_H

#include "accel/accel.h"
#include "render/plan.h"

#include <stdio.h>

/* Tells of the ray through the centre of pixel (x, y) as the renderer treats it. */
void rk_explain_pixel(FILE *out, const rk_scene *scene, const rk_accel *accel,
                      const rk_render_options *options, uint32_t x, uint32_t y);

#endif
