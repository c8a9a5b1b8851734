/* Makes one mesh of all that Assimp found in a file. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_GATHER_H
#define RK_IO_MESH_HELPER_MESH_GATHER_H

#include "io/mesh_helper/mesh_texture.h"
#include "scene/mesh.h"

#include <assimp/scene.h>

/* Every part at every place where the scene's tree of nodes puts it, with that node's transform;
 * polygons cut, points and lines dropped, equal vertices joined, unused ones and unused materials
 * left out. A part without normals gets its faces' own when another part has some. `plain`: give
 * every surface the one default material, white where it has a texture. False with an error that
 * begins with `path` and names the part. */
bool rk_mesh_gather(rk_mesh *mesh, rk_mesh_textures *textures, const struct aiScene *scene,
                    bool plain, const char *path, rk_error *error);

#endif
