/* Colours of vertices and faces, made linear. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_COLOURS_H
#define RK_IO_MESH_HELPER_MESH_COLOURS_H

#include "base/error.h"
#include "base/vec3.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <assimp/scene.h>
#include <stdint.h>

/* Of a face in OFF, PLY or STL. */
typedef struct rk_mesh_colours_face {
    uint32_t corners;
    rk_vec3 rgb; /* as in the file; negative: the face has none */
} rk_mesh_colours_face;

typedef struct rk_mesh_colours {
    bool any;      /* some colour is not white */
    bool is_clear; /* some colour is transparent, in glTF */
    bool torn;     /* only some vertices of an OBJ file have one: whose they are is then lost */
    bool is_gltf;  /* whose colours are linear; others are sRGB-encoded */
    bool replace;  /* they are the diffuse colours, where no picture is; else they multiply them */
    bool may_lack; /* in AMF, black with an opacity of 0 is Assimp's for a vertex without colour */
    float scale;   /* to [0, 1] */
    bool is_unfinite; /* the face that was taken last has nan or inf in its colour */
    uint32_t face_count, next_face;
    rk_mesh_colours_face *faces; /* of a file without colours of vertices, or NULL */
} rk_mesh_colours;

/* Finds out which colours the file has, and how they are meant. glTF's are linear, by its
 * specification; those of other formats are sRGB-encoded, by custom (bytes from a scanner or a
 * painting program). Where one exceeds 1, all are taken to be from 0 to 255. In OBJ, PLY, OFF and
 * STL they are the diffuse colour itself; elsewhere they multiply the material's. Colours of faces
 * are moved from the hints. */
void rk_mesh_colours_init(rk_mesh_colours *colours, const struct aiScene *scene, const char *path,
                          rk_mesh_hints *hints);
void rk_mesh_colours_free(rk_mesh_colours *colours);

/* Returns the colour, linear and clamped to [0, 1]; NaN and infinities
 * become 0. */
rk_vec3 rk_mesh_colour(const rk_mesh_colours *colours, rk_vec3 rgb);

/* The same of a vertex. */
rk_vec3 rk_mesh_colours_vertex(const rk_mesh_colours *colours, const struct aiColor4D *colour);

static inline rk_vec3 rk_mesh_colours_rgb(const struct aiColor4D *colour)
{
    return rk_vec((float)colour->r, (float)colour->g, (float)colour->b);
}

/* The colour of the scene's next face, which has this many corners: white if it has none. */
rk_vec3 rk_mesh_colours_next_face(rk_mesh_colours *colours, uint32_t corners);

#endif
