/* Fog: say here in a line what it does to a picture.
 *
 *   L' = L     then the formulas, in the symbols of the chapter
 *
 * Then the source that they follow: a book's section, a paper, a page. */
#ifndef RK_FEATURES_FOG_H
#define RK_FEATURES_FOG_H

#include "base/vec3.h"

typedef struct rk_fog_options {
    float strength; /* 0, the default, changes nothing; up to 1 */
} rk_fog_options;

/* Returns L'; to the bit L for a strength of 0. */
rk_vec3 rk_fog_colour(rk_vec3 colour, float strength);

#endif
