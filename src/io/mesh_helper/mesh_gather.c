/* Walks the nodes of the file, each with its transform, and emits its polygons triangle by
 * triangle; vertices that are equal in all that they have become one
 * (io/mesh_helper/vertex_pool.h). */
#include "io/mesh_helper/mesh_gather.h"

#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/mesh_io.h"
#include "io/mesh_helper/mesh_left_out.h"
#include "io/mesh_helper/mesh_material.h"
#include "io/mesh_helper/mesh_obj_libraries.h"
#include "io/mesh_helper/polygon.h"
#include "io/mesh_helper/vertex_pool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { most_materials = UINT16_MAX, deepest_node = 1000 };

/* A material of the file becomes one of ours for each set of these that its parts need. */
enum { WITHOUT_TEXTURE = 1, COLOURED = 2, variants = 4 };

/* Row-major 3 x 4: from a part's coordinates to the world's. */
typedef struct placement {
    double m[3][4];
    bool is_identity; /* then coordinates are kept to the bit */
} placement;

typedef struct gather {
    const char *path;
    const struct aiScene *scene;
    bool plain;
    size_t models; /* of a 3MF file; 0 of others */
    bool any_normals, any_texcoords;
    rk_mesh_colours colours;
    rk_mesh_mtl mtl;
    rk_mesh_left_out left;
    bool drew_tr_one, drew_black;
    char lost_material[100]; /* of an OBJ file, that no material file has; the first, or "" */
    size_t lost_materials;
    size_t unfinite_faces, black_faces;
    float (*wedges)[2]; /* of the faces from here on, or NULL */
    bool replaced;      /* a normal or a texture coordinate that is not finite */
    rk_vertex_pool pool;
    uint32_t (*triangles)[3];
    uint16_t *triangle_materials;
    uint32_t triangle_count, triangle_room;
    uint32_t *material_numbers; /* ours plus 1 for each of the scene's and each set of variants; 0:
                                   unused so far */
    uint32_t *material_sources; /* of each of ours, the scene's times `variants`, plus the set */
    uint32_t material_count;
} gather;

/* The state of emitting one part. */
typedef struct part {
    const struct aiMesh *mesh;
    const placement *place;
    const struct aiVector3D *texcoords;  /* or NULL */
    rk_mesh_texture_transform transform; /* of these */
    const struct aiColor4D *colours;     /* of vertices, or NULL */
    rk_vec3 face_colour;                 /* white unless faces have colours */
    uint32_t
        *numbers; /* the pool's index plus 1 of each of the part's vertices; 0: not yet in it */
    uint16_t material;
    uint32_t room; /* corners of the largest polygon */
    rk_vec3 *points;
    uint32_t (*triangles)[3];
    uint32_t *left;
} part;

static const char *const remedy = "repair the mesh or export it again";

/* --- places -------------------------------------------------------------------------------- */

static placement place_in(const placement *parent, const struct aiMatrix4x4 *t)
{
    const double child[3][4] = {
        {(double)t->a1, (double)t->a2, (double)t->a3, (double)t->a4},
        {(double)t->b1, (double)t->b2, (double)t->b3, (double)t->b4},
        {(double)t->c1, (double)t->c2, (double)t->c3, (double)t->c4},
    };
    placement result = {.is_identity = true};
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            double sum = column == 3 ? parent->m[row][3] : 0;
            for (int k = 0; k < 3; k++)
                sum += parent->m[row][k] * child[k][column];
            result.m[row][column] = sum;
            result.is_identity &= sum == (row == column ? 1 : 0);
        }
    return result;
}

static rk_vec3 move_point(const placement *p, rk_vec3 v)
{
    if (p->is_identity)
        return v;
    double x = (double)v.x, y = (double)v.y, z = (double)v.z, moved[3];
    for (int i = 0; i < 3; i++)
        moved[i] = p->m[i][0] * x + p->m[i][1] * y + p->m[i][2] * z + p->m[i][3];
    return rk_vec((float)moved[0], (float)moved[1], (float)moved[2]);
}

/* Normals are transformed by the inverse transpose. The cofactors equal it up to a positive factor,
 * once multiplied by the determinant's sign, and exist for singular transforms, too. */
static void cofactors(const placement *p, double c[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            c[i][k] = p->m[i1][k1] * p->m[i2][k2] - p->m[i1][k2] * p->m[i2][k1];
        }
    double determinant = p->m[0][0] * c[0][0] + p->m[0][1] * c[0][1] + p->m[0][2] * c[0][2];
    for (int i = 0; i < 3 && determinant < 0; i++)
        for (int k = 0; k < 3; k++)
            c[i][k] = -c[i][k];
}

/* False for a vector without direction. */
static bool make_unit(const double v[3], rk_vec3 *unit)
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0 && isfinite(length)))
        return false;
    *unit = rk_vec((float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length));
    return true;
}

static bool move_normal(const placement *p, const struct aiVector3D *n, rk_vec3 *moved)
{
    double v[3] = {(double)n->x, (double)n->y, (double)n->z};
    if (p->is_identity)
        return make_unit(v, moved);
    double c[3][3], w[3];
    cofactors(p, c);
    for (int i = 0; i < 3; i++)
        w[i] = c[i][0] * v[0] + c[i][1] * v[1] + c[i][2] * v[2];
    return make_unit(w, moved);
}

/* A face without area has no normal and is never hit: any unit vector will do. */
static rk_vec3 face_normal(rk_vec3 a, rk_vec3 b, rk_vec3 c)
{
    double e[3] = {(double)b.x - (double)a.x, (double)b.y - (double)a.y, (double)b.z - (double)a.z};
    double f[3] = {(double)c.x - (double)a.x, (double)c.y - (double)a.y, (double)c.z - (double)a.z};
    double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    rk_vec3 unit = rk_vec(0, 0, 1);
    make_unit(n, &unit);
    return unit;
}

/* --- triangles ----------------------------------------------------------------------------- */

static bool grow_triangles(gather *g, rk_error *error)
{
    if (g->triangle_room > UINT32_MAX / 2)
        return rk_fail(error, "%s: more than %u triangles: simplify the mesh", g->path,
                       g->triangle_room);
    uint32_t room = g->triangle_room ? 2 * g->triangle_room : 1 << 12;
    void *triangles = realloc(g->triangles, room * sizeof *g->triangles);
    if (triangles)
        g->triangles = triangles;
    void *materials = realloc(g->triangle_materials, room * sizeof *g->triangle_materials);
    if (materials)
        g->triangle_materials = materials;
    if (!triangles || !materials)
        return rk_fail(error, "%s: no memory for %u triangles: simplify the mesh", g->path, room);
    g->triangle_room = room;
    return true;
}

static rk_vec3 position_of(const part *p, uint32_t vertex)
{
    const struct aiVector3D *v = &p->mesh->mVertices[vertex];
    return move_point(p->place, rk_vec((float)v->x, (float)v->y, (float)v->z));
}

static rk_vec2 move_texcoord(const rk_mesh_texture_transform *t, const struct aiVector3D *at)
{
    const double u = (double)at->x, v = (double)at->y;
    return (rk_vec2){(float)(t->m[0][0] * u + t->m[0][1] * v + t->m[0][2]),
                     (float)(t->m[1][0] * u + t->m[1][1] * v + t->m[1][2])};
}

static bool is_finite_vector(const struct aiVector3D *v)
{
    return isfinite(v->x) && isfinite(v->y) && isfinite(v->z);
}

/* The corners of a face whose coordinates are numbers, after they are moved, too. */
static bool is_finite_face(const part *p, const struct aiFace *face)
{
    for (uint32_t i = 0; i < face->mNumIndices; i++) {
        const rk_vec3 at = position_of(p, face->mIndices[i]);
        if (!(isfinite(at.x) && isfinite(at.y) && isfinite(at.z)))
            return false;
    }
    return true;
}

/* A vertex with a normal of its own, or in a mesh without normals, is the same for all its faces
 * and is looked up once; one that takes its face's normal belongs to that face. */
static bool emit_corner(gather *g, part *p, const uint32_t corners[3], const uint32_t places[3],
                        int k, uint32_t *index, rk_error *error)
{
    uint32_t source = corners[k];
    if (p->numbers[source]) {
        *index = p->numbers[source] - 1;
        return true;
    }
    rk_vertex vertex = {.position = position_of(p, source)};
    bool own = !g->any_normals;
    if (!own && p->mesh->mNormals) {
        own = move_normal(p->place, &p->mesh->mNormals[source], &vertex.normal);
        g->replaced |= !is_finite_vector(&p->mesh->mNormals[source]);
    }
    if (!own)
        vertex.normal = face_normal(position_of(p, corners[0]), position_of(p, corners[1]),
                                    position_of(p, corners[2]));
    if (p->texcoords && g->wedges)
        vertex.texcoord = (rk_vec2){g->wedges[places[k]][0], g->wedges[places[k]][1]};
    else if (p->texcoords)
        vertex.texcoord = move_texcoord(&p->transform, &p->texcoords[source]);
    if (!isfinite(vertex.texcoord.x + vertex.texcoord.y)) {
        vertex.texcoord = (rk_vec2){0, 0};
        g->replaced = true;
    }
    vertex.colour =
        p->colours ? rk_mesh_colours_vertex(&g->colours, &p->colours[source]) : p->face_colour;
    own &= g->colours.face_count == 0 && !g->wedges;
    if (!rk_vertex_pool_add(&g->pool, &vertex, index, error))
        return false;
    if (own)
        p->numbers[source] = *index + 1;
    return true;
}

/* `places` are the corners' numbers within their face. */
static bool emit_triangle(gather *g, part *p, const uint32_t corners[3], const uint32_t places[3],
                          rk_error *error)
{
    if (g->triangle_count == g->triangle_room && !grow_triangles(g, error))
        return false;
    for (int k = 0; k < 3; k++)
        if (!emit_corner(g, p, corners, places, k, &g->triangles[g->triangle_count][k], error))
            return false;
    g->triangle_materials[g->triangle_count++] = p->material;
    return true;
}

static bool make_polygon_room(const gather *g, part *p, uint32_t corners, rk_error *error)
{
    if (corners <= p->room)
        return true;
    free(p->points);
    free(p->triangles);
    free(p->left);
    p->room = 0;
    p->points = rk_allocate(corners, sizeof *p->points, g->path, error);
    p->triangles = rk_allocate(corners, sizeof *p->triangles, g->path, error);
    p->left = rk_allocate(corners, sizeof *p->left, g->path, error);
    if (!p->points || !p->triangles || !p->left)
        return false;
    p->room = corners;
    return true;
}

static bool emit_polygon(gather *g, part *p, const struct aiFace *face, rk_error *error)
{
    uint32_t corners = face->mNumIndices;
    if (!make_polygon_room(g, p, corners, error))
        return false;
    for (uint32_t i = 0; i < corners; i++)
        p->points[i] = position_of(p, face->mIndices[i]);
    if (!rk_polygon_triangulate(p->points, corners, p->triangles, p->left))
        return rk_fail(error,
                       "%s: a face has %u corners and is not convex: at most %d are divided into "
                       "triangles; divide it before exporting",
                       g->path, corners, RK_POLYGON_CORNERS_MAX);
    for (uint32_t i = 0; i < corners - 2; i++) {
        const uint32_t *corner = p->triangles[i];
        uint32_t triangle[3] = {face->mIndices[corner[0]], face->mIndices[corner[1]],
                                face->mIndices[corner[2]]};
        if (!emit_triangle(g, p, triangle, corner, error))
            return false;
    }
    return true;
}

/* --- parts and nodes ----------------------------------------------------------------------- */

static bool check_face(const gather *g, const part *p, uint32_t number, rk_error *error)
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

static const rk_mesh_mtl_material *mtl_of(const gather *g, const struct aiMaterial *material)
{
    struct aiString name;
    return g->mtl.count > 0 &&
                   aiGetMaterialString(material, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS
               ? rk_mesh_mtl_find(&g->mtl, name.data)
               : NULL;
}

/* A picture of a scan repeats the colours of its vertices. */
static void find_colours(gather *g, part *p, bool textured)
{
    p->face_colour = rk_vec(1, 1, 1);
    const bool hidden = textured && g->colours.replace;
    const bool by_vertex = g->colours.any && g->colours.face_count == 0;
    p->colours = by_vertex && !hidden ? p->mesh->mColors[0] : NULL;
    g->left.has[RK_MESH_LEFT_OUT_HIDDEN_COLOURS] |= g->colours.any && hidden && p->mesh->mColors[0];
}

/* By more than rounding. */
static bool leaves_picture(const part *p)
{
    const float slack = 1e-3f;
    for (uint32_t i = 0; i < p->mesh->mNumVertices; i++) {
        const rk_vec2 at = move_texcoord(&p->transform, &p->texcoords[i]);
        if (at.x < -slack || at.x > 1 + slack || at.y < -slack || at.y > 1 + slack)
            return true;
    }
    return false;
}

static bool find_material(gather *g, part *p, rk_error *error)
{
    uint32_t source = g->plain ? 0 : p->mesh->mMaterialIndex;
    if (source >= g->scene->mNumMaterials && !g->plain)
        return rk_fail(error, "%s: part \"%.100s\" uses material %u, but the file has %u: %s",
                       g->path, p->mesh->mName.data, source, g->scene->mNumMaterials, remedy);
    uint32_t set = 0, key = variants * source;
    bool textured =
        source < g->scene->mNumMaterials && rk_mesh_texture_set(g->scene->mMaterials[source], &set);
    p->texcoords = p->mesh->mTextureCoords[set];
    if (textured && !p->texcoords && g->any_texcoords)
        key += WITHOUT_TEXTURE;
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

static bool has_unfinite_colour(const gather *g, const part *p, const struct aiFace *face)
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

static bool emit_faces(gather *g, part *p, rk_error *error)
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
        if (!is_finite_face(p, face))
            g->unfinite_faces++;
        else if (face->mNumIndices == 3
                     ? !emit_triangle(g, p, face->mIndices, (const uint32_t[3]){0, 1, 2}, error)
                     : !emit_polygon(g, p, face, error))
            return false;
        if (g->wedges)
            g->wedges += face->mNumIndices;
    }
    return true;
}

static bool emit_part(gather *g, const struct aiMesh *mesh, const placement *place, rk_error *error)
{
    if (!mesh->mVertices || !mesh->mFaces)
        return true;
    part p = {.mesh = mesh, .place = place, .transform = {{{1, 0, 0}, {0, 1, 0}}}};
    p.numbers = rk_allocate(mesh->mNumVertices, sizeof *p.numbers, g->path, error);
    bool ok = p.numbers && emit_faces(g, &p, error);
    free(p.numbers);
    free(p.points);
    free(p.triangles);
    free(p.left);
    return ok;
}

static bool emit_node(gather *g, const struct aiNode *node, const placement *parent, int depth,
                      rk_error *error)
{
    if (depth > deepest_node)
        return rk_fail(error, "%s: its parts are nested deeper than %d: %s", g->path, deepest_node,
                       remedy);
    placement place = place_in(parent, &node->mTransformation);
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
static void see_lost(gather *g, const struct aiMaterial *source, rk_material *material)
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
static void draw_tr_one(gather *g, const struct aiMaterial *source, rk_material *material)
{
    const rk_mesh_mtl_material *mtl = mtl_of(g, source);
    if (!mtl || !mtl->is_tr_one || material->alpha > 0)
        return;
    material->alpha = 1;
    g->drew_tr_one = true;
}

/* Maya writes Kd 0 0 0 beside a picture that replaces it. */
static void draw_picture_of_black(gather *g, const struct aiMaterial *source, rk_material *material)
{
    if (!mtl_of(g, source) || material->kd.x > 0 || material->kd.y > 0 || material->kd.z > 0)
        return;
    material->kd = rk_vec(1, 1, 1);
    g->drew_black = true;
}

static void set_material(gather *g, rk_mesh *mesh, rk_mesh_textures *textures, uint32_t i)
{
    const struct aiMaterial *source = g->scene->mMaterials[g->material_sources[i] / variants];
    const uint32_t variant = g->material_sources[i] % variants;
    if (!(variant & WITHOUT_TEXTURE) && g->models == 0)
        rk_mesh_textures_find(textures, i, g->scene, source);
    bool varies = textures->of_material[i] != 0 || variant & COLOURED;
    if (!g->plain)
        mesh->materials[i] = rk_mesh_material(source, varies);
    if (!(variant & COLOURED && g->colours.replace))
        see_lost(g, source, &mesh->materials[i]);
    draw_tr_one(g, source, &mesh->materials[i]);
    if (g->models > 0 && rk_mesh_texture_set(source, &(uint32_t){0}))
        mesh->materials[i].kd = rk_vec(0.8f, 0.8f, 0.8f); /* Assimp's is black */
    if (textures->of_material[i] != 0)
        draw_picture_of_black(g, source, &mesh->materials[i]);
    rk_mesh_left_out_of_material(&g->left, source);
    if (variant & COLOURED ? g->colours.replace : g->plain && varies)
        mesh->materials[i].kd = rk_vec(1, 1, 1);
}

static bool finish(gather *g, rk_mesh *mesh, rk_mesh_textures *textures, rk_error *error)
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

static void tell(gather *g, rk_mesh_hints *hints)
{
    rk_mesh_left_out_of_scene(&g->left, g->scene);
    if (g->models > 0) /* thumbnails */
        g->left.has[RK_MESH_LEFT_OUT_PICTURES] = false;
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
    if (g->drew_tr_one)
        rk_mesh_hints_note(hints, g->path,
                           "Tr 1 makes a material invisible; it is drawn as opaque, because some "
                           "programs mean that: write d 0 for an invisible one");
    if (g->drew_black)
        rk_mesh_hints_note(hints, g->path,
                           "Kd 0 0 0 makes a picture (map_Kd) black; the picture is drawn as it "
                           "is, because some programs mean that");
    rk_mesh_left_out_tell(&g->left, g->path, hints);
}

static bool check_root(const gather *g, rk_error *error)
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
    gather g = {.path = path,
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
    const placement world = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, true};
    const size_t keys = variants * ((size_t)scene->mNumMaterials + 1);
    g.material_numbers = rk_allocate(keys, sizeof *g.material_numbers, path, error);
    g.material_sources = rk_allocate(keys, sizeof *g.material_sources, path, error);
    rk_mesh_colours_init(&g.colours, scene, path, hints);
    bool ok = g.material_numbers && g.material_sources && check_root(&g, error) &&
              rk_mesh_mtl_read(&g.mtl, error);
    g.pool.coloured = g.colours.any;
    ok = ok && emit_node(&g, scene->mRootNode, &world, 0, error) &&
         finish(&g, mesh, textures, error);
    if (ok)
        tell(&g, hints);
    rk_mesh_mtl_free(&g.mtl);
    rk_mesh_colours_free(&g.colours);
    rk_vertex_pool_free(&g.pool);
    free(g.triangles);
    free(g.triangle_materials);
    free(g.material_numbers);
    free(g.material_sources);
    return ok;
}
