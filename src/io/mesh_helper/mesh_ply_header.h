/* The header of a PLY file as Assimp understands it. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_PLY_HEADER_H
#define RK_IO_MESH_HELPER_MESH_PLY_HEADER_H

#include "io/mesh_helper/mesh_syntax.h"

/* Assimp wants the format in the second line, ends an element at a comment, and takes a line feed
 * that is the first byte of the rows for an end of the header, unless the header's last line ends
 * in a carriage return and a line feed. If one of these is so, the corrected text of the hints,
 * which it replaces, or of the file gets another header. `rows` is its length, which is that of
 * the file's. Elements other than vertices and faces are left out of it if the rows are without
 * them (`drops_foreign`). False when memory is short. */
bool rk_mesh_ply_header_mend(rk_mesh_hints *hints, const char *text, size_t size, size_t rows,
                             bool has_misplaced_remark, bool begins_with_feed, bool drops_foreign);

#endif
