/* Writes a corrected copy of a mesh file's text, which Assimp reads in its place. Part of
 * raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_REWRITE_H
#define RK_IO_MESH_HELPER_MESH_REWRITE_H

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

/* Coordinates in single precision keep 1 / 16,777,216 of their distance from the origin, so those
 * of a mesh that is far away are taken from its first vertex. */
typedef struct mesh_extent {
    double first[3], low[3], high[3];
    bool begun;
} mesh_extent;

static inline void extent_add(mesh_extent *e, const double at[3])
{
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

static inline bool text_read_point(text_cursor *c, double at[3])
{
    return text_read_number(c, &at[0]) && text_read_number(c, &at[1]) &&
           text_read_number(c, &at[2]);
}

/* Replaces the three numbers at the cursor by those relative to the first vertex. */
static inline void rewrite_point(mesh_rewrite *r, text_cursor *c, const mesh_extent *e)
{
    double at[3];
    text_skip_blanks(c);
    const char *from = c->at;
    if (!text_read_point(c, at))
        return;
    rewrite_skip(r, from, c->at);
    fprintf(r->out, "%.9g %.9g %.9g", at[0] - e->first[0], at[1] - e->first[1],
            at[2] - e->first[2]);
}

#endif
