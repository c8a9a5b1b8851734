/* io/mesh_helper/mesh_syntax.h for Wavefront OBJ, in two passes: the first checks and counts; if
 * something is to be left out, moved or found elsewhere, the second writes a corrected text. An
 * index of a vertex that is not there ends the first: a line is lost, so others may be wrong, too.
 * One statement per line: v and vn with three numbers (after v, a fourth is the weight of a curve's
 * point, which faces do not use, and three more are its colour), vt with one to three, f with
 * corners v, v/vt, v//vn or v/vt/vn, whose indices count from 1, or backwards from the latest.
 * Format: Wavefront's Advanced Visualizer manual, appendix B1. */
#include "io/mesh_helper/mesh_obj_colours.h"
#include "io/mesh_helper/mesh_obj_libraries.h"
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdio.h>
#include <stdlib.h>

enum { POSITION, TEXCOORD, NORMAL, kinds };

/* What costs a face or its smoothness, not the file. */
enum { SHORT_FACE, LACKING_FACE, UNFINITE, faults };

/* What one face is found to be. */
typedef struct obj_face {
    size_t corners;
    bool lacks_reference; /* to a texture coordinate or a normal that is not there */
} obj_face;

typedef struct obj_parser {
    const char *path;
    long long count[kinds], total[kinds]; /* so far; after the first pass */
    long long largest[kinds]; /* index used by a face, which may precede the named line */
    size_t largest_line[kinds];
    size_t faces;                         /* of three corners or more */
    size_t corners;                       /* of these faces */
    size_t faults[faults], first[faults]; /* their numbers, and the line of the first */
    size_t short_corners;                 /* of the first short face */
    mesh_extent extent;
    bool has_unfinite; /* positions */
    bool
        has_weights; /* a fourth number of a vertex, by which Assimp would divide, or of a colour */
    bool has_colours;  /* three more numbers of a vertex */
    bool has_points;   /* numbers that begin with one, which Assimp does not read */
    bool has_comments; /* after numbers */
    bool has_curves;   /* or curved surfaces */
    bool has_lines;    /* or points */
    bool calls_files;  /* that are to be read in the line's place */
    const rk_mesh_obj_colours *colours; /* of its vertices, one each, or NULL */
    rk_mesh_obj_libraries libraries;
    mesh_rewrite *rewrite; /* in the second pass */
    rk_mesh_hints *hints;
} obj_parser;

static const char *const remedy = "repair the line or export the mesh again";

static void count_fault(obj_parser *s, int fault, size_t line)
{
    if (s->faults[fault]++ == 0)
        s->first[fault] = line;
}

static void note_position(obj_parser *s, const double at[3])
{
    s->has_unfinite |= !isfinite(at[0] + at[1] + at[2]);
    extent_add(&s->extent, at);
}

static bool begins_with_point(const char *from, const char *to)
{
    for (const char *at = from; at < to && (at = memchr(at, '.', (size_t)(to - at))); at++)
        if (at == from || strchr(" \t+-", at[-1]))
            return true;
    return false;
}

/* Numbers that begin with their point are told, or mended. */
static void mend_points(obj_parser *s, const char *from, const char *to)
{
    const char *comment = memchr(from, '#', (size_t)(to - from));
    to = comment ? comment : to;
    if (!s->rewrite)
        s->has_points |= begins_with_point(from, to);
    else if (s->rewrite->copied < to)
        rewrite_points_of_numbers(s->rewrite, s->rewrite->copied > from ? s->rewrite->copied : from,
                                  to);
}

static const char *line_end(const text_cursor *c)
{
    const char *newline = memchr(c->at, '\n', (size_t)(c->end - c->at));
    return newline ? newline : c->end;
}

static void skip_weight(obj_parser *s, text_cursor *c)
{
    text_cursor next = *c;
    if (!text_read_finite(&next) || !text_line_ended(&next))
        return;
    s->has_weights = true;
    if (s->rewrite)
        rewrite_skip(s->rewrite, c->at, next.at);
    *c = next;
}

/* A colour's fourth number, which Assimp takes for a vertex of four. Returns the colour's end. */
static const char *skip_opacity(obj_parser *s, const text_cursor *c)
{
    text_cursor at = *c;
    for (int i = 0; i < 3; i++)
        if (!text_read_finite(&at))
            return line_end(c);
    const char *end = at.at;
    if (!text_read_finite(&at) || !text_line_ended(&at))
        return line_end(c);
    s->has_weights = true;
    mend_points(s, c->at, end);
    if (s->rewrite)
        rewrite_skip(s->rewrite, end, at.at);
    return end;
}

/* Unless the line has more than a position. */
static void write_colour(obj_parser *s, const text_cursor *c)
{
    text_cursor rest = *c;
    if (!s->rewrite || !s->colours || !text_line_ended(&rest))
        return;
    const uint32_t mrgb = s->colours->mrgb[s->count[POSITION]];
    rewrite_skip(s->rewrite, c->at, c->at);
    fprintf(s->rewrite->out, " %.6g %.6g %.6g ", (mrgb >> 16 & 255) / 255.0,
            (mrgb >> 8 & 255) / 255.0, (mrgb & 255) / 255.0);
}

static bool parse_position(obj_parser *s, text_cursor *c, rk_error *error)
{
    size_t line = c->line;
    const char *from = c->at;
    double at[3];
    if (s->rewrite)
        rewrite_point(s->rewrite, c, extent_origin(&s->extent));
    else if (!text_read_point(c, at))
        return rk_fail(error, "%s:%zu: a v line needs three numbers: %s", s->path, line, remedy);
    else
        note_position(s, at);
    mend_points(s, from, c->at);
    skip_weight(s, c);
    text_cursor rest = *c;
    s->has_colours |= !text_line_ended(&rest);
    mend_points(s, c->at, skip_opacity(s, c));
    write_colour(s, c);
    s->count[POSITION]++;
    return true;
}

/* Numbers that are not finite become zeros: a normal without direction is replaced by the face's.
 */
static void parse_attribute(obj_parser *s, text_cursor *c, int kind)
{
    const char *from = c->at;
    size_t line = c->line;
    int needed = kind == TEXCOORD ? 1 : 3, found = 0;
    while (found < needed && text_read_finite(c))
        found++;
    s->count[kind]++;
    if (found == needed) {
        mend_points(s, from, line_end(c));
        return;
    }
    count_fault(s, UNFINITE, line);
    if (!s->rewrite)
        return;
    while (!text_line_ended(c))
        c->at++;
    rewrite_skip(s->rewrite, from, c->at);
    fputs(" 0 0 0", s->rewrite->out);
}

static bool parse_index(obj_parser *s, text_cursor *c, long long *index, rk_error *error)
{
    if (text_read_integer(c, index))
        return true;
    return rk_fail(error, "%s:%zu: a face's index is not a number: %s", s->path, c->line, remedy);
}

static bool check_position(obj_parser *s, const text_cursor *c, long long index, rk_error *error)
{
    if (index == 0)
        return rk_fail(error, "%s:%zu: a face uses index 0, but OBJ counts from 1: %s", s->path,
                       c->line, remedy);
    if (index < -s->count[POSITION])
        return rk_fail(error,
                       "%s:%zu: a face uses index %lld, but only %lld vertices precede it: %s",
                       s->path, c->line, index, s->count[POSITION], remedy);
    if (index > s->largest[POSITION]) {
        s->largest[POSITION] = index;
        s->largest_line[POSITION] = c->line;
    }
    return true;
}

/* A positive index may come before its line: it is judged in the second pass. */
static bool is_there(obj_parser *s, const text_cursor *c, int kind, long long index)
{
    if (index <= 0)
        return index != 0 && -index <= s->count[kind];
    if (!s->rewrite && index > s->largest[kind]) {
        s->largest[kind] = index;
        s->largest_line[kind] = c->line;
    }
    return !s->rewrite || index <= s->total[kind];
}

/* v, v/vt, v//vn or v/vt/vn. */
static bool parse_corner(obj_parser *s, text_cursor *c, obj_face *face, rk_error *error)
{
    long long index = 0;
    if (!parse_index(s, c, &index, error) || !check_position(s, c, index, error))
        return false;
    for (int kind = TEXCOORD; kind <= NORMAL && c->at < c->end && *c->at == '/'; kind++) {
        c->at++;
        if (text_is_separator(c) || *c->at == '/')
            continue;
        if (!parse_index(s, c, &index, error))
            return false;
        face->lacks_reference |= !is_there(s, c, kind, index);
    }
    if (!text_is_separator(c))
        return rk_fail(error, "%s:%zu: a face's corner is not v, v/vt, v//vn or v/vt/vn: %s",
                       s->path, c->line, remedy);
    face->corners++;
    return true;
}

/* Positions alone. */
static void rewrite_face(mesh_rewrite *r, const char *from, const text_cursor *end)
{
    rewrite_skip(r, from, end->at);
    for (text_cursor c = {from, end->at, 0}; !text_line_ended(&c);) {
        long long index = 0;
        text_read_integer(&c, &index);
        fprintf(r->out, " %lld", index);
        while (!text_is_separator(&c))
            c.at++;
    }
}

static bool parse_face(obj_parser *s, text_cursor *c, rk_error *error)
{
    size_t line = c->line;
    const char *from = c->at;
    obj_face face = {0};
    while (!text_line_ended(c))
        if (!parse_corner(s, c, &face, error))
            return false;
    if (face.corners < 3) {
        if (s->faults[SHORT_FACE] == 0)
            s->short_corners = face.corners;
        count_fault(s, SHORT_FACE, line);
        if (s->rewrite)
            rewrite_skip(s->rewrite, from - 1, c->at);
        return true;
    }
    s->faces++;
    s->corners += face.corners;
    if (face.lacks_reference) {
        count_fault(s, LACKING_FACE, line);
        if (s->rewrite)
            rewrite_face(s->rewrite, from, c);
    }
    return true;
}

static bool is_one_of(const char *word, size_t length, const char *const *words)
{
    for (; *words; words++)
        if (strlen(*words) == length && memcmp(*words, word, length) == 0)
            return true;
    return false;
}

/* What the picture does not show, by the manual's words. */
static void see_word(obj_parser *s, const char *word, size_t length)
{
    static const char *const curves[] = {"curv", "curv2", "surf", "bsp", "bzp", "cdc", "cdp", NULL};
    static const char *const lines[] = {"l", "p", NULL}, *const calls[] = {"call", "csh", NULL};
    s->has_curves |= is_one_of(word, length, curves);
    s->has_lines |= is_one_of(word, length, lines);
    s->calls_files |= is_one_of(word, length, calls);
}

static bool parse_line(obj_parser *s, text_cursor *c, rk_error *error)
{
    const char *word = c->at;
    while (!text_is_separator(c))
        c->at++;
    size_t length = (size_t)(c->at - word);
    if (length == 1 && word[0] == 'v')
        return parse_position(s, c, error);
    if (length == 1 && word[0] == 'f' && s->rewrite)
        rk_mesh_obj_libraries_before_face(&s->libraries, word, s->rewrite);
    if (length == 1 && word[0] == 'f')
        return parse_face(s, c, error);
    if (length == 2 && memcmp(word, "vn", 2) == 0)
        parse_attribute(s, c, NORMAL);
    if (length == 2 && memcmp(word, "vt", 2) == 0)
        parse_attribute(s, c, TEXCOORD);
    if (length == 6 && memcmp(word, "usemtl", 6) == 0) {
        s->hints->uses += !s->rewrite;
        rk_mesh_obj_libraries_use(&s->libraries, c, s->faces > 0);
    }
    if (length == 6 && memcmp(word, "mtllib", 6) == 0)
        rk_mesh_obj_libraries_read(&s->libraries, c, s->rewrite);
    see_word(s, word, length);
    return true;
}

/* After numbers, where Assimp takes it for more of them. A name may have the sign in it. */
static void skip_comment(obj_parser *s, const char *word, const text_cursor *c)
{
    static const char *const numbered[] = {"v", "vn", "vt", "f", "l", "p", NULL};
    const char *end = line_end(c), *after = word;
    while (after < end && *after != ' ' && *after != '\t')
        after++;
    const char *comment = memchr(word, '#', (size_t)(end - word));
    if (!comment || !is_one_of(word, (size_t)(after - word), numbered))
        return;
    s->has_comments = true;
    if (s->rewrite)
        rewrite_skip(s->rewrite, comment > s->rewrite->copied ? comment : s->rewrite->copied, end);
}

static bool parse_pass(obj_parser *s, const char *text, size_t size, rk_error *error)
{
    text_cursor c = text_begin(text, size);
    for (; text_next_content(&c); text_next_line(&c)) {
        const char *word = c.at;
        if (!parse_line(s, &c, error))
            return false;
        skip_comment(s, word, &c);
    }
    if (s->faces == 0 && s->faults[SHORT_FACE] > 0)
        return rk_fail(error, "%s:%zu: a face has %zu corners, but needs three: %s", s->path,
                       s->first[SHORT_FACE], s->short_corners, remedy);
    if (s->faces == 0 && (s->has_curves || s->has_lines))
        return rk_fail(error,
                       "%s: has no face, only points, lines, curves or curved surfaces, which are "
                       "not drawn: export it as polygons",
                       s->path);
    return s->faces > 0 ||
           rk_fail(error,
                   "%s: has no face: export it with faces, or rename it if it is no OBJ file",
                   s->path);
}

static void note_words(const obj_parser *s)
{
    if (s->has_curves)
        rk_mesh_hints_note(s->hints, s->path,
                           "has curves or curved surfaces (such as curv or surf lines), which the "
                           "picture does not show: export them as polygons");
    if (s->calls_files)
        rk_mesh_hints_note(s->hints, s->path,
                           "calls other files (call or csh lines), which are not read");
}

static void note_faults(const obj_parser *s)
{
    static const char *const what[faults] = {
        "faces of fewer than three corners are left out",
        "faces use texture coordinates or normals that are not there, and are drawn without",
        "texture coordinates or normals are not finite numbers, and are replaced"};
    for (int i = 0; i < faults; i++)
        if (s->faults[i] > 0)
            rk_mesh_hints_note(s->hints, s->path, "%zu %s (first in line %zu)", s->faults[i],
                               what[i], s->first[i]);
}

static bool write_corrected(const obj_parser *first, const char *text, size_t size, rk_error *error)
{
    obj_parser s = {.path = first->path,
                    .libraries = {.path = first->path,
                                  .hints = first->hints,
                                  .begins_without = first->libraries.begins_without},
                    .extent = first->extent,
                    .colours = first->colours,
                    .hints = first->hints};
    mesh_rewrite rewrite;
    if (!rewrite_begin(&rewrite, s.path, text, s.hints, error))
        return false;
    memcpy(s.total, first->count, sizeof s.total);
    s.rewrite = &rewrite;
    bool ok = parse_pass(&s, text, size, error);
    ok = rewrite_end(&rewrite, s.path, text + size, error) && ok;
    note_faults(&s);
    s.hints->faces = s.faces;
    s.hints->corners = s.corners;
    return ok;
}

static bool parse_coloured(const char *path, const char *text, size_t size,
                           const rk_mesh_obj_colours *colours, rk_mesh_hints *hints,
                           rk_error *error)
{
    obj_parser s = {.path = path, .libraries = {.path = path, .hints = hints}, .hints = hints};
    if (!parse_pass(&s, text, size, error))
        return false;
    if (s.largest[POSITION] > s.count[POSITION])
        return rk_fail(error, "%s:%zu: a face uses index %lld, but the file has %lld vertices: %s",
                       path, s.largest_line[POSITION], s.largest[POSITION], s.count[POSITION],
                       remedy);
    rk_mesh_obj_libraries_note(&s.libraries, s.has_colours || colours->count > 0);
    note_words(&s);
    hints->faces = s.faces;
    hints->corners = s.corners;
    if (colours->count == (size_t)s.count[POSITION])
        s.colours = colours;
    else if (colours->count > 0)
        rk_mesh_hints_note(hints, path,
                           "has %zu colours (#MRGB) for %lld vertices, which the picture does not "
                           "show",
                           colours->count, s.count[POSITION]);
    bool whole = !s.has_unfinite && !s.has_weights && !s.has_comments && !s.has_points &&
                 !s.colours &&
                 s.faults[SHORT_FACE] + s.faults[LACKING_FACE] + s.faults[UNFINITE] == 0 &&
                 !extent_is_far(&s.extent) && s.largest[TEXCOORD] <= s.count[TEXCOORD] &&
                 s.largest[NORMAL] <= s.count[NORMAL] &&
                 ((!s.libraries.renames && !s.libraries.begins_without) || hints->plain);
    return whole || write_corrected(&s, text, size, error);
}

bool rk_mesh_syntax_obj(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    hints->plain = true;
    rk_mesh_obj_colours colours = {0};
    bool ok = rk_mesh_obj_colours_find(&colours, path, text, size, error) &&
              parse_coloured(path, text, size, &colours, hints, error);
    free(colours.mrgb);
    return ok;
}
