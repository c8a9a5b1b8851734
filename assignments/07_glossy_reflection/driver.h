/* What the files of this driver share. */
#ifndef RK_07_GLOSSY_REFLECTION_DRIVER_H
#define RK_07_GLOSSY_REFLECTION_DRIVER_H

#include "driver/side_view.h"

typedef struct choices {
    rk_side_view viewer;
    bool convergence, policies;
    uint32_t most, reference; /* samples */
} choices;

/* The map's name in options, tables and names of pictures. */
static inline const char *map_name(rk_disk_map map)
{
    return map == RK_DISK_POLAR ? "polar" : "concentric";
}

/* Makes the picture of driver->debug: "rays" or "dots". */
bool draw_view(rk_driver *driver, const choices *c, rk_error *error);

/* Puts the table of --convergence or --policies. */
bool put_study(rk_driver *driver, const choices *c, rk_error *error);

#endif
