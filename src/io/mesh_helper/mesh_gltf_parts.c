/* io/mesh_helper/mesh_gltf_parts.h for what the file says. Format: Khronos, "glTF 2.0
 * Specification", sections 3.6 and 3.7. */
#include "io/mesh_helper/mesh_gltf_parts.h"

#include <stdio.h>
#include <stdlib.h>

enum { UINT32 = 5125, TRIANGLES = 4, FAN = 6 };

typedef struct accessor {
    rk_mesh_gltf_parts_numbers numbers;
    long long count;
    const char *kind; /* where componentType is, or NULL */
    bool has_bytes, is_draco, keeps_kind;
} accessor;

typedef struct reader {
    const char *path;
    rk_mesh_hints *hints;
    accessor *accessors;
    size_t accessor_count;
    bool differ; /* a part has normals or texture coordinates of another number than vertices */
} reader;

static void *room_for(void *rows, size_t count, size_t size)
{
    return (count & (count - 1)) == 0 ? realloc(rows, (count ? 2 * count : 1) * size) : rows;
}

static bool fail_memory(const reader *r, rk_error *error)
{
    return rk_fail(error, "%s: no memory for its parts: simplify the mesh", r->path);
}

/* --- accessors ----------------------------------------------------------------------------- */

static accessor read_accessor(json_cursor *c)
{
    accessor a = {0};
    json_string key;
    if (!json_enter(c, '{'))
        return json_skip(c), a;
    while (json_next_key(c, &key)) {
        if (json_equals(&key, "componentType")) {
            a.kind = c->at;
            a.numbers.kind = (uint16_t)json_read_index(c, 0);
        } else if (json_equals(&key, "count")) {
            a.count = json_read_index(c, 0);
        } else {
            a.has_bytes |= json_equals(&key, "bufferView") || json_equals(&key, "sparse");
            a.numbers.is_fraction |= json_equals(&key, "normalized") && *c->at == 't';
            json_skip(c);
        }
    }
    return a;
}

static bool read_accessors(reader *r, json_cursor c, rk_error *error)
{
    if (!json_find_key(&c, "accessors") || !json_enter(&c, '['))
        return true;
    while (json_next(&c)) {
        void *room = room_for(r->accessors, r->accessor_count, sizeof *r->accessors);
        if (!room)
            return fail_memory(r, error);
        r->accessors = room;
        r->accessors[r->accessor_count++] = read_accessor(&c);
    }
    return true;
}

static accessor accessor_at(const reader *r, long long index)
{
    const bool is_there = index >= 0 && (size_t)index < r->accessor_count;
    return is_there ? r->accessors[index] : (accessor){.count = -1};
}

/* --- parts --------------------------------------------------------------------------------- */

/* Returns the number of vertices, or -1. */
static long long read_attributes(reader *r, json_cursor *c, rk_mesh_gltf_parts_one *part)
{
    long long least = INT64_MAX, most = -1, vertices = -1;
    json_string key;
    if (!json_enter(c, '{'))
        return json_skip(c), -1;
    while (json_next_key(c, &key)) {
        const accessor a = accessor_at(r, json_read_index(c, -1));
        const bool is_set = key.length == 10 && memcmp(key.begin, "TEXCOORD_", 9) == 0;
        const int set = is_set ? key.begin[9] - '0' : -1;
        const bool is_position = json_equals(&key, "POSITION");
        const bool is_normal = json_equals(&key, "NORMAL");
        if (json_equals(&key, "WEIGHTS_0"))
            part->weights = a.numbers;
        const bool is_texcoord = set >= 0 && set < AI_MAX_NUMBER_OF_TEXTURECOORDS;
        if (!is_position && !is_normal && !is_texcoord)
            continue;
        *(is_position ? &part->positions
          : is_normal ? &part->normals
                      : &part->texcoords[set]) = a.numbers;
        vertices = is_position ? a.count : vertices;
        least = a.count < least ? a.count : least;
        most = a.count > most ? a.count : most;
    }
    r->differ |= least < most;
    return vertices;
}

static int64_t triangles_of(long long corners, long long mode)
{
    if (corners < 0 || mode > FAN)
        return -1;
    return mode < TRIANGLES ? 0 : mode == TRIANGLES ? corners / 3 : corners > 2 ? corners - 2 : 0;
}

static bool names_draco(json_cursor c)
{
    return json_find_key(&c, "KHR_draco_mesh_compression");
}

/* Indices of up to 65,535 vertices fit 16 bits. */
static void note_indices(reader *r, long long indices, bool is_draco, long long vertices)
{
    if (indices < 0 || (size_t)indices >= r->accessor_count)
        return;
    accessor *a = &r->accessors[indices];
    a->is_draco |= is_draco;
    a->keeps_kind |= !is_draco || vertices < 0 || vertices > 65535;
}

static rk_mesh_gltf_parts_one read_part(reader *r, json_cursor *c)
{
    rk_mesh_gltf_parts_one part = {
        .number = (uint32_t)r->hints->part_count, .vertices = -1, .triangles = -1, .material = -1};
    long long mode = TRIANGLES, corners = -1;
    long long indices = -1;
    bool has_indices = false, has_draco = false;
    json_string key;
    if (!json_enter(c, '{'))
        return json_skip(c), part;
    while (json_next_key(c, &key)) {
        if (json_equals(&key, "attributes")) {
            part.vertices = read_attributes(r, c, &part);
        } else if (json_equals(&key, "material")) {
            part.material = json_read_index(c, -1);
        } else if (json_equals(&key, "mode")) {
            mode = json_read_index(c, FAN + 1);
        } else if (json_equals(&key, "indices")) {
            has_indices = true;
            indices = json_read_index(c, -1);
            corners = accessor_at(r, indices).count;
        } else {
            has_draco |= json_equals(&key, "extensions") && names_draco(*c);
            json_skip(c);
        }
    }
    note_indices(r, indices, has_draco, part.vertices);
    part.triangles = has_draco ? -1 : triangles_of(has_indices ? corners : part.vertices, mode);
    return part;
}

static bool read_primitives(reader *r, json_cursor *c, rk_error *error)
{
    if (!json_enter(c, '['))
        return json_skip(c), true;
    while (json_next(c)) {
        rk_mesh_hints *h = r->hints;
        void *room = room_for(h->parts, h->part_count, sizeof *h->parts);
        if (!room)
            return fail_memory(r, error);
        h->parts = room;
        h->parts[h->part_count] = read_part(r, c);
        h->part_count++;
    }
    return true;
}

/* Assimp names an unnamed mesh by its number, and numbers the parts of a mesh that has several. */
static void name_parts(rk_mesh_gltf_parts_one *parts, size_t count, const json_string *name,
                       uint32_t mesh)
{
    char text[sizeof parts->name];
    if (name->length > 90 || memchr(name->begin, '\\', name->length))
        return;
    if (name->length > 0)
        snprintf(text, sizeof text, "%.*s", (int)name->length, name->begin);
    else
        snprintf(text, sizeof text, "meshes[%u]", mesh);
    for (size_t i = 0; i < count; i++)
        if (count == 1)
            snprintf(parts[i].name, sizeof text, "%s", text);
        else
            snprintf(parts[i].name, sizeof text, "%.91s-%u", text, (uint32_t)i);
}

static bool read_mesh(reader *r, json_cursor *c, uint32_t number, rk_error *error)
{
    const size_t before = r->hints->part_count;
    json_string key, name = {"", 0};
    if (!json_enter(c, '{'))
        return json_skip(c), true;
    while (json_next_key(c, &key)) {
        if (json_equals(&key, "primitives")) {
            if (!read_primitives(r, c, error))
                return false;
        } else if (json_equals(&key, "name") && *c->at == '"') {
            name = json_read_string(c);
        } else {
            json_skip(c);
        }
    }
    if (r->hints->part_count > before)
        name_parts(r->hints->parts + before, r->hints->part_count - before, &name, number);
    return true;
}

static bool read_meshes(reader *r, json_cursor c, rk_error *error)
{
    if (!json_find_key(&c, "meshes") || !json_enter(&c, '['))
        return true;
    for (uint32_t i = 0; json_next(&c); i++)
        if (!read_mesh(r, &c, i, error))
            return false;
    return true;
}

static int by_number(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return x < y ? -1 : x > y;
}

/* Assimp takes long for so many, and 10 kB for each. */
static bool check_materials(const reader *r, rk_error *error)
{
    const rk_mesh_hints *h = r->hints;
    if (h->part_count <= UINT16_MAX)
        return true;
    int64_t *materials = rk_allocate(h->part_count, sizeof *materials, r->path, error);
    if (!materials)
        return false;
    size_t count = 1;
    for (size_t i = 0; i < h->part_count; i++)
        materials[i] = h->parts[i].material;
    qsort(materials, h->part_count, sizeof *materials, by_number);
    for (size_t i = 1; i < h->part_count; i++)
        count += materials[i] != materials[i - 1];
    free(materials);
    return count <= UINT16_MAX ||
           rk_fail(error, "%s: uses %zu materials, more than %d: merge equal ones", r->path, count,
                   UINT16_MAX);
}

/* Assimp decodes the indices of a Draco part, and loses those of 32 bits; its other widths are made
 * from the same numbers. */
static bool narrow_draco_indices(const reader *r, json_cursor file, rk_error *error)
{
    rk_mesh_hints *h = r->hints;
    for (size_t i = 0; i < r->accessor_count; i++) {
        const accessor *a = &r->accessors[i];
        if (!a->is_draco || a->numbers.kind != UINT32 || a->has_bytes)
            continue;
        h->has_wide_draco |= a->keeps_kind;
        if (a->keeps_kind)
            continue;
        if (!h->text) {
            h->size = (size_t)(file.end - file.at);
            h->text = rk_allocate_unset(h->size, 1, r->path, error);
            if (!h->text)
                return false;
            memcpy(h->text, file.at, h->size);
        }
        h->text[a->kind - file.at + 3] = '3';
    }
    return true;
}

bool rk_mesh_gltf_parts_read(rk_mesh_hints *hints, const char *path, json_cursor text,
                             json_cursor file, rk_error *error)
{
    reader r = {.path = path, .hints = hints};
    bool ok = read_accessors(&r, text, error) && read_meshes(&r, text, error) &&
              check_materials(&r, error) && narrow_draco_indices(&r, file, error);
    if (r.differ)
        rk_mesh_hints_note(hints, path,
                           "has normals or texture coordinates of another number than vertices, "
                           "which the picture does not show");
    free(r.accessors);
    return ok;
}
