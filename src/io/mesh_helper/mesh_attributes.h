/* Normals, colours and texture coordinates of vertices that Assimp did not read. Part of
 * raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_ATTRIBUTES_H
#define RK_IO_MESH_HELPER_MESH_ATTRIBUTES_H

#include "io/mesh_helper/mesh_syntax.h"

#include <assimp/scene.h>

/* Lets the scene's only mesh use the hints' arrays, if it has their vertices. Assimp must not free
 * them. */
void rk_mesh_attributes_lend(const struct aiScene *scene, const rk_mesh_hints *hints);

#endif
