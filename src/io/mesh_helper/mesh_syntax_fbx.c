/* io/mesh_helper/mesh_syntax.h for FBX, as text or binary: of models that show the same mesh in
 * different materials, Assimp gives all those of the first, which is told. Objects have numbers,
 * and connections say what belongs to what. Binary: nested records, each with where it ends, the
 * number and size of its properties, and a name. Source: Blender Foundation, "FBX binary file
 * format specification". */
#include "io/little_endian.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <stdlib.h>
#include <string.h>

typedef enum fbx_kind { GEOMETRY, MODEL, MATERIAL, fbx_kinds } fbx_kind;

static const char *const kind_names[fbx_kinds] = {"Geometry", "Model", "Material"};

typedef struct fbx_object {
    int64_t id;
    fbx_kind kind;
    uint64_t
        look; /* a model's materials, mixed in their order; a mesh's, those of its first model */
    bool is_shown;
} fbx_object;

typedef struct fbx_link {
    int64_t from, to;
} fbx_link;

typedef struct fbx_parser {
    fbx_object *objects;
    fbx_link *links;
    size_t object_count, link_count;
    bool is_short; /* memory is */
} fbx_parser;

/* Makes room for one more of `size` bytes. */
static bool grow(fbx_parser *s, void **list, size_t count, size_t size)
{
    if ((count & (count - 1)) != 0)
        return true;
    void *larger = realloc(*list, (count ? 2 * count : 1) * size);
    s->is_short |= !larger;
    *list = larger ? larger : *list;
    return larger != NULL;
}

static void add_object(fbx_parser *s, const char *name, size_t length, int64_t id)
{
    for (int kind = 0; kind < fbx_kinds; kind++) {
        if (strlen(kind_names[kind]) != length || memcmp(name, kind_names[kind], length) != 0)
            continue;
        void *list = s->objects;
        if (grow(s, &list, s->object_count, sizeof *s->objects))
            ((fbx_object *)list)[s->object_count++] =
                (fbx_object){.id = id, .kind = (fbx_kind)kind};
        s->objects = list;
    }
}

static void add_link(fbx_parser *s, int64_t from, int64_t to)
{
    void *list = s->links;
    if (grow(s, &list, s->link_count, sizeof *s->links))
        ((fbx_link *)list)[s->link_count++] = (fbx_link){from, to};
    s->links = list;
}

/* --- text ---------------------------------------------------------------------------------- */

/* `Model: 200, ...` and `C: "OO",100,200`. */
static void read_line(fbx_parser *s, const char *line, size_t length)
{
    char text[80], *end;
    while (length > 0 && strchr(" \t", *line))
        line++, length--;
    length = length < sizeof text - 1 ? length : sizeof text - 1;
    memcpy(text, line, length);
    text[length] = '\0';
    const char *colon = strchr(text, ':');
    if (!colon)
        return;
    const size_t name = (size_t)(colon - text);
    const char *rest = colon + 1 + strspn(colon + 1, " ");
    if (name == 1 && *text == 'C' && strncmp(rest, "\"OO\"", 4) == 0) {
        const int64_t from = strtoll(rest + 4 + strspn(rest + 4, ", "), &end, 10);
        add_link(s, from, strtoll(end + strspn(end, ", "), NULL, 10));
    } else if (*rest >= '0' && *rest <= '9') {
        add_object(s, text, name, strtoll(rest, NULL, 10));
    }
}

static void read_text(fbx_parser *s, const char *text, size_t size)
{
    const char *const end = text + size;
    for (const char *line = text, *next; line < end; line = next) {
        next = memchr(line, '\n', (size_t)(end - line));
        next = next ? next + 1 : end;
        read_line(s, line, (size_t)(next - line));
    }
}

/* --- binary -------------------------------------------------------------------------------- */

typedef struct fbx_record {
    const char *name;
    size_t name_size, properties, children, end; /* the last three are places in the file */
} fbx_record;

/* False at the end of a list, or where the file is damaged. */
static bool read_record(const char *text, size_t size, size_t at, fbx_record *record)
{
    const size_t word = rk_little_endian_32(text + 23) >= 7500 ? 8 : 4, head = 3 * word + 1;
    if (at > size || size - at < head)
        return false;
    const uint64_t end = rk_little_endian(text + at, word),
                   bytes = rk_little_endian(text + at + 2 * word, word);
    record->name = text + at + head;
    record->name_size = (unsigned char)text[at + head - 1];
    record->properties = at + head + record->name_size;
    record->children = record->properties + bytes;
    record->end = end;
    return end <= size && end > at && bytes <= size && record->children <= end;
}

static bool is_named(const fbx_record *record, const char *name)
{
    return record->name_size == strlen(name) && memcmp(record->name, name, strlen(name)) == 0;
}

/* Their first property is a number, or of a connection, that of objects, a word before two. */
static void read_child(fbx_parser *s, const char *text, const fbx_record *r)
{
    static const char link[] = "S\2\0\0\0OOL";
    const char *first = text + r->properties;
    const size_t bytes = r->children - r->properties, begin = sizeof link - 1;
    if (is_named(r, "C") && bytes >= begin + 17 && memcmp(first, link, begin) == 0)
        add_link(s, (int64_t)rk_little_endian(first + begin, 8),
                 (int64_t)rk_little_endian(first + begin + 9, 8));
    else if (bytes >= 9 && *first == 'L')
        add_object(s, r->name, r->name_size, (int64_t)rk_little_endian(first + 1, 8));
}

static void read_binary(fbx_parser *s, const char *text, size_t size)
{
    fbx_record list, child;
    for (size_t at = 27; read_record(text, size, at, &list); at = list.end)
        if (is_named(&list, "Objects") || is_named(&list, "Connections"))
            for (size_t in = list.children; read_record(text, list.end, in, &child); in = child.end)
                read_child(s, text, &child);
}

/* --- looks --------------------------------------------------------------------------------- */

static int compare_ids(const void *a, const void *b)
{
    const int64_t x = ((const fbx_object *)a)->id, y = ((const fbx_object *)b)->id;
    return (x > y) - (x < y);
}

static fbx_object *find(const fbx_parser *s, int64_t id, fbx_kind kind)
{
    const fbx_object key = {.id = id};
    fbx_object *found =
        s->objects ? bsearch(&key, s->objects, s->object_count, sizeof key, compare_ids) : NULL;
    return found && found->kind == kind ? found : NULL;
}

static bool has_meshes_of_several_looks(const fbx_parser *s)
{
    bool differs = false;
    for (size_t i = 0; i < s->link_count; i++) {
        fbx_object *model = find(s, s->links[i].to, MODEL);
        if (model && find(s, s->links[i].from, MATERIAL))
            model->look = model->look * 0x9e3779b97f4a7c15 + (uint64_t)s->links[i].from;
    }
    for (size_t i = 0; i < s->link_count; i++) {
        const fbx_object *model = find(s, s->links[i].to, MODEL);
        fbx_object *mesh = model ? find(s, s->links[i].from, GEOMETRY) : NULL;
        if (!mesh)
            continue;
        differs |= mesh->is_shown && mesh->look != model->look;
        mesh->look = mesh->is_shown ? mesh->look : model->look;
        mesh->is_shown = true;
    }
    return differs;
}

bool rk_mesh_syntax_fbx(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    static const char mark[] = "Kaydara FBX Binary  ";
    fbx_parser s = {0};
    if (size > 27 && memcmp(text, mark, sizeof mark) == 0)
        read_binary(&s, text, size);
    else
        read_text(&s, text, size);
    if (s.object_count > 0)
        qsort(s.objects, s.object_count, sizeof *s.objects, compare_ids);
    if (!s.is_short && has_meshes_of_several_looks(&s))
        rk_mesh_hints_note(hints, path,
                           "shows a mesh several times in different materials, of which Assimp "
                           "reads those of one: the others look like it");
    free(s.objects);
    free(s.links);
    return !s.is_short || rk_fail(error, "%s: no memory for its objects: simplify the mesh", path);
}
