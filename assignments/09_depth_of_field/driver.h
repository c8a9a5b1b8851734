/* Declarations that the files of this driver share. */
#ifndef RK_09_DEPTH_OF_FIELD_DRIVER_H
#define RK_09_DEPTH_OF_FIELD_DRIVER_H

#include "driver/driver_main.h"
#include "render/stages/depth_of_field_stage.h"

typedef struct choices {
    float viewer_yaw, viewer_pitch, viewer_far; /* of the view from the side */
    bool convergence, circles;
    uint32_t seeds;
    uint32_t rays; /* of --pixel; in focus, fewer than --debug rays draws */
} choices;

/* Returns the camera's view. */
static inline rk_view view_of(const rk_driver *driver)
{
    return rk_view_of(&driver->scene.camera, driver->render.width, driver->render.height);
}

/* Renders from the side of the lens, and draws --debug focus or --debug rays over it. */
bool draw_from_the_side(rk_driver *driver, rk_error *error);

/* Renders, and marks the pixels that take lens samples. */
bool draw_blurred(rk_driver *driver, rk_error *error);

/* Puts the table of --convergence; it builds a scene of its own. */
bool put_study(rk_driver *driver, rk_error *error);

/* Puts the tables of --circles. */
bool put_circles(rk_driver *driver, rk_error *error);

#endif
