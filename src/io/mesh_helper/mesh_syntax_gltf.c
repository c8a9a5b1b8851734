/* io/mesh_helper/mesh_syntax.h for the extensions that a glTF file names: Assimp reads the file as
 * if those that it does not know were not there, which shows another mesh, or none. Format:
 * Khronos, "glTF 2.0 Specification", section 3.12. */
#include "io/mesh_helper/json_cursor.h"
#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_gltf_parts.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <stdio.h>
#include <string.h>

/* Drawn, or told elsewhere (lights, emission), or without a meaning for pictures. */
static const char *const drawn[] = {
    "KHR_binary_glTF",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
};

/* What a picture shows does not depend on these: what faces were before they were triangles, what
 * they mean, coarser copies, or a compression of what the file also has without. */
static const char *const meanings[] = {
    "EXT_feature_metadata",    "EXT_instance_features",   "EXT_mesh_features", "EXT_mesh_manifold",
    "EXT_meshopt_compression", "EXT_structural_metadata", "FB_ngon_encoding",  "GODOT_single_root",
    "KHR_animation_pointer",   "KHR_node_selectability",  "MSFT_lod",
};

/* These change how surfaces look, not where they are. */
static const char *const looks[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                    "MSFT_texture_", "KHR_techniques_webgl"};

static bool is_drawn(const json_string *name)
{
    for (size_t i = 0; i < sizeof drawn / sizeof *drawn; i++)
        if (json_equals(name, drawn[i]))
            return true;
    return false;
}

static bool is_meaning(const json_string *name)
{
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings; i++)
        if (json_equals(name, meanings[i]))
            return true;
    return false;
}

static bool is_look(const json_string *name)
{
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++)
        if (name->length >= strlen(looks[i]) &&
            memcmp(name->begin, looks[i], strlen(looks[i])) == 0)
            return true;
    return false;
}

/* Moves to the next string of a list; false at its end. */
static bool next_string(json_cursor *c, json_string *string)
{
    while (c->at < c->end && *c->at != '"' && *c->at != ']')
        c->at++;
    if (c->at == c->end || *c->at == ']')
        return false;
    *string = json_read_string(c);
    for (size_t i = 0; i < string->length; i++)
        if (string->begin[i] < ' ' || string->begin[i] > '~' || string->length > 100)
            string->length = 0;
    return true;
}

static void add_name(char *list, size_t size, const json_string *name)
{
    const size_t length = strlen(list);
    snprintf(list + length, size - length, "%s%.*s", length ? ", " : "", (int)name->length,
             name->begin);
}

static bool check_required(const char *path, json_cursor c, rk_error *error)
{
    json_string name;
    if (!json_find_key(&c, "extensionsRequired"))
        return true;
    while (next_string(&c, &name))
        if (name.length > 0 && !is_drawn(&name) && !is_look(&name))
            return rk_fail(error,
                           "%s: needs the glTF extension %.*s, which is not read: export it "
                           "without",
                           path, (int)name.length, name.begin);
    return true;
}

/* Assimp crashes on a skin without the matrices, which may be missing if they change nothing. */
static bool check_skins(const char *path, json_cursor c, rk_error *error)
{
    if (!json_find_key(&c, "skins") || !json_enter(&c, '['))
        return true;
    for (; json_next(&c); json_skip(&c)) {
        json_cursor skin = c;
        if (*c.at == '{' && !json_find_key(&skin, "inverseBindMatrices"))
            return rk_fail(error,
                           "%s: has a skin without inverse bind matrices, which Assimp does not "
                           "read: export it with them, or without its skin",
                           path);
    }
    return true;
}

/* Assimp poses morph targets by the mesh's weights, which those of a node replace. */
static void note_node_weights(const char *path, json_cursor c, rk_mesh_hints *hints)
{
    if (!json_find_key(&c, "nodes") || !json_enter(&c, '['))
        return;
    for (; json_next(&c); json_skip(&c)) {
        json_cursor node = c;
        if (*c.at == '{' && json_find_key(&node, "weights")) {
            rk_mesh_hints_note(hints, path,
                               "has weights of morph targets in its nodes, which Assimp does not "
                               "read: the picture shows those of the meshes");
            return;
        }
    }
}

static void note_used(const char *path, json_cursor c, rk_mesh_hints *hints)
{
    char list[600] = "";
    json_string name;
    if (!json_find_key(&c, "extensionsUsed"))
        return;
    while (next_string(&c, &name))
        if (name.length > 0 && !is_drawn(&name) && !is_meaning(&name))
            add_name(list, sizeof list, &name);
    if (*list)
        rk_mesh_hints_note(hints, path, "uses %s, which the picture does not show", list);
}

/* What is a list in version 2.0 is an object in 1.0, whose `asset` may be missing. */
static bool is_version_1(json_cursor c)
{
    json_cursor buffers = c, asset = c;
    if (json_find_key(&buffers, "buffers") && *buffers.at == '{')
        return true;
    return json_find_key(&asset, "asset") && json_find_key(&asset, "version") &&
           asset.end - asset.at > 2 && asset.at[0] == '"' && asset.at[1] < '2';
}

/* False with an error if one is a stand-in. */
static bool find_missing(const char *path, json_cursor c, rk_mesh_hints *hints, rk_error *error)
{
    char found[RK_MESH_FILES_NAME];
    json_string key;
    if (!json_find_key(&c, "buffers") || !(json_enter(&c, '[') || json_enter(&c, '{')))
        return true;
    for (; json_next(&c); json_skip(&c)) {
        if (*c.at == '"' && !json_next_key(&c, &key)) /* in version 1.0 */
            return true;
        json_cursor uri = c;
        if (!json_find_key(&uri, "uri") || *uri.at != '"')
            continue;
        const json_string name = json_read_string(&uri);
        if (name.length > 5 && memcmp(name.begin, "data:", 5) == 0)
            continue;
        if (rk_mesh_files_find(found, path, "", name.begin, name.length)) {
            rk_error what;
            const char *what_and_remedy = what.text;
            if (rk_mesh_files_is_stand_in(path, found, &what))
                return rk_fail(error, "%s: needs the file %s, which %s", path, found,
                               what_and_remedy);
            continue;
        }
        snprintf(hints->missing, sizeof hints->missing, "%.*s", (int)name.length, name.begin);
        return true;
    }
    return true;
}

bool rk_mesh_syntax_gltf_part(const char *path, json_cursor part, json_cursor file,
                              rk_mesh_hints *hints, rk_error *error)
{
    if (!check_required(path, part, error) || !check_skins(path, part, error) ||
        !rk_mesh_gltf_parts_read(hints, path, part, file, error))
        return false;
    hints->is_gltf_1 = is_version_1(part);
    if (!find_missing(path, part, hints, error))
        return false;
    note_used(path, part, hints);
    note_node_weights(path, part, hints);
    return true;
}

bool rk_mesh_syntax_gltf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                         rk_error *error)
{
    const bool has_mark = size > 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0;
    const json_cursor all = {text, text + size}, json = {text + (has_mark ? 3 : 0), all.end};
    return rk_mesh_syntax_gltf_part(path, json, all, hints, error);
}
