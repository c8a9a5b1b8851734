/* The reference is drawn with another seed, so that its noise is independent. Errors of several
 * seeds are averaged as squares: their mean is an RMSE, too. */
#include "driver/convergence.h"

rk_picture_error rk_picture_compare(const rk_image *got, const rk_image *want)
{
    rk_picture_error total = {0, 0, 0};
    double squares = 0, sum = 0, count = 0;
    for (size_t i = 0; i < got->width * got->height; i++)
        for (int axis = 0; axis < 3; axis++) {
            double error =
                (double)rk_axis(got->pixels[i], axis) - (double)rk_axis(want->pixels[i], axis);
            if (isnan(rk_axis(want->pixels[i], axis)))
                continue;
            squares += error * error;
            sum += error;
            total.max_error = fmax(total.max_error, fabs(error));
            count++;
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

/* Adds a picture's error and number of rays; `rmse` is a sum of squares until all are added. */
static void add_picture(const rk_driver *driver, const rk_image *truth, uint32_t seeds,
                        rk_seed_errors *sum)
{
    const rk_picture_error off = rk_picture_compare(&driver->image, truth);
    const double pixels = (double)(truth->width * truth->height);
    sum->rmse += off.rmse * off.rmse / seeds;
    sum->rmse_low = fmin(sum->rmse_low, off.rmse);
    sum->rmse_high = fmax(sum->rmse_high, off.rmse);
    sum->max_error += off.max_error / seeds;
    sum->bias += off.bias / seeds;
    sum->rays += (double)rk_counters_rays(&driver->counters) / pixels / seeds;
}

bool rk_convergence_errors(rk_driver *driver, const rk_image *truth, uint32_t seeds,
                           rk_seed_errors *errors, rk_error *error)
{
    double seconds[RK_CONVERGENCE_SEEDS_MAX];
    const uint32_t seed = driver->render.seed;
    bool ok = true;
    *errors = (rk_seed_errors){.rmse_low = (double)INFINITY};
    for (uint32_t i = 0; ok && i < seeds; i++) {
        driver->render.seed = seed + i;
        ok = rk_driver_render(driver, error);
        seconds[i] = driver->render_ms.median / 1e3;
        if (ok)
            add_picture(driver, truth, seeds, errors);
    }
    driver->render.seed = seed;
    errors->seconds = ok ? rk_timing_of(seconds, seeds).median : 0;
    errors->rmse = sqrt(errors->rmse);
    return ok;
}

bool rk_convergence_row_of(rk_driver *driver, const rk_convergence *study, const char *method,
                           uint32_t samples, double *rmse, rk_error *error)
{
    char path[4096];
    rk_seed_errors off;
    if (!rk_convergence_errors(driver, study->truth, study->seeds, &off, error))
        return false;
    const rk_convergence_row row = {
        .feature = driver->feature,
        .scene = driver->scene.name,
        .method = method,
        .samples = samples,
        .seconds = off.seconds,
        .rays = off.rays,
        .rmse = off.rmse,
        .rmse_low = off.rmse_low,
        .rmse_high = off.rmse_high,
        .max_error = off.max_error,
        .bias = off.bias,
        .reference = study->reference,
        .seeds = study->seeds,
    };
    if (rmse)
        *rmse = off.rmse;
    return rk_driver_table(driver, study->table, path, error) &&
           rk_table_put_convergence(path, &row, error);
}
