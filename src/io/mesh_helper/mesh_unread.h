/* Formats that no reader here knows, with what to do instead. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_UNREAD_H
#define RK_IO_MESH_HELPER_MESH_UNREAD_H

#include "base/error.h"

#include <stddef.h>

/* False if the name's ending is one of theirs. The file's bytes tell the kinds of VRML. */
bool rk_mesh_unread_check(const char *path, const char *text, size_t size, rk_error *error);

#endif
