/* Formats differ: glTF has a base colour, others have diffuse and specular colours with a
 * shininess. Values that Assimp made up are told from those of the file where that is possible. */
#include "io/mesh_helper/mesh_material.h"

#include "base/image.h"

#include <assimp/GltfMaterial.h>
#include <string.h>

/* NaN is kept: both comparisons are false. */
static float clamp_fraction(float v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

static bool read_colour(const struct aiMaterial *material, const char *key, unsigned type,
                        unsigned index, rk_vec3 *colour, float *alpha)
{
    struct aiColor4D c = {0, 0, 0, 1};
    if (aiGetMaterialColor(material, key, type, index, &c) != aiReturn_SUCCESS)
        return false;
    *colour = rk_vec(clamp_fraction(c.r), clamp_fraction(c.g), clamp_fraction(c.b));
    *alpha = clamp_fraction(c.a);
    return true;
}

static bool has_text(const struct aiMaterial *material, const char *key, unsigned type,
                     unsigned index, const char *text)
{
    struct aiString string;
    return aiGetMaterialString(material, key, type, index, &string) == aiReturn_SUCCESS &&
           strcmp(string.data, text) == 0;
}

/* Assimp's grey where the file gives no diffuse colour. A file that gives just this grey cannot be
 * told apart, but that is rarer with a texture than no colour. */
static bool is_made_up(rk_vec3 kd)
{
    return kd.x == 0.6f && kd.y == 0.6f && kd.z == 0.6f;
}

/* With KHR_materials_pbrSpecularGlossiness the base colour is only a default, white. */
static void take_diffuse(const struct aiMaterial *material, rk_vec3 *kd, float *alpha)
{
    rk_vec3 diffuse;
    float diffuse_alpha;
    const bool is_white = kd->x == 1 && kd->y == 1 && kd->z == 1 && *alpha == 1;
    if (!is_white || !read_colour(material, AI_MATKEY_COLOR_DIFFUSE, &diffuse, &diffuse_alpha))
        return;
    *kd = diffuse;
    *alpha = diffuse_alpha;
}

rk_material rk_mesh_material(const struct aiMaterial *material, bool varies, bool is_encoded)
{
    rk_material m = {.kd = rk_vec(0.8f, 0.8f, 0.8f), .alpha = 1};
    if (has_text(material, AI_MATKEY_NAME, AI_DEFAULT_MATERIAL_NAME)) {
        if (varies)
            m.kd = rk_vec(1, 1, 1);
        return m;
    }
    float base_alpha, unused;
    bool is_gltf = read_colour(material, AI_MATKEY_BASE_COLOR, &m.kd, &base_alpha);
    if (is_gltf) {
        take_diffuse(material, &m.kd, &base_alpha);
        bool is_mask = has_text(material, AI_MATKEY_GLTF_ALPHAMODE, "MASK");
        if (is_mask || has_text(material, AI_MATKEY_GLTF_ALPHAMODE, "BLEND"))
            m.alpha = base_alpha;
        ai_real cutoff = 0.5f;
        aiGetMaterialFloatArray(material, AI_MATKEY_GLTF_ALPHACUTOFF, &cutoff, NULL);
        m.alpha_cutoff = is_mask ? clamp_fraction((float)cutoff) : 0;
        return m;
    }
    if (read_colour(material, AI_MATKEY_COLOR_DIFFUSE, &m.kd, &unused) && is_encoded)
        m.kd = rk_vec(rk_srgb_decode(m.kd.x), rk_srgb_decode(m.kd.y), rk_srgb_decode(m.kd.z));
    if (varies && is_made_up(m.kd))
        m.kd = rk_vec(1, 1, 1);
    read_colour(material, AI_MATKEY_COLOR_SPECULAR, &m.ks, &unused);
    ai_real value;
    if (aiGetMaterialFloatArray(material, AI_MATKEY_SHININESS, &value, NULL) == aiReturn_SUCCESS)
        m.shininess = value < 0 ? 0 : (float)value;
    if (aiGetMaterialFloatArray(material, AI_MATKEY_OPACITY, &value, NULL) == aiReturn_SUCCESS)
        m.alpha = clamp_fraction((float)value);
    return m;
}
