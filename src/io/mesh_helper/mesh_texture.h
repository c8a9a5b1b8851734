/* The diffuse textures of materials. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_TEXTURE_H
#define RK_IO_MESH_HELPER_MESH_TEXTURE_H

#include "base/error.h"
#include "io/mesh_helper/mesh_mtl.h"

#include <assimp/scene.h>
#include <stdint.h>

typedef struct rk_mesh_texture {
    struct aiString name; /* as in the mesh file, without trailing blanks */
    const unsigned char
        *data; /* the scene's, if the picture is embedded in the mesh file; else NULL */
    uint32_t data_size;
    bool clamps;
} rk_mesh_texture;

typedef struct rk_mesh_textures {
    uint32_t count;
    rk_mesh_texture *entries;
    uint32_t *of_material;       /* each material's entry plus 1; 0: none */
    uint32_t *alpha_of_material; /* the same for its opacity; the same entry: its alpha channel */
    bool too_many;               /* only the first RK_MESH_STREAM_TEXTURES_MAX are kept */
} rk_mesh_textures;

/* Allocates the textures of `material_count` materials, which have none so far. */
bool rk_mesh_textures_init(rk_mesh_textures *textures, uint32_t material_count, const char *path,
                           rk_error *error);
void rk_mesh_textures_free(rk_mesh_textures *textures);

/* Sets the textures of our material `number` to those that the scene's material names: its colour
 * is map_Kd in MTL, the base colour in glTF; its opacity is map_d in MTL, or else the alpha channel
 * of its colour, which glTF may forbid, and LightWave does. Materials that name the same picture
 * share one entry. */
void rk_mesh_textures_find(rk_mesh_textures *textures, uint32_t number, const struct aiScene *scene,
                           const struct aiMaterial *material, const char *path);

/* From a file's texture coordinates to those of its picture: u' = m[0][0] u + m[0][1] v + m[0][2],
 * and v' by m[1]. */
typedef struct rk_mesh_texture_transform {
    double m[2][3];
} rk_mesh_texture_transform;

/* Returns the transform of the material's picture: KHR_texture_transform in glTF, scale and offset
 * in other formats. `mtl`: what Assimp leaves out of an MTL file, or NULL. */
rk_mesh_texture_transform rk_mesh_texture_transform_of(const struct aiMaterial *material,
                                                       const rk_mesh_mtl_material *mtl);

/* Does the material name a picture? `set` is then the set of texture coordinates that it uses: 0
 * except in glTF and Collada, whose channels Assimp may count from 1. */
bool rk_mesh_texture_set(const struct aiMaterial *material, uint32_t *set);

/* Does its picture continue in a way that is not drawn: mirrored, or differently in u and v? */
bool rk_mesh_texture_wraps_otherwise(const struct aiMaterial *material);

#endif
