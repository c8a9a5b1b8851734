/* A picture from beside the camera, over which a driver draws the ray that the camera sends through
 * a pixel. */
#ifndef RK_DRIVER_SIDE_VIEW_H
#define RK_DRIVER_SIDE_VIEW_H

#include "driver/driver.h"

typedef struct rk_side_view {
    float yaw, pitch; /* degrees that the viewer is turned from the camera */
    float far;        /* times the camera's distance */
} rk_side_view;

/* The three options' rows, for a driver's own table: `view` is a rk_side_view of struct `type`.
 * Beside the camera, and as far. */
#define RK_SIDE_VIEW_OPTIONS(type, view)                                                           \
    {"viewer-yaw",                                                                                 \
     RK_FIELD(type, view.yaw),                                                                     \
     "DEG",                                                                                        \
     "--debug rays is seen from the camera turned so far about y",                                 \
     -360,                                                                                         \
     360,                                                                                          \
     40},                                                                                          \
        {"viewer-pitch", RK_FIELD(type, view.pitch), "DEG", "and so far about x", -360, 360, 0},   \
    {                                                                                              \
        "viewer-far", RK_FIELD(type, view.far), "F", "from F times the camera's distance", 0.01,   \
            100, 1                                                                                 \
    }

/* Returns the ray through the centre of the pixel that is drawn (rk_driver_draw_pixel): it is none
 * of the picture that is rendered now. */
rk_ray rk_side_view_ray(rk_driver *driver);

/* Moves the camera, renders, darkens the picture and begins drawings that nothing hides. The caller
 * frees the overlay. */
bool rk_side_view_render(const rk_side_view *view, rk_driver *driver, rk_overlay *overlay,
                         rk_error *error);

#endif
