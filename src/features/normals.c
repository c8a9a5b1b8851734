/* The colour of a normal, and the normal of a triangle.
 * Two pure functions, in the order of the chapter and of the assignment's steps. */
#include "features/normals.h"

rk_vec3 rk_normals_colour(rk_vec3 n)
{
    /* solution */
    return rk_vec(0.5f + 0.5f * n.x, 0.5f + 0.5f * n.y, 0.5f + 0.5f * n.z);
    /* starter
    // First step: x becomes red, y green, z blue. For now what faces the camera is white.
    float grey = 0.5f - 0.5f * n.z;
    return rk_vec(grey, grey, grey);
    end */
}

rk_vec3 rk_normals_of_triangle(rk_vec3 a, rk_vec3 b, rk_vec3 c)
{
    /* solution */
    return rk_normalize(rk_cross(rk_sub(b, a), rk_sub(c, a)));
    /* starter
    // Second step: at right angles to two edges, and of length 1. For now it points from the
    // origin to corner a.
    return rk_normalize(a);
    end */
}
