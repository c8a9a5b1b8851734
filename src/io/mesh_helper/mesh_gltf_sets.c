/* Walks the materials. Format: Khronos, KHR_texture_transform; GLB: glTF 2.0 specification, section
 * 4.4. */
#include "io/mesh_helper/mesh_gltf_sets.h"

#include "io/little_endian.h"
#include "io/mesh_helper/json_cursor.h"
#include "io/mesh_helper/mesh_rewrite.h"

#include <stdint.h>
#include <stdio.h>

/* Textures are in objects of materials, or of their extensions. */
enum { deepest = 4, glb_header = 20 };

/* `object` is a texture's if its extension has a set. */
static bool mend_texture(mesh_rewrite *r, json_cursor object, bool *any)
{
    json_cursor set = object, own = object;
    if (!json_find_key(&set, "extensions") || !json_find_key(&set, "KHR_texture_transform") ||
        !json_find_key(&set, "texCoord"))
        return false;
    const long long number = json_read_index(&set, 0);
    const bool has_own = json_find_key(&own, "texCoord");
    json_cursor end = own;
    if (number == (has_own ? json_read_index(&end, 0) : 0))
        return true;
    *any = true;
    if (has_own) {
        rewrite_skip(r, own.at, end.at);
        fprintf(r->out, "%lld", number);
    } else {
        json_enter(&object, '{');
        rewrite_skip(r, object.at, object.at);
        fprintf(r->out, "\"texCoord\":%lld,", number);
    }
    return true;
}

static void mend_object(mesh_rewrite *r, json_cursor object, int depth, bool *any)
{
    json_string key;
    if (depth > deepest || mend_texture(r, object, any) || !json_enter(&object, '{'))
        return;
    for (; json_next_key(&object, &key); json_skip(&object))
        if (*object.at == '{')
            mend_object(r, object, depth + 1, any);
}

static bool has_set(json_cursor text)
{
    static const char word[] = "\"KHR_texture_transform\"";
    for (const char *at = text.at; (at = memchr(at, '"', (size_t)(text.end - at))); at++)
        if ((size_t)(text.end - at) > sizeof word && memcmp(at, word, sizeof word - 1) == 0)
            return true;
    return false;
}

static void set_word(char *text, uint64_t word)
{
    for (int i = 0; i < 4; i++)
        text[i] = (char)(unsigned char)(word >> 8 * i);
}

bool rk_mesh_gltf_sets_mend(const char *text, size_t size, char **changed, size_t *changed_size)
{
    json_cursor json = {text, text + size};
    const bool is_glb = size > glb_header && memcmp(text, "glTF", 4) == 0;
    *changed = NULL;
    if (is_glb) {
        if (rk_little_endian_32(text + 4) != 2 ||
            rk_little_endian_32(text + 12) > size - glb_header)
            return true;
        json = (json_cursor){text + glb_header, text + glb_header + rk_little_endian_32(text + 12)};
    } else if (size > 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        json.at += 3;
    }
    json_cursor c = json;
    if (!has_set(json) || !json_find_key(&c, "materials") || !json_enter(&c, '['))
        return true;
    mesh_rewrite r = {open_memstream(changed, changed_size), text};
    if (!r.out)
        return false;
    bool any = false;
    for (; json_next(&c); json_skip(&c))
        mend_object(&r, c, 0, &any);
    rewrite_skip(&r, json.end, json.end);
    const long before = ftell(r.out);
    for (long at = before; is_glb && at % 4; at++)
        fputc(' ', r.out); /* chunks are aligned */
    const long after = ftell(r.out);
    rewrite_skip(&r, text + size, text + size);
    const bool ok = fclose(r.out) == 0 && before >= 0;
    if (ok && any && is_glb) {
        set_word(*changed + 12, (uint64_t)after - glb_header);
        set_word(*changed + 8, *changed_size);
    }
    if (!ok || !any) {
        free(*changed);
        *changed = NULL;
    }
    return ok;
}
