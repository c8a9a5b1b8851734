/* Debug drawings over a finished picture: lines, boxes, triangles and points in the scene's own
 * coordinates, hidden where the scene is in front of them. */
#ifndef RK_DRIVER_OVERLAY_H
#define RK_DRIVER_OVERLAY_H

#include "accel/accel.h"
#include "base/image.h"
#include "base/parallel.h"
#include "scene/scene.h"

typedef struct rk_overlay {
    rk_image *image;
    rk_view view;
    float *depth; /* per pixel: distance along the ray through its centre, infinite without a hit */
} rk_overlay;

/* Finds the depth of every pixel of `image`. */
bool rk_overlay_init(rk_overlay *overlay, rk_image *image, const rk_scene *scene,
                     const rk_accel *accel, rk_pool *pool, rk_error *error);
void rk_overlay_free(rk_overlay *overlay);

/* Clips a segment at the smallest depth that can be projected; false if none of it is in front. */
bool rk_overlay_clip(const rk_view *view, rk_vec3 *from, rk_vec3 *to);

/* A line `width` pixels wide with smooth edges. Its depth equals its width: a surface hides it only
 * if it is farther than that in front. */
void rk_overlay_line(rk_overlay *overlay, rk_vec3 from, rk_vec3 to, rk_vec3 colour, float width);

/* A shadow ray: blue if unoccluded, dashed orange if occluded. */
void rk_overlay_shadow_ray(rk_overlay *overlay, rk_vec3 from, rk_vec3 to, bool occluded);

/* A disk that faces the viewer; `radius`: pixels. */
void rk_overlay_point(rk_overlay *overlay, rk_vec3 point, rk_vec3 colour, float radius);

/* The twelve edges of a box; `width`: pixels of a picture 800 pixels high, and scaled to this one.
 * At least one pixel, unless `width` is less. */
void rk_overlay_wireframe(rk_overlay *overlay, const rk_box *box, rk_vec3 colour, float width);

/* A box of coloured glass: its far and then its near faces are blended with opacity `alpha`. */
void rk_overlay_box(rk_overlay *overlay, const rk_box *box, rk_vec3 colour, float alpha);

/* A triangle blended with opacity `alpha`; a triangle of the scene covers exactly its own pixels.
 */
void rk_overlay_triangle(rk_overlay *overlay, rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 colour,
                         float alpha);

/* Colour n of a cycle of distinct ones. */
rk_vec3 rk_overlay_colour(uint32_t n);

#endif
