/* Traversal of the wide tree. The headers of this folder, from wide_boxes.h to this one, are parts
 * of one text that is compiled once for each instruction set, which is why all of it is static;
 * begin with docs/94_kernel.md, which draws and counts what is named here.
 *
 *   batch of up to RK_BATCH_MAX rays
 *     |  sixteen after sixteen, those with equal signs and nearly one direction
 *     v
 *   packet (wide_packet.h)          too few of them, or parted deep in the tree
 *     |                               |
 *     v                               v
 *   shaft (wide_boxes.h)            flight: a single ray (wide_single.h), many in turn
 *     around the packet's rays        (wide_flights.h)
 *     |                               |
 *     |    node: eight boxes          |
 *     +-->   leaf: blocks          <--+
 *              block: four triangles (wide_hits.h)
 *
 * Shaft: contains a packet's rays; a child that it misses is missed by all of them. A single ray
 * is a shaft without width, so that both enter a node's children by push_children.
 *
 * Packet: sixteen rays, one in each lane. Of a child that the shaft enters, lanes_that_enter tests
 * the rays themselves; lanes_in_block tests four triangles against all of them.
 *
 * Flight: a single ray with its stack. Flights take steps in turn, so that none waits for memory.
 *
 * Bound: of an error. Float decides about a triangle where an error as large as its bound changes
 * nothing; decide_exactly decides about the others.
 *
 * Shadow packets (wide_shadow.h): on their way together, without shafts. The stack keeps which rays
 * enter which child.
 *
 * Included by one file for each instruction set; not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_TRACE_H
#define RK_ACCEL_KERNEL_WIDE_TRACE_H

#include "accel/kernel/wide_kernel.h"
#include "accel/kernel/wide_shadow.h"

#include <string.h>

/* --- Batches ---------------------------------------------------------------------------------- */

/* -0 becomes 0: its reciprocal has the sign of the others. */
RK_INLINE sixteen load_sixteen(const rk_ray_batch *rays, uint32_t first)
{
    const rk_f16 zero = rk_f16_all(0);
    return (sixteen){{rk_f16_load(&rays->origin_x[first]), rk_f16_load(&rays->origin_y[first]),
                      rk_f16_load(&rays->origin_z[first])},
                     {rk_f16_add(rk_f16_load(&rays->direction_x[first]), zero),
                      rk_f16_add(rk_f16_load(&rays->direction_y[first]), zero),
                      rk_f16_add(rk_f16_load(&rays->direction_z[first]), zero)},
                     rk_f16_load(&rays->t_max[first])};
}

/* The lanes whose directions are less than 18 degrees from this one: for others, a shaft would be
 * too wide. */
RK_INLINE uint32_t in_cone_of(const f16x3 *d, int lane)
{
    f16x3 axis = {rk_f16_all(rk_f16_lane(d->x, lane)), rk_f16_all(rk_f16_lane(d->y, lane)),
                  rk_f16_all(rk_f16_lane(d->z, lane))};
    rk_f16 cos = f16x3_dot(*d, axis);
    rk_f16 lengths = rk_f16_mul(f16x3_dot(*d, *d), f16x3_dot(axis, axis));
    return rk_f16_le(rk_f16_mul(lengths, rk_f16_all(0.9f)), rk_f16_mul(cos, cos));
}

/* Takes the next packet out of `left`, of sixteen lanes: coherent rays of equal signs. Returns its
 * lanes, or 0 if they are too few for one: those left over are traced as single rays. Not inline,
 * because clang 14 then loses lanes in WebAssembly. */
static __attribute__((noinline)) uint32_t next_packet(packet *p, const tree_extent *extent,
                                                      const sixteen *lanes, uint32_t *left,
                                                      uint32_t *alone, bool with_shaft)
{
    const rk_f16 zero = rk_f16_all(0),
                 components[3] = {lanes->direction.x, lanes->direction.y, lanes->direction.z};
    while (*left) {
        const int lane = __builtin_ctz(*left);
        uint32_t active = *left & in_cone_of(&lanes->direction, lane), signs = 0;
        for (int k = 0; k < 3; k++) {
            const uint32_t backward = rk_f16_lt(components[k], zero);
            active &= backward >> lane & 1 ? backward : ~backward;
            signs |= (backward >> lane & 1) << k;
        }
        active |= 1u << lane;
        if (__builtin_popcount(active) < least_lanes) {
            *alone |= *left;
            return 0;
        }
        *left &= ~active;
        if (fill_packet(p, extent, *lanes, signs, active, with_shaft))
            return active;
        *alone |= active;
    }
    return 0;
}

/* Lanes of which t_max is 0 or more: another, or NaN, would spoil the bounds of all. */
RK_INLINE uint32_t hopeful_lanes(const rk_ray_batch *rays, const sixteen *lanes, uint32_t first,
                                 uint32_t *alone)
{
    const uint32_t all = lanes_of(rays, first), hopeful = rk_f16_le(rk_f16_all(0), lanes->t_max);
    *alone = all & ~hopeful;
    return all & hopeful;
}

/* Traces sixteen rays of the batch. Returns the lanes that are left for single rays. */
RK_INLINE uint32_t trace_sixteen(query kind, const rk_wide_bvh *wide, const tree_extent *extent,
                                 const rk_ray_batch *rays, uint32_t first, rk_hit_batch *hits,
                                 rk_occlusion_batch *answers, flights *flying, work *done)
{
    const sixteen lanes = load_sixteen(rays, first);
    uint32_t alone, left = hopeful_lanes(rays, &lanes, first, &alone), active;
    packet p;
    p.rays = rays;
    p.first = first;
    while ((active = next_packet(&p, extent, &lanes, &left, &alone, true)) != 0) {
        trace_packet(&p, kind, wide, flying, done);
        if (kind == CLOSEST)
            put_hits(&p, wide, active, hits);
        else
            put_answers(&p, active, answers);
    }
    return alone;
}

/* Rays that are in no packet. */
typedef struct single_rays {
    const rk_ray_batch *rays;
    rk_hit_batch *hits;
    rk_occlusion_batch *answers;
    uint32_t count, next;
    uint16_t index[RK_BATCH_MAX];
} single_rays;

RK_INLINE void put_result(const single_rays *single, query kind, uint32_t index, const rk_hit *hit,
                          bool is_occluded)
{
    if (kind == CLOSEST)
        rk_batch_put_hit(single->hits, index, hit);
    else
        single->answers->occluded[index] = is_occluded;
}

RK_INLINE void start_single(single_rays *single, const rk_ray_batch *rays, rk_hit_batch *hits,
                            rk_occlusion_batch *answers)
{
    single->rays = rays;
    single->hits = hits;
    single->answers = answers;
    single->count = single->next = 0;
}

RK_INLINE void add_single(single_rays *single, uint32_t first, uint32_t lanes)
{
    while (lanes)
        single->index[single->count++] = (uint16_t)(first + next_bit(&lanes));
}

/* Starts the next ray that takes no special care, if there is one. */
RK_INLINE void start_next(single_rays *single, flights *flying, unsigned char at, query kind,
                          const rk_wide_bvh *wide, const tree_extent *extent, work *done)
{
    while (single->next < single->count) {
        const uint32_t index = single->index[single->next++];
        const rk_ray ray = rk_batch_ray(single->rays, index);
        const float longest = rk_watertight_longest(&ray);
        if (is_ordinary_ray(extent, &ray, longest)) {
            start_flight(flying, at, &ray, longest, 0);
            flying->all[at].index = index;
            return;
        }
        const rk_hit hit = trace_carefully(wide, &ray, done);
        put_result(single, kind, index, &hit, hit.triangle != RK_MISS);
    }
}

/* Where a flight has ended, the next one begins. */
RK_INLINE void trace_single(single_rays *single, flights *flying, query kind,
                            const rk_wide_bvh *wide, const tree_extent *extent, work *done)
{
    flying->nodes.count = flying->leaves.count = 0;
    for (unsigned char at = 0; at < flights_max; at++)
        start_next(single, flying, at, kind, wide, extent, done);
    while (step(flying, kind, wide, done))
        for (uint32_t j = 0; j < flying->ended.count; j++) {
            const unsigned char at = flying->ended.at[j];
            const flight *f = &flying->all[at];
            rk_hit hit = {.triangle = RK_MISS};
            if (kind == CLOSEST)
                hit = final_hit(&f->best, wide, &f->ray);
            put_result(single, kind, f->index, &hit, f->is_occluded);
            start_next(single, flying, at, kind, wide, extent, done);
        }
}

RK_INLINE void trace(query kind, const rk_wide_bvh *wide, const rk_ray_batch *rays,
                     rk_hit_batch *hits, rk_occlusion_batch *answers, rk_counters *counters)
{
    const tree_extent extent = extent_of(wide);
    work done = {0, 0};
    flights flying;
    single_rays single;
    start_single(&single, rays, hits, answers);
    for (uint32_t first = 0; first < rays->count; first += packet_rays)
        add_single(&single, first,
                   trace_sixteen(kind, wide, &extent, rays, first, hits, answers, &flying, &done));
    trace_single(&single, &flying, kind, wide, &extent, &done);
    counters->box_tests += RK_WIDE_CHILDREN * done.nodes;
    counters->triangle_tests += RK_WIDE_BLOCK * done.blocks;
}

#ifdef RK_SIMD_SIXTEEN

RK_INLINE void trace_group(shadow_packets *group, const uint32_t *active, const rk_wide_bvh *wide,
                           rk_occlusion_batch *answers, work *done)
{
    trace_shadow_packets(group, wide, done);
    for (uint32_t i = 0; i < group->count; i++)
        put_answers(&group->all[i].packet, active[i], answers);
    group->count = 0;
}

static __attribute__((noinline)) void trace_shadows(const rk_wide_bvh *wide,
                                                    const rk_ray_batch *rays,
                                                    rk_occlusion_batch *answers,
                                                    rk_counters *counters)
{
    const tree_extent extent = extent_of(wide);
    work done = {0, 0};
    single_rays single;
    start_single(&single, rays, NULL, answers);
    union {
        shadow_packets packets;
        flights flights;
    } flying;
    shadow_packets *group = &flying.packets;
    uint32_t active[shadow_packets_max];
    group->count = 0;
    for (uint32_t first = 0; first < rays->count; first += packet_rays) {
        const sixteen lanes = load_sixteen(rays, first);
        uint32_t alone, left = hopeful_lanes(rays, &lanes, first, &alone);
        for (;;) {
            shadow_packet *s = &group->all[group->count];
            s->packet.rays = rays;
            s->packet.first = first;
            active[group->count] = next_packet(&s->packet, &extent, &lanes, &left, &alone, false);
            if (active[group->count] == 0)
                break;
            start_shadow_packet(s);
            group->count++;
        }
        add_single(&single, first, alone);
        if (group->count >= shadow_packets_max - packets_per_sixteen)
            trace_group(group, active, wide, answers, &done);
    }
    trace_group(group, active, wide, answers, &done);
    trace_single(&single, &flying.flights, OCCLUSION, wide, &extent, &done);
    counters->box_tests += RK_WIDE_CHILDREN * done.nodes;
    counters->triangle_tests += RK_WIDE_BLOCK * done.blocks;
}

/* Sorted, if that pays. */
RK_INLINE void trace_occlusion(const rk_wide_bvh *wide, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters)
{
    if (!gain_by_sorting(rays)) {
        trace_shadows(wide, rays, answers, counters);
        return;
    }
    sorted_rays sorted;
    rk_occlusion_batch found;
    sort_by_signs(&sorted, rays);
    trace_shadows(wide, &sorted.rays, &found, counters);
    for (uint32_t i = 0; i < rays->count; i++)
        answers->occluded[sorted.index[i]] = found.occluded[i];
}

#else

RK_INLINE void trace_occlusion(const rk_wide_bvh *wide, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters)
{
    trace(OCCLUSION, wide, rays, NULL, answers, counters);
}

#endif

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
        trace_occlusion(wide, rays, answers, counters);
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
