/* Angles are in degrees and turned in double, so that a view's axes are orthogonal up to the last
 * bit. */
#include "scene/camera.h"

#include <assert.h>

static const double radians_per_degree = RK_PI_DOUBLE / 180;

rk_camera rk_camera_default(void)
{
    return (rk_camera){.distance = 3, .rotation = rk_vec(20, 20, 0), .fov = 50};
}

/* Rotates (p[a], p[b]) by an angle from axis a towards axis b. */
static void turn(double p[3], int a, int b, double degrees)
{
    double cosine = cos(degrees * radians_per_degree), sine = sin(degrees * radians_per_degree);
    double pa = p[a], pb = p[b];
    p[a] = cosine * pa - sine * pb;
    p[b] = sine * pa + cosine * pb;
}

/* R (x, y, z), in double, so that the axes are orthogonal up to the last bit of a float. */
static void rotate(const rk_camera *camera, double p[3])
{
    turn(p, 1, 2, (double)camera->rotation.x);
    turn(p, 2, 0, (double)camera->rotation.y);
    turn(p, 0, 1, (double)camera->rotation.z);
}

static rk_vec3 rotated_axis(const rk_camera *camera, double x, double y, double z)
{
    double p[3] = {x, y, z};
    rotate(camera, p);
    return rk_vec((float)p[0], (float)p[1], (float)p[2]);
}

rk_view rk_view_of(const rk_camera *camera, size_t width, size_t height)
{
    assert(width > 0 && height > 0 && "a picture has at least one pixel");
    assert(camera->fov > 0 && camera->fov < 180 && "the field of view is in (0, 180) degrees");
    double back[3] = {0, 0, -(double)camera->distance};
    rotate(camera, back);
    double half_height = tan(0.5 * (double)camera->fov * radians_per_degree);
    return (rk_view){
        .position = rk_vec((float)((double)camera->look_at.x + back[0]),
                           (float)((double)camera->look_at.y + back[1]),
                           (float)((double)camera->look_at.z + back[2])),
        .right = rotated_axis(camera, -1, 0, 0),
        .up = rotated_axis(camera, 0, 1, 0),
        .forward = rotated_axis(camera, 0, 0, 1),
        .half_width = (float)(half_height * (double)width / (double)height),
        .half_height = (float)half_height,
        .width = (float)width,
        .height = (float)height,
        .pixel = (float)(2 * half_height / (double)height),
    };
}

bool rk_view_project(const rk_view *view, rk_vec3 point, rk_vec2 *pixel, float *depth)
{
    rk_vec3 offset = rk_sub(point, view->position);
    *depth = rk_dot(offset, view->forward);
    if (!(*depth > 0))
        return false;
    float pixels_per_unit = 1 / (*depth * view->pixel);
    pixel->x = 0.5f * view->width + rk_dot(offset, view->right) * pixels_per_unit;
    pixel->y = 0.5f * view->height - rk_dot(offset, view->up) * pixels_per_unit;
    return true;
}
