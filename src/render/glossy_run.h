/* The directions of a rough mirror's samples, four at a time; not installed. */
#ifndef RK_RENDER_GLOSSY_RUN_H
#define RK_RENDER_GLOSSY_RUN_H

#include "features/glossy_reflection.h"

enum { RK_GLOSSY_RUN_MAX = 64 };

typedef struct rk_glossy_run {
    float x[RK_GLOSSY_RUN_MAX], y[RK_GLOSSY_RUN_MAX]; /* places on the unit disk */
    float direction_x[RK_GLOSSY_RUN_MAX], direction_y[RK_GLOSSY_RUN_MAX];
    float direction_z[RK_GLOSSY_RUN_MAX];
    float is_above[RK_GLOSSY_RUN_MAX]; /* not 0 if the direction does not lead into the surface */
} rk_glossy_run;

/* Replaces the first `count` places by points of the disk: rk_disk_at for each. `agrees`: see
 * rk_glossy_run_agrees. */
void rk_glossy_run_map(rk_glossy_run *run, rk_disk_map map, uint32_t count, bool agrees);

/* Fills in the directions to the first `count` places: rk_glossy_direction for each. */
void rk_glossy_run_aim(rk_glossy_run *run, const rk_glossy_disk *disk, uint32_t count, bool agrees);

/* Four at a time, are they the features' to the bit, by many examples? Not with a student's
 * functions that are still wrong: these draw their own picture. */
bool rk_glossy_run_agrees(void);

#endif
