/* io/mesh_helper/mesh_syntax.h for PLY: a header that declares elements (vertex, face, ...) with
 * their counts and properties, then the rows, as text or binary. All counts are checked against the
 * rows. Format: Greg Turk, "The PLY Polygon File Format", Stanford University, 1994. */
#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/mesh_ply_header.h"
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/text_cursor.h"

#include <stdint.h>
#include <stdlib.h>

enum { max_elements = 16, max_properties = 128 };

typedef enum ply_type {
    INT8,
    UINT8,
    INT16,
    UINT16,
    INT32,
    UINT32,
    FLOAT32,
    FLOAT64,
    types
} ply_type;
static const char *const type_names[2][types] = {
    {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
    {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
static const size_t type_sizes[types] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef struct ply_property {
    bool is_list;
    ply_type count_type, type;
    bool is_geometry; /* a coordinate that must be finite, or a list of vertex indices */
    int axis;         /* 0 to 2: x, y, z of a vertex; or -1 */
    int channel;      /* 0 to 2: red, green, blue of a face; or -1 */
    int label;        /* that divides the faces, see labels; or -1 */
    bool is_wedge;    /* a list of texture coordinates, a pair for each corner of the face */
} ply_property;

/* Numbers of a face by which some programs say what it looks like. */
enum { PICTURE, MATERIAL, labels };
static const char *const label_names[labels] = {"texnumber", "material_index"};
static const char *const label_meanings[labels] = {"several pictures", "several materials"};

typedef struct ply_element {
    char name[32];
    long long count;
    size_t line;           /* of the header */
    const char *from, *to; /* its rows */
    int property_count;
    ply_property properties[max_properties];
} ply_element;

typedef struct ply_parser {
    const char *path;
    int encoding;
    int element_count;
    ply_element elements[max_elements];
    long long vertices;
    mesh_extent extent;
    double at[3];  /* of the vertex being read */
    double rgb[3]; /* of the face being read, as sRGB from 0 to 1 if bytes */
    uint32_t face_corners;
    float *wedges; /* of the face being read: at most two for each corner */
    size_t wedge_values, wedge_room;
    double label[labels];      /* of the first face */
    bool differs[labels];      /* some face has another */
    bool labelled[labels];     /* a face was read */
    int pictures;              /* that comments name */
    bool has_misplaced_remark; /* a comment before the format or after an element */
    bool has_format;
    bool has_diffuse;  /* colours of vertices by names that Assimp does not know */
    bool has_unfinite; /* coordinates */
    bool moving;       /* the second pass */
    bool drops;        /* then of elements other than vertices and faces */
    double origin[3];  /* then of the vertices' coordinates */
    char *moved;       /* then of a binary file: a copy of its text */
    const char *text;
    mesh_rewrite rewrite; /* or that of a text */
    rk_mesh_hints *hints;
} ply_parser;

enum { ASCII, LITTLE, BIG }; /* encodings, in the order of their names in read_format */
static const char *const remedy = "export the mesh again";

/* --- header -------------------------------------------------------------------------------- */

static bool fail_header(const ply_parser *s, size_t line, const char *what, rk_error *error)
{
    return rk_fail(error, "%s:%zu: %s: %s", s->path, line, what, remedy);
}

static bool read_type(text_cursor *c, ply_type *type)
{
    char word[32];
    if (!text_read_word(c, word, sizeof word))
        return false;
    for (int i = 0; i < types; i++)
        if (strcmp(word, type_names[0][i]) == 0 || strcmp(word, type_names[1][i]) == 0) {
            *type = (ply_type)i;
            return true;
        }
    return false;
}

static bool read_format(ply_parser *s, text_cursor *c, rk_error *error)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char word[32];
    if (text_read_word(c, word, sizeof word))
        for (int i = ASCII; i <= BIG; i++)
            if (strcmp(word, names[i]) == 0) {
                s->encoding = i;
                s->has_format = true;
                return true;
            }
    return fail_header(s, c->line,
                       "the format is not ascii, binary_little_endian or binary_big_endian", error);
}

static bool read_element(ply_parser *s, text_cursor *c, rk_error *error)
{
    if (s->element_count == max_elements)
        return fail_header(s, c->line, "more than 16 kinds of elements", error);
    ply_element *e = &s->elements[s->element_count++];
    e->line = c->line;
    bool named = text_read_word(c, e->name, sizeof e->name);
    text_skip_blanks(c);
    if (!named || !text_read_integer(c, &e->count) || e->count < 0)
        return fail_header(s, c->line, "an element line needs a name and a count", error);
    if (e->count > UINT32_MAX)
        return rk_fail(error, "%s:%zu: %lld rows of %s exceed 32-bit indices: %s", s->path, c->line,
                       e->count, e->name, remedy);
    if (strcmp(e->name, "tristrips") == 0 && e->count > 0) /* Assimp makes one triangle of them */
        return rk_fail(error, "%s:%zu: has triangle strips, which are not read: save it with faces",
                       s->path, c->line);
    if (strcmp(e->name, "vertex") == 0)
        s->vertices = e->count;
    return true;
}

static bool is_geometry(const ply_element *e, const ply_property *p, const char *name)
{
    if (p->is_list)
        return strcmp(e->name, "face") == 0 &&
               (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0);
    static const char *const coordinates[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int i = 0; i < 6 && strcmp(e->name, "vertex") == 0; i++)
        if (strcmp(name, coordinates[i]) == 0)
            return true;
    return false;
}

static bool read_property(ply_parser *s, text_cursor *c, rk_error *error)
{
    if (s->element_count == 0)
        return fail_header(s, c->line, "a property precedes the first element", error);
    ply_element *e = &s->elements[s->element_count - 1];
    if (e->property_count == max_properties)
        return fail_header(s, c->line, "more than 128 properties in an element", error);
    ply_property *p = &e->properties[e->property_count++];
    text_cursor start = *c;
    char word[32];
    p->is_list = text_read_word(c, word, sizeof word) && strcmp(word, "list") == 0;
    if (!p->is_list)
        *c = start;
    if ((p->is_list && (!read_type(c, &p->count_type) || p->count_type >= FLOAT32)) ||
        !read_type(c, &p->type) || !text_read_word(c, word, sizeof word))
        return fail_header(s, c->line, "a property line needs known types and a name", error);
    p->is_geometry = is_geometry(e, p, word);
    bool is_axis = p->is_geometry && !p->is_list && strlen(word) == 1;
    p->axis = is_axis ? word[0] - 'x' : -1;
    p->channel = p->is_list || strcmp(e->name, "face") != 0 ? -1
                 : strcmp(word, "red") == 0                 ? 0
                 : strcmp(word, "green") == 0               ? 1
                 : strcmp(word, "blue") == 0                ? 2
                                                            : -1;
    p->label = -1;
    for (int i = 0; i < labels && !p->is_list && strcmp(e->name, "face") == 0; i++)
        if (strcmp(word, label_names[i]) == 0)
            p->label = i;
    p->is_wedge = p->is_list && strcmp(e->name, "face") == 0 && strcmp(word, "texcoord") == 0;
    s->has_diffuse |= strcmp(e->name, "vertex") == 0 && strcmp(word, "diffuse_red") == 0;
    return true;
}

/* Leaves the cursor on the first byte after end_header's line. */
static bool read_header(ply_parser *s, text_cursor *c, rk_error *error)
{
    char word[32];
    if (!text_read_word(c, word, sizeof word) || strcmp(word, "ply") != 0)
        return fail_header(s, c->line, "a PLY file begins with the line ply", error);
    bool ok = true;
    for (text_next_line(c); ok && c->at < c->end; text_next_line(c)) {
        if (!text_read_word(c, word, sizeof word))
            continue;
        if (strcmp(word, "end_header") == 0) {
            text_next_line(c);
            return true;
        }
        const bool is_remark = strcmp(word, "comment") == 0 || strcmp(word, "obj_info") == 0;
        s->has_misplaced_remark |= is_remark && (s->element_count > 0 || !s->has_format);
        s->pictures +=
            is_remark && text_read_word(c, word, sizeof word) && strcmp(word, "TextureFile") == 0;
        if (strcmp(word, "format") == 0)
            ok = read_format(s, c, error);
        else if (strcmp(word, "element") == 0)
            ok = read_element(s, c, error);
        else if (strcmp(word, "property") == 0)
            ok = read_property(s, c, error);
    }
    return ok && fail_header(s, c->line, "the file ends within the header", error);
}

static bool check_header(const ply_parser *s, rk_error *error)
{
    bool has_faces = false;
    for (int i = 0; i < s->element_count; i++) {
        const ply_element *e = &s->elements[i];
        if (e->count > 0 && e->property_count == 0)
            return fail_header(s, e->line, "an element without properties", error);
        has_faces |= e->count > 0 && strcmp(e->name, "face") == 0;
    }
    if (s->vertices > 0 && !has_faces)
        return rk_fail(
            error,
            "%s: has no triangles, only points: reconstruct its surface, for instance in "
            "MeshLab, and save that",
            s->path);
    if (s->vertices == 0)
        return rk_fail(error, "%s: has no triangles: choose a mesh with faces", s->path);
    return true;
}

/* --- rows ---------------------------------------------------------------------------------- */

static bool fail_ended(const ply_parser *s, const ply_element *e, long long row, rk_error *error)
{
    return rk_fail(error,
                   "%s:%zu: the header promises %lld rows of %s, but the file ends in row %lld: %s",
                   s->path, e->line, e->count, e->name, row + 1, remedy);
}

static bool parse_text_index(ply_parser *s, text_cursor *c, bool is_vertex, rk_error *error)
{
    long long index;
    text_skip_blanks(c);
    if (!is_vertex)
        return text_read_finite(c) ||
               rk_fail(error, "%s:%zu: a list's value is missing or not a number: %s", s->path,
                       c->line, remedy);
    if (!text_read_integer(c, &index) || !text_is_separator(c))
        return rk_fail(error, "%s:%zu: a face's index is missing or not a number: %s", s->path,
                       c->line, remedy);
    if (index < 0 || index >= s->vertices)
        return rk_fail(error, "%s:%zu: a face uses vertex %lld, but the file has %lld: %s", s->path,
                       c->line, index, s->vertices, remedy);
    return true;
}

static void see_label(ply_parser *s, int label, double value)
{
    if (!s->labelled[label])
        s->label[label] = value;
    s->differs[label] |= value != s->label[label];
    s->labelled[label] = true;
}

static bool keep_wedge_value(ply_parser *s, double value, rk_error *error)
{
    if (s->wedge_values == s->wedge_room) {
        const size_t room = s->wedge_room ? 2 * s->wedge_room : 64;
        void *larger = realloc(s->wedges, room * sizeof *s->wedges);
        if (!larger)
            return rk_fail(error, "%s: no memory for its texture coordinates: simplify the mesh",
                           s->path);
        s->wedges = larger;
        s->wedge_room = room;
    }
    s->wedges[s->wedge_values++] = (float)value;
    return true;
}

static bool parse_text_wedge(ply_parser *s, text_cursor *c, rk_error *error)
{
    double value;
    if (!text_read_coordinate(c, &value))
        return rk_fail(error, "%s:%zu: a list's value is missing or not a number: %s", s->path,
                       c->line, remedy);
    return keep_wedge_value(s, value, error);
}

static void count_face(ply_parser *s, size_t corners)
{
    s->face_corners = (uint32_t)corners;
    if (corners < 3 || s->moving)
        return;
    s->hints->faces++;
    s->hints->corners += corners;
}

static bool is_foreign(const ply_element *e)
{
    return strcmp(e->name, "vertex") != 0 && strcmp(e->name, "face") != 0;
}

/* Assimp does not skip elements that precede vertices or faces. */
static bool has_foreign_before_ours(const ply_parser *s)
{
    bool has_foreign = false;
    for (int i = 0; i < s->element_count; i++) {
        if (has_foreign && !is_foreign(&s->elements[i]))
            return true;
        has_foreign |= is_foreign(&s->elements[i]);
    }
    return false;
}

/* In the second pass, coordinates are written relative to the first vertex if it is far away. */
static bool parse_text_axis(ply_parser *s, text_cursor *c, int axis)
{
    text_skip_blanks(c);
    const char *from = c->at;
    if (!text_read_coordinate(c, &s->at[axis]))
        return false;
    const double moved = s->at[axis] - s->origin[axis];
    if (!s->moving || moved == s->at[axis])
        return true;
    rewrite_skip(&s->rewrite, from, c->at);
    if (isfinite(moved))
        fprintf(s->rewrite.out, "%.9g", moved);
    else
        fputs("nan", s->rewrite.out);
    return true;
}

static double channel_scale(ply_type type)
{
    return type == UINT8 ? 1 / 255.0 : type == UINT16 ? 1 / 65535.0 : 1;
}

static bool parse_text_number(ply_parser *s, text_cursor *c, const ply_property *p)
{
    char word[64];
    double value;
    if (p->axis >= 0)
        return parse_text_axis(s, c, p->axis);
    if (p->is_geometry)
        return text_read_coordinate(c, &value);
    if (!text_read_word(c, word, sizeof word))
        return false;
    if (p->channel >= 0)
        s->rgb[p->channel] = strtod(word, NULL) * channel_scale(p->type);
    if (p->label >= 0)
        see_label(s, p->label, strtod(word, NULL));
    return true;
}

static bool has_face_colours(const ply_element *e)
{
    int channels = 0;
    for (int k = 0; k < e->property_count; k++)
        channels |= e->properties[k].channel >= 0 ? 1 << e->properties[k].channel : 0;
    return channels == 7;
}

/* Grows with the rows: the header may promise more than there are. */
static bool keep_face_colour(ply_parser *s, rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    const size_t count = h->face_colour_count;
    if ((count & (count - 1)) == 0) {
        void *room = realloc(h->face_colours, (count ? 2 * count : 1) * sizeof *h->face_colours);
        if (!room)
            return rk_fail(error, "%s: no memory for the colours of its faces: simplify the mesh",
                           s->path);
        h->face_colours = room;
    }
    const rk_vec3 rgb = rk_vec((float)s->rgb[0], (float)s->rgb[1], (float)s->rgb[2]);
    h->face_colours[h->face_colour_count++] = (rk_mesh_colours_face){s->face_corners, rgb};
    return true;
}

static bool has_wedges(const ply_element *e)
{
    for (int k = 0; k < e->property_count; k++)
        if (e->properties[k].is_wedge)
            return true;
    return false;
}

/* A face without texture coordinates takes the picture's corner. */
static bool end_wedges(ply_parser *s, rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    const bool fits = s->wedge_values == 2 * (size_t)s->face_corners;
    for (uint32_t i = 0; i < s->face_corners && s->face_corners >= 3; i++) {
        if ((h->wedge_count & (h->wedge_count - 1)) == 0) {
            void *room =
                realloc(h->wedges, (h->wedge_count ? 2 * h->wedge_count : 1) * sizeof *h->wedges);
            if (!room)
                return rk_fail(
                    error, "%s: no memory for its texture coordinates: simplify the mesh", s->path);
            h->wedges = room;
        }
        for (int k = 0; k < 2; k++)
            h->wedges[h->wedge_count][k] = fits ? s->wedges[2 * i + (uint32_t)k] : 0;
        h->wedge_count++;
    }
    s->wedge_values = 0;
    return true;
}

/* A vertex, a face, or something else. */
static bool end_row(ply_parser *s, const ply_element *e, rk_error *error)
{
    if (s->moving)
        return true;
    if (strcmp(e->name, "face") == 0 && has_wedges(e) && !end_wedges(s, error))
        return false;
    if (strcmp(e->name, "face") == 0 && has_face_colours(e))
        return keep_face_colour(s, error);
    if (strcmp(e->name, "vertex") != 0)
        return true;
    s->has_unfinite |= !isfinite(s->at[0] + s->at[1] + s->at[2]);
    extent_add(&s->extent, s->at);
    return true;
}

static bool parse_text_property(ply_parser *s, text_cursor *c, const ply_property *p,
                                rk_error *error)
{
    if (!p->is_list)
        return parse_text_number(s, c, p) ||
               rk_fail(error, "%s:%zu: a number is missing: %s", s->path, c->line, remedy);
    long long count;
    text_skip_blanks(c);
    if (!text_read_integer(c, &count) || count < 0)
        return rk_fail(error, "%s:%zu: a list's count is missing or not a number: %s", s->path,
                       c->line, remedy);
    for (long long i = 0; i < count; i++)
        if (p->is_wedge && !s->moving ? !parse_text_wedge(s, c, error)
                                      : !parse_text_index(s, c, p->is_geometry, error))
            return false;
    if (p->is_geometry)
        count_face(s, (size_t)count);
    return true;
}

static bool parse_text_row(ply_parser *s, text_cursor *c, const ply_element *e, long long row,
                           rk_error *error)
{
    if (!text_next_content(c))
        return fail_ended(s, e, row, error);
    for (int k = 0; k < e->property_count; k++)
        if (!parse_text_property(s, c, &e->properties[k], error))
            return false;
    if (!end_row(s, e, error))
        return false;
    text_next_line(c);
    return true;
}

static bool parse_text(ply_parser *s, text_cursor *c, rk_error *error)
{
    for (int i = 0; i < s->element_count; i++) {
        ply_element *e = &s->elements[i];
        const char *from = c->at;
        for (long long row = 0; row < e->count; row++)
            if (!parse_text_row(s, c, e, row, error))
                return false;
        if (s->moving && s->drops && is_foreign(e))
            rewrite_skip(&s->rewrite, from, c->at);
    }
    return true;
}

static uint64_t read_bits(const ply_parser *s, const char *at, size_t size)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)(unsigned char)at[s->encoding == LITTLE ? i : size - 1 - i] << (8 * i);
    return bits;
}

static double read_value(const ply_parser *s, const char *at, ply_type type)
{
    uint64_t bits = read_bits(s, at, type_sizes[type]);
    uint32_t low = (uint32_t)bits;
    float single;
    double wide;
    switch (type) {
    case INT8:
        return (int8_t)bits;
    case INT16:
        return (int16_t)bits;
    case INT32:
        return (int32_t)bits;
    case FLOAT32:
        memcpy(&single, &low, sizeof single);
        return (double)single;
    case FLOAT64:
        memcpy(&wide, &bits, sizeof wide);
        return fabs(wide) <= 0x1.fffffep127 ? wide : (double)INFINITY;
    default:
        return low;
    }
}

static bool parse_binary_indices(ply_parser *s, const char *at, const ply_property *p, size_t count,
                                 long long row, rk_error *error)
{
    for (size_t i = 0; i < count; i++) {
        double index = read_value(s, at + i * type_sizes[p->type], p->type);
        if (!(index >= 0 && index < (double)s->vertices))
            return rk_fail(error, "%s: face %lld uses vertex %.0f, but the file has %lld: %s",
                           s->path, row, index, s->vertices, remedy);
    }
    return true;
}

static void write_bits(const ply_parser *s, size_t offset, uint64_t bits, size_t size)
{
    for (size_t i = 0; i < size; i++)
        s->moved[offset + (s->encoding == LITTLE ? i : size - 1 - i)] = (char)(bits >> 8 * i);
}

static void take_binary(ply_parser *s, const char *from, const ply_property *p)
{
    s->at[p->axis] = read_value(s, from, p->type);
    if (!s->moving || s->origin[p->axis] == 0)
        return;
    double moved = s->at[p->axis] - s->origin[p->axis];
    float single = (float)moved;
    uint64_t bits = 0;
    uint32_t low;
    memcpy(&low, &single, sizeof low);
    memcpy(&bits, &moved, sizeof bits);
    write_bits(s, (size_t)(from - s->text), p->type == FLOAT64 ? bits : low, type_sizes[p->type]);
}

static bool parse_binary_row(ply_parser *s, text_cursor *c, const ply_element *e, long long row,
                             rk_error *error)
{
    for (int k = 0; k < e->property_count; k++) {
        const ply_property *p = &e->properties[k];
        size_t size = type_sizes[p->type], left = (size_t)(c->end - c->at);
        if (p->is_list) {
            size_t count_size = type_sizes[p->count_type];
            if (left < count_size)
                return fail_ended(s, e, row, error);
            double count = read_value(s, c->at, p->count_type);
            c->at += count_size;
            if (count < 0 || count * (double)size > (double)(left - count_size))
                return fail_ended(s, e, row, error);
            if (p->is_geometry && !parse_binary_indices(s, c->at, p, (size_t)count, row, error))
                return false;
            if (p->is_geometry)
                count_face(s, (size_t)count);
            for (size_t i = 0; p->is_wedge && !s->moving && i < (size_t)count; i++)
                if (!keep_wedge_value(s, read_value(s, c->at + i * size, p->type), error))
                    return false;
            c->at += (size_t)count * size;
            continue;
        }
        if (left < size)
            return fail_ended(s, e, row, error);
        if (p->axis >= 0)
            take_binary(s, c->at, p);
        if (p->channel >= 0)
            s->rgb[p->channel] = read_value(s, c->at, p->type) * channel_scale(p->type);
        if (p->label >= 0)
            see_label(s, p->label, read_value(s, c->at, p->type));
        c->at += size;
    }
    return end_row(s, e, error);
}

static bool parse_binary(ply_parser *s, text_cursor *c, rk_error *error)
{
    for (int i = 0; i < s->element_count; i++) {
        ply_element *e = &s->elements[i];
        e->from = c->at;
        for (long long row = 0; row < e->count; row++)
            if (!parse_binary_row(s, c, e, row, error))
                return false;
        e->to = c->at;
    }
    return true;
}

/* Of the copy. */
static void drop_foreign_rows(ply_parser *s)
{
    size_t kept = (size_t)(s->elements[0].from - s->text);
    for (int i = 0; i < s->element_count; i++) {
        const ply_element *e = &s->elements[i];
        const size_t size = is_foreign(e) ? 0 : (size_t)(e->to - e->from);
        memmove(s->moved + kept, s->moved + (e->from - s->text), size);
        kept += size;
    }
    s->hints->size = kept;
}

static bool parse_rows(ply_parser *s, text_cursor c, rk_error *error)
{
    return s->encoding == ASCII ? parse_text(s, &c, error) : parse_binary(s, &c, error);
}

/* A name from the file, fit to be printed. */
static const char *printable(char name[32])
{
    for (char *at = name; *at; at++)
        if (*at < '!' || *at > '~')
            *at = '?';
    return name;
}

static void tell_what_is_not_drawn(ply_parser *s)
{
    if (s->pictures > 1 && !s->differs[PICTURE])
        rk_mesh_hints_note(s->hints, s->path,
                           "names %d pictures (comment TextureFile): the picture shows one of them "
                           "everywhere",
                           s->pictures);
    for (int i = 0; i < labels; i++)
        if (s->differs[i])
            rk_mesh_hints_note(s->hints, s->path, "has %s for its faces (%s): the picture shows %s",
                               label_meanings[i], label_names[i],
                               i == PICTURE ? "one of them everywhere" : "none of them");
    if (s->has_diffuse)
        rk_mesh_hints_note(s->hints, s->path,
                           "has colours of vertices as diffuse_red, diffuse_green and "
                           "diffuse_blue, which the picture does not show: name them red, green "
                           "and blue");
    for (int i = 0; i < s->element_count; i++) {
        ply_element *e = &s->elements[i];
        if (e->count > 0 && is_foreign(e))
            rk_mesh_hints_note(s->hints, s->path,
                               "has \"%s\" elements, which the picture does not show",
                               printable(e->name));
    }
}

/* Integers stay as they are. */
static bool is_movable(const ply_parser *s)
{
    for (int i = 0; i < s->element_count; i++)
        for (int k = 0; k < s->elements[i].property_count; k++) {
            const ply_property *p = &s->elements[i].properties[k];
            if (p->axis >= 0 && s->encoding != ASCII && p->type < FLOAT32)
                return false;
        }
    return extent_is_far(&s->extent) || (s->has_unfinite && s->encoding == ASCII);
}

static bool write_moved(ply_parser *s, text_cursor rows, const char *text, size_t size,
                        rk_error *error)
{
    rk_mesh_hints *h = s->hints;
    s->moving = true;
    s->text = text;
    if (is_movable(s))
        memcpy(s->origin, extent_origin(&s->extent), sizeof s->origin);
    if (s->encoding != ASCII) {
        h->text = s->moved = rk_allocate_unset(size, 1, s->path, error);
        h->size = size;
        if (!s->moved)
            return false;
        memcpy(s->moved, text, size);
        const bool ok = parse_rows(s, rows, error);
        if (ok && s->drops)
            drop_foreign_rows(s);
        return ok;
    }
    s->rewrite = (mesh_rewrite){open_memstream(&h->text, &h->size), text};
    bool ok = s->rewrite.out && parse_rows(s, rows, error);
    if (s->rewrite.out) {
        rewrite_skip(&s->rewrite, text + size, text + size);
        ok = fclose(s->rewrite.out) == 0 && ok;
    }
    return ok || rk_fail(error, "%s: no memory for its text: simplify the mesh", s->path);
}

static bool mend_header(const ply_parser *s, size_t rows, const char *text, size_t size,
                        rk_error *error)
{
    const char *from = s->hints->text ? s->hints->text : text;
    const size_t left = s->hints->text ? s->hints->size : size;
    const bool begins_with_feed = s->encoding != ASCII && rows < left && from[rows] == '\n';
    return rk_mesh_ply_header_mend(s->hints, text, size, rows, s->has_misplaced_remark,
                                   begins_with_feed, s->drops) ||
           rk_fail(error, "%s: no memory for its text: simplify the mesh", s->path);
}

bool rk_mesh_syntax_ply(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    hints->plain = true;
    ply_parser s = {.path = path, .hints = hints};
    text_cursor c = text_begin(text, size);
    bool ok = read_header(&s, &c, error) && check_header(&s, error) && parse_rows(&s, c, error);
    free(s.wedges);
    if (!ok)
        return false;
    for (int i = 0; i < s.element_count; i++)
        if (strcmp(s.elements[i].name, "tristrips") == 0)
            hints->faces = 0;
    hints->vertices = (size_t)s.vertices;
    tell_what_is_not_drawn(&s);
    s.drops = has_foreign_before_ours(&s);
    return ((!is_movable(&s) && !s.drops) || write_moved(&s, c, text, size, error)) &&
           mend_header(&s, (size_t)(c.at - text), text, size, error);
}
