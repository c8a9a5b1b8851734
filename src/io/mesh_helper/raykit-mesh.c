/* raykit-mesh FILE: reads a mesh with Assimp and writes it to standard output in the format of
 * mesh_stream.h. On failure the exit status is 1 and the last line on standard error is the reason.
 * raykit-mesh --version: prints the version, which is that of the drivers.
 * rk_mesh_file_read starts it; a file that makes Assimp crash ends only this process. */
#include "io/mesh_helper/mesh_amf_places.h"
#include "io/mesh_helper/mesh_attributes.h"
#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_gather.h"
#include "io/mesh_helper/mesh_gltf_parts.h"
#include "io/mesh_helper/mesh_guard.h"
#include "io/mesh_helper/mesh_io.h"
#include "io/mesh_helper/mesh_rewrite.h"
#include "io/mesh_helper/mesh_syntax.h"
#include "io/mesh_helper/mesh_up.h"
#include "io/mesh_helper/mesh_x3d_colours.h"
#include "io/mesh_stream.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool write_bytes(const void *bytes, uint64_t size, rk_error *error)
{
    for (const char *at = bytes; size > 0;) {
        ssize_t n = write(STDOUT_FILENO, at, size);
        if (n < 0 && errno != EINTR)
            return rk_fail(error, "raykit-mesh: its answer could not be written: %s: try again",
                           strerror(errno));
        if (n > 0) {
            at += n;
            size -= (uint64_t)n;
        }
    }
    return true;
}

static bool write_materials(const rk_mesh *mesh, const rk_mesh_textures *textures, rk_error *error)
{
    bool ok = true;
    for (uint32_t i = 0; i < mesh->material_count && ok; i++) {
        const rk_material *m = &mesh->materials[i];
        rk_mesh_stream_material row = {{m->kd.x, m->kd.y, m->kd.z},
                                       {m->ks.x, m->ks.y, m->ks.z},
                                       m->shininess,
                                       m->alpha,
                                       m->alpha_cutoff,
                                       textures->of_material[i],
                                       textures->alpha_of_material[i]};
        ok = write_bytes(&row, sizeof row, error);
    }
    return ok;
}

static bool write_textures(const rk_mesh_textures *textures, rk_error *error)
{
    bool ok = true;
    for (uint32_t i = 0; i < textures->count && ok; i++) {
        const rk_mesh_texture *t = &textures->entries[i];
        rk_mesh_stream_texture row = {t->clamps, t->name.length, t->data_size};
        ok = write_bytes(&row, sizeof row, error);
    }
    for (uint32_t i = 0; i < textures->count && ok; i++) {
        const rk_mesh_texture *t = &textures->entries[i];
        ok = write_bytes(t->name.data, t->name.length, error) &&
             write_bytes(t->data, t->data_size, error);
    }
    return ok;
}

static bool count_texture_bytes(const rk_mesh_textures *textures, const char *path, uint32_t *count,
                                rk_error *error)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < textures->count; i++)
        bytes += (uint64_t)textures->entries[i].name.length + textures->entries[i].data_size;
    *count = (uint32_t)bytes;
    return bytes <= UINT32_MAX ||
           rk_fail(error, "%s: its pictures exceed 4 GB: make them smaller", path);
}

static bool write_mesh(const rk_mesh *mesh, const rk_mesh_textures *textures, const char *path,
                       rk_error *error)
{
    rk_mesh_stream_header header = {
        .magic = RK_MESH_STREAM_MAGIC,
        .version = RK_MESH_STREAM_VERSION,
        .flags = (mesh->normals ? (uint32_t)RK_MESH_NORMALS : 0) |
                 (mesh->texcoords ? (uint32_t)RK_MESH_TEXCOORDS : 0) |
                 (mesh->colours ? (uint32_t)RK_MESH_COLOURS : 0),
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count,
        .material_count = mesh->material_count,
        .texture_count = textures->count,
        .up = mesh->up,
    };
    rk_mesh_stream_sizes sizes = rk_mesh_stream_sizes_of(&header);
    return count_texture_bytes(textures, path, &header.texture_bytes, error) &&
           write_bytes(&header, sizeof header, error) &&
           write_bytes(mesh->positions, sizes.positions, error) &&
           write_bytes(mesh->normals, sizes.normals, error) &&
           write_bytes(mesh->texcoords, sizes.texcoords, error) &&
           write_bytes(mesh->colours, sizes.colours, error) &&
           write_bytes(mesh->triangles, sizes.triangles, error) &&
           write_bytes(mesh->triangle_materials, sizes.triangle_materials, error) &&
           write_materials(mesh, textures, error) && write_textures(textures, error);
}

/* Pictures are named from the mesh or from the material file's folder. Those that are nowhere keep
 * their name, for the note about them. */
static void find_pictures(rk_mesh_textures *textures, const rk_mesh_hints *hints, const char *path)
{
    for (uint32_t i = 0; i < textures->count; i++) {
        struct aiString *name = &textures->entries[i].name;
        char found[RK_MESH_FILES_NAME];
        bool there = textures->entries[i].data ||
                     rk_mesh_files_find(found, path, "", name->data, name->length);
        if (textures->entries[i].data)
            continue;
        for (int k = 0; k < hints->folder_count && !there; k++)
            there = rk_mesh_files_find(found, path, hints->folders[k], name->data, name->length);
        const char *slash = strrchr(name->data, '/'), *back = strrchr(name->data, '\\');
        const char *last = back > slash ? back : slash;
        for (int k = -1; k < hints->folder_count && !there && last; k++)
            there = rk_mesh_files_find(found, path, k < 0 ? "" : hints->folders[k], last + 1,
                                       strlen(last + 1));
        if (there && strlen(found) < sizeof name->data) {
            strcpy(name->data, found);
            name->length = (ai_uint32)strlen(found);
        }
    }
}

/* What was checked must be what is drawn. Vertices are compared where Assimp keeps the file's: in
 * PLY and OFF, unless it copies them for parts of several materials; of an OBJ it makes one for
 * each corner, and in other formats there is no count of our own. */
static void compare_counts(rk_mesh_hints *hints, const struct aiScene *scene, const char *path)
{
    size_t faces = 0, corners = 0, vertices = 0;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        vertices += scene->mMeshes[i]->mNumVertices;
        for (uint32_t k = 0; k < scene->mMeshes[i]->mNumFaces; k++) {
            uint32_t count = scene->mMeshes[i]->mFaces[k].mNumIndices;
            faces += count >= 3;
            corners += count >= 3 ? count : 0;
        }
    }
    if (hints->faces && (faces != hints->faces || corners != hints->corners))
        rk_mesh_hints_note(hints, path,
                           "has %zu faces of %zu corners, but Assimp reads %zu of %zu: the picture "
                           "differs from the file; export it in another format",
                           hints->faces, hints->corners, faces, corners);
    if (hints->vertices && scene->mNumMeshes == 1 && vertices != hints->vertices)
        rk_mesh_hints_note(hints, path,
                           "has %zu vertices, but Assimp reads %zu: the picture differs from the "
                           "file; export it in another format",
                           hints->vertices, vertices);
}

/* Of formats that only Assimp reads; OBJ, PLY and OFF were moved. */
static void note_distance(rk_mesh_hints *hints, const rk_mesh *mesh, const char *path)
{
    mesh_extent extent = {0};
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const rk_vec3 *p = &mesh->positions[i];
        extent_add(&extent, (const double[3]){(double)p->x, (double)p->y, (double)p->z});
    }
    double share = extent_share(&extent);
    if (share < 1e-4)
        rk_mesh_hints_note(hints, path,
                           "lies %.2g times its size away from the origin, where numbers in single "
                           "precision are coarse: move it to the origin before exporting it",
                           1 / share);
}

/* In double precision, in which the square of a float is not 0. */
static bool has_area(const rk_mesh *mesh, const uint32_t corners[3])
{
    double e[2][3], n[3], edges = 0;
    for (int k = 0; k < 2; k++) {
        const rk_vec3 a = mesh->positions[corners[0]], b = mesh->positions[corners[k + 1]];
        e[k][0] = (double)b.x - (double)a.x;
        e[k][1] = (double)b.y - (double)a.y;
        e[k][2] = (double)b.z - (double)a.z;
        edges += e[k][0] * e[k][0] + e[k][1] * e[k][1] + e[k][2] * e[k][2];
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = e[0][j] * e[1][k] - e[0][k] * e[1][j];
    }
    return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) > 0x1p-24 * edges;
}

static void note_area(rk_mesh_hints *hints, const rk_mesh *mesh, const char *path)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        if (has_area(mesh, mesh->triangles[i]))
            return;
    rk_mesh_hints_note(hints, path,
                       "the corners of each triangle are on a line, so nothing of it is visible: "
                       "export the mesh again");
}

/* By `d 0` or the like, which some programs write by mistake. */
static void note_invisible(rk_mesh_hints *hints, const rk_mesh *mesh,
                           const rk_mesh_textures *textures, const char *path)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        const rk_material *m = &mesh->materials[i];
        const bool is_cut = m->alpha < m->alpha_cutoff && textures->alpha_of_material[i] == 0;
        count += m->alpha == 0 || is_cut;
    }
    if (count > 0)
        rk_mesh_hints_note(hints, path,
                           "%u of %u materials have an opacity of 0 (such as d 0), so that "
                           "--transparency shows nothing of them: make them opaque if they should "
                           "not be",
                           count, mesh->material_count);
}

/* Assimp does not pass on which faces are flat. */
static void note_flat_faces(rk_mesh_hints *hints, const char *path)
{
    if (rk_mesh_files_has_ending(path, "blend") || rk_mesh_files_has_ending(path, "3ds"))
        rk_mesh_hints_note(hints, path,
                           "flat faces may be drawn smooth: export it as glTF if they should not");
}

static void mark_shown(const struct aiNode *node, bool *is_shown)
{
    for (uint32_t i = 0; i < node->mNumMeshes; i++)
        is_shown[node->mMeshes[i]] = true;
    for (uint32_t i = 0; i < node->mNumChildren; i++)
        mark_shown(node->mChildren[i], is_shown);
}

/* Other programs show an object of 3DS that has no node, too. */
static void note_unshown(rk_mesh_hints *hints, const struct aiScene *scene, const char *path)
{
    if (!rk_mesh_files_has_ending(path, "3ds"))
        return;
    bool *is_shown = calloc(scene->mNumMeshes, sizeof *is_shown);
    uint32_t count = 0;
    if (is_shown)
        mark_shown(scene->mRootNode, is_shown);
    for (uint32_t i = 0; is_shown && i < scene->mNumMeshes; i++)
        count += !is_shown[i];
    if (count > 0)
        rk_mesh_hints_note(hints, path,
                           "%u of its %u parts %s no node in its keyframes: Assimp leaves %s out",
                           count, scene->mNumMeshes, count == 1 ? "has" : "have",
                           count == 1 ? "it" : "them");
    free(is_shown);
}

/* Assimp reads one material for each part of a 3MF file, and nothing of the extensions. */
static void note_rest_of_3mf(rk_mesh_hints *hints, const char *path)
{
    if (hints->models > 0)
        rk_mesh_hints_note(hints, path,
                           "of a 3MF file each part shows one material: colours of triangles, "
                           "colour groups (whose parts may show another part's colour), textures "
                           "and painting, if it has any, are not drawn");
    if (hints->models > 1)
        rk_mesh_hints_note(hints, path,
                           "has %zu models in its archive, of which Assimp reads one: parts in the "
                           "others (production extension) are not drawn",
                           hints->models);
}

static bool is_unknown(const char *path)
{
    const char *dot = strrchr(path, '.');
    return !dot || !aiIsExtensionSupported(dot);
}

static bool fail_unknown(const char *path, rk_error *error)
{
    return rk_fail(error, "%s: has a format that Assimp does not read: export it as glTF or OBJ",
                   path);
}

/* Assimp tries all its readers on an unknown file, and gives the last one's reason. */
static bool fail_unread(const char *path, const rk_mesh_hints *hints, rk_error *error)
{
    const char *reason = aiGetErrorString();
    if (is_unknown(path))
        return fail_unknown(path, error);
    if (rk_mesh_files_has_ending(path, "blend"))
        return rk_fail(error, "%s: could not be read: open it in Blender, and export it as glTF",
                       path);
    if (hints->missing[0])
        return rk_fail(error,
                       "%s: needs the file %s, which is missing: put it beside the mesh file", path,
                       hints->missing);
    if (hints->is_gltf_1)
        return rk_fail(error,
                       "%s: is glTF 1.0, of which Assimp cannot read this file: convert it to glTF "
                       "2.0, for instance by Blender",
                       path);
    if (hints->parts && strstr(reason, "has no faces"))
        return rk_fail(error,
                       "%s: all triangles of a part use vertices that are not there: export it "
                       "again",
                       path);
    if (hints->has_wide_draco && strstr(reason, "accessor without data"))
        return rk_fail(error,
                       "%s: is compressed by Draco with 32-bit indices, which Assimp does not "
                       "decode: export it uncompressed",
                       path);
    if (strstr(reason, "No suitable reader"))
        return rk_fail(
            error,
            "%s: Assimp cannot read it, because it is damaged or breaks the rules of its "
            "format: export it again, or in another format",
            path);
    size_t length = strlen(reason);
    while (length > 0 && strchr(" .\n", reason[length - 1]))
        length--;
    return rk_fail(error, "%s: Assimp cannot read it: %.*s: export it again, or as glTF or OBJ",
                   path, length < 600 ? (int)length : 600, reason);
}

/* Assimp draws the nodes of some formats if the file has no mesh. */
static bool is_skeleton(const struct aiScene *scene, const char *path)
{
    struct aiString name;
    /* Its own material is there only if the file has none; Collada's meshes have names. */
    if (scene->mNumMeshes == 1 && scene->mMeshes[0]->mNumBones > 0 &&
        scene->mMeshes[0]->mName.length == 0 && rk_mesh_files_has_ending(path, "dae"))
        return true;
    return scene->mNumMeshes == 1 && scene->mNumMaterials == 1 &&
           aiGetMaterialString(scene->mMaterials[0], AI_MATKEY_NAME, &name) == aiReturn_SUCCESS &&
           strcmp(name.data, "SkeletonMaterial") == 0;
}

/* A Collada file's axes stay as they are, as of other formats. */
static const struct aiScene *import(const char *path)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION,
                               rk_mesh_files_has_ending(path, "dae"));
    const struct aiScene *scene = aiImportFileExWithProperties(path, 0, &rk_mesh_io, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

/* No post-processing: Assimp's triangulation aborts on some broken files, and its joining of
 * vertices is slow. Its scene is not released: that crashes after some 3MF files with pictures, and
 * the process ends anyway. */
static bool convert(const char *path, rk_mesh_hints *hints, rk_error *error)
{
    static const struct aiScene *scene;
    if (!rk_mesh_syntax_check(path, hints, error))
        return false;
    if (hints->text)
        rk_mesh_io_replace(path, hints->text, hints->size);
    scene = import(path);
    if (!scene && strstr(aiGetErrorString(), "bad_alloc"))
        return rk_mesh_guard_fail_memory(hints->uses, error);
    if (!scene || (hints->is_gltf_1 && !scene->mRootNode))
        return fail_unread(path, hints, error);
    if (is_unknown(path) && (is_skeleton(scene, path) || scene->mNumMeshes == 0))
        return fail_unknown(path, error);
    if (is_skeleton(scene, path))
        return rk_fail(error,
                       "%s: has no triangles in its scene: export a mesh with faces that a node "
                       "shows",
                       path);
    compare_counts(hints, scene, path);
    rk_mesh_attributes_lend(scene, hints);
    rk_mesh_amf_places_apply(scene, hints);
    rk_mesh mesh = {0};
    rk_mesh_textures textures = {0};
    bool ok = rk_mesh_gltf_parts_mend(scene, hints, path, error) &&
              rk_mesh_gather(&mesh, &textures, scene, path, hints, error) &&
              rk_mesh_validate(&mesh, path, error);
    if (ok) {
        rk_mesh_up_set(&mesh, scene, path, hints->up);
        find_pictures(&textures, hints, path);
        if (hints->pictures_replace)
            rk_mesh_x3d_colours_replace(&mesh, &textures, path);
        note_distance(hints, &mesh, path);
        note_area(hints, &mesh, path);
        note_invisible(hints, &mesh, &textures, path);
        note_flat_faces(hints, path);
        note_unshown(hints, scene, path);
        note_rest_of_3mf(hints, path);
        ok = write_mesh(&mesh, &textures, path, error);
    }
    if (!ok && hints->undrawn[0] && strstr(error->text, "has no triangles"))
        rk_fail(
            error,
            "%s: Assimp reads no triangles of it, only nodes that it leaves out (%s): export it "
            "without them, or as glTF",
            path, hints->undrawn);
    if (!ok && strstr(error->text, "no memory for"))
        rk_mesh_guard_fail_memory(hints->uses, error);
    if (textures.too_many)
        rk_mesh_hints_note(hints, path,
                           "names more than %d textures: surfaces with the others are untextured",
                           RK_MESH_STREAM_TEXTURES_MAX);
    rk_mesh_textures_free(&textures);
    rk_mesh_free(&mesh);
    return ok;
}

static void free_hints(rk_mesh_hints *hints)
{
    free(hints->text);
    free(hints->normals);
    free(hints->colours);
    free(hints->texcoords);
    free(hints->face_colours);
    free(hints->wedges);
    free(hints->parts);
    free(hints->places);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fputs(
            "usage: raykit-mesh FILE (writes the mesh to standard output for rk_mesh_file_read)\n",
            stderr);
        return EXIT_FAILURE;
    }
    if (strcmp(argv[1], "--version") == 0) {
        puts("raykit-mesh " PACKAGE_VERSION);
        return EXIT_SUCCESS;
    }
    rk_mesh_hints hints;
    rk_error error = {0};
    rk_mesh_guard_begin(argv[1]);
    bool ok = convert(argv[1], &hints, &error);
    const char *text = ok ? hints.note.text : error.text;
    if (*text)
        fprintf(stderr, "%s\n", text);
    free_hints(&hints);
    return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
