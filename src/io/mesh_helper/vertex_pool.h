/* Vertices without duplicates: equal ones, to the bit, get the same index. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_VERTEX_POOL_H
#define RK_IO_MESH_HELPER_VERTEX_POOL_H

#include "base/error.h"
#include "base/vec3.h"

#include <stdint.h>

typedef struct rk_vertex {
    rk_vec3 position, normal;
    rk_vec2 texcoord;
} rk_vertex;

typedef struct rk_vertex_pool {
    const char *name; /* what errors begin with; the rest begins zeroed */
    rk_vertex *vertices;
    uint32_t count, room;
    uint32_t *table; /* 2 * room places: 0 empty, else an index plus 1 */
} rk_vertex_pool;

/* Returns the vertex's index in *index. False with an error when memory or 32 bits are short. */
bool rk_vertex_pool_add(rk_vertex_pool *pool, const rk_vertex *vertex, uint32_t *index,
                        rk_error *error);

/* Accepts a pool that never held a vertex. */
void rk_vertex_pool_free(rk_vertex_pool *pool);

#endif
