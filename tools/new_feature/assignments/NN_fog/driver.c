/* Draws the figures and measures the tables of fog. */
#include "driver/driver.h"
#include "render/stages/fog_stage.h"

static const char summary[] = "Renders a scene with fog (--strength).";

int main(int argc, char **argv)
{
    rk_fog_options fog = {.strength = 1};
    const rk_option options[] = {
        {"strength", RK_OPTION_FLOAT, &fog.strength, "S", "of fog; 0: none", 0, 1},
        {0},
    };
    const char *const views[] = {NULL};
    rk_driver driver = rk_driver_default("fog", summary);
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = rk_driver_build(&driver, &error) && rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        ok = rk_driver_row(&driver, "render", "ms", driver.render_ms, &error);
    else if (ok) {
        rk_fog_stage(&driver.image, &fog);
        ok = rk_driver_save(&driver, rk_fog_wanted(&fog) ? NULL : "without", &error);
    }
    return rk_driver_finish(&driver, ok, &error);
}
