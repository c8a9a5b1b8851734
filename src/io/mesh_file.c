/* Runs raykit-mesh on a file and checks all of its output before using it. */
#include "io/mesh_file.h"

#include "io/helper.h"
#include "io/image_file.h"
#include "io/mesh_note.h"
#include "io/mesh_stream.h"
#include "io/texture_file.h"

#include <stdlib.h>

/* A hundred million triangles fit; larger files are not for this kit. */
static const size_t longest_answer = (size_t)4 << 30;

/* Of all pictures of a mesh together: sixteen of 4096 x 4096, 3.2 GB. */
static const size_t most_texels = (size_t)1 << 28;

static bool check_header(const rk_mesh_stream_header *header, size_t size, const char *path,
                         rk_error *error)
{
    if (memcmp(header->magic, RK_MESH_STREAM_MAGIC, sizeof header->magic) != 0 ||
        header->version != RK_MESH_STREAM_VERSION)
        return rk_fail(error,
                       "%s: raykit-mesh sent another version's format: run make, or install "
                       "raykit again",
                       path);
    if (header->material_count > UINT16_MAX)
        return rk_fail(error, "%s: uses %u materials, more than %d: merge equal ones", path,
                       header->material_count, UINT16_MAX);
    if (header->texture_count > RK_MESH_STREAM_TEXTURES_MAX)
        return rk_fail(
            error,
            "%s: raykit-mesh sent %u textures, more than %d: run make, or install raykit again",
            path, header->texture_count, RK_MESH_STREAM_TEXTURES_MAX);
    if (rk_mesh_stream_size(header) != size)
        return rk_fail(error,
                       "%s: raykit-mesh sent %zu bytes, but its counts require %llu: run make, or "
                       "install raykit again",
                       path, size, (unsigned long long)rk_mesh_stream_size(header));
    if (header->up > 3)
        return rk_fail(error,
                       "%s: raykit-mesh sent an up axis of number %u: run make, or install raykit "
                       "again",
                       path, header->up);
    if (header->triangle_count == 0 || header->material_count == 0)
        return rk_fail(error, "%s: has no triangles: choose a mesh with faces", path);
    return true;
}

static const unsigned char *take(void *array, const unsigned char *from, uint64_t bytes)
{
    if (bytes)
        memcpy(array, from, (size_t)bytes);
    return from + bytes;
}

/* The beginnings of the parts of variable length. */
typedef struct tail {
    const unsigned char *materials, *textures, *texture_bytes;
} tail;

static rk_mesh_stream_material material_row(const tail *rest, uint32_t i)
{
    rk_mesh_stream_material row;
    take(&row, rest->materials + i * sizeof row, sizeof row);
    return row;
}

static rk_mesh_stream_texture texture_row(const tail *rest, uint32_t i)
{
    rk_mesh_stream_texture row;
    take(&row, rest->textures + i * sizeof row, sizeof row);
    return row;
}

static tail unpack(rk_mesh *mesh, const rk_mesh_stream_header *header, const unsigned char *from)
{
    rk_mesh_stream_sizes sizes = rk_mesh_stream_sizes_of(header);
    from = take(mesh->positions, from, sizes.positions);
    from = take(mesh->normals, from, sizes.normals);
    from = take(mesh->texcoords, from, sizes.texcoords);
    from = take(mesh->colours, from, sizes.colours);
    from = take(mesh->triangles, from, sizes.triangles);
    from = take(mesh->triangle_materials, from, sizes.triangle_materials);
    tail rest = {from, from + sizes.materials, from + sizes.materials + sizes.textures};
    for (uint32_t i = 0; i < header->material_count; i++) {
        rk_mesh_stream_material m = material_row(&rest, i);
        rk_material *material = &mesh->materials[i];
        material->kd = rk_vec(m.kd[0], m.kd[1], m.kd[2]);
        material->ks = rk_vec(m.ks[0], m.ks[1], m.ks[2]);
        material->shininess = m.shininess;
        material->alpha = m.alpha;
        material->alpha_cutoff = m.alpha_cutoff;
    }
    return rest;
}

/* --- textures ------------------------------------------------------------------------------ */

static bool check_textures(const tail *rest, const rk_mesh_stream_header *header, const char *path,
                           rk_error *error)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < header->texture_count; i++) {
        rk_mesh_stream_texture row = texture_row(rest, i);
        bytes += (uint64_t)row.name_size + row.data_size;
    }
    if (bytes != header->texture_bytes)
        return rk_fail(error,
                       "%s: raykit-mesh sent %u bytes of textures, but their sizes require %llu: "
                       "run make, or install raykit again",
                       path, header->texture_bytes, (unsigned long long)bytes);
    for (uint32_t i = 0; i < header->material_count; i++) {
        const rk_mesh_stream_material row = material_row(rest, i);
        const uint32_t texture = row.texture > row.alpha_texture ? row.texture : row.alpha_texture;
        if (texture > header->texture_count)
            return rk_fail(error,
                           "%s: material %u uses texture %u, but there are only %u: run make, or "
                           "install raykit again",
                           path, i, texture, header->texture_count);
    }
    return true;
}

/* The pictures of a mesh file while they are read. */
typedef struct picture_reader {
    rk_mesh *mesh;
    const tail *rest;
    const char *path;
    size_t texels_left;
    rk_image_file_reader images;
} picture_reader;

/* `from` points to the name, which a picture may follow. */
static bool read_texture(picture_reader *reader, rk_texture *texture, uint32_t number,
                         const unsigned char *from, rk_texture_file_part part, rk_error *error)
{
    const rk_mesh_stream_texture row = texture_row(reader->rest, number - 1);
    char *name = rk_allocate((size_t)row.name_size + 1, 1, reader->path, error);
    if (!name)
        return false;
    const unsigned char *data = take(name, from, row.name_size);
    rk_texture_file_source source = {
        name, row.data_size ? data : NULL, row.data_size, row.clamps != 0, part, &reader->images};
    bool ok = rk_texture_file_read(texture, &source, reader->path, &reader->texels_left, error);
    free(name);
    return ok;
}

static bool uses(const rk_mesh_stream_material *row, uint32_t number, rk_texture_file_part part)
{
    if (part == RK_TEXTURE_COLOUR)
        return row->texture == number;
    return row->alpha_texture == number && (row->texture == number) == (part == RK_TEXTURE_ALPHA);
}

/* The mean opacity if it is nowhere one half, so that rounding to opaque or nothing would leave
 * nothing; else 1. */
static float faintness(const rk_image *opacity)
{
    double sum = 0;
    const size_t count = opacity->width * opacity->height;
    for (size_t i = 0; i < count; i++) {
        if (opacity->pixels[i].x >= 0.5f)
            return 1;
        sum += (double)opacity->pixels[i].x;
    }
    return (float)(sum / (double)count);
}

static void set_texture(rk_material *material, const rk_texture *texture, rk_texture_file_part part,
                        float faint)
{
    if (part == RK_TEXTURE_COLOUR)
        material->kd_texture = texture;
    else if (faint < 1 && material->alpha_cutoff == 0)
        material->alpha *= faint;
    else
        material->alpha_texture = texture;
}

/* Reads one part of a picture if a material uses it. */
static bool read_part(picture_reader *reader, uint32_t number, const unsigned char *from,
                      rk_texture_file_part part, rk_error *error)
{
    rk_mesh *mesh = reader->mesh;
    rk_texture *texture = &mesh->textures[mesh->texture_count];
    float faint = 1;
    for (uint32_t k = 0; k < mesh->material_count; k++) {
        const rk_mesh_stream_material row = material_row(reader->rest, k);
        if (!uses(&row, number, part))
            continue;
        if (texture == &mesh->textures[mesh->texture_count]) { /* the first that uses it */
            if (!read_texture(reader, texture, number, from, part, error))
                return false;
            if (!texture->image.pixels) /* opaque */
                return true;
            mesh->texture_count++;
            faint = part == RK_TEXTURE_COLOUR ? 1 : faintness(&texture->image);
        }
        set_texture(&mesh->materials[k], texture, part, faint);
    }
    return true;
}

/* Reads every texture that can be read. Returns the number of others, with the first one's
 * error. */
static uint32_t read_each(rk_mesh *mesh, const rk_mesh_stream_header *header, const tail *rest,
                          const char *path, rk_error *why)
{
    picture_reader reader = {mesh, rest, path, most_texels, {0}};
    const unsigned char *from = rest->texture_bytes;
    uint32_t lost = 0;
    for (uint32_t i = 0; i < header->texture_count; i++) {
        const rk_mesh_stream_texture row = texture_row(rest, i);
        bool ok = true;
        for (int part = RK_TEXTURE_COLOUR; ok && part <= RK_TEXTURE_OPACITY; part++)
            ok = read_part(&reader, i + 1, from, (rk_texture_file_part)part, lost ? NULL : why);
        lost += !ok;
        from += (size_t)row.name_size + row.data_size;
    }
    rk_image_file_reader_end(&reader.images);
    return lost;
}

/* A picture that cannot be read costs only itself and gives a note, like a missing MTL: many
 * scanned meshes name pictures that are gone. False when memory is short. */
static bool read_textures(rk_mesh *mesh, const rk_mesh_stream_header *header, const tail *rest,
                          const char *path, rk_error *note)
{
    if (header->texture_count == 0)
        return true;
    if (!mesh->texcoords) {
        rk_mesh_note_add(note, "%s: has textures but no texture coordinates: surfaces are plain",
                         path);
        return true;
    }
    mesh->textures = /* each may be a colour and, in two ways, an opacity */
        rk_allocate(3 * (size_t)header->texture_count, sizeof *mesh->textures, path, note);
    if (!mesh->textures)
        return false;
    rk_error why;
    uint32_t lost = read_each(mesh, header, rest, path, &why);
    if (lost > 0)
        rk_mesh_note_add(
            note, "%s: %u of %u textures cannot be read, their surfaces are plain; the first: %s",
            path, lost, header->texture_count, why.text);
    return true;
}

/* A cutoff without a picture decides for the whole material. */
static void settle_cutoffs(rk_mesh *mesh)
{
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        rk_material *m = &mesh->materials[i];
        if (m->alpha_cutoff == 0 || m->alpha_texture)
            continue;
        m->alpha = m->alpha >= m->alpha_cutoff ? 1 : 0;
        m->alpha_cutoff = 0;
    }
}

/* --- the whole ----------------------------------------------------------------------------- */

static bool parse(rk_mesh *mesh, const unsigned char *bytes, size_t size, const char *path,
                  rk_error *error)
{
    rk_mesh_stream_header header;
    if (size < sizeof header)
        return rk_fail(error,
                       "%s: raykit-mesh sent only %zu bytes: run make, or install raykit again",
                       path, size);
    memcpy(&header, bytes, sizeof header);
    if (!check_header(&header, size, path, error))
        return false;
    rk_error reason;
    if (!rk_mesh_init(mesh, header.vertex_count, header.triangle_count, header.material_count,
                      (int)(header.flags & (RK_MESH_NORMALS | RK_MESH_TEXCOORDS | RK_MESH_COLOURS)),
                      &reason))
        return rk_fail(error, "%s: %.900s", path, reason.text);
    mesh->up = header.up;
    tail rest = unpack(mesh, &header, bytes + sizeof header);
    if (check_textures(&rest, &header, path, error) && rk_mesh_validate(mesh, path, error) &&
        read_textures(mesh, &header, &rest, path, error)) {
        settle_cutoffs(mesh);
        return true;
    }
    rk_mesh_free(mesh);
    return false;
}

bool rk_mesh_file_read(rk_mesh *mesh, const char *path, rk_error *error)
{
    *mesh = (rk_mesh){0};
    const char *const arguments[] = {path, NULL};
    rk_helper_call call = {.program = "raykit-mesh",
                           .package = "libassimp-dev 5.2 or later",
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
