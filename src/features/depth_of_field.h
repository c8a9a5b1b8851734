/* Depth of field: a camera with a lens instead of a pinhole. What lies on the focal surface is
 * sharp; a point before or behind it becomes a disk, its circle of confusion. The lens is a disk
 * around the camera's position, in the camera's own x and y. */
#ifndef RK_FEATURES_DEPTH_OF_FIELD_H
#define RK_FEATURES_DEPTH_OF_FIELD_H

#include "scene/camera.h"

#include <stdint.h>

/* What is sharp: as in photography all points of one depth, a plane across the view; or, as in
 * classic courses, all points of one distance from the camera, a sphere around it. */
typedef enum rk_focal_surface { RK_FOCAL_PLANE, RK_FOCAL_SPHERE } rk_focal_surface;

typedef struct rk_lens {
    float focal_distance; /* of the focal surface, world units, above 0 */
    float aperture;       /* the lens's diameter, thousandths of a world unit; 0 is a pinhole */
    rk_focal_surface focal;
} rk_lens;

/* Returns the ray through the point (x, y) of the picture, pixels as in rk_view_ray, that starts at
 * the lens's point for `xi` in [0, 1)^2 by the concentric map (rk_disk_at): x of the disk counts
 * along view->right, y along view->up. All rays of one (x, y) meet on the focal surface. The
 * direction is unit, t_max infinite. The ray from the lens's centre is rk_view_ray's, to the bit.
 */
rk_ray rk_lens_ray(const rk_lens *lens, const rk_view *view, float x, float y, rk_vec2 xi);

/* Returns the diameter in pixels of the circle of confusion of the point at `t` of `ray`, one of
 * rk_view_ray's: A |d - f| / (d f) over the side of a pixel at distance 1, where A is the aperture,
 * f the focal distance and d the point's depth. On a focal sphere d is the point's distance from
 * the camera, and the circle grows by 1 / cos of the ray's angle to the view; this is to first
 * order in A / d. t may be infinite. */
float rk_lens_coc_diameter(const rk_lens *lens, const rk_view *view, const rk_ray *ray, float t);

/* Circles of a smaller diameter, in pixels, count as points. */
#define RK_LENS_COC_MIN 0.5f

/* Which pixels need lens samples? Those onto which a circle of confusion of RK_LENS_COC_MIN or more
 * may spill. `blur`: width * height diameters, what each pixel sees, 0 where it sees nothing.
 * `coc_count`: (width + 1) * (height + 1) numbers, overwritten. On return coc_count[y * (width + 1)
 * + x] is the number of pixels whose circle, taken as the square around it, reaches pixel (x, y).
 */
void rk_lens_coc(const float *blur, uint32_t width, uint32_t height, int32_t *coc_count);

#endif
