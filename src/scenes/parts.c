#include "scenes/builtin.h"

#include <string.h>

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
