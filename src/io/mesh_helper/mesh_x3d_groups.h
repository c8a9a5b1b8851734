/* X3D names a node by DEF and shows it again by USE. Assimp 5.2 leaves one level too many after a
 * group with USE and after an empty one, and loses what follows; so a USE is replaced by what it
 * stands for, and an empty group is given a node. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_X3D_GROUPS_H
#define RK_IO_MESH_HELPER_MESH_X3D_GROUPS_H

#include "base/error.h"

#include <stddef.h>

/* `*mended` is a corrected copy, to be freed, or NULL if there are no such groups. */
bool rk_mesh_x3d_groups_mend(const char *path, const char *text, size_t size, char **mended,
                             size_t *mended_size, rk_error *error);

#endif
