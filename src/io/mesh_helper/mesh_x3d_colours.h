/* What pictures of X3D files do to the diffuse colour. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_X3D_COLOURS_H
#define RK_IO_MESH_HELPER_MESH_X3D_COLOURS_H

#include "io/mesh_helper/mesh_texture.h"

#include "scene/mesh.h"

/* Makes the diffuse colours white that pictures replace. The pictures' names are those of files. */
void rk_mesh_x3d_colours_replace(rk_mesh *mesh, const rk_mesh_textures *textures, const char *path);

#endif
