/* What the files of this driver share. */
#ifndef RK_10_MOTION_BLUR_DRIVER_H
#define RK_10_MOTION_BLUR_DRIVER_H

#include "driver/driver.h"

static const char *const sampling_names[] = {"equidistant", "stratified", "low-discrepancy"};
enum { sampling_count = sizeof sampling_names / sizeof sampling_names[0] };

typedef struct choices {
    uint32_t reference; /* samples of what --convergence compares with */
    bool convergence, still;
} choices;

/* Renders and draws driver->debug over the picture. */
bool draw_view(rk_driver *driver, const choices *c, rk_error *error);

/* Puts the table of --convergence. */
bool put_study(rk_driver *driver, const choices *c, rk_error *error);

#endif
