/* io/mesh_helper/mesh_syntax.h for OFF: the word OFF, which may be missing, with prefixes that
 * announce texture coordinates (ST), colours (C) and normals (N), three counts (vertices, faces,
 * edges), one line per vertex, one line per face: its number of corners, their indices from 0,
 * optionally a colour. Assimp reads no more than positions and corners: what else a line has is
 * read here. Formats: Geomview manual, "OFF files"; MeshLab's exporter writes NC, and colours
 * before normals. */
#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdint.h>
#include <stdlib.h>
#include <strings.h>

static const char *const remedy = "export the mesh again";

enum { most_numbers = 16 }; /* of a vertex's line, that are of interest */

typedef struct off_parser {
    const char *path;
    bool has_normals, has_colours, has_texcoords;
    bool colours_first;
    long long vertices, faces;
    int needed;        /* numbers of a vertex without its colour */
    int colour_size;   /* 3 or 4, by the first vertex; 0 without */
    bool has_further;  /* numbers in a vertex's line */
    bool any_colour;   /* of a face */
    bool has_map;      /* colours of faces as one number */
    bool no_word;      /* or in small letters */
    bool no_edges;     /* the third count is missing */
    bool has_unfinite; /* coordinates */
    bool has_comments; /* which Assimp takes for rows */
    bool is_loose;     /* lines end anywhere within a face, or a vertex without attributes */
    float top;         /* the largest number of a face's colour */
    float alpha;       /* the smallest opacity of a face */
    mesh_extent extent;
    rk_mesh_hints *hints;
} off_parser;

/* --- header -------------------------------------------------------------------------------- */

static bool read_counts(off_parser *s, text_cursor *c, rk_error *error)
{
    long long *counts[2] = {&s->vertices, &s->faces};
    for (int i = 0; i < 2; i++) {
        text_skip_blanks(c);
        if (!text_next_content(c) || !text_read_integer(c, counts[i]) || *counts[i] < 0 ||
            !text_is_separator(c))
            return rk_fail(error, "%s:%zu: the counts of vertices and faces are missing: %s",
                           s->path, c->line, remedy);
        if (*counts[i] > UINT32_MAX)
            return rk_fail(error, "%s:%zu: %lld rows exceed 32-bit indices: %s", s->path, c->line,
                           *counts[i], remedy);
    }
    if (s->vertices == 0 || s->faces == 0)
        return rk_fail(error, "%s: has no triangles: choose a mesh with faces", s->path);
    s->no_edges = text_line_ended(c);
    text_next_line(c);
    return true;
}

static bool read_word(off_parser *s, text_cursor *c, rk_error *error)
{
    char word[16] = "", next[16] = "";
    text_next_content(c);
    const text_cursor before = *c;
    size_t length = text_read_word(c, word, sizeof word) ? strlen(word) : 0;
    s->needed = 3;
    s->no_word = length > 0 && strspn(word, "0123456789") == length;
    if (s->no_word) {
        *c = before;
        return true;
    }
    s->no_word = strcasecmp(word, "off") == 0 && strcmp(word, "OFF") != 0;
    if (s->no_word)
        return true;
    if (length < 3 || strcmp(word + length - 3, "OFF") != 0)
        return rk_fail(error,
                       "%s:%zu: an OFF file begins with the word OFF: rename it with the ending of "
                       "its format, or export it again",
                       s->path, c->line);
    if (strpbrk(word, "4n"))
        return rk_fail(error, "%s:%zu: OFF in four or more dimensions is not supported: %s",
                       s->path, c->line, remedy);
    text_cursor rest = *c;
    if (text_read_word(&rest, next, sizeof next) && strcmp(next, "BINARY") == 0)
        return rk_fail(error, "%s:%zu: is a binary OFF file, which is not read: save it as text",
                       s->path, c->line);
    s->has_texcoords = strstr(word, "ST") != NULL;
    s->has_colours = strchr(word, 'C') != NULL;
    s->has_normals = strchr(word, 'N') != NULL;
    s->colours_first = strstr(word, "NC") != NULL;
    s->needed = 3 + 3 * s->has_normals + 2 * s->has_texcoords;
    return true;
}

/* --- rows ---------------------------------------------------------------------------------- */

static int read_further(text_cursor *c, float numbers[most_numbers])
{
    int count = 0;
    double value;
    for (text_cursor at = *c; count < most_numbers && !text_line_ended(&at); count++) {
        if (!text_read_coordinate(&at, &value))
            break;
        numbers[count] = (float)value;
    }
    return count;
}

/* The first line decides how many numbers a colour has. */
static void see_first(off_parser *s, int count)
{
    const int over = 3 + count - s->needed;
    if (s->has_colours && over >= 3)
        s->colour_size = over == 3 ? 3 : 4;
    s->needed += s->colour_size;
}

static void *row_of(void *rows, size_t count, size_t size)
{
    return (count & (count - 1)) == 0 ? realloc(rows, (count ? 2 * count : 1) * size) : rows;
}

/* A row more for each array that there is. */
static bool make_room(off_parser *s, size_t row, rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    void *room;
    bool ok = true;
    if (ok && s->has_normals && (ok = (room = row_of(h->normals, row, sizeof *h->normals))))
        h->normals = room;
    if (ok && s->colour_size > 0 && (ok = (room = row_of(h->colours, row, sizeof *h->colours))))
        h->colours = room;
    if (ok && s->has_texcoords && (ok = (room = row_of(h->texcoords, row, sizeof *h->texcoords))))
        h->texcoords = room;
    return ok || rk_fail(error, "%s: no memory for its vertices: simplify the mesh", s->path);
}

static bool keep_attributes(off_parser *s, const float *numbers, size_t row, rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    const float *normal = numbers + (s->colours_first ? s->colour_size : 0);
    const float *colour = numbers + (s->colours_first ? 0 : 3 * s->has_normals);
    const float *texcoord = numbers + 3 * s->has_normals + s->colour_size;
    if (!make_room(s, row, error))
        return false;
    if (s->has_normals)
        memcpy(h->normals[row], normal, sizeof h->normals[row]);
    if (s->colour_size > 0) {
        h->colours[row][3] = 1;
        memcpy(h->colours[row], colour, (size_t)s->colour_size * sizeof *colour);
    }
    if (s->has_texcoords) {
        h->texcoords[row][2] = 0;
        memcpy(h->texcoords[row], texcoord, 2 * sizeof *texcoord);
    }
    return true;
}

static bool has_loose_vertices(const off_parser *s)
{
    return s->is_loose && !s->has_normals && !s->has_colours && !s->has_texcoords;
}

static bool read_point(const off_parser *s, text_cursor *c, double at[3])
{
    for (int i = 0; i < 3; i++)
        if ((has_loose_vertices(s) && !text_next_content(c)) || !text_read_coordinate(c, &at[i]))
            return false;
    return true;
}

static bool parse_vertex(off_parser *s, text_cursor *c, size_t row, rk_error *error)
{
    double at[3];
    float numbers[most_numbers] = {0};
    if (!read_point(s, c, at))
        return rk_fail(error, "%s:%zu: a vertex needs three numbers: %s", s->path, c->line, remedy);
    s->has_unfinite |= !isfinite(at[0] + at[1] + at[2]);
    extent_add(&s->extent, at);
    if (has_loose_vertices(s))
        return true;
    const int count = read_further(c, numbers);
    if (row == 0)
        see_first(s, count);
    if (3 + count < s->needed)
        return rk_fail(error, "%s:%zu: a vertex needs %d numbers, as the first has: %s", s->path,
                       c->line, s->needed, remedy);
    s->has_further |= 3 + count > s->needed;
    return keep_attributes(s, numbers, row, error);
}

/* Three or four numbers are a colour, and its opacity; a single one is of a colour map. */
static bool keep_face_colour(off_parser *s, text_cursor *c, long long corners, rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    float numbers[most_numbers];
    const int count = read_further(c, numbers);
    const bool has_colour = count == 3 || count == 4;
    s->any_colour |= has_colour;
    s->has_map |= count > 0 && !has_colour;
    for (int i = 0; has_colour && i < count; i++)
        s->top = fmaxf(s->top, numbers[i]);
    if (count == 4)
        s->alpha = fminf(s->alpha, numbers[3]);
    void *room = row_of(h->face_colours, h->face_colour_count, sizeof *h->face_colours);
    if (!room)
        return rk_fail(error, "%s: no memory for the colours of its faces: simplify the mesh",
                       s->path);
    h->face_colours = room;
    h->face_colours[h->face_colour_count++] = (rk_mesh_colours_face){
        (uint32_t)corners,
        has_colour ? rk_vec(numbers[0], numbers[1], numbers[2]) : rk_vec(-1, -1, -1)};
    return true;
}

static bool parse_face(off_parser *s, text_cursor *c, rk_error *error)
{
    long long corners, index;
    text_skip_blanks(c);
    if (!text_read_integer(c, &corners) || corners < 1)
        return rk_fail(error, "%s:%zu: a face must begin with its number of corners: %s", s->path,
                       c->line, remedy);
    for (long long i = 0; i < corners; i++) {
        text_skip_blanks(c);
        if (s->is_loose)
            text_next_content(c);
        if (!text_read_integer(c, &index) || !text_is_separator(c))
            return rk_fail(error, "%s:%zu: a face's index is missing or not a number: %s", s->path,
                           c->line, remedy);
        if (index < 0 || index >= s->vertices)
            return rk_fail(error, "%s:%zu: a face uses vertex %lld, but the file has %lld: %s",
                           s->path, c->line, index, s->vertices, remedy);
    }
    s->hints->faces += corners >= 3;
    s->hints->corners += corners >= 3 ? (size_t)corners : 0;
    return keep_face_colour(s, c, corners, error);
}

static void end_row(const off_parser *s, text_cursor *c, bool is_vertex)
{
    if (!is_vertex || !has_loose_vertices(s))
        text_next_line(c);
}

static bool parse_rows(off_parser *s, text_cursor c, rk_error *error)
{
    const size_t header_line = c.line - 1;
    for (long long row = 0; row < s->vertices + s->faces; row++) {
        if (!text_next_content(&c))
            return rk_fail(
                error,
                "%s:%zu: %lld vertices and %lld faces are promised, but the file ends after "
                "%lld of these lines: %s",
                s->path, header_line, s->vertices, s->faces, row, remedy);
        const bool is_vertex = row < s->vertices;
        if (is_vertex ? !parse_vertex(s, &c, (size_t)row, error) : !parse_face(s, &c, error))
            return false;
        end_row(s, &c, is_vertex);
    }
    return !s->is_loose || !text_next_content(&c);
}

/* Nearly all files have a line for each row, by which a mistake is found where it is. Only what
 * has not, and fits to the last number, is read as numbers between any white space. */
static bool parse_rows_or_numbers(off_parser *s, text_cursor c, rk_error *error)
{
    const off_parser begun = *s;
    rk_error ignored;
    if (parse_rows(s, c, error))
        return true;
    *s = begun;
    s->is_loose = true;
    s->hints->faces = s->hints->corners = s->hints->face_colour_count = 0;
    if (!parse_rows(s, c, &ignored))
        return false;
    *error = (rk_error){0};
    return true;
}

/* --- the whole ----------------------------------------------------------------------------- */

static void note_rows(const off_parser *s)
{
    if (s->has_colours && s->colour_size == 0)
        rk_mesh_hints_note(s->hints, s->path,
                           "announces colours of vertices (C), but their lines have none");
    if (s->has_further)
        rk_mesh_hints_note(s->hints, s->path,
                           "has numbers in its vertices' lines that the first line does not "
                           "announce, and that the picture does not show: colours need COFF");
    if (s->has_map)
        rk_mesh_hints_note(s->hints, s->path,
                           "has colours of faces as numbers of a colour map, which the picture "
                           "does not show");
    if (s->alpha < (s->top > 1 ? 255 : 1))
        rk_mesh_hints_note(s->hints, s->path,
                           "has transparent colours of faces, which are drawn as opaque");
}

static void write_face(FILE *out, text_cursor *c)
{
    long long corners = 0, index = 0;
    text_next_content(c);
    text_read_integer(c, &corners);
    fprintf(out, "%lld", corners);
    for (long long i = 0; i < corners; i++) {
        text_next_content(c);
        text_read_integer(c, &index);
        fprintf(out, " %lld", index);
    }
    fputc('\n', out);
    text_next_line(c);
}

/* A line for each row, without what Assimp does not read. */
static void write_lines(FILE *out, const off_parser *s, text_cursor c)
{
    const double *origin = extent_origin(&s->extent);
    double at[3];
    for (long long row = 0; row < s->vertices && text_next_content(&c); row++) {
        read_point(s, &c, at);
        if (isfinite(at[0] + at[1] + at[2]))
            fprintf(out, "%.9g %.9g %.9g\n", at[0] - origin[0], at[1] - origin[1],
                    at[2] - origin[2]);
        else
            fputs("nan nan nan\n", out);
        end_row(s, &c, true);
    }
    for (long long row = 0; row < s->faces; row++)
        write_face(out, &c);
}

/* Vertices relative to the first, if they are far away, and a header that announces nothing. */
static bool write_corrected(const off_parser *s, text_cursor vertices, rk_error *error)
{
    mesh_rewrite rewrite;
    if (!rewrite_begin(&rewrite, s->path, vertices.at, s->hints, error))
        return false;
    fprintf(rewrite.out, "OFF\n%lld %lld 0\n", s->vertices, s->faces);
    const bool by_rows = s->is_loose || s->has_comments;
    if (by_rows)
        write_lines(rewrite.out, s, vertices);
    for (long long row = 0; !by_rows && row < s->vertices && text_next_content(&vertices); row++) {
        rewrite_point(&rewrite, &vertices, extent_origin(&s->extent));
        text_next_line(&vertices);
    }
    if (!by_rows)
        rewrite_skip(&rewrite, vertices.end, vertices.end);
    return fclose(rewrite.out) == 0 || rewrite_fail(s->path, error);
}

bool rk_mesh_syntax_off(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    hints->plain = true;
    off_parser s = {.path = path, .hints = hints, .alpha = INFINITY};
    s.has_comments = memchr(text, '#', size) != NULL;
    text_cursor c = text_begin(text, size);
    if (!read_word(&s, &c, error) || !read_counts(&s, &c, error) ||
        !parse_rows_or_numbers(&s, c, error))
        return false;
    if (!s.any_colour)
        hints->face_colour_count = 0;
    hints->vertices = (size_t)s.vertices;
    note_rows(&s);
    const bool announces = s.has_normals || s.has_colours || s.has_texcoords;
    return !(announces || s.no_word || s.no_edges || s.is_loose || s.has_comments ||
             s.has_unfinite || extent_is_far(&s.extent)) ||
           write_corrected(&s, c, error);
}
