/* Rings of vertices, and the band of triangles between two of them; not installed. */
#ifndef RK_SCENES_RING_H
#define RK_SCENES_RING_H

#include <stdint.h>

/* Vertices first .. first + count - 1 around an axis, right-handed; a ring of one is a pole. */
typedef struct rk_ring {
    uint32_t first, count;
} rk_ring;

/* Fills the band from ring a to ring b, which lies farther along the axis, with as many triangles
 * as both have edges; returns the row after the last. */
uint32_t (*rk_ring_stitch(uint32_t (*row)[3], rk_ring a, rk_ring b))[3];

#endif
