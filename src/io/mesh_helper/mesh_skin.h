/* Poses parts of a glTF file that have bones as their joints stand in the file, by linear blend
 * skinning. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_SKIN_H
#define RK_IO_MESH_HELPER_MESH_SKIN_H

#include "base/error.h"
#include "io/mesh_helper/mesh_place.h"

typedef struct rk_mesh_skin_joint {
    const char *name;
    rk_mesh_place place;
    bool is_unclear; /* another of this name stands elsewhere */
} rk_mesh_skin_joint;

typedef struct rk_mesh_skin {
    rk_mesh_skin_joint *joints; /* all nodes, by name; NULL if no part is to be posed */
    size_t count;
    bool is_told; /* of other formats, which say less clearly how a part moves */
    bool is_unposed;
    char lost[100]; /* the first joint by which a part could not be posed, or "" */
} rk_mesh_skin;

/* False when memory is short. */
bool rk_mesh_skin_begin(rk_mesh_skin *skin, const struct aiScene *scene, const char *path,
                        rk_error *error);
void rk_mesh_skin_end(rk_mesh_skin *skin);

/* Sets where each vertex of the part stands, to free(); or NULL if that is where its node puts it.
 * False when memory is short. */
bool rk_mesh_skin_pose(rk_mesh_skin *skin, const struct aiMesh *mesh, const rk_mesh_place *node,
                       rk_mesh_place **places, const char *path, rk_error *error);

#endif
