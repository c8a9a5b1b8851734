/* Checks a mesh file before Assimp reads it, to report faults with their lines: Assimp accepts,
 * drops or crashes on many that a user should know about. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_SYNTAX_H
#define RK_IO_MESH_HELPER_MESH_SYNTAX_H

#include "base/error.h"

/* Further results of the check. */
typedef struct rk_mesh_hints {
    bool plain;    /* no surface has a material: Assimp's grey does not count */
    rk_error note; /* a warning for the user, or "" */
} rk_mesh_hints;

/* True if the file exists and no fault is found; formats without a checker here pass. False with an
 * error `FILE: what` or `FILE:LINE: what`. */
bool rk_mesh_syntax_check(const char *path, rk_mesh_hints *hints, rk_error *error);

/* Each checks one format, given the file's bytes (no NUL at the end). */
bool rk_mesh_syntax_obj(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_ply(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_off(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_glb(const char *path, const char *text, size_t size, rk_error *error);

#endif
