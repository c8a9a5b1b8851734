/* Converts Assimp's material properties to rk_material. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_MATERIAL_H
#define RK_IO_MESH_HELPER_MESH_MATERIAL_H

#include "scene/mesh.h"

#include <assimp/material.h>

/* MTL: Kd, Ks, Ns, and d or Tr. glTF: the base colour, or the diffuse
 * colour of specular-glossiness, with its alpha if alphaMode is BLEND or
 * MASK, and the cutoff of MASK. The grey that Assimp gives surfaces without a material becomes
 * rk_mesh_init's default. Colours are clamped to [0, 1]; where the colour `varies`, by a texture or
 * by colours of vertices, a material without Kd does not darken it by Assimp's grey. Values that
 * are not finite are kept, for rk_mesh_validate to refuse. `is_encoded`: the diffuse colour is in
 * sRGB, as 3MF's. */
rk_material rk_mesh_material(const struct aiMaterial *material, bool varies, bool is_encoded);

#endif
