/* Declarations that the files of this driver share. */
#ifndef RK_08_CUBEMAP_DRIVER_H
#define RK_08_CUBEMAP_DRIVER_H

#include "driver/driver_main.h"
#include "render/stages/cubemap_stage.h"

typedef struct choices {
    float mirror;  /* NaN: materials keep their own */
    uint32_t side; /* 0: the map's own */
    bool marked, filters;
} choices;

/* The colour of a texel. */
typedef rk_vec3 paint(uint32_t side, rk_cube_face face, uint32_t column, uint32_t row);

/* Replaces the map by one with `side` texels per side, each of its `colour`. */
bool paint_map(rk_cubemap *map, uint32_t side, paint *colour, rk_error *error);

/* Paints the environment of --marked, --side or --debug seam, if one is given. */
bool paint_environment(rk_driver *driver, rk_error *error);

/* Draw --debug cross and --debug seam: the map alone, without a scene. */
bool draw_cross(rk_driver *driver, rk_error *error);
bool draw_seam(rk_driver *driver, rk_error *error);

/* Puts the table of --filters. */
bool put_study(rk_driver *driver, rk_error *error);

/* Puts the rows of --timing: the picture, and a lookup by each filter. */
bool put_rows(rk_driver *driver, rk_error *error);

#endif
