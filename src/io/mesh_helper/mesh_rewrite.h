/* Writes a corrected copy of a mesh file's text, which Assimp reads in its place. Part of
 * raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_REWRITE_H
#define RK_IO_MESH_HELPER_MESH_REWRITE_H

#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdio.h>

typedef struct mesh_rewrite {
    FILE *out;
    const char *copied; /* up to here */
} mesh_rewrite;

/* Copies what precedes `from`; what follows is to replace the text up to `to`. */
static inline void rewrite_skip(mesh_rewrite *r, const char *from, const char *to)
{
    fwrite(r->copied, 1, (size_t)(from - r->copied), r->out);
    r->copied = to;
}

static inline bool rewrite_fail(const char *path, rk_error *error)
{
    return rk_fail(error, "%s: no memory for its text: simplify the mesh", path);
}

static inline bool rewrite_begin(mesh_rewrite *r, const char *path, const char *text,
                                 rk_mesh_hints *hints, rk_error *error)
{
    *r = (mesh_rewrite){open_memstream(&hints->text, &hints->size), text};
    return r->out || rewrite_fail(path, error);
}

/* Copies the rest of the text. */
static inline bool rewrite_end(mesh_rewrite *r, const char *path, const char *end, rk_error *error)
{
    rewrite_skip(r, end, end);
    return fclose(r->out) == 0 || rewrite_fail(path, error);
}

/* Writes a zero before each number of the text that begins with its point, which Assimp does not
 * take for one. */
static inline void rewrite_points_of_numbers(mesh_rewrite *r, const char *from, const char *to)
{
    for (const char *at = from; at < to; at++)
        if (*at == '.' && (at == from || strchr(" \t+-", at[-1]))) {
            rewrite_skip(r, at, at);
            fputc('0', r->out);
        }
}

/* Coordinates in single precision keep 1 / 16,777,216 of their distance from the origin, so those
 * of a mesh that is far away are taken from its first vertex. */
typedef struct mesh_extent {
    double first[3], low[3], high[3];
    bool begun;
} mesh_extent;

/* Points that are not finite count for nothing. */
static inline void extent_add(mesh_extent *e, const double at[3])
{
    if (!isfinite(at[0] + at[1] + at[2]))
        return;
    for (int i = 0; i < 3; i++) {
        if (!e->begun)
            e->first[i] = e->low[i] = e->high[i] = at[i];
        e->low[i] = fmin(e->low[i], at[i]);
        e->high[i] = fmax(e->high[i], at[i]);
    }
    e->begun = true;
}

/* The extent divided by the distance; 1 without an extent. */
static inline double extent_share(const mesh_extent *e)
{
    double size = 0, distance = 0;
    for (int i = 0; i < 3; i++) {
        size = fmax(size, e->high[i] - e->low[i]);
        distance = fmax(distance, fmax(fabs(e->low[i]), fabs(e->high[i])));
    }
    return size > 0 ? size / distance : 1;
}

/* At 64 times its extent, a quarter of a millionth of it is lost; an exporter's six digits keep
 * more. */
static inline bool extent_is_far(const mesh_extent *e)
{
    return extent_share(e) < 1.0 / 64;
}

/* Reads a number that is finite as a float. */
static inline bool text_read_number(text_cursor *c, double *value)
{
    text_skip_blanks(c);
    const char *from = c->at;
    char number[64];
    if (!text_read_finite(c))
        return false;
    size_t length = (size_t)(c->at - from);
    length = length < sizeof number ? length : sizeof number - 1;
    memcpy(number, from, length);
    number[length] = '\0';
    *value = strtod(number, NULL);
    return true;
}

/* Skips a number that is none, or none in single precision: nan, -inf, 1e99, or 1.#IND as old
 * programs of Windows write it. */
static inline bool text_skip_unfinite(text_cursor *c)
{
    char word[64] = "", *end;
    size_t length = 0;
    text_skip_blanks(c);
    for (; c->at + length < c->end && !strchr(" \t\r\n", c->at[length]); length++)
        if (length < sizeof word - 1)
            word[length] = c->at[length];
    const char *digits = word + (word[0] == '-' || word[0] == '+');
    const double value = strtod(word, &end);
    if (strncmp(digits, "1.#", 3) != 0 &&
        (end == word || *end != '\0' || fabs(value) <= 0x1.fffffep127))
        return false;
    c->at += length;
    return true;
}

/* Reads a number; NAN for one that is not finite. */
static inline bool text_read_coordinate(text_cursor *c, double *value)
{
    const text_cursor from = *c;
    if (text_read_number(c, value) && !(c->at < c->end && *c->at == '#' && c->at[-1] == '.'))
        return true;
    *c = from;
    *value = (double)NAN;
    return text_skip_unfinite(c);
}

static inline bool text_read_point(text_cursor *c, double at[3])
{
    return text_read_coordinate(c, &at[0]) && text_read_coordinate(c, &at[1]) &&
           text_read_coordinate(c, &at[2]);
}

/* Of what is to be written relative to the first vertex, or as it is. */
static inline const double *extent_origin(const mesh_extent *e)
{
    static const double none[3];
    return extent_is_far(e) ? e->first : none;
}

/* Replaces the three numbers at the cursor by those relative to the origin, and numbers that are
 * not finite by one that Assimp knows. */
static inline void rewrite_point(mesh_rewrite *r, text_cursor *c, const double origin[3])
{
    double at[3];
    text_skip_blanks(c);
    const char *from = c->at;
    if (!text_read_point(c, at))
        return;
    const bool is_finite = isfinite(at[0] + at[1] + at[2]);
    if (is_finite && origin[0] == 0 && origin[1] == 0 && origin[2] == 0)
        return;
    rewrite_skip(r, from, c->at);
    if (is_finite)
        fprintf(r->out, "%.9g %.9g %.9g", at[0] - origin[0], at[1] - origin[1], at[2] - origin[2]);
    else
        fputs("nan nan nan", r->out);
}

#endif
