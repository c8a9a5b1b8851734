/* Declarations for the files of this driver. */
#ifndef RK_11_AMBIENT_OCCLUSION_DRIVER_H
#define RK_11_AMBIENT_OCCLUSION_DRIVER_H

#include "driver/driver_main.h"
#include "driver/side_view.h"
#include "render/stages/ambient_occlusion_stage.h"

typedef struct choices {
    rk_side_view viewer;
    bool on_floor;
    bool convergence, closed_forms;
    uint32_t most, reference; /* samples */
    uint32_t seeds;
    uint32_t traced, unoccluded; /* the rays that --debug rays has drawn */
} choices;

/* Ambient light alone, on white surfaces: a pixel's colour is A. */
void show_visibility_alone(rk_driver *driver);

/* Make the pictures of --debug visibility and --debug rays. */
bool draw_visibility(rk_driver *driver, rk_error *error);
bool draw_rays(rk_driver *driver, rk_error *error);

/* Replaces the driver's scene by that of --on-floor: an exact sphere on an endless floor. */
bool put_on_floor(rk_driver *driver, rk_error *error);

/* Write the tables of --convergence and --closed-forms. */
bool put_convergence(rk_driver *driver, rk_error *error);
bool put_closed_forms(rk_driver *driver, rk_error *error);

#endif
