/* A USE follows its DEF, whose element is complete before it, so copies within copies come to an
 * end. Format: ISO/IEC 19775-1, 4.4.3, "DEF/USE semantics", and 19776-1, 4.3.4. */
#include "io/mesh_helper/mesh_x3d_groups.h"

#include "io/mesh_helper/xml_tag.h"

#include <stdint.h>
#include <stdio.h>

enum { deepest = 100, longest_shown = 100 };

/* Assimp takes about 20 bytes for each of the text, and has 256 MB and 128 for each of the file. */
enum { base_text = 12 << 20, text_per_byte = 6 };

typedef struct x3d_def {
    xml_span name, tag;
} x3d_def;

typedef struct x3d_groups {
    const char *path, *end;
    x3d_def *defs;
    size_t def_count, written, most;
    FILE *out;
    rk_error *error;
} x3d_groups;

/* Of those that Assimp reads; the others it leaves out with what they hold. */
static bool is_group(xml_span tag)
{
    return xml_is_tag(tag, "Group") || xml_is_tag(tag, "StaticGroup") ||
           xml_is_tag(tag, "Switch") || xml_is_tag(tag, "Transform");
}

static bool is_def(xml_span tag, xml_span *name)
{
    return !strchr("!?/", tag.from[1]) && xml_find_attribute(tag, "DEF", name);
}

/* Of the element that the tag begins. */
static const char *end_of_element(xml_span tag, const char *end)
{
    const char *at = tag.to;
    for (size_t depth = tag.to[-2] != '/'; depth > 0 && xml_next_tag(&at, end, &tag);) {
        if (tag.from[1] == '/')
            depth--;
        else if (!strchr("!?", tag.from[1]))
            depth += tag.to[-2] != '/';
    }
    return at;
}

static bool is_empty(xml_span tag, const char *end)
{
    const char *at = tag.to;
    while (at < end && xml_is_blank(*at))
        at++;
    return tag.to[-2] == '/' || (end - at > 1 && memcmp(at, "</", 2) == 0);
}

/* --- definitions --------------------------------------------------------------------------- */

static int compare_defs(const void *a, const void *b)
{
    const x3d_def *one = a, *other = b;
    const size_t lengths[2] = {(size_t)(one->name.to - one->name.from),
                               (size_t)(other->name.to - other->name.from)};
    const size_t length = lengths[0] < lengths[1] ? lengths[0] : lengths[1];
    const int order = memcmp(one->name.from, other->name.from, length);
    if (order != 0)
        return order;
    if (lengths[0] != lengths[1])
        return lengths[0] < lengths[1] ? -1 : 1;
    return one->tag.from < other->tag.from ? -1 : one->tag.from > other->tag.from;
}

static bool add_def(x3d_groups *s, xml_span name, xml_span tag)
{
    const size_t n = s->def_count;
    if ((n & (n - 1)) == 0) {
        void *room = realloc(s->defs, (n ? 2 * n : 1) * sizeof *s->defs);
        if (!room)
            return false;
        s->defs = room;
    }
    s->defs[s->def_count++] = (x3d_def){name, tag};
    return true;
}

/* The last of its name before the tag, or NULL. */
static const x3d_def *find_def(const x3d_groups *s, xml_span name, xml_span tag)
{
    const x3d_def key = {name, tag};
    size_t low = 0, high = s->def_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (compare_defs(&s->defs[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    const size_t length = (size_t)(name.to - name.from);
    const x3d_def *def = low > 0 ? &s->defs[low - 1] : NULL;
    return def && (size_t)(def->name.to - def->name.from) == length &&
                   memcmp(def->name.from, name.from, length) == 0
               ? def
               : NULL;
}

/* --- the copy ------------------------------------------------------------------------------ */

static bool fail_memory(const x3d_groups *s)
{
    return rk_fail(s->error, "%s: no memory for its text: simplify the mesh", s->path);
}

static bool write_span(x3d_groups *s, const char *from, const char *to)
{
    s->written += (size_t)(to - from);
    if (s->written > s->most)
        return rk_fail(s->error,
                       "%s: its nodes with USE stand for more than %zu MB of text: export it with "
                       "fewer of them, or as glTF",
                       s->path, s->most >> 20);
    return fwrite(from, 1, (size_t)(to - from), s->out) == (size_t)(to - from) || fail_memory(s);
}

static bool fail_use(x3d_groups *s, xml_span name, const char *what)
{
    const size_t length = (size_t)(name.to - name.from);
    return rk_fail(s->error, "%s: uses the node %.*s %s: export it again", s->path,
                   length < longest_shown ? (int)length : longest_shown, name.from, what);
}

static bool write_elements(x3d_groups *s, const char *from, const char *to, int depth);

static bool write_use(x3d_groups *s, xml_span tag, xml_span name, int depth)
{
    const x3d_def *def = find_def(s, name, tag);
    if (!def)
        return fail_use(s, name, "that is not defined before");
    const char *end = end_of_element(def->tag, s->end);
    if (end > tag.from)
        return fail_use(s, name, "in itself");
    if (depth == deepest)
        return fail_use(s, name, "too deep in others");
    return write_elements(s, def->tag.from, end, depth + 1);
}

/* It shows nothing, but it counts among a Switch's. */
static bool write_empty(x3d_groups *s)
{
    static const char with_node[] = "<Group><WorldInfo/></Group>";
    return write_span(s, with_node, with_node + sizeof with_node - 1);
}

/* A copy's names are empty. */
static bool write_elements(x3d_groups *s, const char *from, const char *to, int depth)
{
    const char *at = from;
    bool ok = true;
    for (xml_span tag, name; ok && xml_next_tag(&at, to, &tag);) {
        const bool has_use = is_group(tag) && xml_find_attribute(tag, "USE", &name);
        if (has_use || (is_group(tag) && is_empty(tag, to))) {
            ok = write_span(s, from, tag.from) &&
                 (has_use ? write_use(s, tag, name, depth) : write_empty(s));
            from = at = end_of_element(tag, to);
        } else if (depth > 0 && is_def(tag, &name)) {
            ok = write_span(s, from, name.from);
            from = name.to;
        }
    }
    return ok && write_span(s, from, to);
}

bool rk_mesh_x3d_groups_mend(const char *path, const char *text, size_t size, char **mended,
                             size_t *mended_size, rk_error *error)
{
    const char *at = text;
    x3d_groups s = {
        .path = path, .end = text + size, .most = base_text + text_per_byte * size, .error = error};
    bool is_needed = false, ok = true;
    for (xml_span tag, name; ok && xml_next_tag(&at, s.end, &tag);) {
        is_needed |=
            is_group(tag) && (is_empty(tag, s.end) || xml_find_attribute(tag, "USE", &name));
        ok = !is_def(tag, &name) || add_def(&s, name, tag);
    }
    *mended = NULL;
    s.out = ok && is_needed ? open_memstream(mended, mended_size) : NULL;
    if (s.def_count > 0)
        qsort(s.defs, s.def_count, sizeof *s.defs, compare_defs);
    if (!ok || (is_needed && !s.out))
        ok = fail_memory(&s);
    if (s.out) {
        ok = write_elements(&s, text, s.end, 0);
        ok = fclose(s.out) == 0 ? ok : fail_memory(&s);
    }
    if (!ok) {
        free(*mended);
        *mended = NULL;
    }
    free(s.defs);
    return ok;
}
