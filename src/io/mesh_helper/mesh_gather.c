/* Walks the nodes of the file, each with its transform, and emits its polygons triangle by
 * triangle; vertices that are equal in all that they have become one
 * (io/mesh_helper/vertex_pool.h). */
#include "io/mesh_helper/mesh_gather.h"

#include "io/mesh_helper/mesh_emit.h"
#include "io/mesh_helper/mesh_io.h"
#include "io/mesh_helper/mesh_material.h"
#include "io/mesh_helper/mesh_obj_libraries.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { most_materials = UINT16_MAX, deepest_node = 1000 };

/* A material of the file becomes one of ours for each set of these that its parts need. */
enum { WITHOUT_TEXTURE = 1, COLOURED = 2, variants = 4 };

static const char *const remedy = "repair the mesh or export it again";

/* --- parts and nodes ----------------------------------------------------------------------- */

static bool check_face(const rk_mesh_emit_state *g, const rk_mesh_emit_part *p, uint32_t number,
                       rk_error *error)
{
    const struct aiFace *face = &p->mesh->mFaces[number];
    const char *name = p->mesh->mName.data;
    if (face->mNumIndices > 0 && !face->mIndices)
        return rk_fail(error, "%s: face %u of part \"%.100s\" has no indices: %s", g->path, number,
                       name, remedy);
    for (uint32_t i = 0; i < face->mNumIndices; i++)
        if (face->mIndices[i] >= p->mesh->mNumVertices)
            return rk_fail(error,
                           "%s: face %u of part \"%.100s\" uses vertex %u, but it has %u: %s",
                           g->path, number, name, face->mIndices[i], p->mesh->mNumVertices, remedy);
    return true;
}

static const rk_mesh_mtl_material *mtl_of(const rk_mesh_emit_state *g,
                                          const struct aiMaterial *material)
{
    struct aiString name;
    return g->mtl.count > 0 &&
                   aiGetMaterialString(material, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS
               ? rk_mesh_mtl_find(&g->mtl, name.data)
               : NULL;
}

/* A picture of a scan repeats the colours of its vertices. */
static void find_colours(rk_mesh_emit_state *g, rk_mesh_emit_part *p, bool textured)
{
    p->face_colour = rk_vec(1, 1, 1);
    const bool hidden = textured && g->colours.replace;
    const bool by_vertex = g->colours.any && g->colours.face_count == 0;
    p->colours = by_vertex && !hidden ? p->mesh->mColors[0] : NULL;
    g->left.has[RK_MESH_LEFT_OUT_HIDDEN_COLOURS] |= g->colours.any && hidden && p->mesh->mColors[0];
}

/* By more than rounding. */
static bool leaves_picture(const rk_mesh_emit_part *p)
{
    const float slack = 1e-3f;
    for (uint32_t i = 0; i < p->mesh->mNumVertices; i++) {
        const rk_vec2 at = rk_mesh_emit_texcoord(&p->transform, &p->texcoords[i]);
        if (at.x < -slack || at.x > 1 + slack || at.y < -slack || at.y > 1 + slack)
            return true;
    }
    return false;
}

static uint32_t source_named(const rk_mesh_emit_state *g, const char *name, uint32_t otherwise)
{
    struct aiString other;
    for (uint32_t i = 0; i < g->scene->mNumMaterials; i++)
        if (aiGetMaterialString(g->scene->mMaterials[i], AI_MATKEY_NAME, &other) ==
                aiReturn_SUCCESS &&
            strcmp(other.data, name) == 0)
            return i;
    return otherwise;
}

/* Where no material file has the name that an OBJ uses, the longest one before a comment, in the
 * OBJ or in the file. */
static uint32_t without_comment(const rk_mesh_emit_state *g, uint32_t source)
{
    struct aiString name;
    if (!g->mtl.count || aiGetMaterialString(g->scene->mMaterials[source], AI_MATKEY_NAME, &name) !=
                             aiReturn_SUCCESS)
        return source;
    for (char *sign; (sign = strrchr(name.data, '#')) && !rk_mesh_mtl_find(&g->mtl, name.data);) {
        if (sign == name.data || !strchr(" \t", sign[-1]))
            return source;
        while (sign > name.data && strchr(" \t", sign[-1]))
            sign--;
        *sign = '\0';
    }
    const rk_mesh_mtl_material *commented = rk_mesh_mtl_find_commented(&g->mtl, name.data);
    const bool is_cut = strlen(name.data) < name.length;
    return commented ? source_named(g, commented->name, source)
           : is_cut  ? source_named(g, name.data, source)
                     : source;
}

static bool find_material(rk_mesh_emit_state *g, rk_mesh_emit_part *p, rk_error *error)
{
    uint32_t source = g->plain ? 0 : p->mesh->mMaterialIndex;
    if (source >= g->scene->mNumMaterials && !g->plain)
        return rk_fail(error, "%s: part \"%.100s\" uses material %u, but the file has %u: %s",
                       g->path, p->mesh->mName.data, source, g->scene->mNumMaterials, remedy);
    if (source < g->scene->mNumMaterials && !g->plain)
        source = without_comment(g, source);
    uint32_t set = 0, key = variants * source;
    bool textured =
        source < g->scene->mNumMaterials && rk_mesh_texture_set(g->scene->mMaterials[source], &set);
    p->texcoords = p->mesh->mTextureCoords[set];
    if (!p->texcoords && !g->colours.is_gltf) /* numbers of sets are Assimp's own */
        p->texcoords = p->mesh->mTextureCoords[0];
    if (textured && !p->texcoords && g->any_texcoords) {
        key += WITHOUT_TEXTURE;
        g->left.has[RK_MESH_LEFT_OUT_UNPLACED] |= g->models == 0; /* of 3MF, all are told */
    }
    find_colours(g, p, textured && p->texcoords);
    if (textured && p->texcoords) {
        const struct aiMaterial *material = g->scene->mMaterials[source];
        p->transform = rk_mesh_texture_transform_of(material, mtl_of(g, material));
        g->left.has[RK_MESH_LEFT_OUT_WRAPS] |=
            rk_mesh_texture_wraps_otherwise(material) && leaves_picture(p);
    }
    if (p->colours || g->colours.face_count > 0)
        key += COLOURED;
    if (g->material_numbers[key] == 0) {
        if (g->material_count == most_materials)
            return rk_fail(error, "%s: uses more than %d materials: merge equal ones", g->path,
                           most_materials);
        g->material_sources[g->material_count] = key;
        g->material_numbers[key] = ++g->material_count;
    }
    p->material = (uint16_t)(g->material_numbers[key] - 1);
    return true;
}

static bool has_unfinite_colour(const rk_mesh_emit_state *g, const rk_mesh_emit_part *p,
                                const struct aiFace *face)
{
    if (g->colours.face_count > 0)
        return g->colours.is_unfinite;
    for (uint32_t i = 0; p->colours && i < face->mNumIndices; i++) {
        const struct aiColor4D *c = &p->colours[face->mIndices[i]];
        if (!(isfinite(c->r) && isfinite(c->g) && isfinite(c->b)))
            return true;
    }
    return false;
}

static bool emit_faces(rk_mesh_emit_state *g, rk_mesh_emit_part *p, rk_error *error)
{
    bool has_material = false;
    for (uint32_t i = 0; i < p->mesh->mNumFaces; i++) {
        const struct aiFace *face = &p->mesh->mFaces[i];
        if (!check_face(g, p, i, error))
            return false;
        if (face->mNumIndices < 3)
            continue;
        if (!has_material && !find_material(g, p, error))
            return false;
        has_material = true;
        if (g->colours.face_count > 0)
            p->face_colour = rk_mesh_colours_next_face(&g->colours, face->mNumIndices);
        g->black_faces += has_unfinite_colour(g, p, face);
        if (!rk_mesh_emit_is_finite(p, face))
            g->unfinite_faces++;
        else if (face->mNumIndices == 3
                     ? !rk_mesh_emit_triangle(g, p, face->mIndices, (const uint32_t[3]){0, 1, 2},
                                              error)
                     : !rk_mesh_emit_polygon(g, p, face, error))
            return false;
        if (g->wedges)
            g->wedges += face->mNumIndices;
    }
    return true;
}

static bool emit_part(rk_mesh_emit_state *g, const struct aiMesh *mesh, const rk_mesh_place *place,
                      rk_error *error)
{
    if (!mesh->mVertices || !mesh->mFaces)
        return true;
    rk_mesh_emit_part p = {.mesh = mesh, .place = place, .transform = {{{1, 0, 0}, {0, 1, 0}}}};
    p.numbers = rk_allocate(mesh->mNumVertices, sizeof *p.numbers, g->path, error);
    bool ok = p.numbers && rk_mesh_skin_pose(&g->skin, mesh, place, &p.places, g->path, error) &&
              emit_faces(g, &p, error);
    free(p.numbers);
    free(p.places);
    free(p.points);
    free(p.triangles);
    free(p.left);
    return ok;
}

static bool emit_node(rk_mesh_emit_state *g, const struct aiNode *node, const rk_mesh_place *parent,
                      int depth, rk_error *error)
{
    if (depth > deepest_node)
        return rk_fail(error, "%s: its parts are nested deeper than %d: %s", g->path, deepest_node,
                       remedy);
    rk_mesh_place place = rk_mesh_place_in(parent, &node->mTransformation);
    for (uint32_t i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= g->scene->mNumMeshes)
            return rk_fail(error, "%s: node \"%.100s\" uses part %u, but the file has %u: %s",
                           g->path, node->mName.data, node->mMeshes[i], g->scene->mNumMeshes,
                           remedy);
        if (!emit_part(g, g->scene->mMeshes[node->mMeshes[i]], &place, error))
            return false;
    }
    for (uint32_t i = 0; i < node->mNumChildren; i++)
        if (!emit_node(g, node->mChildren[i], &place, depth + 1, error))
            return false;
    return true;
}

/* --- the whole ----------------------------------------------------------------------------- */

/* Assimp makes one of the name, of another grey. Longer names are cut, and of many files not all
 * are known. */
static void see_lost(rk_mesh_emit_state *g, const struct aiMaterial *source, rk_material *material)
{
    struct aiString name;
    if (!rk_mesh_io_mtl(0) || rk_mesh_io_mtl(RK_MESH_IO_MTLS - 1) || mtl_of(g, source) ||
        aiGetMaterialString(source, AI_MATKEY_NAME, &name) != aiReturn_SUCCESS ||
        name.length >= sizeof((rk_mesh_mtl_material *)0)->name - 1 ||
        strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) == 0)
        return;
    material->kd = rk_vec(0.8f, 0.8f, 0.8f);
    if (rk_mesh_obj_libraries_means_none(name.data))
        return;
    if (g->lost_materials++ == 0)
        snprintf(g->lost_material, sizeof g->lost_material, "%.90s", name.data);
}

/* Some exporters write Tr 1 for opaque. */
static void draw_tr_one(rk_mesh_emit_state *g, const struct aiMaterial *source,
                        rk_material *material)
{
    const rk_mesh_mtl_material *mtl = mtl_of(g, source);
    if (!mtl || !mtl->is_tr_one || material->alpha > 0)
        return;
    material->alpha = 1;
    g->drew_tr_one = true;
}

/* Some exporters of Collada write a transparency of 0 for opaque. */
static void draw_clear(rk_mesh_emit_state *g, rk_material *material)
{
    const char *dot = strrchr(g->path, '.');
    if (!dot || strcasecmp(dot, ".dae") != 0 || material->alpha > 0)
        return;
    material->alpha = 1;
    g->drew_clear = true;
}

/* Maya writes Kd 0 0 0 beside a picture that replaces it. */
static void draw_picture_of_black(rk_mesh_emit_state *g, const struct aiMaterial *source,
                                  rk_material *material)
{
    if (!mtl_of(g, source) || material->kd.x > 0 || material->kd.y > 0 || material->kd.z > 0)
        return;
    material->kd = rk_vec(1, 1, 1);
    g->drew_black = true;
}

static void set_material(rk_mesh_emit_state *g, rk_mesh *mesh, rk_mesh_textures *textures,
                         uint32_t i)
{
    const struct aiMaterial *source = g->scene->mMaterials[g->material_sources[i] / variants];
    const uint32_t variant = g->material_sources[i] % variants;
    if (!(variant & WITHOUT_TEXTURE) && g->models == 0)
        rk_mesh_textures_find(textures, i, g->scene, source, g->path);
    bool varies = textures->of_material[i] != 0 || variant & COLOURED;
    if (!g->plain)
        mesh->materials[i] = rk_mesh_material(source, varies, g->models > 0);
    if (!(variant & COLOURED && g->colours.replace))
        see_lost(g, source, &mesh->materials[i]);
    draw_tr_one(g, source, &mesh->materials[i]);
    draw_clear(g, &mesh->materials[i]);
    if (g->models > 0 && rk_mesh_texture_set(source, &(uint32_t){0}))
        mesh->materials[i].kd = rk_vec(0.8f, 0.8f, 0.8f); /* Assimp's is black */
    if (textures->of_material[i] != 0)
        draw_picture_of_black(g, source, &mesh->materials[i]);
    rk_mesh_left_out_of_material(&g->left, source);
    if (variant & COLOURED ? g->colours.replace : g->plain && varies)
        mesh->materials[i].kd = rk_vec(1, 1, 1);
}

static bool finish(rk_mesh_emit_state *g, rk_mesh *mesh, rk_mesh_textures *textures,
                   rk_error *error)
{
    if (g->triangle_count == 0 && g->unfinite_faces > 0)
        return rk_fail(
            error,
            "%s: each face (%zu in all) has a corner that is not a finite number (nan or "
            "inf): %s",
            g->path, g->unfinite_faces, remedy);
    if (g->triangle_count == 0 && g->models > 1)
        return rk_fail(error,
                       "%s: has its parts in other models of its archive (production extension), "
                       "which Assimp does not read: export it without, or as STL",
                       g->path);
    if (g->triangle_count == 0 && g->models > 0)
        return rk_fail(error,
                       "%s: has no triangles in what it builds; shapes of 3MF's extensions "
                       "(volumes, functions, beams) are not read: export it as STL",
                       g->path);
    const char *dot = strrchr(g->path, '.');
    if (g->triangle_count == 0 && dot && strcasecmp(dot, ".irr") == 0)
        return rk_fail(error,
                       "%s: is a scene of Irrlicht of which Assimp reads no triangles: name one of "
                       "the meshes that it uses",
                       g->path);
    if (g->triangle_count == 0)
        return rk_fail(error, "%s: has no triangles: choose a mesh with faces", g->path);
    int optional = (g->any_normals ? RK_MESH_NORMALS : 0) |
                   (g->any_texcoords ? RK_MESH_TEXCOORDS : 0) |
                   (g->colours.any ? RK_MESH_COLOURS : 0);
    rk_error reason;
    if (!rk_mesh_init(mesh, g->pool.count, g->triangle_count, g->material_count, optional, &reason))
        return rk_fail(error, "%s: %.900s", g->path, reason.text);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const rk_vertex vertex = rk_vertex_pool_at(&g->pool, i);
        mesh->positions[i] = vertex.position;
        if (mesh->normals)
            mesh->normals[i] = vertex.normal;
        if (mesh->texcoords)
            mesh->texcoords[i] = vertex.texcoord;
        if (mesh->colours)
            mesh->colours[i] = vertex.colour;
    }
    memcpy(mesh->triangles, g->triangles, g->triangle_count * sizeof *g->triangles);
    memcpy(mesh->triangle_materials, g->triangle_materials,
           g->triangle_count * sizeof *g->triangle_materials);
    if (!rk_mesh_textures_init(textures, mesh->material_count, g->path, error)) {
        rk_mesh_free(mesh);
        return false;
    }
    for (uint32_t i = 0; i < mesh->material_count; i++)
        if (g->material_sources[i] / variants < g->scene->mNumMaterials)
            set_material(g, mesh, textures, i);
    return true;
}

static void tell(rk_mesh_emit_state *g, rk_mesh_hints *hints)
{
    /* Assimp has freed a 3MF file's thumbnails. */
    rk_mesh_left_out_of_scene(&g->left, g->scene, g->models == 0);
    g->left.has[RK_MESH_LEFT_OUT_TORN_COLOURS] = g->colours.torn;
    g->left.has[RK_MESH_LEFT_OUT_CLEAR_COLOURS] = g->colours.is_clear;
    if (g->unfinite_faces > 0)
        rk_mesh_hints_note(hints, g->path,
                           "%zu %s left out: a corner is not a finite number (nan or inf)",
                           g->unfinite_faces, g->unfinite_faces == 1 ? "face is" : "faces are");
    if (g->black_faces > 0)
        rk_mesh_hints_note(hints, g->path,
                           "%zu %s a colour that is not a finite number (nan or inf), which is "
                           "drawn as 0",
                           g->black_faces, g->black_faces == 1 ? "face has" : "faces have");
    if (g->replaced)
        rk_mesh_hints_note(hints, g->path,
                           "some normals or texture coordinates are not finite numbers, and are "
                           "replaced");
    if (g->lost_materials > 0)
        rk_mesh_hints_note(hints, g->path,
                           "uses %zu %s that no material file has (the first: %s), whose surfaces "
                           "are grey",
                           g->lost_materials, g->lost_materials == 1 ? "material" : "materials",
                           g->lost_material);
    if (g->skin.is_unposed)
        rk_mesh_hints_note(hints, g->path,
                           "has a skin whose joints stand elsewhere than where it was bound to "
                           "them, which the picture does not show");
    if (g->skin.lost[0] && !g->skin.is_told)
        rk_mesh_hints_note(
            hints, g->path,
            "has a skin that is not applied, because its joint \"%s\" is missing, or "
            "has the name of another: give joints different names",
            g->skin.lost);
    if (g->drew_tr_one)
        rk_mesh_hints_note(hints, g->path,
                           "Tr 1 makes a material invisible; it is drawn as opaque, because some "
                           "programs mean that: write d 0 for an invisible one");
    if (g->drew_clear)
        rk_mesh_hints_note(hints, g->path,
                           "a transparency of 0 makes a material invisible; it is drawn as opaque, "
                           "because some programs mean that");
    if (g->drew_black)
        rk_mesh_hints_note(hints, g->path,
                           "Kd 0 0 0 makes a picture (map_Kd) black; the picture is drawn as it "
                           "is, because some programs mean that");
    rk_mesh_left_out_tell(&g->left, g->path, hints);
}

static bool check_root(const rk_mesh_emit_state *g, rk_error *error)
{
    return g->scene->mRootNode ||
           rk_fail(error,
                   "%s: Assimp finds nothing in it: it is damaged, or its text is in UTF-16: "
                   "export it again, or in another format",
                   g->path);
}

bool rk_mesh_gather(rk_mesh *mesh, rk_mesh_textures *textures, const struct aiScene *scene,
                    const char *path, rk_mesh_hints *hints, rk_error *error)
{
    rk_mesh_emit_state g = {.path = path,
                            .scene = scene,
                            .plain = hints->plain,
                            .models = hints->models,
                            .pool.name = path};
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        g.any_normals |= scene->mMeshes[i]->mNormals != NULL;
        g.any_texcoords |= scene->mMeshes[i]->mTextureCoords[0] != NULL;
    }
    if (scene->mNumMeshes == 1 && hints->wedge_count == hints->corners)
        g.wedges = hints->wedges;
    const rk_mesh_place world = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, true};
    const size_t keys = variants * ((size_t)scene->mNumMaterials + 1);
    g.material_numbers = rk_allocate(keys, sizeof *g.material_numbers, path, error);
    g.material_sources = rk_allocate(keys, sizeof *g.material_sources, path, error);
    rk_mesh_colours_init(&g.colours, scene, path, hints);
    bool ok = g.material_numbers && g.material_sources && check_root(&g, error) &&
              rk_mesh_mtl_read(&g.mtl, error) && rk_mesh_skin_begin(&g.skin, scene, path, error);
    g.pool.coloured = g.colours.any;
    ok = ok && emit_node(&g, scene->mRootNode, &world, 0, error) &&
         finish(&g, mesh, textures, error);
    if (ok)
        tell(&g, hints);
    rk_mesh_mtl_free(&g.mtl);
    rk_mesh_skin_end(&g.skin);
    rk_mesh_colours_free(&g.colours);
    rk_vertex_pool_free(&g.pool);
    free(g.triangles);
    free(g.triangle_materials);
    free(g.material_numbers);
    free(g.material_sources);
    return ok;
}
