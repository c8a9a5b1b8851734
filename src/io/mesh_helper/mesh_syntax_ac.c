/* io/mesh_helper/mesh_syntax.h for AC3D, whose surfaces name a material by its number in the file:
 * Assimp 5.2 drops those whose number is beyond the last, so they are given the first. Format:
 * "The AC3D file format", surfaces (SURF, mat, refs). */
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <stdio.h>

static bool skip_word(text_cursor *c, const char *word)
{
    const size_t length = strlen(word);
    text_skip_blanks(c);
    if ((size_t)(c->end - c->at) <= length || memcmp(c->at, word, length) != 0 ||
        !strchr(" \t", c->at[length]))
        return false;
    c->at += length;
    text_skip_blanks(c);
    return true;
}

static size_t count_materials(text_cursor c)
{
    size_t count = 0;
    for (; c.at < c.end; text_next_line(&c))
        count += skip_word(&c, "MATERIAL");
    return count;
}

bool rk_mesh_syntax_ac(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                       rk_error *error)
{
    text_cursor c = text_begin(text, size);
    const size_t materials = count_materials(c);
    size_t beyond = 0;
    long long number;
    mesh_rewrite rewrite;
    if (!rewrite_begin(&rewrite, path, text, hints, error))
        return false;
    for (; c.at < c.end; text_next_line(&c)) {
        if (!skip_word(&c, "mat"))
            continue;
        const char *from = c.at;
        if (!text_read_integer(&c, &number) || number <= 0 || (size_t)number < materials)
            continue;
        beyond++;
        rewrite_skip(&rewrite, from, c.at);
        fputc('0', rewrite.out);
    }
    if (!rewrite_end(&rewrite, path, c.end, error))
        return false;
    if (beyond > 0)
        rk_mesh_hints_note(hints, path,
                           "%zu of its surfaces name a material beyond its %zu: they are drawn in "
                           "the first one",
                           beyond, materials);
    return true;
}
