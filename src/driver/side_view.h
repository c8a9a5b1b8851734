/* A picture from beside the camera, over which a driver draws the ray that the camera sends through
 * a pixel. */
#ifndef RK_DRIVER_SIDE_VIEW_H
#define RK_DRIVER_SIDE_VIEW_H

#include "driver/driver.h"

typedef struct rk_side_view {
    float yaw, pitch; /* degrees that the viewer is turned from the camera */
    float far;        /* times the camera's distance */
} rk_side_view;

/* Beside the camera, and as far. */
static inline rk_side_view rk_side_view_default(void)
{
    return (rk_side_view){.yaw = 40, .far = 1};
}

/* The three options' rows, for a driver's own table. */
#define RK_SIDE_VIEW_OPTIONS(view)                                                                 \
    {"viewer-yaw",                                                                                 \
     RK_OPTION_FLOAT,                                                                              \
     &(view).yaw,                                                                                  \
     "DEG",                                                                                        \
     "--debug rays is seen from the camera turned so far about y",                                 \
     -360,                                                                                         \
     360},                                                                                         \
        {"viewer-pitch", RK_OPTION_FLOAT, &(view).pitch, "DEG", "and so far about x", -360, 360},  \
    {                                                                                              \
        "viewer-far", RK_OPTION_FLOAT, &(view).far, "F", "from F times the camera's distance",     \
            0.01, 100                                                                              \
    }

/* Returns the ray through the centre of the pixel that is drawn (rk_driver_draw_pixel): it is none
 * of the picture that is rendered now. */
rk_ray rk_side_view_ray(rk_driver *driver);

/* Moves the camera, renders, darkens the picture and begins drawings that nothing hides. The caller
 * frees the overlay. */
bool rk_side_view_render(const rk_side_view *view, rk_driver *driver, rk_overlay *overlay,
                         rk_error *error);

#endif
