/* Memory, checks that name the first fault, and what loaders need: bounds, normalization by the
 * mean of different positions (found by hashing), smooth normals, appending. */
#include "scene/mesh.h"

#include <stdlib.h>
#include <string.h>

bool rk_mesh_init(rk_mesh *mesh, uint32_t vertices, uint32_t triangles, uint32_t materials,
                  int optional_arrays, rk_error *error)
{
    *mesh = (rk_mesh){
        .vertex_count = vertices, .triangle_count = triangles, .material_count = materials};
    mesh->positions = rk_allocate(vertices, sizeof *mesh->positions, "vertices", error);
    mesh->triangles = rk_allocate(triangles, sizeof *mesh->triangles, "triangles", error);
    mesh->triangle_materials =
        rk_allocate(triangles, sizeof *mesh->triangle_materials, "triangles", error);
    mesh->materials = rk_allocate(materials, sizeof *mesh->materials, "materials", error);
    bool ok = mesh->positions && mesh->triangles && mesh->triangle_materials && mesh->materials;
    if (ok && (optional_arrays & RK_MESH_NORMALS))
        ok = (mesh->normals = rk_allocate(vertices, sizeof *mesh->normals, "normals", error)) !=
             NULL;
    if (ok && (optional_arrays & RK_MESH_TEXCOORDS))
        ok = (mesh->texcoords = rk_allocate(vertices, sizeof *mesh->texcoords,
                                            "texture coordinates", error)) != NULL;
    if (ok && (optional_arrays & RK_MESH_COLOURS))
        ok = (mesh->colours = rk_allocate(vertices, sizeof *mesh->colours, "colours", error)) !=
             NULL;
    if (!ok) {
        rk_mesh_free(mesh);
        return false;
    }
    for (uint32_t i = 0; i < materials; i++)
        mesh->materials[i] = (rk_material){.kd = rk_vec(0.8f, 0.8f, 0.8f), .alpha = 1};
    return true;
}

void rk_mesh_free(rk_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->texcoords);
    free(mesh->colours);
    free(mesh->triangles);
    free(mesh->triangle_materials);
    free(mesh->materials);
    for (uint32_t i = 0; i < mesh->texture_count; i++)
        rk_texture_free(&mesh->textures[i]);
    free(mesh->textures);
    *mesh = (rk_mesh){0};
}

static bool is_finite3(rk_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static bool is_fraction(float v)
{
    return v >= 0 && v <= 1;
}

static const char *const remedy = "repair the mesh or export it again";

static bool validate_vertices(const rk_mesh *mesh, const char *name, rk_error *error)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        if (!is_finite3(mesh->positions[i]))
            return rk_fail(error, "%s: vertex %u is not a finite point: %s", name, i, remedy);
        if (mesh->normals && !is_finite3(mesh->normals[i]))
            return rk_fail(error, "%s: the normal of vertex %u is not finite: %s", name, i, remedy);
        if (mesh->texcoords && !(isfinite(mesh->texcoords[i].x) && isfinite(mesh->texcoords[i].y)))
            return rk_fail(error, "%s: the texture coordinate of vertex %u is not finite: %s", name,
                           i, remedy);
        if (mesh->colours && !is_finite3(mesh->colours[i]))
            return rk_fail(error, "%s: the colour of vertex %u is not finite: %s", name, i, remedy);
    }
    return true;
}

static bool validate_triangles(const rk_mesh *mesh, const char *name, rk_error *error)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        for (int k = 0; k < 3; k++)
            if (mesh->triangles[i][k] >= mesh->vertex_count)
                return rk_fail(error, "%s: triangle %u uses vertex %u, but there are only %u: %s",
                               name, i, mesh->triangles[i][k], mesh->vertex_count, remedy);
        if (mesh->triangle_materials[i] >= mesh->material_count)
            return rk_fail(error, "%s: triangle %u uses material %u, but there are only %u: %s",
                           name, i, mesh->triangle_materials[i], mesh->material_count, remedy);
    }
    return true;
}

/* Is it NULL, or one of the mesh's textures, with an image? */
static bool is_texture_of(const rk_texture *texture, const rk_mesh *mesh)
{
    for (uint32_t i = 0; texture && i < mesh->texture_count; i++)
        if (texture == &mesh->textures[i])
            return texture->image.pixels != NULL;
    return texture == NULL;
}

static bool validate_materials(const rk_mesh *mesh, const char *name, rk_error *error)
{
    for (uint32_t i = 0; i < mesh->material_count; i++) {
        const rk_material *m = &mesh->materials[i];
        if (!is_finite3(m->kd) || !is_finite3(m->ks) || !(m->shininess >= 0) ||
            !isfinite(m->shininess) || !is_fraction(m->alpha) || !is_fraction(m->alpha_cutoff))
            return rk_fail(
                error,
                "%s: material %u has a colour that is not finite, a negative shininess or an "
                "opacity outside [0, 1]: repair it or export the mesh again",
                name, i);
        if (!is_finite3(m->absorption) || !(m->absorption.x >= 0) || !(m->absorption.y >= 0) ||
            !(m->absorption.z >= 0))
            return rk_fail(error,
                           "%s: material %u has an absorption that is negative or not finite: "
                           "choose 0 for clear glass, more for darker glass",
                           name, i);
        if (!is_texture_of(m->kd_texture, mesh) || !is_texture_of(m->alpha_texture, mesh))
            return rk_fail(error,
                           "%s: a texture of material %u is not one of the mesh's, or has no "
                           "image: add it to the mesh's textures",
                           name, i);
    }
    return true;
}

bool rk_mesh_validate(const rk_mesh *mesh, const char *name, rk_error *error)
{
    return validate_vertices(mesh, name, error) && validate_triangles(mesh, name, error) &&
           validate_materials(mesh, name, error);
}

bool rk_mesh_has_cutouts(const rk_mesh *mesh)
{
    for (uint32_t i = 0; i < mesh->material_count; i++)
        if (mesh->materials[i].alpha_texture)
            return true;
    return false;
}

rk_box rk_mesh_bounds(const rk_mesh *mesh)
{
    rk_box box = rk_box_empty();
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        box = rk_box_add(box, mesh->positions[i]);
    return box;
}

static uint32_t hash_position(rk_vec3 p)
{
    uint32_t bits[3];
    memcpy(bits, &p, sizeof bits);
    uint32_t h = bits[0] * 0x9e3779b1u ^ bits[1] * 0x85ebca77u ^ bits[2] * 0xc2b2ae3du;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ h >> 13;
}

/* Finds distinct positions by an open-addressing hash table of vertex indices. */
static bool mean_of_distinct(const rk_mesh *mesh, double mean[3], rk_error *error)
{
    size_t slots = 16;
    while (slots < 2 * (size_t)mesh->vertex_count)
        slots *= 2;
    uint32_t *table = rk_allocate(slots, sizeof *table, "distinct vertices", error);
    if (!table)
        return false;
    uint32_t distinct = 0;
    double sum[3] = {0, 0, 0};
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        /* Adding 0 gives -0 and 0, which are equal, the same bits. */
        rk_vec3 p = rk_add(mesh->positions[i], rk_vec(0, 0, 0));
        size_t slot = hash_position(p) & (slots - 1);
        while (table[slot]) {
            rk_vec3 other = mesh->positions[table[slot] - 1];
            if (other.x == p.x && other.y == p.y && other.z == p.z)
                break;
            slot = (slot + 1) & (slots - 1);
        }
        if (table[slot])
            continue;
        table[slot] = i + 1;
        distinct++;
        sum[0] += (double)p.x, sum[1] += (double)p.y, sum[2] += (double)p.z;
    }
    free(table);
    for (int k = 0; k < 3; k++)
        mean[k] = distinct ? sum[k] / distinct : 0;
    return true;
}

bool rk_mesh_normalize(rk_mesh *mesh, rk_error *error)
{
    double mean[3];
    if (!mean_of_distinct(mesh, mean, error))
        return false;
    double farthest = 0; /* squared */
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 p = mesh->positions[i];
        double x = (double)p.x - mean[0], y = (double)p.y - mean[1], z = (double)p.z - mean[2];
        farthest = fmax(farthest, x * x + y * y + z * z);
    }
    double scale = farthest > 0 ? 1 / sqrt(farthest) : 1;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 *p = &mesh->positions[i];
        *p = rk_vec((float)(((double)p->x - mean[0]) * scale),
                    (float)(((double)p->y - mean[1]) * scale),
                    (float)(((double)p->z - mean[2]) * scale));
    }
    return true;
}

bool rk_mesh_smooth(rk_mesh *mesh, rk_error *error)
{
    rk_vec3 *normals = rk_allocate(mesh->vertex_count, sizeof *normals, "normals", error);
    if (!normals)
        return false;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->triangles[i];
        rk_vec3 a = mesh->positions[corner[0]];
        /* The cross product's length is twice the area, so it is the weight already. */
        rk_vec3 weighted =
            rk_cross(rk_sub(mesh->positions[corner[1]], a), rk_sub(mesh->positions[corner[2]], a));
        for (int k = 0; k < 3; k++)
            normals[corner[k]] = rk_add(normals[corner[k]], weighted);
    }
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        normals[i] = rk_normalize(normals[i]);
    free(mesh->normals);
    mesh->normals = normals;
    return true;
}

void rk_mesh_append(rk_mesh *mesh, const rk_mesh *part, rk_vec3 shift, float scale,
                    uint16_t material)
{
    uint32_t v = mesh->vertex_count, t = mesh->triangle_count;
    for (uint32_t i = 0; i < part->vertex_count; i++)
        mesh->positions[v + i] = rk_madd(shift, part->positions[i], scale);
    memcpy(&mesh->normals[v], part->normals, part->vertex_count * sizeof *mesh->normals);
    for (uint32_t i = 0; i < part->triangle_count; i++) {
        for (int k = 0; k < 3; k++)
            mesh->triangles[t + i][k] = v + part->triangles[i][k];
        mesh->triangle_materials[t + i] = (uint16_t)(material + part->triangle_materials[i]);
    }
    for (uint32_t i = 0; i < part->material_count; i++)
        mesh->materials[material + i] = part->materials[i];
    mesh->vertex_count += part->vertex_count;
    mesh->triangle_count += part->triangle_count;
}
