/* The tables of --circles: the circle of confusion by distance, along the middle ray, and for the
 * surfaces that the middle column of the picture shows. */
#include "driver.h"

#include "accel/query/trace_one.h"
#include "driver/number_row.h"

/* Up to one and a half times the camera's distance from its target. */
static bool put_distances(const rk_driver *driver, const rk_view *view, rk_error *error)
{
    enum { STEPS = 120 };
    const rk_ray middle = rk_view_ray(view, 0.5f * view->width, 0.5f * view->height);
    for (int k = 1; k <= STEPS; k++) {
        const float distance = 1.5f * driver->scene.camera.distance * (float)k / STEPS;
        const float diameter = rk_lens_coc_diameter(&driver->render.lens, view, &middle, distance);
        const double numbers[] = {(double)distance, (double)diameter};
        if (!rk_driver_number_row(driver, "depth_of_field_circles", "distance diameter", 1, numbers,
                                  error))
            return false;
    }
    return true;
}

static bool put_column(const rk_driver *driver, const rk_view *view, rk_error *error)
{
    for (float y = 0.5f; y < view->height; y += 4) {
        const rk_ray ray = rk_view_ray(view, 0.5f * view->width, y);
        const rk_hit hit = rk_trace_one(&driver->accel, &ray);
        if (hit.triangle == RK_MISS)
            continue;
        const rk_vec3 reach = rk_scale(ray.direction, hit.t);
        const double numbers[] = {
            (double)y, (double)rk_dot(reach, view->forward), (double)rk_dot(reach, view->up),
            (double)rk_lens_coc_diameter(&driver->render.lens, view, &ray, hit.t)};
        if (!rk_driver_number_row(driver, "depth_of_field_column", "y depth height diameter", 1,
                                  numbers, error))
            return false;
    }
    return true;
}

bool put_circles(rk_driver *driver, rk_error *error)
{
    const rk_view view = view_of(driver);
    return put_distances(driver, &view, error) && put_column(driver, &view, error);
}
