/* io/mesh_helper/mesh_gltf_parts.h: Assimp 5.2 copies the bytes of an element into the first ones
 * of its vector of floats, whatever they are, and then turns the second coordinate v of textures
 * into 1 - v; so the bytes are still there. Format: Khronos, "glTF 2.0 Specification", sections 3.6
 * and 3.7, and KHR_mesh_quantization. */
#include "io/mesh_helper/mesh_gltf_parts.h"

#include <math.h>
#include <stdlib.h>

enum { INT8 = 5120, UINT8, INT16, UINT16, POINTS = 0, TRIANGLES = 4, FAN = 6 };

typedef struct accessor {
    rk_mesh_gltf_parts_numbers numbers;
    long long count;
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
            a.numbers.kind = (uint16_t)json_read_index(c, 0);
        } else if (json_equals(&key, "count")) {
            a.count = json_read_index(c, 0);
        } else {
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

static rk_mesh_gltf_parts_one read_part(reader *r, json_cursor *c)
{
    rk_mesh_gltf_parts_one part = {.triangles = -1};
    long long mode = TRIANGLES, corners = -1, vertices = -1;
    bool has_indices = false, has_draco = false;
    json_string key;
    if (!json_enter(c, '{'))
        return json_skip(c), part;
    while (json_next_key(c, &key)) {
        if (json_equals(&key, "attributes")) {
            vertices = read_attributes(r, c, &part);
        } else if (json_equals(&key, "mode")) {
            mode = json_read_index(c, FAN + 1);
        } else if (json_equals(&key, "indices")) {
            has_indices = true;
            corners = accessor_at(r, json_read_index(c, -1)).count;
        } else {
            has_draco |= json_equals(&key, "extensions") && names_draco(*c);
            json_skip(c);
        }
    }
    part.triangles = has_draco ? -1 : triangles_of(has_indices ? corners : vertices, mode);
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
        h->parts[h->part_count++] = read_part(r, c);
    }
    return true;
}

static bool read_meshes(reader *r, json_cursor c, rk_error *error)
{
    if (!json_find_key(&c, "meshes") || !json_enter(&c, '['))
        return true;
    while (json_next(&c)) {
        json_string key;
        if (!json_enter(&c, '{')) {
            json_skip(&c);
            continue;
        }
        while (json_next_key(&c, &key))
            if (!json_equals(&key, "primitives"))
                json_skip(&c);
            else if (!read_primitives(r, &c, error))
                return false;
    }
    return true;
}

bool rk_mesh_gltf_parts_read(rk_mesh_hints *hints, const char *path, json_cursor text,
                             rk_error *error)
{
    reader r = {.path = path, .hints = hints};
    bool ok = read_accessors(&r, text, error) && read_meshes(&r, text, error);
    if (r.differ)
        rk_mesh_hints_note(hints, path,
                           "has normals or texture coordinates of another number than vertices, "
                           "which the picture does not show");
    free(r.accessors);
    return ok;
}

/* --- mending ------------------------------------------------------------------------------- */

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
    if (!rows || numbers.kind < INT8 || numbers.kind > UINT16 ||
        !is_packed(rows, count, size, numbers.kind >= INT16))
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

static bool check_triangles(const struct aiMesh *mesh, const rk_mesh_gltf_parts_one *part,
                            uint32_t number, const char *path, rk_error *error)
{
    const long long lost = part->triangles - (long long)mesh->mNumFaces;
    if (part->triangles < 0 || lost <= 0)
        return true;
    return rk_fail(error,
                   "%s: %lld of %lld triangles of part %u (\"%.100s\") use vertices that are not "
                   "there: export it again",
                   path, lost, (long long)part->triangles, number, mesh->mName.data);
}

bool rk_mesh_gltf_parts_mend(const struct aiScene *scene, const rk_mesh_hints *hints,
                             const char *path, rk_error *error)
{
    if (hints->part_count != scene->mNumMeshes)
        return true;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        struct aiMesh *mesh = scene->mMeshes[i];
        const rk_mesh_gltf_parts_one *part = &hints->parts[i];
        if (!check_triangles(mesh, part, i, path, error))
            return false;
        unpack(mesh->mVertices, mesh->mNumVertices, 3, part->positions);
        unpack(mesh->mNormals, mesh->mNumVertices, 3, part->normals);
        for (int k = 0; k < AI_MAX_NUMBER_OF_TEXTURECOORDS; k++)
            unpack(mesh->mTextureCoords[k], mesh->mNumVertices, 2, part->texcoords[k]);
    }
    return true;
}
