/* A picture that lacks what the file has is wrong without a word; one sentence per file is enough.
 */
#include "io/mesh_helper/mesh_left_out.h"

#include <assimp/GltfMaterial.h>
#include <stdio.h>
#include <string.h>

static const char *const names[RK_MESH_LEFT_OUT_COUNT] = {
    [RK_MESH_LEFT_OUT_POINTS] = "points or lines",
    [RK_MESH_LEFT_OUT_BUMPS] = "bump or normal maps",
    [RK_MESH_LEFT_OUT_EMISSION] = "surfaces that emit light",
    [RK_MESH_LEFT_OUT_GLOSS] = "pictures of metalness, roughness, highlights or ambient light",
    [RK_MESH_LEFT_OUT_PICTURES] = "pictures without compression inside the file",
    [RK_MESH_LEFT_OUT_UNPLACED] = "pictures on parts without texture coordinates",
    [RK_MESH_LEFT_OUT_WRAPS] = "pictures that are mirrored or repeat in one direction only",
    [RK_MESH_LEFT_OUT_HIDDEN_COLOURS] = "colours of vertices where there are pictures",
    [RK_MESH_LEFT_OUT_TORN_COLOURS] = "colours of only some vertices",
    [RK_MESH_LEFT_OUT_CLEAR_COLOURS] = "transparent colours of vertices",
    [RK_MESH_LEFT_OUT_ANIMATION] = "animation",
    [RK_MESH_LEFT_OUT_CAMERAS] = "cameras",
    [RK_MESH_LEFT_OUT_LIGHTS] = "lights",
};

static bool has_points(const struct aiMesh *mesh)
{
    return mesh->mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE);
}

void rk_mesh_left_out_of_scene(rk_mesh_left_out *left, const struct aiScene *scene, bool pictures)
{
    for (uint32_t i = 0; i < scene->mNumMeshes; i++)
        left->has[RK_MESH_LEFT_OUT_POINTS] |= has_points(scene->mMeshes[i]);
    left->has[RK_MESH_LEFT_OUT_ANIMATION] |= scene->mNumAnimations > 0;
    left->has[RK_MESH_LEFT_OUT_CAMERAS] |= scene->mNumCameras > 0;
    left->has[RK_MESH_LEFT_OUT_LIGHTS] |= scene->mNumLights > 0;
    for (uint32_t i = 0; pictures && i < scene->mNumTextures; i++)
        left->has[RK_MESH_LEFT_OUT_PICTURES] |= scene->mTextures[i]->mHeight > 0;
}

static bool has_picture(const struct aiMaterial *material, const enum aiTextureType *types)
{
    for (; *types != aiTextureType_NONE; types++)
        if (aiGetMaterialTextureCount(material, *types) > 0)
            return true;
    return false;
}

static bool emits(const struct aiMaterial *material)
{
    static const enum aiTextureType maps[] = {aiTextureType_EMISSIVE, aiTextureType_EMISSION_COLOR,
                                              aiTextureType_NONE};
    struct aiColor4D c = {0, 0, 0, 1};
    struct aiString mode;
    aiGetMaterialColor(material, AI_MATKEY_COLOR_EMISSIVE, &c);
    const bool multiplies = /* the picture, in glTF */
        aiGetMaterialString(material, AI_MATKEY_GLTF_ALPHAMODE, &mode) == aiReturn_SUCCESS;
    return c.r > 0 || c.g > 0 || c.b > 0 || (!multiplies && has_picture(material, maps));
}

void rk_mesh_left_out_of_material(rk_mesh_left_out *left, const struct aiMaterial *material)
{
    static const enum aiTextureType bumps[] = {aiTextureType_HEIGHT, aiTextureType_NORMALS,
                                               aiTextureType_NORMAL_CAMERA,
                                               aiTextureType_DISPLACEMENT, aiTextureType_NONE};
    static const enum aiTextureType gloss[] = {
        aiTextureType_SPECULAR,          aiTextureType_SHININESS, aiTextureType_METALNESS,
        aiTextureType_DIFFUSE_ROUGHNESS, aiTextureType_AMBIENT,   aiTextureType_AMBIENT_OCCLUSION,
        aiTextureType_LIGHTMAP,          aiTextureType_NONE};
    left->has[RK_MESH_LEFT_OUT_BUMPS] |= has_picture(material, bumps);
    left->has[RK_MESH_LEFT_OUT_GLOSS] |= has_picture(material, gloss);
    left->has[RK_MESH_LEFT_OUT_EMISSION] |= emits(material);
}

void rk_mesh_left_out_tell(const rk_mesh_left_out *left, const char *path, rk_mesh_hints *hints)
{
    char list[600] = "";
    int count = 0, told = 0;
    for (int i = 0; i < RK_MESH_LEFT_OUT_COUNT; i++)
        count += left->has[i];
    for (int i = 0; i < RK_MESH_LEFT_OUT_COUNT; i++) {
        if (!left->has[i])
            continue;
        const size_t length = strlen(list);
        told++;
        snprintf(list + length, sizeof list - length, "%s%s",
                 told == 1       ? ""
                 : told == count ? " and "
                                 : ", ",
                 names[i]);
    }
    if (count > 0)
        rk_mesh_hints_note(hints, path, "has %s, which the picture does not show", list);
}
