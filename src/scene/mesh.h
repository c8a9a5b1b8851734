/* Indexed triangles with materials. */
#ifndef RK_SCENE_MESH_H
#define RK_SCENE_MESH_H

#include "base/box.h"
#include "base/error.h"
#include "base/texture.h"
#include "base/vec3.h"

#include <stdint.h>

typedef struct rk_material {
    rk_vec3 kd;         /* diffuse colour, each component in [0, 1] */
    rk_vec3 ks;         /* specular colour, each component in [0, 1] */
    float shininess;    /* exponent of the highlight, >= 0 */
    float alpha;        /* opacity: 1 opaque, 0 invisible */
    rk_vec3 absorption; /* sigma_a >= 0 inside a closed object; transmittance exp(-sigma_a x) after
                           x world units */
    const rk_texture *kd_texture;    /* multiplies kd, or NULL; one of the mesh's textures */
    const rk_texture *alpha_texture; /* whose red multiplies alpha, or NULL; one of the mesh's */
    float alpha_cutoff; /* with an alpha_texture: where their product is below it, there is no
                           surface; elsewhere it is opaque. 0: transparency; where the renderer's
                           option is off, no surface where the texture is below one half */
} rk_material;

typedef struct rk_mesh {
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t material_count;
    rk_vec3 *positions; /* vertex_count */
    rk_vec3 *normals;   /* vertex_count unit vectors, or NULL: faces are flat */
    rk_vec2 *texcoords; /* vertex_count, or NULL */
    rk_vec3 *colours;   /* vertex_count linear colours in [0, 1], which multiply kd; or NULL */
    uint32_t (*triangles)[3];     /* triangle_count rows of vertex indices */
    uint16_t *triangle_materials; /* triangle_count indices into materials */
    rk_material *materials;       /* material_count, at least 1 */
    uint32_t texture_count;
    rk_texture *textures; /* texture_count, each owning its image; or NULL */
    uint32_t up; /* the axis that points up, 1 to 3 for x to z, where the file names it; else 0 */
} rk_mesh;

enum { RK_MESH_NORMALS = 1, RK_MESH_TEXCOORDS = 2, RK_MESH_COLOURS = 4 }; /* optional arrays */

/* Makes a mesh with all arrays zeroed and every material the default: kd .8, opaque. */
bool rk_mesh_init(rk_mesh *mesh, uint32_t vertices, uint32_t triangles, uint32_t materials,
                  int optional_arrays, rk_error *error);
void rk_mesh_free(rk_mesh *mesh);

/* Checks everything that later code relies on: false for indices out of range, a position, normal,
 * texture coordinate, colour or material that is NaN or infinite, a negative absorption, or a
 * texture that is not the mesh's. The error begins with `name`, followed by the place. */
bool rk_mesh_validate(const rk_mesh *mesh, const char *name, rk_error *error);

/* Is there a material with an alpha_texture? Rays go on through what it cuts out. */
bool rk_mesh_has_cutouts(const rk_mesh *mesh);

/* Appends a part that has normals and nothing else that is optional, scaled by `scale` and moved by
 * `shift`; its materials take the numbers from `material` on. The mesh has normals and enough
 * memory: its counts say how far the arrays are filled. */
void rk_mesh_append(rk_mesh *mesh, const rk_mesh *part, rk_vec3 shift, float scale,
                    uint16_t material);

rk_box rk_mesh_bounds(const rk_mesh *mesh);

/* Moves and scales the mesh into the unit ball: the mean of its distinct vertices goes to 0, the
 * farthest vertex to distance 1. A mesh of one distinct point is only moved. Computed in double. */
bool rk_mesh_normalize(rk_mesh *mesh, rk_error *error);

/* Replaces the normals by area-weighted averages of the faces around each vertex. */
bool rk_mesh_smooth(rk_mesh *mesh, rk_error *error);

#endif
