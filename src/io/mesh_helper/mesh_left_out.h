/* Tells the user what a file has and the picture does not show. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_LEFT_OUT_H
#define RK_IO_MESH_HELPER_MESH_LEFT_OUT_H

#include "io/mesh_helper/mesh_syntax.h"

#include <assimp/scene.h>

/* What a file may have, in the order in which it is told. */
typedef enum rk_mesh_left_out_kind {
    RK_MESH_LEFT_OUT_POINTS,
    RK_MESH_LEFT_OUT_BUMPS,
    RK_MESH_LEFT_OUT_EMISSION,
    RK_MESH_LEFT_OUT_GLOSS,
    RK_MESH_LEFT_OUT_PICTURES,
    RK_MESH_LEFT_OUT_UNPLACED,
    RK_MESH_LEFT_OUT_WRAPS,
    RK_MESH_LEFT_OUT_HIDDEN_COLOURS,
    RK_MESH_LEFT_OUT_TORN_COLOURS,
    RK_MESH_LEFT_OUT_CLEAR_COLOURS,
    RK_MESH_LEFT_OUT_ANIMATION,
    RK_MESH_LEFT_OUT_CAMERAS,
    RK_MESH_LEFT_OUT_LIGHTS,
    RK_MESH_LEFT_OUT_COUNT
} rk_mesh_left_out_kind;

typedef struct rk_mesh_left_out {
    bool has[RK_MESH_LEFT_OUT_COUNT];
} rk_mesh_left_out;

/* Looks at the scene without its materials, and at a material that is in use. */
void rk_mesh_left_out_of_scene(rk_mesh_left_out *left, const struct aiScene *scene, bool pictures);
void rk_mesh_left_out_of_material(rk_mesh_left_out *left, const struct aiMaterial *material);

/* Adds one sentence to the note if anything is left out. */
void rk_mesh_left_out_tell(const rk_mesh_left_out *left, const char *path, rk_mesh_hints *hints);

#endif
