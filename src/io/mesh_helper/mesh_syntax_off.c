/* io/mesh_helper/mesh_syntax.h for OFF: the word OFF with prefixes that announce texture
 * coordinates, colours and normals, three counts (vertices, faces, edges), one line per vertex, one
 * line per face: its number of corners, their indices from 0, optionally a colour. Format: Geomview
 * manual, "OFF files". */
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdint.h>

static const char *const remedy = "export the mesh again";

static bool statue_counts(const char *path, text_cursor *c, long long counts[2], rk_error *error)
{
    for (int i = 0; i < 2; i++) {
        text_skip_blanks(c);
        if (!text_next_content(c) || !text_read_integer(c, &counts[i]) || counts[i] < 0 ||
            !text_is_separator(c))
            return rk_fail(error, "%s:%zu: the counts of vertices and faces are missing: %s", path,
                           c->line, remedy);
        if (counts[i] > UINT32_MAX)
            return rk_fail(error, "%s:%zu: %lld rows exceed 32-bit indices: %s", path, c->line,
                           counts[i], remedy);
    }
    if (counts[0] == 0 || counts[1] == 0)
        return rk_fail(error, "%s: has no triangles: choose a mesh with faces", path);
    text_next_line(c);
    return true;
}

static bool parse_vertex(const char *path, text_cursor *c, mesh_extent *extent, bool *has_unfinite,
                         rk_error *error)
{
    double at[3];
    if (!text_read_point(c, at))
        return rk_fail(error, "%s:%zu: a vertex needs three numbers: %s", path, c->line, remedy);
    *has_unfinite |= !isfinite(at[0] + at[1] + at[2]);
    extent_add(extent, at);
    return true;
}

/* Vertices relative to the first, if they are far away. */
static bool write_moved(const char *path, text_cursor vertices, long long count, const char *text,
                        const mesh_extent *extent, rk_mesh_hints *hints, rk_error *error)
{
    mesh_rewrite rewrite = {open_memstream(&hints->text, &hints->size), text};
    if (!rewrite.out)
        return rk_fail(error, "%s: no memory for its text: simplify the mesh", path);
    for (long long row = 0; row < count && text_next_content(&vertices); row++) {
        rewrite_point(&rewrite, &vertices, extent_origin(extent));
        text_next_line(&vertices);
    }
    rewrite_skip(&rewrite, vertices.end, vertices.end);
    return fclose(rewrite.out) == 0 ||
           rk_fail(error, "%s: no memory for its text: simplify the mesh", path);
}

static bool parse_face(const char *path, text_cursor *c, long long vertices, rk_mesh_hints *hints,
                       rk_error *error)
{
    long long corners, index;
    text_skip_blanks(c);
    if (!text_read_integer(c, &corners) || corners < 1)
        return rk_fail(error, "%s:%zu: a face must begin with its number of corners: %s", path,
                       c->line, remedy);
    for (long long i = 0; i < corners; i++) {
        text_skip_blanks(c);
        if (!text_read_integer(c, &index) || !text_is_separator(c))
            return rk_fail(error, "%s:%zu: a face's index is missing or not a number: %s", path,
                           c->line, remedy);
        if (index < 0 || index >= vertices)
            return rk_fail(error, "%s:%zu: a face uses vertex %lld, but the file has %lld: %s",
                           path, c->line, index, vertices, remedy);
    }
    hints->faces += corners >= 3;
    hints->corners += corners >= 3 ? (size_t)corners : 0;
    return true;
}

bool rk_mesh_syntax_off(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    hints->plain = true;
    text_cursor c = text_begin(text, size);
    char word[16] = "";
    size_t length =
        text_next_content(&c) && text_read_word(&c, word, sizeof word) ? strlen(word) : 0;
    if (length < 3 || strcmp(word + length - 3, "OFF") != 0)
        return rk_fail(error,
                       "%s:%zu: an OFF file begins with the word OFF: does it have another format?",
                       path, c.line);
    if (strpbrk(word, "4n"))
        return rk_fail(error, "%s:%zu: OFF in four or more dimensions is not supported: %s", path,
                       c.line, remedy);
    long long counts[2];
    if (!statue_counts(path, &c, counts, error))
        return false;
    size_t header_line = c.line - 1;
    const text_cursor rows = c;
    mesh_extent extent = {0};
    bool has_unfinite = false;
    for (long long row = 0; row < counts[0] + counts[1]; row++) {
        if (!text_next_content(&c))
            return rk_fail(
                error,
                "%s:%zu: %lld vertices and %lld faces are promised, but the file ends after "
                "%lld of these lines: %s",
                path, header_line, counts[0], counts[1], row, remedy);
        if (row < counts[0] ? !parse_vertex(path, &c, &extent, &has_unfinite, error)
                            : !parse_face(path, &c, counts[0], hints, error))
            return false;
        text_next_line(&c);
    }
    hints->vertices = (size_t)counts[0];
    return !(has_unfinite || extent_is_far(&extent)) ||
           write_moved(path, rows, counts[0], text, &extent, hints, error);
}
