/* Recorded rays as lines in the picture, for pages that draw them over it. */
#ifndef RK_DRIVER_PIXEL_RAYS_H
#define RK_DRIVER_PIXEL_RAYS_H

#include "render/ray_record.h"

#include <stdio.h>

/* Prints a line "@ KIND X Y X Y" for each ray: where it begins and ends, in pixels from the upper
 * left corner. KIND is camera, reflected, shadow, or occluded for a shadow ray that does not reach
 * the light. What is behind the viewer is left out. */
void rk_print_pixel_rays(FILE *out, const rk_ray_record *record, const rk_view *view);

#endif
