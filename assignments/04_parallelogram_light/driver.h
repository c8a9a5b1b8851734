/* Declarations that the files of this driver share. */
#ifndef RK_04_PARALLELOGRAM_LIGHT_DRIVER_H
#define RK_04_PARALLELOGRAM_LIGHT_DRIVER_H

#include "driver/driver_main.h"

typedef struct choices {
    uint32_t light; /* 0: as the scene has it; or 1 + rk_light_kind */
    bool coloured, convergence, sharpness, early_outs, growth;
    float lamp_x, lamp_z, lamp_size; /* moved by, along x and z; size: a factor */
    uint32_t lights; /* strips of the scene's only light; 0: the scene's own lights */
    float brightness;
    uint32_t most, reference; /* samples */
    uint32_t seeds;
    uint32_t traced, unoccluded; /* the rays that --debug rays has drawn */
} choices;

/* Renders, and draws driver->debug over the picture: "rays" or "samples". */
bool draw_view(rk_driver *driver, rk_error *error);

/* Puts the table of --convergence. */
bool put_study(rk_driver *driver, rk_error *error);

/* Puts the table of --sharpness. */
bool put_sharpness(rk_driver *driver, rk_error *error);

/* Puts the table of --early-outs. */
bool put_early_outs(rk_driver *driver, rk_error *error);

/* Puts the tables of --growth and saves its pictures. */
bool put_growth(rk_driver *driver, rk_error *error);

#endif
