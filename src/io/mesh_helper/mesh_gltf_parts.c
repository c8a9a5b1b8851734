/* io/mesh_helper/mesh_gltf_parts.h: Assimp 5.2 copies the bytes of an element into the first ones
 * of its vector of floats, whatever they are, and then turns the second coordinate v of textures
 * into 1 - v; so the bytes are still there. Format: Khronos, "glTF 2.0 Specification", sections 3.6
 * and 3.7, and KHR_mesh_quantization. */
#include "io/mesh_helper/mesh_gltf_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { INT8 = 5120, UINT8, INT16, UINT16, UINT32 = 5125, POINTS = 0, TRIANGLES = 4, FAN = 6 };

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
        .number = (uint32_t)r->hints->part_count, .vertices = -1, .triangles = -1};
    long long mode = TRIANGLES, corners = -1;
    long long indices = -1;
    bool has_indices = false, has_draco = false;
    json_string key;
    if (!json_enter(c, '{'))
        return json_skip(c), part;
    while (json_next_key(c, &key)) {
        if (json_equals(&key, "attributes")) {
            part.vertices = read_attributes(r, c, &part);
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
              narrow_draco_indices(&r, file, error);
    if (r.differ)
        rk_mesh_hints_note(hints, path,
                           "has normals or texture coordinates of another number than vertices, "
                           "which the picture does not show");
    free(r.accessors);
    return ok;
}

/* --- mending ------------------------------------------------------------------------------- */

/* 0 for floats. */
static int integer_kind(rk_mesh_gltf_parts_numbers numbers)
{
    const bool is_integer = numbers.kind >= INT8 && numbers.kind <= UINT16;
    return is_integer ? 2 * numbers.kind + numbers.is_fraction : 0;
}

static float integer_at(const unsigned char *bytes, int i, rk_mesh_gltf_parts_numbers numbers)
{
    const bool is_wide = numbers.kind >= INT16, is_signed = numbers.kind % 2 == 0;
    const unsigned bits = is_wide ? bytes[2 * i] | (unsigned)bytes[2 * i + 1] << 8 : bytes[i];
    const int value = !is_signed ? (int)bits : is_wide ? (int16_t)bits : (int8_t)bits;
    const float most = (float)((is_wide ? 65535 : 255) >> is_signed);
    return numbers.is_fraction ? fmaxf((float)value / most, -1) : (float)value;
}

/* A later Assimp may read them right: then something is behind the bytes of an element. */
static bool is_packed(const struct aiVector3D *rows, uint32_t count, int size, bool is_wide)
{
    static const unsigned char nothing[sizeof *rows];
    const size_t used = (size_t)size * (is_wide ? 2 : 1);
    for (uint32_t i = 0; i < count; i++) {
        struct aiVector3D row = rows[i];
        if (size == 2)
            row.y -= 1;
        if (memcmp((const char *)&row + used, nothing, sizeof row - used) != 0)
            return false;
    }
    return true;
}

static void unpack(struct aiVector3D *rows, uint32_t count, int size,
                   rk_mesh_gltf_parts_numbers numbers)
{
    if (!rows || !integer_kind(numbers) || !is_packed(rows, count, size, numbers.kind >= INT16))
        return;
    for (uint32_t i = 0; i < count; i++) {
        unsigned char bytes[sizeof *rows];
        memcpy(bytes, &rows[i], sizeof bytes);
        rows[i].x = integer_at(bytes, 0, numbers);
        rows[i].y = integer_at(bytes, 1, numbers);
        rows[i].z = size > 2 ? integer_at(bytes, 2, numbers) : 0;
        if (size == 2)
            rows[i].y = 1 - rows[i].y;
    }
}

/* --- pairing ------------------------------------------------------------------------------- */

static int by_vertices(const void *a, const void *b)
{
    const rk_mesh_gltf_parts_one *x = a, *y = b;
    if (x->vertices != y->vertices)
        return x->vertices < y->vertices ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* The first of the sorted parts that has as many vertices, or more. */
static size_t first_of(const rk_mesh_hints *hints, int64_t vertices)
{
    size_t low = 0, high = hints->part_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (hints->parts[middle].vertices < vertices)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool is_same_kind(const rk_mesh_gltf_parts_one *a, const rk_mesh_gltf_parts_one *b)
{
    bool same = integer_kind(a->positions) == integer_kind(b->positions) &&
                integer_kind(a->normals) == integer_kind(b->normals);
    for (int k = 0; k < AI_MAX_NUMBER_OF_TEXTURECOORDS; k++)
        same &= integer_kind(a->texcoords[k]) == integer_kind(b->texcoords[k]);
    return same;
}

/* Returns NULL if no part has the name and the number of vertices. Prefers one of which no triangle
 * is missing. `differ` tells that others fit as well, with other kinds of numbers. */
static const rk_mesh_gltf_parts_one *part_of(const struct aiMesh *mesh, const rk_mesh_hints *hints,
                                             bool *differ)
{
    const rk_mesh_gltf_parts_one *best = NULL;
    *differ = false;
    for (size_t i = first_of(hints, mesh->mNumVertices); i < hints->part_count; i++) {
        const rk_mesh_gltf_parts_one *part = &hints->parts[i];
        if (part->vertices != mesh->mNumVertices)
            break;
        if (*part->name && strcmp(part->name, mesh->mName.data) != 0)
            continue;
        const bool is_whole = part->triangles <= mesh->mNumFaces;
        if (!best || (is_whole && best->triangles > mesh->mNumFaces)) {
            best = part;
            *differ = false;
        } else if (is_whole || best->triangles > mesh->mNumFaces) {
            *differ |= !is_same_kind(best, part);
        }
    }
    return best;
}

static bool check_triangles(const struct aiMesh *mesh, const rk_mesh_gltf_parts_one *part,
                            const char *path, rk_error *error)
{
    const long long lost = part->triangles - (long long)mesh->mNumFaces;
    if (part->triangles < 0 || lost <= 0)
        return true;
    return rk_fail(error,
                   "%s: %lld of %lld triangles of part %u (\"%.100s\") use vertices that are not "
                   "there: export it again",
                   path, lost, (long long)part->triangles, part->number, mesh->mName.data);
}

static void unpack_part(struct aiMesh *mesh, const rk_mesh_gltf_parts_one *part)
{
    unpack(mesh->mVertices, mesh->mNumVertices, 3, part->positions);
    unpack(mesh->mNormals, mesh->mNumVertices, 3, part->normals);
    for (int k = 0; k < AI_MAX_NUMBER_OF_TEXTURECOORDS; k++)
        unpack(mesh->mTextureCoords[k], mesh->mNumVertices, 2, part->texcoords[k]);
}

bool rk_mesh_gltf_parts_mend(const struct aiScene *scene, rk_mesh_hints *hints, const char *path,
                             rk_error *error)
{
    const char *unclear = NULL;
    if (hints->part_count > 0)
        qsort(hints->parts, hints->part_count, sizeof *hints->parts, by_vertices);
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        struct aiMesh *mesh = scene->mMeshes[i];
        bool differ;
        const rk_mesh_gltf_parts_one *part = part_of(mesh, hints, &differ);
        if (differ)
            unclear = mesh->mName.data;
        if (!part)
            continue;
        if (!check_triangles(mesh, part, path, error))
            return false;
        if (!differ)
            unpack_part(mesh, part);
    }
    if (unclear)
        rk_mesh_hints_note(hints, path,
                           "has several parts named \"%.100s\" with coordinates of different "
                           "kinds, which may be drawn wrongly: give them different names",
                           unclear);
    return true;
}
