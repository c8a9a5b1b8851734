/* The camera of the classic course: it looks at a point from a distance, rotated by Euler angles.
 * position = look_at + R (0, 0, -distance), R = Rz Ry Rx; x points to the left of the picture. */
#ifndef RK_SCENE_CAMERA_H
#define RK_SCENE_CAMERA_H

#include "base/ray.h"
#include "base/vec3.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct rk_camera {
    rk_vec3 look_at;
    float distance;
    rk_vec3 rotation; /* degrees about x, then y, then z */
    float fov;        /* vertical field of view, degrees, in (0, 180) */
} rk_camera;

/* Looks at 0 from distance 3, with rotation (20, 20, 0) and a field of view of 50 degrees. */
rk_camera rk_camera_default(void);

/* Derived from a camera and a picture size. The axes are unit and orthogonal. */
typedef struct rk_view {
    rk_vec3 position;
    rk_vec3 right, up, forward;    /* of the picture */
    float half_width, half_height; /* of the picture plane at distance 1 */
    float width, height;           /* pixels */
    float pixel;                   /* side of a pixel, a square, on that plane */
} rk_view;

/* Requires a field of view in its range and at least one pixel; rk_render checks both. */
rk_view rk_view_of(const rk_camera *camera, size_t width, size_t height);

/* The point (x, y) of the picture, on the picture plane at distance 1, relative to the camera: its
 * component along the view direction is 1. x and y are pixels from the top left corner; the centre
 * of pixel (i, j) is (i + .5, j + .5). */
static inline rk_vec3 rk_view_through(const rk_view *view, float x, float y)
{
    float right = (x - 0.5f * view->width) * view->pixel;
    float up = (0.5f * view->height - y) * view->pixel;
    return rk_madd(rk_madd(view->forward, view->right, right), view->up, up);
}

/* The ray through that point. The direction is unit, t_max infinite. */
static inline rk_ray rk_view_ray(const rk_view *view, float x, float y)
{
    return (rk_ray){view->position, rk_normalize(rk_view_through(view, x, y)), INFINITY};
}

/* Projects a point: pixels from the top left corner, and its depth along the view direction. False
 * behind the camera (depth <= 0); the pixel is then left unchanged. */
bool rk_view_project(const rk_view *view, rk_vec3 point, rk_vec2 *pixel, float *depth);

#endif
