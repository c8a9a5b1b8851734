/* Names of a PLY file's properties that mean what Assimp knows by other ones. Part of raykit-mesh.
 */
#ifndef RK_IO_MESH_HELPER_MESH_PLY_NAMES_H
#define RK_IO_MESH_HELPER_MESH_PLY_NAMES_H

#include <stdbool.h>
#include <stddef.h>

/* Copies the file with the usual names and blanks, if it has others, to free(). `*changed` is NULL
 * if it has none, or if false is returned because memory is short. */
bool rk_mesh_ply_names_mend(const char *text, size_t size, char **changed, size_t *changed_size);

#endif
