/* Point Cloud Library writes normal_x; some programs write capitals. Assimp wants one blank between
 * two words. */
#include "io/mesh_helper/mesh_ply_names.h"

#include "io/mesh_helper/mesh_rewrite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[][2] = {
    {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}, {"NX", "nx"}, {"NY", "ny"},
    {"NZ", "nz"},       {"X", "x"},         {"Y", "y"},         {"Z", "z"},
};

static const char *usual_name(const char *name)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i][0], name) == 0)
            return names[i][1];
    return NULL;
}

/* `property TYPE NAME` of a vertex. Returns whether the name is another. */
static bool see_line(text_cursor *c, bool *is_vertex, mesh_rewrite *rewrite)
{
    char word[32], type[32], name[32];
    if (!text_read_word(c, word, sizeof word))
        return false;
    if (strcmp(word, "element") == 0)
        *is_vertex = text_read_word(c, word, sizeof word) && strcmp(word, "vertex") == 0;
    if (!*is_vertex || strcmp(word, "property") != 0 || !text_read_word(c, type, sizeof type))
        return false;
    text_skip_blanks(c);
    const char *from = c->at;
    const char *usual = text_read_word(c, name, sizeof name) ? usual_name(name) : NULL;
    if (usual && rewrite) {
        rewrite_skip(rewrite, from, c->at);
        fputs(usual, rewrite->out);
    }
    return usual != NULL;
}

/* Up to the end of the header; of other files, to that of their lines. */
static bool see_header(const char *text, size_t size, mesh_rewrite *rewrite)
{
    bool is_vertex = false, any = false;
    for (text_cursor c = text_begin(text, size); c.at < c.end; text_next_line(&c)) {
        if ((size_t)(c.end - c.at) >= 10 && memcmp(c.at, "end_header", 10) == 0)
            return any;
        any |= see_line(&c, &is_vertex, rewrite);
    }
    return false;
}

/* Returns whether there are other blanks than one space between two words. */
static bool see_blanks(const char *line, const char *end, mesh_rewrite *rewrite)
{
    bool any = false;
    while (end > line && strchr("\r\n", end[-1]))
        end--;
    for (const char *from = line; from < end; from++) {
        const char *to = from;
        while (to < end && strchr(" \t", *to))
            to++;
        const bool is_edge = from == line || to == end;
        if (to == from || (to == from + 1 && *from == ' ' && !is_edge))
            continue;
        any = true;
        if (rewrite) {
            rewrite_skip(rewrite, from, to);
            fputs(is_edge ? "" : " ", rewrite->out);
        }
        from = to - 1;
    }
    return any;
}

static bool is_remark(const char *line, size_t size)
{
    return (size >= 7 && memcmp(line, "comment", 7) == 0) ||
           (size >= 8 && memcmp(line, "obj_info", 8) == 0);
}

static bool see_header_blanks(const char *text, size_t size, mesh_rewrite *rewrite)
{
    bool any = false;
    for (text_cursor c = text_begin(text, size); c.at < c.end;) {
        const char *line = c.at;
        if ((size_t)(c.end - c.at) >= 10 && memcmp(c.at, "end_header", 10) == 0)
            return any;
        text_next_line(&c);
        any |= !is_remark(line, (size_t)(c.at - line)) && see_blanks(line, c.at, rewrite);
    }
    return false;
}

bool rk_mesh_ply_names_mend(const char *text, size_t size, char **changed, size_t *changed_size)
{
    *changed = NULL;
    const bool has_blanks = see_header_blanks(text, size, NULL);
    if (!has_blanks && !see_header(text, size, NULL))
        return true;
    mesh_rewrite rewrite = {open_memstream(changed, changed_size), text};
    if (!rewrite.out)
        return false;
    if (has_blanks) /* other names are found in what this makes */
        see_header_blanks(text, size, &rewrite);
    else
        see_header(text, size, &rewrite);
    rewrite_skip(&rewrite, text + size, text + size);
    if (fclose(rewrite.out) == 0)
        return true;
    free(*changed);
    *changed = NULL;
    return false;
}
