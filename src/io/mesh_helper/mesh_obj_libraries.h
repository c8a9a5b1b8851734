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
    char lost[512];        /* those of the first line of which some are missing, or "" */
    size_t lost_line;
    char stand_in[512];  /* the first that is none, and what it is; or "" */
    bool any;            /* some line names one */
    char material[64];   /* the first that is used, or "" */
    bool begins_without; /* faces precede it */
} rk_mesh_obj_libraries;

/* Reads the rest of a line after mtllib: a name, which may hold spaces, or several. */
void rk_mesh_obj_libraries_read(rk_mesh_obj_libraries *s, text_cursor *c, mesh_rewrite *rewrite);

/* Reads the rest of a line after usemtl. */
void rk_mesh_obj_libraries_use(rk_mesh_obj_libraries *s, const text_cursor *c, bool has_faces);

/* Before the first face, if it has no material, writes that it has none. */
void rk_mesh_obj_libraries_before_face(rk_mesh_obj_libraries *s, const char *line,
                                       mesh_rewrite *rewrite);

/* Of faces before the first usemtl, which Assimp would give a later material. */
#define RK_MESH_OBJ_NO_MATERIAL "no material"

/* That, or as programs write it that have no material. */
bool rk_mesh_obj_libraries_means_none(const char *material);

/* Tells what is missing; `coloured` vertices do without materials. */
void rk_mesh_obj_libraries_note(const rk_mesh_obj_libraries *s, bool coloured);

#endif
