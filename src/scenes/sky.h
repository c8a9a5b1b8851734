/* The built-in sky, for environments without a file: blue above, bright at the horizon, dark ground
 * below, and a sun in the direction of the default light. */
#ifndef RK_SCENES_SKY_H
#define RK_SCENES_SKY_H

#include "scene/environment.h"

/* Returns the sky's linear colour in a direction of any length but 0; continuous, and smooth except
 * at the sun's edge and the horizon. Ground and sky are at most 1, the sun is 30. */
rk_vec3 rk_sky_at(rk_vec3 direction);

/* Makes a map of the sky: each texel has the colour at its centre. */
bool rk_sky_make(rk_cubemap *map, uint32_t side, rk_error *error);

#endif
