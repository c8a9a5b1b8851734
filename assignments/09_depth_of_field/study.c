/* Errors against the closed form: a wall whose edge is out of focus, by all samplers. */
#include "driver.h"

#include "driver/convergence.h"

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

/* The closed form, in the pixels that the edge reaches. */
static bool draw_closed_form(const rk_driver *driver, double diameter, rk_image *image,
                             rk_error *error)
{
    if (!rk_image_init(image, driver->image.width, driver->image.height, error))
        return false;
    for (size_t x = 0; x < image->width; x++) {
        double right = (double)x + 0.5 - 0.5 * (double)image->width;
        bool is_reached = fabs(right) <= 0.5 * diameter;
        float fraction = is_reached ? (float)wall_fraction(right, diameter) : NAN;
        for (size_t y = 0; y < image->height; y++)
            *rk_image_at(image, x, y) = rk_vec(fraction, fraction, fraction);
    }
    return true;
}

/* The edge of a wall behind the focus, by all samplers. */
bool put_study(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    rk_render_options *o = &driver->render;
    o->shading.model = RK_SHADING_OFF;
    o->lens.focal_distance = 1.5f;
    if (!make_edge(driver, error) || !rk_driver_build(driver, error))
        return false;
    /* The aperture for a circle of confusion of that diameter, by the closed form. */
    const double diameter = 32, d = 3, f = (double)o->lens.focal_distance;
    o->lens.aperture = (float)(1e3 * diameter * (double)view_of(driver).pixel * d * f / (d - f));
    rk_image want = {0};
    const rk_convergence study = {"depth_of_field_convergence", &want, "closed form", c->seeds};
    bool ok = draw_closed_form(driver, diameter, &want, error);
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_SOBOL; kind++)
        for (uint32_t samples = 1; ok && samples <= 1024; samples *= 2) {
            o->lens_samples = samples;
            o->lens_sampling = (rk_sampler_kind)kind;
            ok = rk_convergence_row_of(driver, &study, rk_sampler_name(o->lens_sampling), samples,
                                       NULL, error);
        }
    rk_image_free(&want);
    return ok;
}
