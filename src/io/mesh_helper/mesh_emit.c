/* Each corner of a triangle becomes one of the pool's vertices. */
#include "io/mesh_helper/mesh_emit.h"

#include "io/mesh_helper/polygon.h"

#include <math.h>
#include <stdlib.h>

static bool grow_triangles(rk_mesh_emit_state *g, rk_error *error)
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

static const rk_mesh_place *place_of(const rk_mesh_emit_part *p, uint32_t vertex)
{
    return p->places ? &p->places[vertex] : p->place;
}

static rk_vec3 position_of(const rk_mesh_emit_part *p, uint32_t vertex)
{
    const struct aiVector3D *v = &p->mesh->mVertices[vertex];
    return rk_mesh_place_point(place_of(p, vertex), rk_vec((float)v->x, (float)v->y, (float)v->z));
}

rk_vec2 rk_mesh_emit_texcoord(const rk_mesh_texture_transform *t, const struct aiVector3D *at)
{
    const double u = (double)at->x, v = (double)at->y;
    return (rk_vec2){(float)(t->m[0][0] * u + t->m[0][1] * v + t->m[0][2]),
                     (float)(t->m[1][0] * u + t->m[1][1] * v + t->m[1][2])};
}

static bool is_finite_vector(const struct aiVector3D *v)
{
    return isfinite(v->x) && isfinite(v->y) && isfinite(v->z);
}

bool rk_mesh_emit_is_finite(const rk_mesh_emit_part *p, const struct aiFace *face)
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
static bool emit_corner(rk_mesh_emit_state *g, rk_mesh_emit_part *p, const uint32_t corners[3],
                        const uint32_t places[3], int k, uint32_t *index, rk_error *error)
{
    uint32_t source = corners[k];
    if (p->numbers[source]) {
        *index = p->numbers[source] - 1;
        return true;
    }
    rk_vertex vertex = {.position = position_of(p, source)};
    bool own = !g->any_normals;
    if (!own && p->mesh->mNormals) {
        own = rk_mesh_place_normal(place_of(p, source), &p->mesh->mNormals[source], &vertex.normal);
        g->replaced |= !is_finite_vector(&p->mesh->mNormals[source]);
    }
    if (!own)
        vertex.normal = rk_mesh_place_face_normal(
            position_of(p, corners[0]), position_of(p, corners[1]), position_of(p, corners[2]));
    if (p->texcoords && g->wedges)
        vertex.texcoord = (rk_vec2){g->wedges[places[k]][0], g->wedges[places[k]][1]};
    else if (p->texcoords)
        vertex.texcoord = rk_mesh_emit_texcoord(&p->transform, &p->texcoords[source]);
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

bool rk_mesh_emit_triangle(rk_mesh_emit_state *g, rk_mesh_emit_part *p, const uint32_t corners[3],
                           const uint32_t places[3], rk_error *error)
{
    if (g->triangle_count == g->triangle_room && !grow_triangles(g, error))
        return false;
    for (int k = 0; k < 3; k++)
        if (!emit_corner(g, p, corners, places, k, &g->triangles[g->triangle_count][k], error))
            return false;
    g->triangle_materials[g->triangle_count++] = p->material;
    return true;
}

static bool make_polygon_room(const rk_mesh_emit_state *g, rk_mesh_emit_part *p, uint32_t corners,
                              rk_error *error)
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

bool rk_mesh_emit_polygon(rk_mesh_emit_state *g, rk_mesh_emit_part *p, const struct aiFace *face,
                          rk_error *error)
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
        if (!rk_mesh_emit_triangle(g, p, triangle, corner, error))
            return false;
    }
    return true;
}
