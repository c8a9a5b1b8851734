/* The table of --convergence: how fast each sampling of times converges. */
#include "driver.h"

#include "driver/convergence.h"

#include <stdio.h>

static bool put_errors(rk_driver *driver, const rk_convergence *study, rk_error *error)
{
    for (uint32_t sampling = 0; sampling < rk_time_sampling_names.count; sampling++)
        for (uint32_t samples = 1; samples <= 256; samples *= 2) {
            driver->render.motion.sampling = (rk_time_sampling)sampling;
            driver->render.motion.samples = samples;
            if (!rk_convergence_row_of(driver, study, rk_time_sampling_names.items[sampling],
                                       samples, NULL, error))
                return false;
        }
    return true;
}

/* The reference: so many equidistant times that their error is far below the others'. */
bool put_study(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    char name[64];
    snprintf(name, sizeof name, "%u equidistant times", c->reference);
    driver->render.motion.sampling = RK_TIME_EQUIDISTANT;
    driver->render.motion.samples = c->reference;
    rk_image truth = {0};
    const rk_convergence study = {"motion_blur_convergence", &truth, name, c->seeds};
    bool ok = rk_convergence_reference(driver, &truth, error) && put_errors(driver, &study, error);
    rk_image_free(&truth);
    return ok;
}
