/* io/mesh_helper/mesh_gltf_parts.h for what Assimp makes of them: version 5.2 copies the bytes of
 * an element into the first ones of its vector of floats, whatever they are, and then turns the
 * second coordinate v of textures into 1 - v; so the bytes are still there. Format: Khronos,
 * KHR_mesh_quantization. */
#include "io/mesh_helper/mesh_gltf_parts.h"

#include <math.h>
#include <stddef.h>
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

static bool is_same_kind(const rk_mesh_gltf_parts_one *a, const rk_mesh_gltf_parts_one *b)
{
    bool same = integer_kind(a->positions) == integer_kind(b->positions) &&
                integer_kind(a->weights) == integer_kind(b->weights) &&
                integer_kind(a->normals) == integer_kind(b->normals);
    for (int k = 0; k < AI_MAX_NUMBER_OF_TEXTURECOORDS; k++)
        same &= integer_kind(a->texcoords[k]) == integer_kind(b->texcoords[k]);
    return same;
}

static int by_fit(const void *a, const void *b)
{
    const rk_mesh_gltf_parts_one *x = a, *y = b;
    const int names = strcmp(x->name, y->name);
    if (x->vertices != y->vertices)
        return x->vertices < y->vertices ? -1 : 1;
    if (names != 0)
        return names;
    if (x->triangles != y->triangles)
        return x->triangles < y->triangles ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* A file may have 65,536 parts, so each is looked up: those that may be the same one of Assimp's
 * are neighbours. */
static void sort_parts(rk_mesh_hints *hints)
{
    rk_mesh_gltf_parts_one *parts = hints->parts;
    if (hints->part_count > 0)
        qsort(parts, hints->part_count, sizeof *parts, by_fit);
    for (size_t i = 1; i < hints->part_count; i++)
        parts[i].differs = parts[i].vertices == parts[i - 1].vertices &&
                           strcmp(parts[i].name, parts[i - 1].name) == 0 &&
                           (parts[i - 1].differs || !is_same_kind(&parts[i - 1], &parts[i]));
}

/* The first of the sorted parts that does not come before the wanted one. */
static size_t first_of(const rk_mesh_hints *hints, const rk_mesh_gltf_parts_one *wanted)
{
    size_t low = 0, high = hints->part_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (by_fit(&hints->parts[middle], wanted) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Those of this name that fit, whole ones if there are any; or NULL. */
typedef struct fit {
    const rk_mesh_gltf_parts_one *first;
    bool is_whole, differs;
} fit;

static fit fit_of(const struct aiMesh *mesh, const rk_mesh_hints *hints, const char *name)
{
    rk_mesh_gltf_parts_one wanted = {.vertices = mesh->mNumVertices, .triangles = INT64_MIN};
    if (strlen(name) >= sizeof wanted.name)
        return (fit){0};
    strcpy(wanted.name, name);
    const size_t first = first_of(hints, &wanted);
    wanted.triangles = (int64_t)mesh->mNumFaces + 1;
    size_t end = first_of(hints, &wanted);
    const bool is_whole = end > first;
    if (!is_whole) {
        wanted.triangles = INT64_MAX;
        end = first_of(hints, &wanted);
    }
    return end == first ? (fit){0}
                        : (fit){&hints->parts[first], is_whole, hints->parts[end - 1].differs};
}

/* Returns NULL if no part has the name, or one that is not known, and the number of vertices.
 * Prefers one of which no triangle is missing. `differ` tells that others fit as well, with other
 * kinds of numbers. */
static const rk_mesh_gltf_parts_one *part_of(const struct aiMesh *mesh, const rk_mesh_hints *hints,
                                             bool *differ)
{
    const fit named = fit_of(mesh, hints, mesh->mName.data), unnamed = fit_of(mesh, hints, "");
    const bool has_both = named.first && unnamed.first && named.is_whole == unnamed.is_whole;
    const bool takes_unnamed = !named.first || (unnamed.is_whole && !named.is_whole);
    const fit *best = takes_unnamed ? &unnamed : &named;
    *differ = best->differs ||
              (has_both && (unnamed.differs || !is_same_kind(named.first, unnamed.first)));
    return best->first;
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

/* Adds the weighted differences of the morph targets' rows to the part's. */
static void morph_rows(const struct aiMesh *mesh, size_t rows_of_target, struct aiVector3D *rows)
{
    for (uint32_t i = 0; rows && i < mesh->mNumVertices; i++) {
        const struct aiVector3D base = rows[i];
        for (uint32_t k = 0; k < mesh->mNumAnimMeshes; k++) {
            const struct aiAnimMesh *target = mesh->mAnimMeshes[k];
            struct aiVector3D *targets;
            memcpy(&targets, (const char *)target + rows_of_target, sizeof targets);
            if (!targets || target->mNumVertices != mesh->mNumVertices)
                continue;
            rows[i].x += target->mWeight * (targets[i].x - base.x);
            rows[i].y += target->mWeight * (targets[i].y - base.y);
            rows[i].z += target->mWeight * (targets[i].z - base.z);
        }
    }
}

/* To the shape that the file gives. */
static void morph(struct aiMesh *mesh)
{
    bool any = false;
    for (uint32_t k = 0; k < mesh->mNumAnimMeshes; k++)
        any |= mesh->mAnimMeshes[k]->mWeight != 0;
    if (!any)
        return;
    morph_rows(mesh, offsetof(struct aiAnimMesh, mVertices), mesh->mVertices);
    morph_rows(mesh, offsetof(struct aiAnimMesh, mNormals), mesh->mNormals);
}

bool rk_mesh_gltf_parts_mend(const struct aiScene *scene, rk_mesh_hints *hints, const char *path,
                             rk_error *error)
{
    const char *unclear = NULL;
    bool has_rigid = false;
    sort_parts(hints);
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
        if (!integer_kind(part->positions) && !integer_kind(part->normals))
            morph(mesh);
        if (mesh->mNumBones > 0 && integer_kind(part->weights)) {
            mesh->mNumBones = 0;
            has_rigid = true;
        }
    }
    if (has_rigid)
        rk_mesh_hints_note(
            hints, path,
            "has a skin that is not applied, because its weights are integers, which "
            "Assimp does not read: export them as floats");
    if (unclear)
        rk_mesh_hints_note(hints, path,
                           "has several parts named \"%.100s\" with coordinates of different "
                           "kinds, which may be drawn wrongly: give them different names",
                           unclear);
    return true;
}
