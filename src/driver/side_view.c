/* The picture is darkened, and its depths are infinite, so that no line drawn over it is hidden. */
#include "driver/side_view.h"

bool rk_side_view_render(const rk_side_view *view, rk_driver *driver, rk_overlay *overlay,
                         rk_error *error)
{
    rk_camera *camera = &driver->scene.camera;
    camera->rotation.x += view->pitch;
    camera->rotation.y += view->yaw;
    camera->distance *= view->far;
    if (!rk_driver_render_overlay(driver, overlay, error))
        return false;
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++) {
        overlay->depth[i] = INFINITY;
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.6f);
    }
    return true;
}
