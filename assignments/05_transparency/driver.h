/* Declarations that the files of this driver share. */
#ifndef RK_05_TRANSPARENCY_DRIVER_H
#define RK_05_TRANSPARENCY_DRIVER_H

#include "accel/query/crossings.h"
#include "driver/driver_main.h"
#include "driver/side_view.h"
#include "render/stages/transparency_stage.h"

typedef struct choices {
    float alpha, absorption; /* of all materials; NaN: their own */
    rk_side_view viewer;     /* where --debug rays is seen from */
    bool models;
    uint32_t crossed, traced, unoccluded; /* crossings and shadow rays of the view */
} choices;

/* Renders from beside the camera and draws driver->debug over it. */
bool draw_view(rk_driver *driver, rk_error *error);

/* Puts the table of --models. */
bool put_study(rk_driver *driver, rk_error *error);

#endif
