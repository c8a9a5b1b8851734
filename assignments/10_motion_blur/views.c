/* The debug view: the paths of moving objects, the times on them, and the swept boxes. */
#include "driver.h"

static float single_time_or(const rk_motion_options *motion, float x)
{
    return isnan(motion->single_time)
               ? x
               : rk_shutter_equidistant(&motion->shutter, motion->single_time, motion->samples);
}

/* Random times differ from pixel to pixel, and more than a hundred dots would be a line. */
static bool has_times(const rk_motion_options *motion)
{
    return (motion->sampling == RK_TIME_EQUIDISTANT || !isnan(motion->single_time)) &&
           motion->samples <= 100;
}

static void draw_path(rk_overlay *overlay, const rk_motion_options *motion, const rk_box *rest,
                      const rk_motion *path)
{
    const rk_vec3 orange = rk_vec(1, 0.55f, 0.1f), blue = rk_vec(0.3f, 0.6f, 1);
    const rk_vec3 white = rk_vec(1, 1, 1);
    rk_vec3 centre = rk_scale(rk_add(rest->corner[0], rest->corner[1]), 0.5f);
    float open = motion->shutter.open, close = motion->shutter.close;
    float from = rk_min(open, single_time_or(motion, open));
    float to = rk_max(close, single_time_or(motion, close));
    const int steps = 200;
    rk_vec3 last = rk_add(centre, rk_motion_offset(path, from));
    for (int i = 1; i <= steps; i++) {
        float x = from + (to - from) * ((float)i / (float)steps);
        rk_vec3 next = rk_add(centre, rk_motion_offset(path, x));
        rk_overlay_line(overlay, last, next, x <= close && x > open ? orange : white, 2);
        last = next;
    }
    rk_box swept = rk_motion_sweep(path, &motion->shutter, rest);
    rk_overlay_wireframe(overlay, &swept, orange, 2.5f);
    for (uint32_t k = 1; has_times(motion) && k <= motion->samples; k++) {
        float x = rk_shutter_equidistant(&motion->shutter, (float)k, motion->samples);
        rk_overlay_point(overlay, rk_add(centre, rk_motion_offset(path, x)), orange, 3.5f);
    }
    if (isnan(motion->single_time))
        return;
    const rk_shutter then = {single_time_or(motion, 0), single_time_or(motion, 0)};
    swept = rk_motion_sweep(path, &then, rest);
    rk_overlay_wireframe(overlay, &swept, blue, 2.5f);
    rk_overlay_point(overlay, rk_add(centre, rk_motion_offset(path, then.open)), blue, 6);
}

/* Nothing hides the path: most of it is inside the moving object. */
static bool draw_paths(rk_driver *driver, rk_error *error)
{
    rk_overlay overlay;
    if (!rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++) {
        overlay.depth[i] = INFINITY;
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.6f);
    }
    for (uint32_t i = 0; i < driver->scene.moving_count; i++)
        draw_path(&overlay, &driver->render.motion, &driver->accel.moving[i].nodes[0].box,
                  &driver->scene.moving[i].motion);
    rk_overlay_free(&overlay);
    return true;
}

bool draw_view(rk_driver *driver, rk_error *error)
{
    return rk_driver_render(driver, error) && draw_paths(driver, error);
}
