/* Triangles of one part of a mesh file, and what is gathered of all. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_EMIT_H
#define RK_IO_MESH_HELPER_MESH_EMIT_H

#include "io/mesh_helper/mesh_colours.h"
#include "io/mesh_helper/mesh_left_out.h"
#include "io/mesh_helper/mesh_mtl.h"
#include "io/mesh_helper/mesh_place.h"
#include "io/mesh_helper/mesh_skin.h"
#include "io/mesh_helper/mesh_texture.h"
#include "io/mesh_helper/vertex_pool.h"

typedef struct rk_mesh_emit_state {
    const char *path;
    const struct aiScene *scene;
    bool plain;
    size_t models; /* of a 3MF file; 0 of others */
    bool any_normals, any_texcoords;
    rk_mesh_colours colours;
    rk_mesh_mtl mtl;
    rk_mesh_skin skin;
    rk_mesh_left_out left;
    bool drew_tr_one, drew_clear, drew_black;
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
} rk_mesh_emit_state;

/* The state of emitting one part. */
typedef struct rk_mesh_emit_part {
    const struct aiMesh *mesh;
    const rk_mesh_place *place;
    rk_mesh_place *places;              /* of each vertex, if the part is posed by bones; or NULL */
    const struct aiVector3D *texcoords; /* or NULL */
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
} rk_mesh_emit_part;

rk_vec2 rk_mesh_emit_texcoord(const rk_mesh_texture_transform *t, const struct aiVector3D *at);

/* Are the face's coordinates numbers, after they are moved, too? */
bool rk_mesh_emit_is_finite(const rk_mesh_emit_part *p, const struct aiFace *face);

/* `places` are the corners' numbers within their face. */
bool rk_mesh_emit_triangle(rk_mesh_emit_state *g, rk_mesh_emit_part *p, const uint32_t corners[3],
                           const uint32_t places[3], rk_error *error);
bool rk_mesh_emit_polygon(rk_mesh_emit_state *g, rk_mesh_emit_part *p, const struct aiFace *face,
                          rk_error *error);

#endif
