/* What colours alone have among vectors. */
#ifndef RK_BASE_COLOUR_H
#define RK_BASE_COLOUR_H

#include "base/vec3.h"

#include <stdbool.h>

/* Returns whether no channel has any light; false for NaN. */
static inline bool rk_is_black(rk_vec3 colour)
{
    return fabsf(colour.x) + fabsf(colour.y) + fabsf(colour.z) == 0;
}

#endif
