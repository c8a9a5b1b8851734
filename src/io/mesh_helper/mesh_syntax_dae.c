/* io/mesh_helper/mesh_syntax.h for Collada: Assimp 5.2 gives up on a blank before a number, reads
 * an index of -1 as 0, aborts on a picture without a name, and does not read which set of texture
 * coordinates a material is bound to; it takes the first number in the name of the effect's channel
 * for the set, so that is what it is given. Format: Khronos, "COLLADA, Digital Asset Schema Release
 * 1.4.1". */
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/mesh_up.h"
#include "io/mesh_helper/xml_tag.h"

#include <stdio.h>

enum { most_bindings = 64, most_sets = 32 };

typedef struct dae_binding {
    xml_span channel; /* as the effect calls it */
    unsigned set;
} dae_binding;

typedef struct dae_parser {
    const char *path;
    rk_mesh_hints *hints;
    mesh_rewrite rewrite;
    uint32_t sets; /* bit by bit, those that meshes have */
    dae_binding bindings[most_bindings];
    int binding_count;
    xml_span version;      /* of the format */
    bool is_torn;          /* a channel is bound to different sets */
    bool is_other_profile; /* inside an effect for other programs */
    bool has_other_pictures, has_nameless;
} dae_parser;

static unsigned set_of(xml_span tag, const char *name)
{
    xml_span value;
    const double set = xml_find_attribute(tag, name, &value) ? xml_number(value) : 0;
    return set > 0 && set < most_sets ? (unsigned)set : 0;
}

static dae_binding *find_binding(dae_parser *s, xml_span channel)
{
    const size_t length = (size_t)(channel.to - channel.from);
    for (int i = 0; i < s->binding_count; i++) {
        const xml_span other = s->bindings[i].channel;
        if ((size_t)(other.to - other.from) == length &&
            memcmp(other.from, channel.from, length) == 0)
            return &s->bindings[i];
    }
    return NULL;
}

static void see_binding(dae_parser *s, xml_span tag)
{
    xml_span channel;
    if (!xml_find_attribute(tag, "semantic", &channel))
        return;
    const unsigned set = set_of(tag, "input_set");
    const dae_binding *other = find_binding(s, channel);
    s->is_torn |= other && other->set != set;
    if (!other && s->binding_count < most_bindings)
        s->bindings[s->binding_count++] = (dae_binding){channel, set};
}

static bool is_bound_input(xml_span tag)
{
    xml_span value;
    return xml_is_tag(tag, "input") && xml_find_attribute(tag, "semantic", &value) &&
           xml_is_text(value, "TEXCOORD");
}

static void see_profile(dae_parser *s, xml_span tag)
{
    static const char begin[] = "<profile_";
    const size_t length = (size_t)(tag.to - tag.from);
    if (length > sizeof begin && memcmp(tag.from, begin, sizeof begin - 1) == 0)
        s->is_other_profile = !xml_is_tag(tag, "profile_COMMON") && tag.to[-2] != '/';
    if (length > sizeof begin && memcmp(tag.from, "</profile_", sizeof begin) == 0)
        s->is_other_profile = false;
    s->has_other_pictures |= s->is_other_profile && xml_is_tag(tag, "init_from");
}

/* False with an error if a face has an index below 0, or for a <library>, of which later versions
 * make one element a kind. */
static bool see_tag(dae_parser *s, xml_span tag, const char *end, rk_error *error)
{
    xml_span version;
    if (is_bound_input(tag))
        s->sets |= 1u << set_of(tag, "set");
    if (xml_is_tag(tag, "bind_vertex_input"))
        see_binding(s, tag);
    see_profile(s, tag);
    if (xml_is_tag(tag, "COLLADA") && xml_find_attribute(tag, "version", &version))
        s->version = version;
    if (xml_is_tag(tag, "library") && xml_number(s->version) < 1.4)
        return rk_fail(error,
                       "%s: is Collada %.*s, of which Assimp reads 1.4 and 1.5: export it as one "
                       "of these, or as OBJ",
                       s->path, (int)(s->version.to - s->version.from), s->version.from);
    if (!xml_is_tag(tag, "p"))
        return true;
    const char *close = memchr(tag.to, '<', (size_t)(end - tag.to));
    const char *sign = close ? memchr(tag.to, '-', (size_t)(close - tag.to)) : NULL;
    return !sign || rk_fail(error,
                            "%s: a face has the index %.0f, where Collada counts from 0: export it "
                            "again",
                            s->path, xml_number((xml_span){sign, close}));
}

/* --- the copy ------------------------------------------------------------------------------ */

/* Assimp numbers the sets that are there from 0. */
static unsigned number_of_set(const dae_parser *s, unsigned set)
{
    unsigned number = 0;
    for (unsigned i = 0; i < set; i++)
        number += s->sets >> i & 1;
    return number;
}

static void write_channel(dae_parser *s, xml_span tag)
{
    xml_span channel;
    const dae_binding *binding =
        xml_find_attribute(tag, "texcoord", &channel) ? find_binding(s, channel) : NULL;
    if (!binding)
        return;
    rewrite_skip(&s->rewrite, channel.from, channel.to);
    fprintf(s->rewrite.out, "%u", number_of_set(s, binding->set));
}

static void write_name(dae_parser *s, xml_span tag, const char *end)
{
    const bool is_whole = tag.to[-2] == '/';
    const char *next = tag.to;
    while (next < end && xml_is_blank(*next))
        next++;
    if (!is_whole && !(end - next > 1 && memcmp(next, "</", 2) == 0))
        return;
    s->has_nameless = true;
    rewrite_skip(&s->rewrite, is_whole ? tag.from : tag.to, tag.to);
    fprintf(s->rewrite.out, is_whole ? "<init_from>%s</init_from>" : "%s", RK_MESH_NO_PICTURE);
}

static void write_tag(dae_parser *s, xml_span tag, const char *end)
{
    if (xml_is_tag(tag, "texture") && !s->is_torn)
        write_channel(s, tag);
    if (xml_is_tag(tag, "init_from"))
        write_name(s, tag, end);
    const char *next = tag.to;
    while (next < end && xml_is_blank(*next))
        next++;
    if (next > tag.to && next < end && strchr("+-.0123456789", *next))
        rewrite_skip(&s->rewrite, tag.to, next);
}

static void note(const dae_parser *s)
{
    if (s->is_torn)
        rk_mesh_hints_note(s->hints, s->path,
                           "binds a channel to different sets of texture coordinates, of which "
                           "Assimp reads one: pictures may be misplaced");
    if (s->has_other_pictures)
        rk_mesh_hints_note(s->hints, s->path,
                           "has pictures in effects for other programs (such as profile_CG), "
                           "which Assimp does not read: they are not drawn");
    if (s->has_nameless)
        rk_mesh_hints_note(s->hints, s->path,
                           "has a picture without a file's name (an empty init_from), whose "
                           "surfaces are plain");
}

bool rk_mesh_syntax_dae(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    const char *at = text, *const end = text + size;
    static const char oldest[] = "1.3";
    dae_parser s = {.path = path, .hints = hints, .version = {oldest, oldest + 3}};
    hints->up = rk_mesh_up_of_collada(text, size);
    for (xml_span tag; xml_next_tag(&at, end, &tag);)
        if (!see_tag(&s, tag, end, error))
            return false;
    if (!rewrite_begin(&s.rewrite, path, text, hints, error))
        return false;
    at = text;
    for (xml_span tag; xml_next_tag(&at, end, &tag);)
        write_tag(&s, tag, end);
    if (!rewrite_end(&s.rewrite, path, end, error))
        return false;
    note(&s);
    return true;
}
