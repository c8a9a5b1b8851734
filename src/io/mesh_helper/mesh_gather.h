/* Makes one mesh of everything that Assimp read from a file. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_GATHER_H
#define RK_IO_MESH_HELPER_MESH_GATHER_H

#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/mesh_texture.h"
#include "scene/mesh.h"

#include <assimp/scene.h>

/* Emits each part once per node of the scene's tree that refers to it, with that node's transform;
 * polygons are triangulated, points and lines dropped, equal vertices joined, unused vertices and
 * materials left out. A part without normals gets its face normals if another part has normals.
 * What the file has and the mesh has not is added to the hints' note. hints->plain: give every
 * surface the default material, white where it has a texture. False with an error that begins with
 * `path` and names the part. */
bool rk_mesh_gather(rk_mesh *mesh, rk_mesh_textures *textures, const struct aiScene *scene,
                    const char *path, rk_mesh_hints *hints, rk_error *error);

#endif
