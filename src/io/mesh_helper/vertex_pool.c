/* An open-addressing hash table with linear probing, at most half full. */
#include "io/mesh_helper/vertex_pool.h"

#include <assert.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { first_room = 1 << 12, words = sizeof(rk_vertex) / sizeof(uint32_t) };
static_assert(sizeof(rk_vertex) == 44, "without padding, so that equal vertices are equal bytes");

/* Bytes of a vertex in this pool. */
static size_t vertex_size(const rk_vertex_pool *pool)
{
    return pool->coloured ? sizeof(rk_vertex) : offsetof(rk_vertex, colour);
}

static unsigned char *bytes_at(const rk_vertex_pool *pool, uint32_t index)
{
    return pool->vertices + index * vertex_size(pool);
}

static uint32_t hash_vertex(const rk_vertex *vertex, size_t size)
{
    uint32_t word[words], h = 0;
    memcpy(word, vertex, sizeof word);
    for (size_t i = 0; i < size / sizeof *word; i++)
        h = (h ^ word[i]) * 0x9e3779b1u ^ h >> 15;
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    return h ^ h >> 13;
}

/* The slot of the vertex, or the empty one where it is to be inserted. */
static uint32_t *find_slot(const rk_vertex_pool *pool, const rk_vertex *vertex)
{
    size_t mask = 2 * (size_t)pool->room - 1, size = vertex_size(pool);
    size_t slot = hash_vertex(vertex, size) & mask;
    while (pool->table[slot] && memcmp(bytes_at(pool, pool->table[slot] - 1), vertex, size) != 0)
        slot = (slot + 1) & mask;
    return &pool->table[slot];
}

rk_vertex rk_vertex_pool_at(const rk_vertex_pool *pool, uint32_t index)
{
    rk_vertex vertex = {.colour = {1, 1, 1}};
    memcpy(&vertex, bytes_at(pool, index), vertex_size(pool));
    return vertex;
}

static bool grow(rk_vertex_pool *pool, rk_error *error)
{
    if (pool->room > UINT32_MAX / 2)
        return rk_fail(error, "%s: more than %u vertices: simplify the mesh", pool->name,
                       pool->room);
    rk_vertex_pool larger = {.name = pool->name,
                             .coloured = pool->coloured,
                             .count = pool->count,
                             .room = pool->room ? 2 * pool->room : first_room};
    larger.vertices = rk_allocate(larger.room, vertex_size(pool), pool->name, error);
    larger.table = rk_allocate(2 * (size_t)larger.room, sizeof *larger.table, pool->name, error);
    if (!larger.vertices || !larger.table) {
        rk_vertex_pool_free(&larger);
        return false;
    }
    if (pool->count)
        memcpy(larger.vertices, pool->vertices, pool->count * vertex_size(pool));
    for (uint32_t i = 0; i < larger.count; i++) {
        rk_vertex vertex = rk_vertex_pool_at(&larger, i);
        *find_slot(&larger, &vertex) = i + 1;
    }
    rk_vertex_pool_free(pool);
    *pool = larger;
    return true;
}

bool rk_vertex_pool_add(rk_vertex_pool *pool, const rk_vertex *vertex, uint32_t *index,
                        rk_error *error)
{
    if (pool->count == pool->room && !grow(pool, error))
        return false;
    uint32_t *slot = find_slot(pool, vertex);
    if (*slot == 0) {
        memcpy(bytes_at(pool, pool->count), vertex, vertex_size(pool));
        *slot = ++pool->count;
    }
    *index = *slot - 1;
    return true;
}

void rk_vertex_pool_free(rk_vertex_pool *pool)
{
    free(pool->vertices);
    free(pool->table);
    *pool = (rk_vertex_pool){0};
}
