/* Looks through a mesh file before Assimp does, to say what is wrong and in which line: Assimp
 * accepts, drops or dies of much that a user would rather be told about. Part of raykit-mesh. */
#ifndef RK_IO_MESH_SCAN_H
#define RK_IO_MESH_SCAN_H

#include "base/error.h"

/* True when the file is there and nothing is found to be wrong with it; formats that have no
 * scanner here pass. False with an error `FILE: what` or `FILE:LINE: what`. `note` tells of what a
 * user should know but can be lived with, and is "" otherwise. */
bool rk_mesh_scan(const char *path, rk_error *note, rk_error *error);

/* One format each, over a file's bytes (no NUL at the end). */
bool rk_scan_obj(const char *path, const char *text, size_t size, rk_error *note, rk_error *error);
bool rk_scan_ply(const char *path, const char *text, size_t size, rk_error *error);
bool rk_scan_off(const char *path, const char *text, size_t size, rk_error *error);

#endif
