/* The set of texture coordinates that KHR_texture_transform names, which replaces the texture's.
 * Assimp does not read it. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_GLTF_SETS_H
#define RK_IO_MESH_HELPER_MESH_GLTF_SETS_H

#include <stdbool.h>
#include <stddef.h>

/* Copies the file (.gltf, or .glb of version 2) with the set written as the texture's own to
 * free(). `*changed` is NULL if there is nothing to write, or if false is returned because memory
 * is short. */
bool rk_mesh_gltf_sets_mend(const char *text, size_t size, char **changed, size_t *changed_size);

#endif
