/* io/mesh_helper/mesh_syntax.h for Wavefront OBJ. One statement per line: v and vn with three
 * numbers, vt with one to three, f with corners v, v/vt, v//vn or v/vt/vn, whose indices count from
 * 1, or backwards from the latest. Format: Wavefront's Advanced Visualizer manual, appendix B1. */
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

enum { POSITION, TEXCOORD, NORMAL, kinds };

typedef struct obj_parser {
    const char *path;
    long long count[kinds];
    long long largest[kinds]; /* index used by a face, which may precede the named line */
    size_t largest_line[kinds];
    size_t faces;
    char library[512]; /* the file named by mtllib, or "" */
    size_t library_line;
} obj_parser;

static const char *const nouns[kinds] = {"vertices", "texture coordinates", "normals"};
static const char *const remedy = "repair the line or export the mesh again";

static bool parse_numbers(obj_parser *s, text_cursor *c, int kind, rk_error *error)
{
    size_t line = c->line;
    int needed = kind == TEXCOORD ? 1 : 3;
    for (int i = 0; i < needed; i++)
        if (!text_read_finite(c))
            return rk_fail(error, "%s:%zu: a %s line needs %s: %s", s->path, line,
                           kind == POSITION ? "v"
                           : kind == NORMAL ? "vn"
                                            : "vt",
                           needed == 3 ? "three finite numbers" : "finite numbers", remedy);
    s->count[kind]++;
    return true;
}

static bool parse_index(obj_parser *s, text_cursor *c, int kind, rk_error *error)
{
    long long index;
    if (!text_read_integer(c, &index))
        return rk_fail(error, "%s:%zu: a face's index is not a number: %s", s->path, c->line,
                       remedy);
    if (index == 0)
        return rk_fail(error, "%s:%zu: a face uses index 0, but OBJ counts from 1: %s", s->path,
                       c->line, remedy);
    if (index < -s->count[kind])
        return rk_fail(error, "%s:%zu: a face uses index %lld, but only %lld %s precede it: %s",
                       s->path, c->line, index, s->count[kind], nouns[kind], remedy);
    if (index > s->largest[kind]) {
        s->largest[kind] = index;
        s->largest_line[kind] = c->line;
    }
    return true;
}

/* v, v/vt, v//vn or v/vt/vn. */
static bool parse_corner(obj_parser *s, text_cursor *c, rk_error *error)
{
    if (!parse_index(s, c, POSITION, error))
        return false;
    for (int kind = TEXCOORD; kind <= NORMAL && c->at < c->end && *c->at == '/'; kind++) {
        c->at++;
        bool absent = text_is_separator(c) || *c->at == '/';
        if (!absent && !parse_index(s, c, kind, error))
            return false;
    }
    if (!text_is_separator(c))
        return rk_fail(error, "%s:%zu: a face's corner is not v, v/vt, v//vn or v/vt/vn: %s",
                       s->path, c->line, remedy);
    return true;
}

static bool parse_face(obj_parser *s, text_cursor *c, rk_error *error)
{
    size_t line = c->line, corners = 0;
    for (; !text_line_ended(c); corners++)
        if (!parse_corner(s, c, error))
            return false;
    if (corners < 3)
        return rk_fail(error, "%s:%zu: a face has %zu corners, but needs three: %s", s->path, line,
                       corners, remedy);
    s->faces++;
    return true;
}

/* The name is the rest of the line: it may hold spaces. */
static void keep_library(obj_parser *s, text_cursor *c)
{
    text_skip_blanks(c);
    size_t length = 0;
    while (c->at + length < c->end && c->at[length] != '\n' && length < sizeof s->library - 1)
        length++;
    memcpy(s->library, c->at, length);
    while (length > 0 && strchr(" \t\r", s->library[length - 1]))
        length--;
    s->library[length] = '\0';
    s->library_line = c->line;
}

static bool parse_line(obj_parser *s, text_cursor *c, rk_error *error)
{
    const char *word = c->at;
    while (!text_is_separator(c))
        c->at++;
    size_t length = (size_t)(c->at - word);
    if (length == 1 && word[0] == 'v')
        return parse_numbers(s, c, POSITION, error);
    if (length == 1 && word[0] == 'f')
        return parse_face(s, c, error);
    if (length == 2 && memcmp(word, "vn", 2) == 0)
        return parse_numbers(s, c, NORMAL, error);
    if (length == 2 && memcmp(word, "vt", 2) == 0)
        return parse_numbers(s, c, TEXCOORD, error);
    if (length == 6 && memcmp(word, "mtllib", 6) == 0 && !s->library[0])
        keep_library(s, c);
    return true;
}

/* mesh_io.h refuses others. */
static bool is_readable(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) && access(path, R_OK) == 0;
}

/* Assimp tries the named file, then the mesh's own name with .mtl. */
static bool library_is_there(const obj_parser *s)
{
    char path[4096];
    const char *slash = strrchr(s->path, '/');
    int folder = slash ? (int)(slash - s->path) + 1 : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, s->path, s->library);
    if (is_readable(path))
        return true;
    snprintf(path, sizeof path, "%.*smtl", (int)(strrchr(s->path, '.') - s->path) + 1, s->path);
    return is_readable(path);
}

bool rk_mesh_syntax_obj(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    obj_parser s = {.path = path};
    text_cursor c = text_begin(text, size);
    for (; text_next_content(&c); text_next_line(&c))
        if (!parse_line(&s, &c, error))
            return false;
    for (int kind = 0; kind < kinds; kind++)
        if (s.largest[kind] > s.count[kind])
            return rk_fail(error, "%s:%zu: a face uses index %lld, but the file has %lld %s: %s",
                           path, s.largest_line[kind], s.largest[kind], s.count[kind], nouns[kind],
                           remedy);
    if (s.faces == 0)
        return rk_fail(error, "%s: has no face in its %zu lines: is it an OBJ file with f lines?",
                       path, c.line);
    hints->plain = !s.library[0] || !library_is_there(&s);
    if (s.library[0] && hints->plain)
        rk_fail(&hints->note, "%s:%zu: the material file %s is missing: all surfaces are grey",
                path, s.library_line, s.library);
    return true;
}
