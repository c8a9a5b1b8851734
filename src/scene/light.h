/* Lights: a point, a segment, or a parallelogram that shines to both of its sides. */
#ifndef RK_SCENE_LIGHT_H
#define RK_SCENE_LIGHT_H

#include "base/vec3.h"

typedef enum rk_light_kind {
    RK_LIGHT_POINT,
    RK_LIGHT_SEGMENT,
    RK_LIGHT_PARALLELOGRAM
} rk_light_kind;

/* A point of the light stands at position + x edge01 + y edge02, x and y in [0, 1]; its colour is
 * linear RGB, bilinear in x and y between the corners' colours. A segment has no y, a point
 * neither; what they do not have is not read. */
typedef struct rk_light {
    rk_light_kind kind;
    rk_vec3 position;       /* corner 0 */
    rk_vec3 edge01, edge02; /* from corner 0 to corners 1 and 2 */
    rk_vec3 colours[4];     /* of corners 0, 1, 2, and 3, which is opposite to 0 */
} rk_light;

static inline rk_light rk_light_point(rk_vec3 position, rk_vec3 colour)
{
    return (rk_light){.kind = RK_LIGHT_POINT, .position = position, .colours = {colour}};
}

#endif
