/* Errors against the closed form: a wall whose edge is out of focus, by all samplers. */
#include "driver.h"

#include <stdio.h>

/* A wall that ends at x = 0, seen from 3 units away; without a lens, half of the picture. */
static bool make_edge(rk_driver *driver, rk_error *error)
{
    rk_mesh wall;
    if (!rk_mesh_init(&wall, 3, 1, 1, 0, error))
        return false;
    wall.positions[0] = rk_vec(0, -40, 0);
    wall.positions[1] = rk_vec(0, 40, 0);
    wall.positions[2] = rk_vec(40, 0, 0);
    wall.materials[0].kd = rk_vec(1, 1, 1);
    for (uint32_t k = 0; k < 3; k++)
        wall.triangles[0][k] = k;
    rk_scene_free(&driver->scene);
    driver->scene = (rk_scene){
        .name = "edge",
        .mesh = wall,
        .camera = {.distance = 3, .fov = 50},
        .light_count = 1,
        .lights = {rk_light_point(rk_vec(0, 0, -3), rk_vec(1, 1, 1))},
    };
    return true;
}

/* The fraction of a unit disk left of x: a segment's area over the disk's. x is clamped to [-1,
 * 1]. */
static double disk_left_of(double x)
{
    x = fmin(fmax(x, -1), 1);
    return 0.5 + (asin(x) + x * sqrt(1 - x * x)) / RK_PI_DOUBLE;
}

/* The fraction of the wall in a pixel whose centre is `x` pixels right of the edge, with a circle
 * of confusion of `diameter` pixels: the mean over 64 strips of the pixel. */
static double wall_fraction(double x, double diameter)
{
    const int strips = 64;
    double sum = 0;
    for (int i = 0; i < strips; i++)
        sum += 1 - disk_left_of((x - 0.5 + (i + 0.5) / strips) / (0.5 * diameter));
    return sum / strips;
}

static void measure(const rk_driver *driver, double diameter, rk_convergence_row *row)
{
    const rk_image *image = &driver->image;
    double squares = 0, sum = 0, counted = 0;
    for (size_t x = 0; x < image->width; x++) {
        double right = (double)x + 0.5 - 0.5 * (double)image->width;
        if (fabs(right) > 0.5 * diameter)
            continue;
        double want = wall_fraction(right, diameter);
        for (size_t y = 0; y < image->height; y++, counted++) {
            double error = (double)rk_image_at(image, x, y)->x - want;
            squares += error * error;
            sum += error;
            row->max_error = fmax(row->max_error, fabs(error));
        }
    }
    row->rmse = sqrt(squares / counted);
    row->bias = sum / counted;
}

/* The edge of a wall behind the focus, by all samplers. */
bool put_study(rk_driver *driver, rk_error *error)
{
    rk_render_options *o = &driver->render;
    o->shading.model = RK_SHADING_OFF;
    o->lens.focal_distance = 1.5f;
    char path[4096];
    if (!make_edge(driver, error) || !rk_driver_build(driver, error) ||
        !rk_driver_table(driver, "depth_of_field_convergence", path, error))
        return false;
    /* The aperture for a circle of confusion of that diameter, by the closed form. */
    const double diameter = 32, d = 3, f = (double)o->lens.focal_distance;
    o->lens.aperture = (float)(1e3 * diameter * (double)view_of(driver).pixel * d * f / (d - f));
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_SOBOL; kind++)
        for (uint32_t samples = 1; samples <= 1024; samples *= 2) {
            o->lens_samples = samples;
            o->lens_sampling = (rk_sampler_kind)kind;
            if (!rk_driver_render(driver, error))
                return false;
            rk_convergence_row row = {.feature = driver->feature,
                                      .scene = driver->scene.name,
                                      .method = rk_sampler_name(o->lens_sampling),
                                      .samples = samples,
                                      .seconds = driver->render_ms.median / 1e3,
                                      .reference = "closed form"};
            measure(driver, diameter, &row);
            if (!rk_table_put_convergence(path, &row, error))
                return false;
        }
    return true;
}
