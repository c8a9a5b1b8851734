/* The tables of --positions: the path of each moving object by time, and its ends and bounds while
 * the shutter is open. */
#include "driver.h"

#include "driver/number_row.h"

static bool put_path(const rk_driver *driver, uint32_t object, rk_error *error)
{
    for (int k = -20; k <= 50; k++) {
        const float time = 0.01f * (float)k;
        const rk_vec3 at = rk_motion_offset(&driver->scene.moving[object].motion, time);
        const double numbers[] = {object, (double)time, (double)at.x, (double)at.y};
        if (!rk_driver_number_row(driver, "motion_blur_path", "object time x y", 2, numbers, error))
            return false;
    }
    return true;
}

/* The bounds are the swept box of a point. */
static bool put_shutter(const rk_driver *driver, uint32_t object, rk_error *error)
{
    const rk_shutter *shutter = &driver->render.motion.shutter;
    const rk_motion *motion = &driver->scene.moving[object].motion;
    const rk_box point = {{{0, 0, 0}, {0, 0, 0}}};
    const rk_box swept = rk_motion_sweep(motion, shutter, &point);
    const rk_vec3 from = rk_motion_offset(motion, shutter->open);
    const rk_vec3 to = rk_motion_offset(motion, shutter->close);
    const double numbers[] = {object,
                              (double)shutter->open,
                              (double)shutter->close,
                              (double)from.x,
                              (double)from.y,
                              (double)to.x,
                              (double)to.y,
                              (double)swept.corner[0].x,
                              (double)swept.corner[0].y,
                              (double)swept.corner[1].x,
                              (double)swept.corner[1].y};
    return rk_driver_number_row(
        driver, "motion_blur_shutter",
        "object open close from_x from_y to_x to_y low_x low_y high_x high_y", 3, numbers, error);
}

bool put_positions(rk_driver *driver, rk_error *error)
{
    for (uint32_t i = 0; i < driver->scene.moving_count; i++)
        if (!put_path(driver, i, error) || !put_shutter(driver, i, error))
            return false;
    return true;
}
