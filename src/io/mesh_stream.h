/* The format in which raykit-mesh sends a mesh to rk_mesh_file_read: this header, then the arrays
 * in the order below without gaps, in native byte order (both run on the same machine);
 * not installed. */
#ifndef RK_IO_MESH_STREAM_H
#define RK_IO_MESH_STREAM_H

#include "scene/mesh.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>

#define RK_MESH_STREAM_MAGIC "RKMESH\n"
enum {
    RK_MESH_STREAM_VERSION = 5,
    RK_MESH_STREAM_TEXTURES_MAX = 1024, /* each may take a helper program a quarter of a second */
};

typedef struct rk_mesh_stream_header {
    char magic[8];
    uint32_t version;
    uint32_t flags; /* RK_MESH_NORMALS, ..._TEXCOORDS, ..._COLOURS: optional arrays that follow */
    uint32_t vertex_count, triangle_count, material_count;
    uint32_t texture_count, texture_bytes; /* bytes: all names and embedded pictures */
    uint32_t up;                           /* as in rk_mesh */
} rk_mesh_stream_header;
static_assert(sizeof(rk_mesh_stream_header) == 40, "no padding");

/* In the stream a material is these numbers, whatever else rk_material may come to contain. */
typedef struct rk_mesh_stream_material {
    float kd[3], ks[3], shininess, alpha;
    float alpha_cutoff;
    uint32_t texture, alpha_texture; /* their numbers plus 1, 0: none; the same twice: alpha is
                                        that picture's alpha channel */
} rk_mesh_stream_material;
static_assert(sizeof(rk_mesh_stream_material) == 44, "no padding");

/* After these rows follow, for each texture, its name without a NUL and its embedded picture. */
typedef struct rk_mesh_stream_texture {
    uint32_t clamps; /* 0: repeats */
    uint32_t name_size, data_size;
} rk_mesh_stream_texture;
static_assert(sizeof(rk_mesh_stream_texture) == 12, "no padding");
static_assert(sizeof(rk_vec3) == 12 && sizeof(rk_vec2) == 8,
              "vectors are sent as they are in memory");

/* Bytes of each array, in the order of the stream; 0 for an absent optional one. */
typedef struct rk_mesh_stream_sizes {
    uint64_t positions, normals, texcoords, colours, triangles, triangle_materials, materials,
        textures, texture_bytes;
} rk_mesh_stream_sizes;

static inline rk_mesh_stream_sizes rk_mesh_stream_sizes_of(const rk_mesh_stream_header *header)
{
    uint64_t vertices = header->vertex_count, triangles = header->triangle_count;
    return (rk_mesh_stream_sizes){
        .positions = vertices * sizeof(rk_vec3),
        .normals = header->flags & RK_MESH_NORMALS ? vertices * sizeof(rk_vec3) : 0,
        .texcoords = header->flags & RK_MESH_TEXCOORDS ? vertices * sizeof(rk_vec2) : 0,
        .colours = header->flags & RK_MESH_COLOURS ? vertices * sizeof(rk_vec3) : 0,
        .triangles = triangles * sizeof(uint32_t[3]),
        .triangle_materials = triangles * sizeof(uint16_t),
        .materials = (uint64_t)header->material_count * sizeof(rk_mesh_stream_material),
        .textures = (uint64_t)header->texture_count * sizeof(rk_mesh_stream_texture),
        .texture_bytes = header->texture_bytes,
    };
}

/* The whole stream's bytes; cannot overflow, because each count is below 2^32. */
static inline uint64_t rk_mesh_stream_size(const rk_mesh_stream_header *header)
{
    rk_mesh_stream_sizes s = rk_mesh_stream_sizes_of(header);
    return sizeof *header + s.positions + s.normals + s.texcoords + s.colours + s.triangles +
           s.triangle_materials + s.materials + s.textures + s.texture_bytes;
}

#endif
