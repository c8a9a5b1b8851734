/* io/mesh_helper/mesh_syntax.h for AMF, whose objects have vertices and volumes of triangles:
 * Assimp 5.2 reads the first volume of an object, so the others are joined to it. Format: ISO/ASTM
 * 52915, "Additive manufacturing file format (AMF)". */
#include "io/mesh_helper/mesh_amf_places.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/xml_tag.h"

#include <stdlib.h>
#include <string.h>

typedef struct amf_parser {
    char *text;     /* a copy, in which blanks replace what divides two volumes */
    size_t volumes; /* of this object, so far */
    char *blank;    /* from here to the volume's first triangle; or NULL */
    size_t triangles;
    bool joined, has_looks; /* of a volume that is joined: a material or a colour */
} amf_parser;

static void blank_up_to(amf_parser *s, char *to)
{
    for (char *at = s->blank; at && at < to; at++)
        if (*at != '\n')
            *at = ' ';
    s->blank = NULL;
}

static bool has_word(const char *text, size_t length, const char *word)
{
    for (size_t i = 0; i + strlen(word) <= length; i++)
        if (memcmp(text + i, word, strlen(word)) == 0)
            return true;
    return false;
}

/* `length` includes both brackets. */
static void see_tag(amf_parser *s, char *tag, size_t length, char **last_end)
{
    const bool is_empty = tag[length - 2] == '/';
    const xml_span span = {tag, tag + length};
    if (xml_is_tag(span, "mesh")) {
        s->volumes = 0;
    } else if (xml_is_tag(span, "volume")) {
        if (s->volumes > 0 || is_empty)
            s->blank = is_empty ? tag : *last_end;
        s->joined |= s->blank != NULL;
        s->has_looks |= s->blank && has_word(tag, length, "materialid");
        s->volumes += !is_empty;
        if (is_empty)
            blank_up_to(s, tag + length);
    } else if (xml_is_tag(span, "/volume")) {
        blank_up_to(s, tag);
        *last_end = tag;
    } else if (xml_is_tag(span, "color")) {
        s->has_looks |= s->blank != NULL;
    } else if (xml_is_tag(span, "triangle")) {
        blank_up_to(s, tag);
        s->triangles++;
    }
}

/* Assimp takes a missing opacity for 0, and so a black colour for none. Adds it to colours without
 * one, and notes if one is below 1. */
static char *copy_with_opacities(const char *path, const char *text, size_t size, size_t *copied,
                                 bool *is_clear, rk_error *error)
{
    static const char opaque[] = "<a>1</a>", ending[] = "</color";
    const char *const end = text + size, *from = text, *close;
    size_t colours = 0;
    for (const char *at = text; (at = memchr(at, '<', (size_t)(end - at))); at++)
        colours += (size_t)(end - at) > sizeof ending && memcmp(at, ending, sizeof ending - 1) == 0;
    char *const copy = rk_allocate_unset(size + colours * (sizeof opaque - 1), 1, path, error);
    char *to = copy;
    bool has_opacity = true;
    for (const char *at = text; copy && (at = memchr(at, '<', (size_t)(end - at))); at = close) {
        close = memchr(at, '>', (size_t)(end - at));
        if (!close++)
            break;
        const xml_span tag = {at, close};
        if (xml_is_tag(tag, "color")) {
            has_opacity = false;
        } else if (xml_is_tag(tag, "a") && !has_opacity) {
            char number[32] = {0};
            memcpy(number, close, (size_t)(end - close) < 31 ? (size_t)(end - close) : 31);
            *is_clear |= strtod(number, NULL) < 1;
            has_opacity = true;
        } else if (xml_is_tag(tag, ending + 1) && !has_opacity) {
            memcpy(to, from, (size_t)(at - from));
            to += at - from;
            memcpy(to, opaque, sizeof opaque - 1);
            to += sizeof opaque - 1;
            from = at;
            has_opacity = true;
        }
    }
    if (copy)
        memcpy(to, from, (size_t)(end - from));
    *copied = (size_t)(to - copy) + (size_t)(end - from);
    return copy;
}

bool rk_mesh_syntax_amf(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    if (size >= 2 && memcmp(text, "PK", 2) == 0)
        return rk_fail(error, "%s: is compressed by ZIP: unzip it, and name the file in it", path);
    if (!rk_mesh_amf_places_read(hints, path, text, size, error))
        return false;
    size_t copied = 0;
    bool is_clear = false;
    amf_parser s = {.text = copy_with_opacities(path, text, size, &copied, &is_clear, error)};
    if (!s.text)
        return false;
    char *const end = s.text + copied, *last_end = NULL;
    for (char *at = s.text, *close; (at = memchr(at, '<', (size_t)(end - at))); at = close) {
        close = memchr(at, '>', (size_t)(end - at));
        if (!close++)
            break;
        see_tag(&s, at, (size_t)(close - at), &last_end);
    }
    hints->faces = s.triangles;
    hints->corners = 3 * s.triangles;
    if (s.has_looks)
        rk_mesh_hints_note(hints, path,
                           "has objects of several volumes, which are drawn in the colour of their "
                           "first one");
    if (is_clear)
        rk_mesh_hints_note(hints, path, "has transparent colours, which are drawn as opaque");
    if (!s.joined && copied == size) {
        free(s.text);
        return true;
    }
    hints->text = s.text;
    hints->size = copied;
    return true;
}
