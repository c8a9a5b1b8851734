/* Draws the figures and measures the tables of fog. */
#include "driver/driver_main.h"

static const char summary[] = "Renders a scene with fog (--fog-strength).";

static void set_defaults(rk_driver *driver)
{
    driver->render.fog.strength = 1;
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    return rk_driver_row(driver, "render", "ms", driver->render_ms, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    return rk_driver_save(driver, driver->render.fog.strength > 0 ? NULL : "without", error);
}

int main(int argc, char **argv)
{
    const rk_driver_spec spec = {
        .feature = "fog",
        .summary = summary,
        .set_defaults = set_defaults,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
