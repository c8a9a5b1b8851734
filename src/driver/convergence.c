#include "driver/convergence.h"

rk_picture_error rk_picture_compare(const rk_image *got, const rk_image *want)
{
    rk_picture_error total = {0, 0, 0};
    double squares = 0, sum = 0, count = 3 * (double)(got->width * got->height);
    for (size_t i = 0; i < got->width * got->height; i++)
        for (int axis = 0; axis < 3; axis++) {
            double error =
                (double)rk_axis(got->pixels[i], axis) - (double)rk_axis(want->pixels[i], axis);
            squares += error * error;
            sum += error;
            total.max_error = fmax(total.max_error, fabs(error));
        }
    total.rmse = sqrt(squares / count);
    total.bias = sum / count;
    return total;
}

bool rk_convergence_reference(rk_driver *driver, rk_image *reference, rk_error *error)
{
    rk_image own = driver->image;
    if (!rk_image_init(reference, own.width, own.height, error))
        return false;
    driver->image = *reference;
    driver->render.seed = ~driver->render.seed;
    bool ok = rk_driver_render(driver, error);
    driver->image = own;
    driver->render.seed = ~driver->render.seed;
    if (!ok)
        rk_image_free(reference);
    return ok;
}

bool rk_convergence_row_of(rk_driver *driver, const char *name, const char *method,
                           uint32_t samples, const rk_image *reference, const char *truth,
                           rk_error *error)
{
    char path[4096];
    if (!rk_driver_render(driver, error))
        return false;
    rk_picture_error off = rk_picture_compare(&driver->image, reference);
    const rk_convergence_row row = {
        .feature = driver->feature,
        .scene = driver->scene.name,
        .method = method,
        .samples = samples,
        .seconds = driver->render_ms.median / 1e3,
        .rmse = off.rmse,
        .max_error = off.max_error,
        .bias = off.bias,
        .reference = truth,
    };
    return rk_driver_table(driver, name, path, error) &&
           rk_table_put_convergence(path, &row, error);
}
