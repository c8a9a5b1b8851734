/* Starts raykit-mesh on a file and believes nothing of what it answers before it is checked. */
#include "io/mesh_file.h"

#include "io/helper.h"
#include "io/mesh_stream.h"

#include <stdlib.h>

/* A hundred million triangles fit; what needs more is no file for this kit. */
static const size_t longest_answer = (size_t)4 << 30;

static bool check_header(const rk_mesh_stream_header *header, size_t size, const char *path,
                         rk_error *error)
{
    if (memcmp(header->magic, RK_MESH_STREAM_MAGIC, sizeof header->magic) != 0 ||
        header->version != RK_MESH_STREAM_VERSION)
        return rk_fail(error,
                       "%s: raykit-mesh answers in another version's format: run make, or install "
                       "raykit again",
                       path);
    if (header->material_count > UINT16_MAX)
        return rk_fail(error, "%s: uses %u materials, more than %d: merge those that are alike",
                       path, header->material_count, UINT16_MAX);
    if (rk_mesh_stream_size(header) != size)
        return rk_fail(error, "%s: raykit-mesh answers %zu bytes where its counts make %llu", path,
                       size, (unsigned long long)rk_mesh_stream_size(header));
    if (header->triangle_count == 0 || header->material_count == 0)
        return rk_fail(error, "%s: holds no triangles: choose a mesh with faces", path);
    return true;
}

static const unsigned char *take(void *array, const unsigned char *from, uint64_t bytes)
{
    if (bytes)
        memcpy(array, from, (size_t)bytes);
    return from + bytes;
}

static void unpack(rk_mesh *mesh, const rk_mesh_stream_header *header, const unsigned char *from)
{
    rk_mesh_stream_sizes sizes = rk_mesh_stream_sizes_of(header);
    from = take(mesh->positions, from, sizes.positions);
    from = take(mesh->normals, from, sizes.normals);
    from = take(mesh->texcoords, from, sizes.texcoords);
    from = take(mesh->triangles, from, sizes.triangles);
    from = take(mesh->triangle_materials, from, sizes.triangle_materials);
    for (uint32_t i = 0; i < header->material_count; i++) {
        rk_mesh_stream_material m;
        from = take(&m, from, sizeof m);
        rk_material *material = &mesh->materials[i];
        material->kd = rk_vec(m.kd[0], m.kd[1], m.kd[2]);
        material->ks = rk_vec(m.ks[0], m.ks[1], m.ks[2]);
        material->shininess = m.shininess;
        material->alpha = m.alpha;
    }
}

static bool parse(rk_mesh *mesh, const unsigned char *bytes, size_t size, const char *path,
                  rk_error *error)
{
    rk_mesh_stream_header header;
    if (size < sizeof header)
        return rk_fail(error, "%s: raykit-mesh answers only %zu bytes", path, size);
    memcpy(&header, bytes, sizeof header);
    if (!check_header(&header, size, path, error))
        return false;
    rk_error reason;
    if (!rk_mesh_init(mesh, header.vertex_count, header.triangle_count, header.material_count,
                      (int)(header.flags & (RK_MESH_NORMALS | RK_MESH_TEXCOORDS)), &reason))
        return rk_fail(error, "%s: %.900s", path, reason.text);
    unpack(mesh, &header, bytes + sizeof header);
    if (rk_mesh_validate(mesh, path, error))
        return true;
    rk_mesh_free(mesh);
    return false;
}

bool rk_mesh_read(rk_mesh *mesh, const char *path, rk_error *error)
{
    *mesh = (rk_mesh){0};
    const char *const arguments[] = {path, NULL};
    rk_helper_call call = {.program = "raykit-mesh",
                           .package = "libassimp-dev",
                           .subject = path,
                           .arguments = arguments,
                           .output_max = longest_answer};
    unsigned char *bytes;
    size_t size;
    if (!rk_helper_run(&call, &bytes, &size, error))
        return false;
    bool ok = parse(mesh, bytes, size, path, error);
    free(bytes);
    return ok;
}
