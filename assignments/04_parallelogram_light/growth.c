/* The study of --growth: pictures by the present options with more and more samples on the light,
 * each with its error against a reference, and where the lights are. */
#include "driver.h"

#include "driver/convergence.h"
#include "driver/number_row.h"

#include <stdio.h>

/* The lights from above, in the room around the mesh. */
static bool put_lights(const rk_driver *driver, rk_error *error)
{
    const rk_scene *scene = &driver->scene;
    rk_box room = rk_box_empty();
    for (uint32_t i = 0; i < scene->mesh.vertex_count; i++)
        room = rk_box_add(room, scene->mesh.positions[i]);
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const rk_light *light = &scene->lights[i];
        const double numbers[] = {
            i,
            (double)light->position.x,
            (double)light->position.z,
            (double)light->edge01.x,
            (double)light->edge01.z,
            (double)light->edge02.x,
            (double)light->edge02.z,
            (double)room.corner[0].x,
            (double)room.corner[0].z,
            (double)room.corner[1].x,
            (double)room.corner[1].z,
        };
        if (!rk_driver_number_row(
                driver, "parallelogram_light_lights",
                "light x z edge01_x edge01_z edge02_x edge02_z low_x low_z high_x high_z", 1,
                numbers, error))
            return false;
    }
    return true;
}

static bool put_picture(rk_driver *driver, uint32_t samples, const rk_image *reference,
                        rk_error *error)
{
    char label[32];
    driver->render.light.samples = samples;
    snprintf(label, sizeof label, "growth_%u", samples);
    if (!rk_driver_render(driver, error) || !rk_driver_save(driver, label, error))
        return false;
    const double rmse = rk_picture_compare(&driver->image, reference).rmse;
    const double numbers[] = {samples, rmse, (double)driver->counters.shadow_rays};
    return rk_driver_number_row(driver, "parallelogram_light_growth", "samples rmse shadow_rays", 1,
                                numbers, error);
}

bool put_growth(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_light_options own = driver->render.light;
    rk_image reference;
    driver->render.light.samples = c->reference;
    driver->render.light.sampling = RK_SAMPLER_SOBOL; /* little noise, whatever is compared */
    driver->render.light.early_out = 0;               /* its bias would be taken for the truth */
    if (!put_lights(driver, error) || !rk_convergence_reference(driver, &reference, error))
        return false;
    driver->render.light = own;
    bool ok = true;
    for (uint32_t samples = 1; ok && samples <= c->most; samples *= 2)
        ok = put_picture(driver, samples, &reference, error);
    rk_image_free(&reference);
    return ok;
}
