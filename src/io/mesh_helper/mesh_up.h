/* The axis of a mesh that points up, where the format or the file names it. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_UP_H
#define RK_IO_MESH_HELPER_MESH_UP_H

#include "scene/mesh.h"

#include <assimp/scene.h>

/* Of a Collada file's text: the axis, 1 to 3 for x to z, or 0 if it names none. */
uint32_t rk_mesh_up_of_collada(const char *text, size_t size);

/* Sets mesh->up; `named` is what the file's text names. Turns the mesh if the axis points down. */
void rk_mesh_up_set(rk_mesh *mesh, const struct aiScene *scene, const char *path, uint32_t named);

#endif
