/* Colours of an OBJ file's vertices as ZBrush writes them: comments #MRGB, with eight hexadecimal
 * digits for each vertex, in the vertices' order: a mask, red, green, blue. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_OBJ_COLOURS_H
#define RK_IO_MESH_HELPER_MESH_OBJ_COLOURS_H

#include "base/error.h"

#include <stdint.h>

typedef struct rk_mesh_obj_colours {
    uint32_t *mrgb; /* or NULL */
    size_t count, room;
} rk_mesh_obj_colours;

/* Collects them; none is no error. False when memory is short. The caller frees `mrgb`. */
bool rk_mesh_obj_colours_find(rk_mesh_obj_colours *colours, const char *path, const char *text,
                              size_t size, rk_error *error);

#endif
