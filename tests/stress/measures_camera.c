/* The camera, its lens, and circles of confusion. */
#include "measure.h"

#include "features/depth_of_field.h"
#include "scene/camera.h"

/* Inputs: look_at, rotation, distance, field of view. */
static rk_camera camera_of(const float *in)
{
    return (rk_camera){vector_of(in), in[6], vector_of(in + 3), in[7]};
}

/* --- The view --------------------------------------------------------------------------------- */

/* R = Rz Ry Rx, written out. */
static wide3 rotated(const rk_camera *camera, wide3 p)
{
    const wide degree = 3.14159265358979323846264338L / 180;
    wide sx = sinl((wide)camera->rotation.x * degree), cx = cosl((wide)camera->rotation.x * degree);
    wide sy = sinl((wide)camera->rotation.y * degree), cy = cosl((wide)camera->rotation.y * degree);
    wide sz = sinl((wide)camera->rotation.z * degree), cz = cosl((wide)camera->rotation.z * degree);
    return (wide3){cz * cy * p.x + (cz * sy * sx - sz * cx) * p.y + (cz * sy * cx + sz * sx) * p.z,
                   sz * cy * p.x + (sz * sy * sx + cz * cx) * p.y + (sz * sy * cx - cz * sx) * p.z,
                   -sy * p.x + cy * sx * p.y + cy * cx * p.z};
}

static double error_of_axes(const float *in)
{
    rk_camera camera = camera_of(in);
    rk_view view = rk_view_of(&camera, 800, 600);
    double right = error3_in(view.right, rotated(&camera, (wide3){-1, 0, 0}), eps);
    double up = error3_in(view.up, rotated(&camera, (wide3){0, 1, 0}), eps);
    double forward = error3_in(view.forward, rotated(&camera, (wide3){0, 0, 1}), eps);
    return fmax(right, fmax(up, forward));
}

static double error_of_view_position(const float *in)
{
    rk_camera camera = camera_of(in);
    rk_view view = rk_view_of(&camera, 800, 600);
    wide3 at = widen3(camera.look_at),
          back = rotated(&camera, (wide3){0, 0, -(wide)camera.distance});
    wide3 want = wide_madd(at, back, 1);
    /* Double's 2^-53 matters where the sum cancels. */
    wide3 unit = {eps * (fabsl(want.x) + 0x1p-26L * (fabsl(at.x) + (wide)camera.distance)),
                  eps * (fabsl(want.y) + 0x1p-26L * (fabsl(at.y) + (wide)camera.distance)),
                  eps * (fabsl(want.z) + 0x1p-26L * (fabsl(at.z) + (wide)camera.distance))};
    return error3_each(view.position, want, unit);
}

static wide3 through(const rk_view *view, wide x, wide y)
{
    wide right = (x - (wide)view->width / 2) * (wide)view->pixel;
    wide up = ((wide)view->height / 2 - y) * (wide)view->pixel;
    return wide_madd(wide_madd(widen3(view->forward), widen3(view->right), right), widen3(view->up),
                     up);
}

/* Inputs from 8 on: a picture's width and height, a place in it. */
static rk_view view_of(const float *in)
{
    rk_camera camera = camera_of(in);
    return rk_view_of(&camera, (size_t)in[8], (size_t)in[9]);
}

static double error_of_view_ray(const float *in)
{
    rk_view view = view_of(in);
    float x = in[10] * view.width, y = in[11] * view.height;
    rk_ray ray = rk_view_ray(&view, x, y);
    return error3_in(ray.direction, wide_unit(through(&view, (wide)x, (wide)y)), eps);
}

static double error_of_projection(const float *in)
{
    rk_view view = view_of(in);
    rk_vec3 point = vector_of(in + 10);
    wide3 offset = wide_sub(widen3(point), widen3(view.position));
    wide3 forward = widen3(view.forward), right = widen3(view.right);
    wide depth = wide_dot(offset, forward), per_unit = 1 / (depth * (wide)view.pixel);
    if (!(depth > 0) || wide_dot_size(offset, forward) > 0x1p10L * depth)
        return (double)NAN;
    rk_vec2 pixel;
    float got_depth;
    if (!rk_view_project(&view, point, &pixel, &got_depth))
        return (double)INFINITY;
    wide want = (wide)view.width / 2 + wide_dot(offset, right) * per_unit;
    wide part = wide_dot_size(offset, right) * per_unit;
    wide unit = (wide)view.width / 2 + part * (1 + wide_dot_size(offset, forward) / depth);
    return error_in((wide)pixel.x, want, eps * unit);
}

/* --- The lens --------------------------------------------------------------------------------- */

/* Inputs from 12 on: the focal distance, the lens's diameter over it, a sample. */
static rk_lens lens_of(const float *in, rk_focal_surface focal)
{
    return (rk_lens){in[12], fminf(1000 * in[13] * in[12], 1e6f * in[12]), focal};
}

/* The lens ray's direction against that from its own start to the focus. */
static double error_of_lens_ray(const float *in, rk_focal_surface focal)
{
    rk_camera camera = camera_of(in);
    rk_lens lens = lens_of(in, focal);
    camera.look_at = rk_vec(0, 0, 0), camera.distance = 0;
    rk_view view = rk_view_of(&camera, (size_t)in[8], (size_t)in[9]);
    float x = in[10] * view.width, y = in[11] * view.height;
    rk_ray ray = rk_lens_ray(&lens, &view, x, y, (rk_vec2){in[14], in[15]});
    wide3 to = through(&view, (wide)x, (wide)y);
    wide along = focal == RK_FOCAL_PLANE ? (wide)lens.focal_distance
                                         : (wide)lens.focal_distance / wide_length(to);
    wide3 start = widen3(ray.origin), want = wide_sub(wide_scale(to, along), start);
    /* Where the lens is larger than its focal distance, both terms are, and nearly cancel. */
    wide grows = (wide_length(start) + wide_length(to) * along) / wide_length(want);
    return error3_in(ray.direction, wide_unit(want), eps * grows);
}

static double error_of_plane_lens(const float *in)
{
    return error_of_lens_ray(in, RK_FOCAL_PLANE);
}

static double error_of_sphere_lens(const float *in)
{
    return error_of_lens_ray(in, RK_FOCAL_SPHERE);
}

/* Inputs from 16 on: the distance along the ray. */
static double error_of_circle(const float *in, rk_focal_surface focal)
{
    rk_view view = view_of(in);
    rk_lens lens = lens_of(in, focal);
    rk_ray ray = rk_view_ray(&view, in[10] * view.width, in[11] * view.height);
    wide3 direction = widen3(ray.direction), forward = widen3(view.forward);
    wide cosine = wide_dot(direction, forward), t = (wide)in[16], f = (wide)lens.focal_distance;
    wide d = focal == RK_FOCAL_PLANE ? t * cosine : t;
    wide scale = (wide)lens.aperture / 1000 / (wide)view.pixel;
    if (focal == RK_FOCAL_SPHERE)
        scale /= cosine;
    wide want = scale * fabsl(1 / f - 1 / d);
    wide grows = wide_dot_size(direction, forward) / cosine;
    if (!(cosine > 0x1p-10L) || want > 0x1p120L)
        return (double)NAN;
    return error_in((wide)rk_lens_coc_diameter(&lens, &view, &ray, in[16]), want,
                    eps * scale * (1 / f + 1 / d) * grows);
}

static double error_of_plane_circle(const float *in)
{
    return error_of_circle(in, RK_FOCAL_PLANE);
}

static double error_of_sphere_circle(const float *in)
{
    return error_of_circle(in, RK_FOCAL_SPHERE);
}

#define CAMERA_INPUTS                                                                              \
    {SIGNED, 3, -20, 20}, {BETWEEN, 3, -360, 360}, {POSITIVE, 1, -20, 20},                         \
    {                                                                                              \
        BETWEEN, 1, 0.01f, 179                                                                     \
    }
#define PICTURE_INPUTS                                                                             \
    CAMERA_INPUTS,                                                                                 \
    {                                                                                              \
        BETWEEN, 2, 1, 100000                                                                      \
    }
#define LENS_INPUTS                                                                                \
    PICTURE_INPUTS, {BETWEEN, 2, 0, 1}, {POSITIVE, 2, -20, 10},                                    \
    {                                                                                              \
        FRACTION, 2, 0, 1                                                                          \
    }

static const measure list[] = {
    {.routine = "rk_view_of",
     .what = "error of an axis, eps",
     .error = error_of_axes,
     .domains = {CAMERA_INPUTS},
     .bound = 0.5001,
     .because = "rounded once, below 1; doubles' 2^-53 of angles up to 2 pi",
     .reference = "long double, the matrix written out"},
    {.routine = "rk_view_of",
     .what = "error of the position, eps of it and 2^-50 of look_at and distance",
     .error = error_of_view_position,
     .domains = {CAMERA_INPUTS},
     .bound = 1,
     .because = "rounded once, from double",
     .reference = "long double, the matrix written out"},
    {.routine = "rk_view_ray",
     .what = "error of the direction, eps",
     .error = error_of_view_ray,
     .domains = {PICTURE_INPUTS, {BETWEEN, 2, 0, 1}},
     .bound = 11,
     .because = "5 of each term, whose sum is at most 1.3 of the length in a component; then 4.5",
     .reference = "long double"},
    {.routine = "rk_view_project",
     .what = "error of the pixel, eps times half the width and the sum of its terms",
     .error = error_of_projection,
     .domains = {PICTURE_INPUTS, {SIGNED, 3, -20, 20}},
     .bound = 8,
     .because = "two dot products of 4, the pixels per unit: 2, a product and a sum",
     .reference = "long double"},
    {.routine = "rk_lens_ray: focal plane",
     .what = "error of the direction, eps, times lens and focal distance over the distance between",
     .error = error_of_plane_lens,
     .domains = {LENS_INPUTS},
     .bound = 12,
     .because = "the pinhole's 6.5; the start: 1, a quotient, a product and a sum; then 4.5",
     .reference = "long double, the focus minus the ray's own start"},
    {.routine = "rk_lens_ray: focal sphere",
     .what = "error of the direction, eps, times lens and focal distance over the distance between",
     .error = error_of_sphere_lens,
     .domains = {LENS_INPUTS},
     .bound = 15,
     .because = "the plane's, and the length of the direction: 2.5",
     .reference = "long double, the focus minus the ray's own start"},
    {.routine = "rk_lens_coc_diameter: plane",
     .what = "error, eps times the sum of its terms",
     .error = error_of_plane_circle,
     .domains = {LENS_INPUTS, {POSITIVE, 1, -20, 20}},
     .bound = 11,
     .because = "the depth: 4, its reciprocal, the difference, the aperture: 2, two products",
     .reference = "long double"},
    {.routine = "rk_lens_coc_diameter: sphere",
     .what = "error, eps times the sum of its terms",
     .error = error_of_sphere_circle,
     .domains = {LENS_INPUTS, {POSITIVE, 1, -20, 20}},
     .bound = 11,
     .because =
         "the cosine: 3, its product, reciprocals, the difference, the aperture: 2, two products",
     .reference = "long double"},
};

const measures measures_of_camera = {list, sizeof list / sizeof *list};
