/* Mesh files (OBJ with MTL, PLY, OFF, glTF and what else Assimp reads). */
#ifndef RK_IO_MESH_FILE_H
#define RK_IO_MESH_FILE_H

#include "scene/mesh.h"

/* Reads and validates a mesh, polygons cut into triangles, all its parts merged. False with an
 * error that names the file and the place when it is missing, empty, truncated or malformed. */
bool rk_mesh_read(rk_mesh *mesh, const char *path, rk_error *error);

#endif
