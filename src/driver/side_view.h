/* A picture from beside the camera, over which a driver draws the camera's ray through a pixel. */
#ifndef RK_DRIVER_SIDE_VIEW_H
#define RK_DRIVER_SIDE_VIEW_H

#include "driver/driver.h"

typedef struct rk_side_view {
    float yaw, pitch; /* of the viewer from the camera, degrees */
    float far;        /* times the camera's distance */
} rk_side_view;

/* The rows of the three options, for a driver's own table: `view` is a rk_side_view of struct
 * `type`. By default beside the camera, at the same distance. */
#define RK_SIDE_VIEW_OPTIONS(type, view)                                                           \
    {"viewer-yaw",                                                                                 \
     RK_FIELD(type, view.yaw),                                                                     \
     "DEG",                                                                                        \
     "--debug rays is drawn from the camera rotated by this about y",                              \
     -360,                                                                                         \
     360,                                                                                          \
     40},                                                                                          \
        {"viewer-pitch", RK_FIELD(type, view.pitch), "DEG", "and by this about x", -360, 360, 0},  \
    {                                                                                              \
        "viewer-far", RK_FIELD(type, view.far), "F", "and F times as far away", 0.01, 100, 1       \
    }

/* Moves the camera, renders, darkens the picture and starts an overlay that no surface hides. The
 * caller frees it. */
bool rk_side_view_render(const rk_side_view *view, rk_driver *driver, rk_overlay *overlay,
                         rk_error *error);

#endif
