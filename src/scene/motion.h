/* Moving objects: a part of the mesh, and its path. */
#ifndef RK_SCENE_MOTION_H
#define RK_SCENE_MOTION_H

#include <stdint.h>

/* The path of the classic course. At time x the object is translated by (x, y, 0) from its position
 * at rest, y = a x^3 + b x^2 + c x; at x = 0 it is at rest. */
typedef struct rk_motion {
    float a, b, c;
} rk_motion;

/* Triangles first .. first + count - 1 of the mesh, moving together. */
typedef struct rk_moving {
    uint32_t first, count;
    rk_motion motion;
} rk_moving;

#endif
