/* Common to all builders of binary trees: the record that represents a triangle while they sort,
 * and the copy that a leaf keeps. */
#ifndef RK_SCENE_BVH_BUILD_H
#define RK_SCENE_BVH_BUILD_H

#include "scene/bvh.h"

/* Represents a triangle during the build. */
typedef struct rk_bvh_reference {
    rk_box box;
    rk_vec3 centroid; /* the mean of the corners; finite, because they are */
    uint32_t triangle;
} rk_bvh_reference;

static inline rk_bvh_reference rk_bvh_reference_of(const rk_mesh *mesh, uint32_t triangle)
{
    /* Rounded down: neither a third of the largest float nor the sum of three such thirds
     * overflows. */
    const float third = 0x1.555554p-2f;
    const uint32_t *corner = mesh->triangles[triangle];
    rk_vec3 a = mesh->positions[corner[0]];
    rk_vec3 b = mesh->positions[corner[1]];
    rk_vec3 c = mesh->positions[corner[2]];
    return (rk_bvh_reference){
        .box = {{rk_min3(a, rk_min3(b, c)), rk_max3(a, rk_max3(b, c))}},
        .centroid = rk_madd(rk_madd(rk_scale(a, third), b, third), c, third),
        .triangle = triangle,
    };
}

/* A leaf's copy of a triangle of the mesh. */
static inline rk_triangle rk_bvh_triangle_of(const rk_mesh *mesh, uint32_t triangle)
{
    const uint32_t *corner = mesh->triangles[triangle];
    return (rk_triangle){mesh->positions[corner[0]], mesh->positions[corner[1]],
                         mesh->positions[corner[2]], triangle};
}

#endif
