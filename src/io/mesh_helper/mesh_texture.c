/* A table of different pictures, so that each is sent and read once, however many materials name
 * it. */
#include "io/mesh_helper/mesh_texture.h"

#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_stream.h"

#include <assimp/GltfMaterial.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool rk_mesh_textures_init(rk_mesh_textures *textures, uint32_t material_count, const char *path,
                           rk_error *error)
{
    *textures = (rk_mesh_textures){0};
    textures->of_material = rk_allocate(material_count, sizeof(uint32_t), path, error);
    textures->alpha_of_material = rk_allocate(material_count, sizeof(uint32_t), path, error);
    textures->entries =
        rk_allocate_unset(RK_MESH_STREAM_TEXTURES_MAX, sizeof *textures->entries, path, error);
    if (textures->of_material && textures->alpha_of_material && textures->entries)
        return true;
    rk_mesh_textures_free(textures);
    return false;
}

void rk_mesh_textures_free(rk_mesh_textures *textures)
{
    free(textures->entries);
    free(textures->of_material);
    free(textures->alpha_of_material);
    *textures = (rk_mesh_textures){0};
}

typedef struct named_picture {
    struct aiString name;
    unsigned set;
    enum aiTextureMapMode modes[2];
    enum aiTextureType type;
} named_picture;

/* Assimp's own is for MD2 files without a skin, and those of other games. */
static bool is_made_up(const char *name)
{
    return strncmp(name, RK_MESH_NO_PICTURE, sizeof RK_MESH_NO_PICTURE - 1) == 0 ||
           strcmp(name, "$texture_dummy.bmp") == 0;
}

static bool find_typed(const struct aiMaterial *material, enum aiTextureType type,
                       named_picture *found)
{
    *found = (named_picture){.modes = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap}, .type = type};
    return aiGetMaterialTexture(material, type, 0, &found->name, NULL, &found->set, NULL, NULL,
                                found->modes, NULL) == aiReturn_SUCCESS &&
           found->name.length > 0 && !is_made_up(found->name.data);
}

/* Assimp calls it diffuse; in some formats it is called base colour, or both. */
static bool find_picture(const struct aiMaterial *material, named_picture *found)
{
    return find_typed(material, aiTextureType_DIFFUSE, found) ||
           find_typed(material, aiTextureType_BASE_COLOR, found);
}

/* Without its folders, in the spelling of any system. */
static const char *base_name(const char *name)
{
    for (const char *c = name; *c; c++)
        if (*c == '/' || *c == '\\')
            name = c + 1;
    return name;
}

/* The whole name decides before its last part. */
static const struct aiTexture *find_by_name(const struct aiScene *scene, const char *name)
{
    const char *base = base_name(name);
    const struct aiTexture *found = NULL;
    for (unsigned i = scene->mNumTextures; i-- > 0;) {
        const char *other = scene->mTextures[i]->mFilename.data;
        if (strcmp(other, name) == 0)
            return scene->mTextures[i];
        if (*base && strcmp(base_name(other), base) == 0)
            found = scene->mTextures[i];
    }
    return found;
}

/* An embedded picture is named "*" and its number, or in FBX by its file. Uncompressed ones (with a
 * height), which only a few games' models have, are in no format that raykit-image reads. */
static const struct aiTexture *find_embedded(const struct aiScene *scene, const char *name)
{
    char *end;
    const struct aiTexture *found = NULL;
    const unsigned long number = name[0] == '*' ? strtoul(name + 1, &end, 10) : 0;
    if (name[0] != '*')
        found = find_by_name(scene, name);
    else if (number < scene->mNumTextures && *end == '\0')
        found = scene->mTextures[number];
    return found && found->mHeight == 0 ? found : NULL;
}

static rk_mesh_texture make_entry(const struct aiScene *scene, const named_picture *picture)
{
    rk_mesh_texture entry = {.clamps = picture->modes[0] == aiTextureMapMode_Clamp &&
                                       picture->modes[1] == aiTextureMapMode_Clamp};
    char *name = entry.name.data;
    size_t length = strnlen(picture->name.data, sizeof entry.name.data - 1);
    memcpy(name, picture->name.data, length);
    while (length > 0 && strchr(" \t\r", name[length - 1]))
        name[--length] = '\0';
    entry.name.length = (ai_uint32)length;
    const struct aiTexture *embedded = find_embedded(scene, name);
    if (embedded) {
        entry.data = (const unsigned char *)embedded->pcData;
        entry.data_size = embedded->mWidth;
    }
    return entry;
}

static bool is_same(const rk_mesh_texture *a, const rk_mesh_texture *b)
{
    return a->clamps == b->clamps && strcmp(a->name.data, b->name.data) == 0;
}

/* Returns the entry's number plus 1, or 0. */
static uint32_t add_entry(rk_mesh_textures *textures, const struct aiScene *scene,
                          const named_picture *picture)
{
    rk_mesh_texture entry = make_entry(scene, picture);
    if (entry.name.length == 0)
        return 0;
    uint32_t i = 0;
    while (i < textures->count && !is_same(&textures->entries[i], &entry))
        i++;
    if (i == RK_MESH_STREAM_TEXTURES_MAX) {
        textures->too_many = true;
        return 0;
    }
    if (i == textures->count)
        textures->entries[textures->count++] = entry;
    return i + 1;
}

/* The default of glTF is OPAQUE, which ignores the alpha channel; others have no such word. In
 * LightWave it lets the surface's colour show, and holes have a picture of their own. */
static bool uses_alpha(const struct aiMaterial *material, const char *path)
{
    struct aiString mode;
    if (rk_mesh_files_has_ending(path, "lwo") || rk_mesh_files_has_ending(path, "lws"))
        return false;
    return aiGetMaterialString(material, AI_MATKEY_GLTF_ALPHAMODE, &mode) != aiReturn_SUCCESS ||
           strcmp(mode.data, "OPAQUE") != 0;
}

void rk_mesh_textures_find(rk_mesh_textures *textures, uint32_t number, const struct aiScene *scene,
                           const struct aiMaterial *material, const char *path)
{
    named_picture picture;
    if (find_picture(material, &picture))
        textures->of_material[number] = add_entry(textures, scene, &picture);
    if (uses_alpha(material, path))
        textures->alpha_of_material[number] = textures->of_material[number];
    if (find_typed(material, aiTextureType_OPACITY, &picture))
        textures->alpha_of_material[number] = add_entry(textures, scene, &picture);
}

/* glTF turns, after scaling, about the picture's top left corner, v down, and Assimp has changed
 * the offset as if it turned about the centre; this takes the change back. The sense of the turn is
 * that of Khronos's sample viewer. */
static rk_mesh_texture_transform transform_of_gltf(const struct aiUVTransform *t)
{
    const double c = cos((double)-t->mRotation), s = sin((double)-t->mRotation);
    const double x = (double)t->mScaling.x, y = (double)t->mScaling.y;
    const double offset_u = (double)t->mTranslation.x - 0.5 * x * (1 - c + s);
    const double offset_v = 0.5 * y * (s + c - 1) + 1 - y - (double)t->mTranslation.y;
    return (rk_mesh_texture_transform){
        {{c * x, -s * y, offset_u + s * y}, {s * x, c * y, 1 - offset_v - c * y}}};
}

static rk_mesh_texture_transform scale_and_offset(double x, double y, double u, double v)
{
    return (rk_mesh_texture_transform){{{x, 0, u}, {0, y, v}}};
}

rk_mesh_texture_transform rk_mesh_texture_transform_of(const struct aiMaterial *material,
                                                       const rk_mesh_mtl_material *mtl)
{
    named_picture picture;
    struct aiUVTransform t = {.mScaling = {1, 1}};
    if (mtl)
        return scale_and_offset((double)mtl->scale[0], (double)mtl->scale[1],
                                (double)mtl->offset[0], (double)mtl->offset[1]);
    if (!find_picture(material, &picture) ||
        aiGetMaterialUVTransform(material, AI_MATKEY_UVTRANSFORM(picture.type, 0), &t) !=
            aiReturn_SUCCESS)
        return scale_and_offset(1, 1, 0, 0);
    struct aiString mode;
    if (aiGetMaterialString(material, AI_MATKEY_GLTF_ALPHAMODE, &mode) == aiReturn_SUCCESS)
        return transform_of_gltf(&t);
    return scale_and_offset((double)t.mScaling.x, (double)t.mScaling.y, (double)t.mTranslation.x,
                            (double)t.mTranslation.y);
}

bool rk_mesh_texture_set(const struct aiMaterial *material, uint32_t *set)
{
    named_picture picture;
    if (!find_picture(material, &picture))
        return false;
    *set = picture.set < AI_MAX_NUMBER_OF_TEXTURECOORDS ? picture.set : 0;
    return true;
}

bool rk_mesh_texture_wraps_otherwise(const struct aiMaterial *material)
{
    named_picture picture;
    return find_picture(material, &picture) &&
           (picture.modes[0] != picture.modes[1] || picture.modes[0] == aiTextureMapMode_Mirror);
}
