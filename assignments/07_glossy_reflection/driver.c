#include "render/driver.h"
int main(int argc, char **argv)
{
    const rk_option options[] = {{0}};
    const char *const views[] = {NULL};
    rk_driver driver = rk_driver_default("glossy_reflection", "x");
    driver.render.reflections = true;
    driver.render.glossy.samples=64;
    driver.render.glossy.radius=.1f;
    driver.split="sah3";
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = rk_driver_build(&driver, &error) && rk_driver_render(&driver, &error) && rk_driver_save(&driver, NULL, &error);
    printf("reflected %lu glossy %lu box %lu tri %lu\n", driver.counters.reflected_rays, driver.counters.glossy_samples, driver.counters.box_tests,driver.counters.triangle_tests);
    return rk_driver_finish(&driver, ok, &error);
}
