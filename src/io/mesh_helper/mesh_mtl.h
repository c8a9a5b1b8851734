/* What Assimp leaves out of MTL files. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_MTL_H
#define RK_IO_MESH_HELPER_MESH_MTL_H

#include "base/error.h"

#include <stdint.h>
#include <stdio.h>

typedef struct rk_mesh_mtl_material {
    char name[256];
    float scale[2], offset[2]; /* of the texture coordinates, by map_Kd -s and -o */
    bool is_tr_one;            /* Tr 1 and no d: some exporters mean opaque */
} rk_mesh_mtl_material;

typedef struct rk_mesh_mtl {
    uint32_t count, room;
    rk_mesh_mtl_material *materials;
} rk_mesh_mtl;

/* Reads the MTL files that Assimp has opened (io/mesh_helper/mesh_io.h). False when memory is
 * short. */
bool rk_mesh_mtl_read(rk_mesh_mtl *mtl, rk_error *error);
void rk_mesh_mtl_free(rk_mesh_mtl *mtl);

/* Copies the lines of an MTL file that Assimp understands into `text`, to free(): it refuses a file
 * for one other line, such as aniso, which Blender writes. False when memory is short. */
bool rk_mesh_mtl_copy_known(FILE *file, char **text, size_t *size);

/* Returns the first material of that name, as Assimp does, or NULL. */
const rk_mesh_mtl_material *rk_mesh_mtl_find(const rk_mesh_mtl *mtl, const char *name);

/* Returns the first material whose name is that and a comment, or NULL; NULL also if one has the
 * name alone. */
const rk_mesh_mtl_material *rk_mesh_mtl_find_commented(const rk_mesh_mtl *mtl, const char *name);

#endif
