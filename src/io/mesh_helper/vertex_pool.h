/* Vertices without duplicates: those with equal bits get the same index. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_VERTEX_POOL_H
#define RK_IO_MESH_HELPER_VERTEX_POOL_H

#include "base/error.h"
#include "base/vec3.h"

#include <stdint.h>

typedef struct rk_vertex {
    rk_vec3 position, normal;
    rk_vec2 texcoord;
    rk_vec3 colour; /* last, so that it takes no memory in meshes without colours */
} rk_vertex;

typedef struct rk_vertex_pool {
    const char *name; /* begins errors; all other members start zeroed */
    bool coloured;
    unsigned char *vertices; /* without their colours unless `coloured` */
    uint32_t count, room;
    uint32_t *table; /* 2 * room slots: 0 if empty, else an index plus 1 */
} rk_vertex_pool;

/* Returns the vertex's index in *index. False with an error when memory is short or the index
 * exceeds 32 bits. */
bool rk_vertex_pool_add(rk_vertex_pool *pool, const rk_vertex *vertex, uint32_t *index,
                        rk_error *error);

rk_vertex rk_vertex_pool_at(const rk_vertex_pool *pool, uint32_t index);

/* Accepts an empty pool. */
void rk_vertex_pool_free(rk_vertex_pool *pool);

#endif
