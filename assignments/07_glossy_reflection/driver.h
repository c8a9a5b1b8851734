/* Declarations that the files of this driver share. */
#ifndef RK_07_GLOSSY_REFLECTION_DRIVER_H
#define RK_07_GLOSSY_REFLECTION_DRIVER_H

#include "driver/driver_main.h"
#include "driver/side_view.h"
#include "render/stages/glossy_reflection_stage.h"

typedef struct choices {
    rk_side_view viewer;
    bool convergence, policies;
    uint32_t most, reference; /* samples */
    uint32_t seeds;
    bool of_pixel; /* the picture shows one pixel's rays, and is named after it */
} choices;

/* Make the pictures of --debug rays and --debug dots. */
bool draw_rays(rk_driver *driver, rk_error *error);
bool draw_dots(rk_driver *driver, rk_error *error);

/* Put the tables of --convergence and --policies. */
bool put_convergence(rk_driver *driver, rk_error *error);
bool put_policies(rk_driver *driver, rk_error *error);

#endif
