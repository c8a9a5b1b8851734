/* Declarations that the files of this driver share. */
#ifndef RK_10_MOTION_BLUR_DRIVER_H
#define RK_10_MOTION_BLUR_DRIVER_H

#include "driver/driver_main.h"
#include "render/stages/motion_blur_stage.h"

typedef struct choices {
    uint32_t reference; /* samples of the picture that --convergence compares with */
    uint32_t seeds;
    bool convergence, still, positions;
} choices;

/* Renders and draws driver->debug over the picture. */
bool draw_view(rk_driver *driver, rk_error *error);

/* Puts the table of --convergence. */
bool put_study(rk_driver *driver, rk_error *error);

/* Puts the tables of --positions. */
bool put_positions(rk_driver *driver, rk_error *error);

#endif
