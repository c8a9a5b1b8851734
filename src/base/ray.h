/* A ray and its hit. */
#ifndef RK_BASE_RAY_H
#define RK_BASE_RAY_H

#include "base/vec3.h"

#include <stdint.h>

typedef struct rk_ray {
    rk_vec3 origin;
    rk_vec3 direction; /* any length; t is measured in multiples of it */
    float t_max;       /* hits count for 0 < t <= t_max */
} rk_ray;

#define RK_MISS UINT32_MAX

typedef struct rk_hit {
    float t;           /* the point is origin + t direction */
    float u, v;        /* barycentric: (1 - u - v) a + u b + v c */
    uint32_t triangle; /* index in the mesh, then in the scene's spheres; or RK_MISS */
} rk_hit;

#endif
