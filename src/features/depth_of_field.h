/* Depth of field: a camera with a lens instead of a pinhole. Points on the focal surface are sharp;
 * a point in front of it or behind it becomes a disk, its circle of confusion. The lens is a disk
 * around the camera's position, along the camera's own x and y axes. */
#ifndef RK_FEATURES_DEPTH_OF_FIELD_H
#define RK_FEATURES_DEPTH_OF_FIELD_H

#include "scene/camera.h"

#include <stdint.h>

/* The points in focus: as in photography all points of one depth, a plane perpendicular to the
 * view; or, as in classic courses, all points of one distance from the camera, a sphere around
 * it. */
typedef enum rk_focal_surface { RK_FOCAL_PLANE, RK_FOCAL_SPHERE } rk_focal_surface;

typedef struct rk_lens {
    float focal_distance; /* of the focal surface, world units, above 0; may be infinite */
    float aperture;       /* the lens's diameter, thousandths of a world unit; 0 is a pinhole; at
                             most a million focal distances */
    rk_focal_surface focal;
} rk_lens;

/* Returns the ray through the point (x, y) of the picture, in pixels as in rk_view_ray, that starts
 * at the lens point for `xi` in [0, 1)^2 by the concentric map (rk_disk_at): the disk's x axis is
 * view->right, its y axis view->up. All rays of one (x, y) converge on the focal surface. The
 * direction is unit, and the same wherever the camera is, so a ray misses the focus by the rounding
 * of its origin: by 2^-24 of the camera's distance from (0, 0, 0), 0.0006 of 10,000, and by 12 *
 * 2^-24 of the focus's distance from the camera, at most. t_max is infinite. The ray from the
 * lens's centre is rk_view_ray's, to the bit. */
rk_ray rk_lens_ray(const rk_lens *lens, const rk_view *view, float x, float y, rk_vec2 xi);

/* Returns the diameter in pixels of the circle of confusion of the point at `t` of `ray`, one of
 * rk_view_ray's: A |d - f| / (d f) over the side of a pixel at distance 1, where A is the aperture,
 * f the focal distance and d the point's depth. On a focal sphere d is the point's distance from
 * the camera, and the circle grows by 1 / cos of the ray's angle to the view; this is to first
 * order in A / d. t is above 0 and may be infinite, and so may f: then the circle is A / d, and 0
 * infinitely far away. The unit of length does not matter: where all lengths are 1e-30 or 1e30
 * times as large, the circle is the same, though a product of two of them is 0 or infinite. So may
 * d / f be: of a far point and a tiny f the circle is A / f. */
float rk_lens_coc_diameter(const rk_lens *lens, const rk_view *view, const rk_ray *ray, float t);

/* Circles of confusion of a smaller diameter, in pixels, count as points. */
#define RK_LENS_COC_MIN 0.5f

/* Finds the pixels that need lens samples: those that a circle of confusion of RK_LENS_COC_MIN or
 * more may reach. `diameters`: width * height circles of confusion, one per pixel, 0 where it sees
 * nothing. `coc_count`: (width + 1) * (height + 1) numbers, overwritten. On return coc_count[y *
 * (width + 1) + x] is the number of circles of confusion, each taken as the square around it, that
 * reach pixel (x, y). */
void rk_lens_coc(const float *diameters, uint32_t width, uint32_t height, int32_t *coc_count);

#endif
