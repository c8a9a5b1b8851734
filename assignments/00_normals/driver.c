/* Draws the figures of normals: surfaces in the colours of their normals, without any light. */
#include "driver/driver_main.h"

static const char summary[] =
    "Shows the normals of surfaces as colours, smooth or flat (--normals), without any light.";

static void set_defaults(rk_driver *driver)
{
    driver->scene_name = "teapot";
    driver->render.normals = RK_NORMALS_SMOOTH;
}

static bool prepare(rk_driver *driver, rk_error *error)
{
    (void)error;
    driver->scene.light_count = 0;
    return true;
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    return rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_count_rows(driver, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    static const char *const labels[] = {"none", "smooth", "flat"};
    return rk_driver_save(driver, labels[driver->render.normals], error);
}

int main(int argc, char **argv)
{
    const rk_driver_spec spec = {
        .feature = "normals",
        .summary = summary,
        .set_defaults = set_defaults,
        .prepare = prepare,
        .put_rows = put_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
