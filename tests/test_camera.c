/* The camera: its position, its rays, and projection. */
#include "test.h"

#include "base/random.h"
#include "scene/camera.h"

static const float epsilon = 0x1p-24f; /* half an ulp of 1: one rounding to float */

static rk_view default_view(void)
{
    rk_camera camera = rk_camera_default();
    return rk_view_of(&camera, 800, 800);
}

static void the_default_position_is_above_and_in_front(void **state)
{
    (void)state;
    /* 3 Ry(20) Rx(20) (0, 0, -1) = 3 (-sin 20 cos 20, sin 20, -cos 20 cos 20). */
    rk_view view = default_view();
    rk_check_close(view.position.x, -0.964181414530, 3 * (double)epsilon, "one rounding");
    rk_check_close(view.position.y, 1.026060429977, 3 * (double)epsilon, "one rounding");
    rk_check_close(view.position.z, -2.649066664678, 3 * (double)epsilon, "one rounding");
    rk_check(view.forward.y < 0, "the camera above should look down");
}

static void rotation_is_about_x_then_y_then_z(void **state)
{
    (void)state;
    /* (0, 0, -2), by 90 degrees about x: (0, 2, 0), unchanged by y; by 90 about z: (-2, 0, 0). */
    rk_camera camera = {.distance = 2, .rotation = rk_vec(90, 30, 90), .fov = 50};
    rk_view view = rk_view_of(&camera, 10, 10);
    rk_check_close(view.position.x, -2, 0, "Rz Ry Rx: exact up to 1e-16");
    rk_check_close(view.position.y, 0, 1e-15, "the cosine of pi / 2 as a double");
    rk_check_close(view.position.z, 0, 1e-15, "the cosine of pi / 2 as a double");
}

static void x_grows_to_the_left_of_the_picture(void **state)
{
    (void)state;
    rk_camera camera = {.distance = 3, .fov = 50};
    rk_view view = rk_view_of(&camera, 100, 100);
    rk_vec2 pixel;
    float depth;
    rk_check(rk_view_project(&view, rk_vec(0.5f, 0, 0), &pixel, &depth), "it is in front");
    rk_check(pixel.x < 50, "x = .5 is at column %f, right of the centre", (double)pixel.x);
    rk_check(rk_view_project(&view, rk_vec(0, 0.5f, 0), &pixel, &depth), "it is in front");
    rk_check(pixel.y < 50, "y = .5 is at row %f, below the centre", (double)pixel.y);
}

static void the_axes_are_unit_and_orthogonal(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_vec3 degrees = rk_vec(720 * rk_unit_float(rk_hash(i, 0, 0, 1)) - 360,
                                 720 * rk_unit_float(rk_hash(i, 1, 0, 1)) - 360,
                                 720 * rk_unit_float(rk_hash(i, 2, 0, 1)) - 360);
        rk_camera camera = {.distance = 3, .rotation = degrees, .fov = 50};
        rk_view view = rk_view_of(&camera, 10, 10);
        const double tolerance = 6 * (double)epsilon; /* 3 components, rounded once, and the dot */
        rk_check_close(rk_dot(view.right, view.right), 1, tolerance, "right is unit");
        rk_check_close(rk_dot(view.up, view.up), 1, tolerance, "up is unit");
        rk_check_close(rk_dot(view.forward, view.forward), 1, tolerance, "forward is unit");
        rk_check_close(rk_dot(view.right, view.up), 0, tolerance, "orthogonal");
        rk_check_close(rk_dot(view.up, view.forward), 0, tolerance, "orthogonal");
        rk_check_close(rk_dot(view.forward, view.right), 0, tolerance, "orthogonal");
    }
}

static void the_ray_through_the_centre_hits_the_look_at_point(void **state)
{
    (void)state;
    rk_camera camera = {
        .look_at = rk_vec(1, -2, 5), .distance = 7, .rotation = rk_vec(33, -71, 12), .fov = 35};
    rk_view view = rk_view_of(&camera, 640, 480);
    rk_ray ray = rk_view_ray(&view, 320, 240);
    rk_vec3 target = rk_madd(ray.origin, ray.direction, camera.distance);
    rk_check(rk_length(rk_sub(target, camera.look_at)) <= 12 * 7 * epsilon,
             "missed by %g: a dozen roundings of lengths up to 7",
             (double)rk_length(rk_sub(target, camera.look_at)));
    rk_check(isinf(ray.t_max) && ray.t_max > 0, "a view ray has no end");
}

/* The cosine between a ray through (x, y) and the centre's, by the formula in double. */
static double cosine_wanted(double px, double py, double aspect, double fov)
{
    double t = tan(fov * 3.14159265358979323846 / 360);
    return 1 / sqrt(1 + t * t * (px * px * aspect * aspect + py * py));
}

static void corner_rays_make_the_angles_of_the_field_of_view(void **state)
{
    (void)state;
    const float fovs[] = {0.01f, 1, 50, 90, 120, 170, 179.9f};
    const size_t sizes[][2] = {{800, 800}, {1920, 1080}, {1, 1}, {1, 4000}, {4000, 1}};
    for (int f = 0; f < 7; f++)
        for (int s = 0; s < 5; s++) {
            rk_camera camera = {.distance = 3, .rotation = rk_vec(20, 20, 0), .fov = fovs[f]};
            size_t width = sizes[s][0], height = sizes[s][1];
            rk_view view = rk_view_of(&camera, width, height);
            double aspect = (double)width / (double)height;
            for (int corner = 0; corner < 4; corner++) {
                float x = corner & 1 ? (float)width : 0, y = corner & 2 ? (float)height : 0;
                rk_ray ray = rk_view_ray(&view, x, y);
                rk_check_close(rk_dot(ray.direction, view.forward),
                               cosine_wanted(1, 1, aspect, (double)fovs[f]), 16 * (double)epsilon,
                               "some dozen roundings of numbers up to 1");
                rk_check((rk_dot(ray.direction, view.right) > 0) == (x > 0), "left and right");
                rk_check((rk_dot(ray.direction, view.up) > 0) == (y == 0), "row 0 is at the top");
            }
        }
}

static void the_middles_of_the_edges_make_half_the_vertical_field_of_view(void **state)
{
    (void)state;
    rk_camera camera = {.distance = 1, .fov = 90};
    rk_view view = rk_view_of(&camera, 200, 100);
    rk_ray top = rk_view_ray(&view, 100, 0), left = rk_view_ray(&view, 0, 50);
    rk_check_close(top.direction.y, sqrt(0.5), 4 * (double)epsilon, "45 degrees up");
    rk_check_close(top.direction.z, sqrt(0.5), 4 * (double)epsilon, "45 degrees up");
    rk_check_close(left.direction.x, 2 / sqrt(5), 4 * (double)epsilon, "slope 2 to the left");
    rk_check_close(left.direction.z, 1 / sqrt(5), 4 * (double)epsilon, "slope 2 to the left");
}

static void directions_are_unit(void **state)
{
    (void)state;
    rk_view view = default_view();
    for (int y = 0; y < 800; y += 7)
        for (int x = 0; x < 800; x += 7) {
            rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
            rk_check_close(rk_length(ray.direction), 1, 4 * (double)epsilon, "see rk_normalize");
        }
}

/* A point on a ray has an error of a few roundings of the camera's distance from 0 and of t. Over
 * the depth that is an angle, and over the side of a pixel a distance in pixels. */
static double projection_bound(const rk_view *view, float t, float depth)
{
    double off = (double)rk_length(view->position) + 4 * (double)t;
    return 4 * (double)epsilon *
           (off / ((double)depth * (double)view->pixel) + (double)view->width);
}

static void projecting_a_point_of_a_ray_gives_its_pixel_back(void **state)
{
    (void)state;
    const float fovs[] = {5, 50, 120};
    for (uint32_t i = 0; i < 3000; i++) {
        rk_camera camera = rk_camera_default();
        camera.fov = fovs[i % 3];
        camera.rotation.z = (float)(i % 360);
        rk_view view = rk_view_of(&camera, 640, 480);
        float x = 640 * rk_unit_float(rk_hash(i, 0, 0, 2));
        float y = 480 * rk_unit_float(rk_hash(i, 1, 0, 2));
        float t = exp2f(16 * rk_unit_float(rk_hash(i, 2, 0, 2)) - 4);
        rk_ray ray = rk_view_ray(&view, x, y);
        rk_vec2 pixel;
        float depth;
        rk_check(rk_view_project(&view, rk_madd(ray.origin, ray.direction, t), &pixel, &depth),
                 "a point on a view ray is in front");
        double bound = projection_bound(&view, t, depth);
        rk_check_close(pixel.x, x, bound, "there and back");
        rk_check_close(pixel.y, y, bound, "there and back");
        rk_check_close(depth, t * rk_dot(ray.direction, view.forward),
                       8 * (double)epsilon * (double)(t + 3), "depth is along the view");
    }
}

static void points_behind_the_camera_have_no_pixel(void **state)
{
    (void)state;
    rk_view view = default_view();
    rk_vec2 pixel = {-7, -7};
    float depth;
    rk_vec3 behind = rk_madd(view.position, view.forward, -0.5f);
    rk_check(!rk_view_project(&view, behind, &pixel, &depth), "half a unit behind has a pixel");
    rk_check(!rk_view_project(&view, view.position, &pixel, &depth), "the eye itself has a pixel");
    rk_check(!rk_view_project(&view, rk_vec(NAN, 0, 0), &pixel, &depth), "NaN has a pixel");
    rk_check_close(pixel.x, -7, 0, "the pixel is left alone");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_default_position_is_above_and_in_front),
    cmocka_unit_test(rotation_is_about_x_then_y_then_z),
    cmocka_unit_test(x_grows_to_the_left_of_the_picture),
    cmocka_unit_test(the_axes_are_unit_and_orthogonal),
    cmocka_unit_test(the_ray_through_the_centre_hits_the_look_at_point),
    cmocka_unit_test(corner_rays_make_the_angles_of_the_field_of_view),
    cmocka_unit_test(the_middles_of_the_edges_make_half_the_vertical_field_of_view),
    cmocka_unit_test(directions_are_unit),
    cmocka_unit_test(projecting_a_point_of_a_ray_gives_its_pixel_back),
    cmocka_unit_test(points_behind_the_camera_have_no_pixel),
};

RK_SUITE("camera", tests)
