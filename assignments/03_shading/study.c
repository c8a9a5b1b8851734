/* The table of --lobes: the highlights of each model by angle. */
#include "driver.h"

#include <stdio.h>

/* Rows of both models with light along the normal, by the viewer's angle from the mirror direction:
 * ten per factor of ten, from a hundredth of a degree. */
bool put_study(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"model", "shininess", "angle", "value", NULL};
    char path[4096], cells[3][32];
    if (!rk_driver_table(driver, "shading_lobes", path, error))
        return false;
    for (int model = RK_SHADING_PHONG; model <= RK_SHADING_BLINN_PHONG; model++)
        for (uint32_t i = 0; i < shown; i++)
            for (int k = 0; k < 40; k++) {
                float angle = powf(10, 0.1f * (float)k - 2);
                float value =
                    lobe((rk_shading_model)model, true, shininess_shown[i], up, at_angle(angle));
                if (angle >= 90 || !(value > 1e-3f))
                    break;
                snprintf(cells[0], sizeof cells[0], "%g", (double)shininess_shown[i]);
                snprintf(cells[1], sizeof cells[1], "%.4g", (double)angle);
                snprintf(cells[2], sizeof cells[2], "%.6g", (double)value);
                const char *row[] = {rk_shading_model_names.items[model], cells[0], cells[1],
                                     cells[2]};
                if (!rk_table_put(path, header, row, 4, 3, error))
                    return false;
            }
    return true;
}
