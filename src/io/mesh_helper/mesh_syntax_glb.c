/* io/mesh_helper/mesh_syntax.h for glTF's binary form: a header of three words (magic, version,
 * bytes of the file), then chunks, each with its size and kind; in version 1 one chunk, whose size
 * and kind the header has. Assimp allocates what a chunk claims. Source: glTF 2.0 specification,
 * section 4.4, and the extension KHR_binary_glTF of 1.0. */
#include "io/little_endian.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <stdint.h>
#include <string.h>

static bool check_chunk(const char *path, uint32_t claimed, size_t left, rk_error *error)
{
    return claimed <= left ||
           rk_fail(error,
                   "%s: a part claims %u bytes, but only %zu follow: download or export it again",
                   path, claimed, left);
}

bool rk_mesh_syntax_glb(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    if (size < 20 || memcmp(text, "glTF", 4) != 0)
        return rk_fail(error,
                       "%s: is not a binary glTF file: rename it with the ending of its format, or "
                       "export it again",
                       path);
    const uint32_t whole = rk_little_endian_32(text + 8);
    if (whole > size)
        return rk_fail(error, "%s: claims %u bytes, but has %zu: download or export it again", path,
                       whole, size);
    hints->is_gltf_1 = rk_little_endian_32(text + 4) == 1;
    if (hints->is_gltf_1)
        return check_chunk(path, rk_little_endian_32(text + 12), size - 20, error);
    for (size_t at = 12; size - at >= 8;) {
        const uint32_t claimed = rk_little_endian_32(text + at);
        at += 8;
        if (!check_chunk(path, claimed, size - at, error))
            return false;
        at += claimed;
    }
    const json_cursor part = {text + 20, text + 20 + rk_little_endian_32(text + 12)};
    return rk_mesh_syntax_gltf_part(path, part, (json_cursor){text, text + size}, hints, error);
}
