/* The files that Assimp opens: the mesh, and those that it names. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_IO_H
#define RK_IO_MESH_HELPER_MESH_IO_H

#include <assimp/cfileio.h>
#include <stddef.h>

/* Opens regular files only, because a pipe or a device may never end; others are as missing. Skips
 * a byte order mark before OBJ, MTL and PLY, which Assimp would take for a part of the first line.
 */
extern struct aiFileIO rk_mesh_io;

/* From now on, reading the file of this path gives these bytes, which must outlive it. */
void rk_mesh_io_replace(const char *path, char *text, size_t size);

enum { RK_MESH_IO_MTLS = 16 }; /* further ones are not known */

/* Returns the path of the MTL file that was opened as number `i`, from 0 on, or NULL. */
const char *rk_mesh_io_mtl(int i);

#endif
