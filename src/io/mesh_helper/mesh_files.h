/* Files that a mesh names, found where people have them: beside the mesh or the material file that
 * names them, with quotes or backslashes, in other case of letters. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_FILES_H
#define RK_IO_MESH_HELPER_MESH_FILES_H

#include "base/error.h"

enum { RK_MESH_FILES_NAME = 1024 };

/* Writes to `found` the name, relative to the mesh's folder, of the regular file that `name` (not
 * NUL-terminated) means; `folder` is "" or the part of the name of another file up to its last
 * slash, beside which is looked. False if there is none. */
bool rk_mesh_files_find(char found[RK_MESH_FILES_NAME], const char *mesh_path, const char *folder,
                        const char *name, size_t length);

/* Turns each % with two hexadecimal digits into one character, in place. False if there is none. */
bool rk_mesh_files_unescape(char *name);

/* `ending` without its dot, in any case. */
bool rk_mesh_files_has_ending(const char *path, const char *ending);

/* Is the file, which was found so, another thing in its place? Then the error is a sentence without
 * its subject, "is a ...". */
bool rk_mesh_files_is_stand_in(const char *mesh_path, const char *found, rk_error *what);

#endif
