/* What a glTF file says of its parts (primitives), and Assimp leaves out or reads wrongly: numbers
 * of triangles, and coordinates as small integers. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_MESH_GLTF_PARTS_H
#define RK_IO_MESH_HELPER_MESH_GLTF_PARTS_H

#include "io/mesh_helper/json_cursor.h"
#include "io/mesh_helper/mesh_syntax.h"

#include <assimp/scene.h>
#include <stdint.h>

/* Kind of numbers, as in the file: 5120 int8, 5121 uint8, 5122 int16, 5123 uint16, 5126 float. */
typedef struct rk_mesh_gltf_parts_numbers {
    uint16_t kind; /* 0: absent */
    bool is_fraction;
} rk_mesh_gltf_parts_numbers;

typedef struct rk_mesh_gltf_parts_one {
    char name[104];    /* that Assimp gives it, or "" if it is longer or has escapes */
    uint32_t number;   /* in the file's order */
    int64_t vertices;  /* -1: not known */
    int64_t triangles; /* the same */
    rk_mesh_gltf_parts_numbers positions, normals, weights,
        texcoords[AI_MAX_NUMBER_OF_TEXTURECOORDS];
    int64_t material; /* -1: none is named */
    bool differs;     /* has another kind of numbers than one before it that may be the same */
} rk_mesh_gltf_parts_one;

/* Reads them from the text, which is in the file, into the hints, and corrects the file where
 * Assimp could not read Draco's indices. Files of version 1 have none. False when memory is short.
 */
bool rk_mesh_gltf_parts_read(rk_mesh_hints *hints, const char *path, json_cursor text,
                             json_cursor file, rk_error *error);

/* Turns integers that Assimp took for floats into numbers. Pairs the scene's parts with the file's
 * by name and number of vertices, since Assimp orders them as their nodes; adds a note where that
 * leaves two kinds of integers. False if Assimp has dropped triangles: their indices are out of
 * range. */
bool rk_mesh_gltf_parts_mend(const struct aiScene *scene, rk_mesh_hints *hints, const char *path,
                             rk_error *error);

#endif
