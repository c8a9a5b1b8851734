/* Traversal of the wide tree. The headers of this folder, from wide_boxes.h to this one, are parts
 * of one text that is compiled once for each instruction set, which is why all of it is static;
 * begin with docs/94_kernel.md, which draws and counts what is named here.
 *
 *   batch of up to RK_BATCH_MAX rays --> all from one point: tile (wide_tile.h), whose packets
 *     |                                  have a shaft around all of them, and go on as below
 *     |  sixteen after sixteen,              the others
 *     |  those of nearly one direction         |  sorted by signs
 *     v                                        v
 *   packet with a shaft (wide_shafts.h) --> packets with masks (wide_masks.h), all in turn
 *     |                       its last rays    |
 *     |    node: eight boxes (wide_boxes.h)    |
 *     +-->   leaf: blocks                   <--+
 *              block: four triangles, against sixteen rays (wide_packet.h)
 *                or in pairs, each of one ray and one block (wide_pairs.h)
 *
 * Packet: sixteen rays whose directions have the same signs, one in each lane.
 *
 * Shaft: contains a packet's rays; a child that it misses is missed by all of them. Of a child that
 * it enters, lanes_that_enter tests the rays themselves. A single ray is a shaft without width, so
 * that both enter a node's children by push_children.
 *
 * Tile: a batch of camera rays. Of a child that the shaft around all of them enters,
 * packets_that_enter tests the shafts of its packets, one in each lane.
 *
 * Mask: of a child, with a bit for each lane whose ray enters it. Packets with masks take steps in
 * turn, so that none waits for memory.
 *
 * Pair: a ray and a block, where few rays of a packet enter a leaf. Pairs of all packets are tested
 * several at a time.
 *
 * Bound: of an error. Float decides about a triangle where an error as large as its bound changes
 * nothing; decide_exactly (wide_hits.h) decides about the others.
 *
 * What is counted is a packet's visit: of a node, whose boxes are eight tests, and of a block,
 * whose triangles are four.
 *
 * Included by one file for each instruction set; not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_TRACE_H
#define RK_ACCEL_KERNEL_WIDE_TRACE_H

#include "accel/kernel/wide_kernel.h"
#include "accel/kernel/wide_tile.h"

#include <string.h>

/* --- Batches ---------------------------------------------------------------------------------- */

/* A batch on its way: its rays, and where their results go. */
typedef struct batch {
    const rk_wide_bvh *wide;
    tree_extent extent;
    const rk_ray_batch *rays;
    rk_hit_batch *hits;
    rk_occlusion_batch *answers;
    work done;
    packet packets[packets_max]; /* a tile has as many */
    mask_packets flying;
} batch;

RK_INLINE void put_results(batch *b, query kind, packet *p)
{
    if (kind == CLOSEST)
        put_hits(p, b->wide, b->hits);
    else
        put_answers(p, b->answers);
}

/* Traces sixteen rays of the batch. Returns the lanes that are left for packets with masks. */
RK_INLINE uint32_t trace_sixteen(batch *b, query kind, uint32_t first)
{
    const sixteen lanes = load_sixteen(b->rays, first);
    const uint32_t all = lanes_of(b->rays, first);
    uint32_t left = all & ordinary_lanes(&lanes), alone = all & ~left;
    packet *p = &b->packets[0];
    p->rays = b->rays;
    p->first = first;
    while (next_packet(p, &b->extent, &lanes, &left, &alone)) {
        if (kind == CLOSEST)
            trace_closest(p, b->wide, 0, &b->flying, &b->done);
        else
            trace_packet(p, kind, b->wide, 0, &b->flying, &b->done);
        put_results(b, kind, p);
    }
    return alone;
}

_Static_assert((int)tile_packets == (int)packets_max, "a batch has room for a tile's packets");

/* The closest hits of a batch that is a tile; false, and nothing done, if it is none. */
static __attribute__((noinline)) bool closest_of_tile(batch *b)
{
    tile t = {.packet = b->packets};
    if (!start_tile(&t, &b->extent, b->rays))
        return false;
    trace_tile(&t, b->wide, &b->flying, &b->done);
    for (uint32_t i = 0; i < tile_packets; i++)
        if (t.filled >> i & 1)
            put_hits(&t.packet[i], b->wide, b->hits);
        else
            put_misses(b->rays, i * packet_rays, b->hits);
    return true;
}

/* --- Packets with masks ----------------------------------------------------------------------- */

/* Rays that are left, by the signs of their directions, else in the order of the batch. */
typedef struct left_rays {
    rk_ray_batch rays;
    uint16_t index[RK_BATCH_MAX]; /* in the batch */
    uint32_t start[9];            /* of each combination of signs; the last: the end */
} left_rays;

RK_INLINE void add_left(left_rays *left, uint32_t first, uint32_t lanes)
{
    while (lanes)
        left->index[left->rays.count++] = (uint16_t)(first + next_bit(&lanes));
}

RK_INLINE void sort_by_signs(left_rays *left, const rk_ray_batch *rays)
{
    const uint32_t count = left->rays.count;
    uint32_t next[9] = {0};
    unsigned char signs[RK_BATCH_MAX];
    uint16_t index[RK_BATCH_MAX];
    memcpy(index, left->index, count * sizeof *index);
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t i = index[j];
        signs[j] = (unsigned char)((rays->direction_x[i] < 0) | (rays->direction_y[i] < 0) << 1 |
                                   (rays->direction_z[i] < 0) << 2);
        next[signs[j] + 1]++;
    }
    for (int k = 0; k < 8; k++)
        next[k + 1] += next[k];
    memcpy(left->start, next, sizeof next);
    for (uint32_t j = 0; j < count; j++)
        left->index[next[signs[j]]++] = index[j];
}

RK_INLINE void copy_rays(left_rays *left, const rk_ray_batch *rays)
{
    rk_ray_batch *to = &left->rays;
    for (uint32_t j = 0; j < to->count; j++) {
        const uint32_t i = left->index[j];
        to->origin_x[j] = rays->origin_x[i];
        to->origin_y[j] = rays->origin_y[i];
        to->origin_z[j] = rays->origin_z[i];
        to->direction_x[j] = rays->direction_x[i];
        to->direction_y[j] = rays->direction_y[i];
        to->direction_z[j] = rays->direction_z[i];
        to->t_max[j] = rays->t_max[i];
    }
}

RK_INLINE void trace_started(batch *b, query kind)
{
    const uint32_t count = b->flying.count;
    trace_masks(&b->flying, kind, b->wide, &b->done);
    for (uint32_t i = 0; i < count; i++)
        put_results(b, kind, &b->packets[i]);
}

static __attribute__((noinline)) void trace_alone(batch *b, query kind, uint32_t index)
{
    const rk_ray ray = rk_batch_ray(b->rays, index);
    const rk_hit hit = trace_carefully(b->wide, &ray, &b->done);
    if (kind == CLOSEST)
        rk_batch_put_hit(b->hits, index, &hit);
    else
        b->answers->occluded[index] = hit.triangle != RK_MISS;
}

/* Up to sixteen rays of the same signs; those that would spoil the packet are traced at once. At
 * the end of the batch the first lanes are not theirs, so that sixteen are there to load. */
RK_INLINE void start_packet(batch *b, query kind, uint32_t signs, uint32_t begin, uint32_t end)
{
    const uint32_t last = RK_BATCH_MAX - packet_rays, first = begin < last ? begin : last;
    const uint32_t count = end - begin < packet_rays ? end - begin : packet_rays;
    const uint32_t all = ((1u << count) - 1) << (begin - first);
    const sixteen lanes = load_sixteen(b->rays, first);
    const uint32_t active = all & ordinary_lanes(&lanes);
    uint32_t alone = all & ~active;
    packet *p = &b->packets[b->flying.count];
    p->rays = b->rays;
    p->first = first;
    if (active && fill_packet(p, &b->extent, lanes, signs, active, false))
        start_masks(&b->flying, p, 0, active);
    else
        alone = all;
    while (alone)
        trace_alone(b, kind, first + next_bit(&alone));
    if (b->flying.count == packets_max)
        trace_started(b, kind);
}

/* `start`: of the rays of each combination of signs. */
static __attribute__((noinline)) void trace_by_signs(batch *b, query kind, const uint32_t start[9])
{
    for (uint32_t k = 0; k < 8; k++)
        for (uint32_t first = start[k]; first < start[k + 1]; first += packet_rays)
            start_packet(b, kind, k, first, start[k + 1]);
    trace_started(b, kind);
}

/* Sorted first, unless they are the whole batch and have the same signs. */
RK_INLINE void trace_left(batch *b, query kind, left_rays *left)
{
    const rk_ray_batch *rays = b->rays;
    rk_hit_batch *hits = b->hits, sorted_hits;
    rk_occlusion_batch *answers = b->answers, sorted_answers;
    sort_by_signs(left, rays);
    for (int k = 0; k < 8; k++)
        if (left->start[k + 1] - left->start[k] == rays->count) {
            trace_by_signs(b, kind, left->start);
            return;
        }
    copy_rays(left, rays);
    b->rays = &left->rays;
    b->hits = &sorted_hits;
    b->answers = &sorted_answers;
    trace_by_signs(b, kind, left->start);
    for (uint32_t j = 0; j < left->rays.count; j++)
        if (kind == CLOSEST) {
            const rk_hit hit = rk_batch_hit(&sorted_hits, j);
            rk_batch_put_hit(hits, left->index[j], &hit);
        } else {
            answers->occluded[left->index[j]] = sorted_answers.occluded[j];
        }
}

/* Registers of sixteen numbers test all boxes of a node as fast as a shaft, which shadow rays,
 * parting soon, are too wide for. */
RK_INLINE bool takes_shafts(query kind)
{
#ifdef RK_SIMD_SIXTEEN
    return kind == CLOSEST;
#else
    (void)kind;
    return true;
#endif
}

RK_INLINE void trace(query kind, const rk_wide_bvh *wide, const rk_ray_batch *rays,
                     rk_hit_batch *hits, rk_occlusion_batch *answers, rk_counters *counters)
{
    batch b;
    left_rays left;
    b.wide = wide;
    b.extent = extent_of(wide);
    b.rays = rays;
    b.hits = hits;
    b.answers = answers;
    b.done = (work){0, 0};
    b.flying.count = b.flying.pairs.count = b.flying.pairs.filled = left.rays.count = 0;
    const bool is_tile = kind == CLOSEST && closest_of_tile(&b);
    for (uint32_t first = 0; !is_tile && first < rays->count; first += packet_rays)
        add_left(&left, first,
                 takes_shafts(kind) ? trace_sixteen(&b, kind, first) : lanes_of(rays, first));
    if (left.rays.count > 0)
        trace_left(&b, kind, &left);
    counters->box_tests += RK_WIDE_CHILDREN * b.done.nodes;
    counters->triangle_tests += RK_WIDE_BLOCK * b.done.blocks;
}

static void closest_of_batch(const rk_wide_bvh *wide, const rk_ray_batch *rays, rk_hit_batch *hits,
                             rk_counters *counters)
{
    const rk_hit miss = {0, 0, 0, RK_MISS};
    for (uint32_t i = 0; wide->node_count == 0 && i < rays->count; i++) {
        rk_batch_put_hit(hits, i, &miss);
        hits->t[i] = rays->t_max[i];
    }
    if (wide->node_count > 0)
        trace(CLOSEST, wide, rays, hits, NULL, counters);
}

static void occluded_of_batch(const rk_wide_bvh *wide, const rk_ray_batch *rays,
                              rk_occlusion_batch *answers, rk_counters *counters)
{
    if (wide->node_count > 0)
        trace(OCCLUSION, wide, rays, NULL, answers, counters);
    else
        memset(answers->occluded, 0, rays->count * sizeof *answers->occluded);
}

/* --- Leaves ----------------------------------------------------------------------------------- */

static void visit_block(const rk_wide_block *block, rk_leaf_visitor *visitor)
{
    rk_triangle triangles[RK_WIDE_BLOCK];
    uint32_t count = 0;
    do
        triangles[count] = rk_wide_triangle(block, count);
    while (++count < RK_WIDE_BLOCK && block->index[count] != block->index[count - 1]);
    visitor->visit(visitor, triangles, count);
}

static void visit_leaves(const rk_wide_bvh *wide, const rk_ray *ray, rk_leaf_visitor *visitor,
                         rk_counters *counters)
{
    if (wide->node_count == 0)
        return;
    const shaft s = shaft_of_ray(ray);
    child_stack stack;
    start_stack(&stack);
    for (uint32_t child = 0; child != no_child; child = pop(&stack)) {
        if (!(child & RK_WIDE_LEAF)) {
            push_children(&stack, &s, wide, child, visitor->end, false);
            counters->box_tests += RK_WIDE_CHILDREN;
            continue;
        }
        const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(child)];
        for (uint32_t k = 0; k < rk_wide_leaf_count(child); k++)
            visit_block(&block[k], visitor);
        drop_farther(&stack, visitor->end, false);
    }
}

#endif
