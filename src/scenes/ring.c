/* Stitches two rings of vertices like a zip: of the next edge on each, the one that ends earlier on
 * its ring becomes the next triangle's base. */
#include "scenes/ring.h"

#include <stdbool.h>

static uint32_t edges_of(rk_ring ring)
{
    return ring.count > 1 ? ring.count : 0;
}

static uint32_t vertex_of(rk_ring ring, uint32_t i)
{
    return ring.first + (i < ring.count ? i : 0);
}

uint32_t (*rk_ring_stitch(uint32_t (*row)[3], rk_ring a, rk_ring b))[3]
{
    const uint64_t edges_a = edges_of(a), edges_b = edges_of(b);
    uint32_t i = 0, j = 0;
    while (i < edges_a || j < edges_b) {
        uint64_t end_a = (i + 1) * edges_b, end_b = (j + 1) * edges_a;
        /* At a tie the smaller ring goes first: this keeps the lattice of a subdivided triangle. */
        bool next_is_a = end_a < end_b || (end_a == end_b && edges_a <= edges_b);
        if (j == edges_b || (i < edges_a && next_is_a)) {
            (*row)[0] = vertex_of(a, i), (*row)[1] = vertex_of(a, i + 1),
            (*row)[2] = vertex_of(b, j);
            i++;
        } else {
            (*row)[0] = vertex_of(b, j + 1), (*row)[1] = vertex_of(b, j),
            (*row)[2] = vertex_of(a, i);
            j++;
        }
        row++;
    }
    return row;
}
