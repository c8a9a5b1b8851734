/* The material files that an OBJ file names. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_OBJ_LIBRARIES_H
#define RK_IO_MESH_HELPER_MESH_OBJ_LIBRARIES_H

#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"

typedef struct rk_mesh_obj_libraries {
    const char *path;
    rk_mesh_hints *hints;
    mesh_rewrite *rewrite; /* or NULL */
    bool renames;          /* one has another name than the file says */
    char lost[512];        /* one that is missing, or "" */
    size_t lost_line;
} rk_mesh_obj_libraries;

/* Reads the rest of a line after mtllib: a name, which may hold spaces, or several. */
void rk_mesh_obj_libraries_read(rk_mesh_obj_libraries *s, text_cursor *c, mesh_rewrite *rewrite);

/* Tells what is missing. */
void rk_mesh_obj_libraries_note(const rk_mesh_obj_libraries *s);

#endif
