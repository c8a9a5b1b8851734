/* io/mesh_helper/mesh_syntax.h for 3DS: chunks, each a number of two bytes and a size of four,
 * which counts these six, and may hold others. Vertices are in the scene's coordinates; nodes of
 * the keyframer take them from their object's axes and a pivot to a place of their own. Programs
 * that give nodes no numbers break this rule, each in its way: some count pivots from the middle of
 * the object's box. Assimp applies the rule all the same, and the parts fly asunder. */
#include "io/little_endian.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <string.h>

enum { head_size = 6, main_kind = 0x4d4d, keyframer = 0xb000, node = 0xb002, node_number = 0xb030 };

typedef struct chunk {
    const char *begin, *end; /* of what it holds */
    unsigned kind;
} chunk;

/* The one at `*at`, which moves on. False at the end, or where the file is damaged. */
static bool read_chunk(const char **at, const char *end, chunk *read)
{
    const size_t left = (size_t)(end - *at);
    const uint32_t size = left < head_size ? 0 : rk_little_endian_32(*at + 2);
    if (size < head_size || size > left)
        return false;
    *read = (chunk){*at + head_size, *at + size, rk_little_endian_16(*at)};
    *at += size;
    return true;
}

static bool find_chunk(const chunk *within, unsigned kind, chunk *found)
{
    for (const char *at = within->begin; read_chunk(&at, within->end, found);)
        if (found->kind == kind)
            return true;
    return false;
}

static bool has_nodes_without_numbers(const chunk *keys)
{
    chunk each, number;
    for (const char *at = keys->begin; read_chunk(&at, keys->end, &each);)
        if (each.kind == node && !find_chunk(&each, node_number, &number))
            return true;
    return false;
}

bool rk_mesh_syntax_3ds(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    const chunk file = {.begin = text, .end = text + size};
    chunk whole, keys;
    if (!find_chunk(&file, main_kind, &whole) || !find_chunk(&whole, keyframer, &keys) ||
        !has_nodes_without_numbers(&keys))
        return true;
    hints->text = rk_allocate_unset(size, 1, path, error);
    hints->size = size;
    if (!hints->text)
        return false;
    memcpy(hints->text, text, size);
    memset(hints->text + (keys.begin - head_size - text), 0, 2); /* a kind that is skipped */
    rk_mesh_hints_note(hints, path,
                       "has keyframes whose nodes have no numbers, which programs take "
                       "differently: they are left out, so each object is drawn once, where its "
                       "vertices are stored");
    return true;
}
