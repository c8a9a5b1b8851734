/* io/mesh_helper/mesh_gltf_parts.h for what Assimp makes of them: version 5.2 copies the bytes of an
 * element into the first ones of its vector of floats, whatever they are, and then turns the second
 * coordinate v of textures into 1 - v; so the bytes are still there. Format: Khronos,
 * KHR_mesh_quantization. */
#include "io/mesh_helper/mesh_gltf_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { INT8 = 5120, UINT8, INT16, UINT16 };

/* --- numbers ------------------------------------------------------------------------------- */

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
