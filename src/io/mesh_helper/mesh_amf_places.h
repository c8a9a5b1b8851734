/* Where the constellations of an AMF file put their objects: Assimp 5.2 takes the rotations for
 * displacements. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_AMF_PLACES_H
#define RK_IO_MESH_HELPER_MESH_AMF_PLACES_H

#include "io/mesh_helper/mesh_syntax.h"

#include <assimp/scene.h>

/* Reads them into the hints. False when memory is short. */
bool rk_mesh_amf_places_read(rk_mesh_hints *hints, const char *path, const char *text, size_t size,
                             rk_error *error);

/* Places Assimp's nodes. */
void rk_mesh_amf_places_apply(const struct aiScene *scene, const rk_mesh_hints *hints);

#endif
