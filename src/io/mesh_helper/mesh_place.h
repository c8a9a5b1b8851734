/* Where a node puts its parts. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_PLACE_H
#define RK_IO_MESH_HELPER_MESH_PLACE_H

#include "base/vec3.h"

#include <assimp/scene.h>
#include <stdbool.h>

/* Row-major 3 x 4: from a part's coordinates to the world's. */
typedef struct rk_mesh_place {
    double m[3][4];
    bool is_identity; /* then coordinates are kept to the bit */
} rk_mesh_place;

rk_mesh_place rk_mesh_place_in(const rk_mesh_place *parent, const struct aiMatrix4x4 *t);

rk_vec3 rk_mesh_place_point(const rk_mesh_place *p, rk_vec3 v);

/* Makes it a unit vector. False for a vector without direction. */
bool rk_mesh_place_normal(const rk_mesh_place *p, const struct aiVector3D *n, rk_vec3 *moved);

/* A face without area has no normal and is never hit: any unit vector will do. */
rk_vec3 rk_mesh_place_face_normal(rk_vec3 a, rk_vec3 b, rk_vec3 c);

#endif
