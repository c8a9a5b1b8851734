/* io/mesh_helper/mesh_syntax.h for X3D in XML: tells what Assimp leaves out, and writes tags that
 * Assimp reads wrongly as it needs them. Format: ISO/IEC 19775-1 and 19776-1. */
#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/xml_tag.h"

#include <stdio.h>
#include <string.h>

/* Nodes that show something, or hold what does. */
static const char *const undrawn[] = {
    "Anchor",       "Billboard",         "CADAssembly",      "CADFace",      "CADLayer",
    "CADPart",      "Collision",         "GeoElevationGrid", "GeoLOD",       "GeoLocation",
    "GeoTransform", "HAnimHumanoid",     "IndexedQuadSet",   "LOD",          "MovieTexture",
    "MultiTexture", "NurbsPatchSurface", "ParticleSystem",   "PixelTexture", "QuadSet",
    "Text",         "TriangleStripSet"};

enum { undrawn_count = sizeof undrawn / sizeof *undrawn };

typedef struct x3d_parser {
    const char *path;
    rk_mesh_hints *hints;
    mesh_rewrite rewrite;
    bool has_undrawn[undrawn_count], has_crease, has_prototypes;
} x3d_parser;

/* --- addresses ----------------------------------------------------------------------------- */

/* A list of strings in quotes, or one string without. Moves `at` behind the string. */
static bool next_string(const char **at, const char *end, xml_span *string)
{
    static const char escaped[] = "&quot;";
    while (*at < end && (xml_is_blank(**at) || **at == ','))
        ++*at;
    const bool is_escaped = end - *at >= 6 && memcmp(*at, escaped, 6) == 0;
    if (*at == end)
        return false;
    if (!is_escaped && **at != '"') {
        *string = (xml_span){*at, end};
        *at = end;
        return true;
    }
    const size_t quote = is_escaped ? 6 : 1;
    string->from = *at + quote;
    for (const char *c = string->from; (size_t)(end - c) >= quote; c++)
        if (memcmp(c, is_escaped ? escaped : "\"", quote) == 0) {
            string->to = c;
            *at = c + quote;
            return true;
        }
    return false;
}

/* Assimp refuses the whole file for a string in quotes without a blank, joins it to the next one,
 * and loses blanks; so it is given one alone: the first that is there. */
static void write_address(x3d_parser *s, xml_span list, bool is_needed)
{
    char found[RK_MESH_FILES_NAME];
    xml_span first = {NULL, NULL}, string;
    bool is_there = false;
    for (const char *at = list.from; !is_there && next_string(&at, list.to, &string);) {
        const size_t length = (size_t)(string.to - string.from);
        is_there = rk_mesh_files_find(found, s->path, "", string.from, length);
        if (!first.from || is_there)
            first = string;
    }
    if (!first.from || (first.from == list.from && first.to == list.to))
        return;
    if (is_needed && !is_there && !*s->hints->missing)
        snprintf(s->hints->missing, sizeof s->hints->missing, "%.*s", (int)(first.to - first.from),
                 first.from);
    rewrite_skip(&s->rewrite, list.from, list.to);
    for (const char *c = first.from; c < first.to; c++)
        if (xml_is_blank(*c))
            fputs("%20", s->rewrite.out);
        else
            fputc(*c, s->rewrite.out);
}

/* --- tags ---------------------------------------------------------------------------------- */

/* Assimp's points downwards, and upwards if its height is negative. */
static void turn_cone(x3d_parser *s, xml_span tag)
{
    xml_span side, height, other;
    if (xml_find_attribute(tag, "USE", &other) ||
        (xml_find_attribute(tag, "side", &side) && *side.from == 'f'))
        return;
    if (!xml_find_attribute(tag, "height", &height)) {
        rewrite_skip(&s->rewrite, tag.from + 5, tag.from + 5);
        fputs(" height='-2'", s->rewrite.out);
        return;
    }
    const double value = xml_number(height);
    rewrite_skip(&s->rewrite, height.from, height.to);
    fprintf(s->rewrite.out, "%.9g", -value);
}

static void see_tag(x3d_parser *s, xml_span tag)
{
    xml_span value;
    if (xml_is_tag(tag, "X3D") && xml_find_attribute(tag, "version", &value))
        s->hints->pictures_replace = xml_number(value) < 4;
    for (int i = 0; i < undrawn_count; i++)
        s->has_undrawn[i] |= xml_is_tag(tag, undrawn[i]);
    s->has_prototypes |= xml_is_tag(tag, "ProtoInstance");
    s->has_crease |= xml_find_attribute(tag, "creaseAngle", &value) && xml_number(value) > 0;
    if (xml_is_tag(tag, "Cone"))
        turn_cone(s, tag);
    if ((xml_is_tag(tag, "ImageTexture") || xml_is_tag(tag, "Inline")) &&
        xml_find_attribute(tag, "url", &value))
        write_address(s, value, xml_is_tag(tag, "Inline"));
    if (xml_is_tag(tag, "MetadataString") && xml_find_attribute(tag, "value", &value))
        write_address(s, value, false);
}

static void note(const x3d_parser *s)
{
    char *list = s->hints->undrawn;
    for (int i = 0; i < undrawn_count; i++)
        if (s->has_undrawn[i]) {
            const size_t length = strlen(list);
            snprintf(list + length, sizeof s->hints->undrawn - length, "%s%s", length ? ", " : "",
                     undrawn[i]);
        }
    if (*list)
        rk_mesh_hints_note(
            s->hints, s->path,
            "has nodes (%s), which Assimp does not read: what they hold is not drawn", list);
    if (s->has_crease)
        rk_mesh_hints_note(s->hints, s->path,
                           "has creaseAngle, which Assimp does not read: smooth faces without "
                           "normals are drawn flat");
    if (s->has_prototypes)
        rk_mesh_hints_note(s->hints, s->path,
                           "has prototypes (ProtoInstance), which Assimp does not read: what they "
                           "stand for is not drawn");
}

bool rk_mesh_syntax_x3d(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    const char *at = text, *const end = text + size;
    x3d_parser s = {.path = path, .hints = hints};
    hints->pictures_replace = true;
    if (!rewrite_begin(&s.rewrite, path, text, hints, error))
        return false;
    for (xml_span tag; xml_next_tag(&at, end, &tag);)
        see_tag(&s, tag);
    if (!rewrite_end(&s.rewrite, path, end, error))
        return false;
    note(&s);
    return true;
}
