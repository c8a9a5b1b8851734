/* Looks through a mesh file before Assimp does, to say what is wrong and in which line: Assimp
 * accepts, drops or dies of much that a user would rather be told about. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_SYNTAX_H
#define RK_IO_MESH_HELPER_MESH_SYNTAX_H

#include "base/error.h"

/* What a scan learns besides. */
typedef struct rk_mesh_hints {
    bool plain;    /* no surface has a material, whatever grey Assimp invents */
    rk_error note; /* what a user should know but can live with; "" without */
} rk_mesh_hints;

/* True when the file is there and nothing is found to be wrong with it; formats that have no
 * scanner here pass. False with an error `FILE: what` or `FILE:LINE: what`. */
bool rk_mesh_syntax_check(const char *path, rk_mesh_hints *hints, rk_error *error);

/* One format each, over a file's bytes (no NUL at the end). */
bool rk_mesh_syntax_obj(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_ply(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);
bool rk_mesh_syntax_off(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);

#endif
