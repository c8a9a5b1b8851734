/* Coherent packets: one shaft (wide_boxes.h) around sixteen rays of nearly one direction is tested
 * against a node's boxes. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_SHAFTS_H
#define RK_ACCEL_KERNEL_WIDE_SHAFTS_H

#include "accel/kernel/wide_masks.h"

enum {
    least_lanes = 4, /* of a packet */
    /* If so few rays enter a node, and their shaft so many of its children, it is too wide for
     * them: with masks they enter fewer. */
    apart_lanes = 4,
    wide_children = 4,
};

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
 * lanes, or 0 if they are too few for one: those left over are traced with masks. Not inline,
 * because clang 14 then loses lanes in WebAssembly. */
static __attribute__((noinline)) uint32_t next_packet(packet *p, const tree_extent *extent,
                                                      const sixteen *lanes, uint32_t *left,
                                                      uint32_t *alone)
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
        if (fill_packet(p, extent, *lanes, signs, active, true))
            return active;
        *alone |= active;
    }
    return 0;
}

RK_INLINE rk_f16 plane_hit(float plane, rk_f16 origin, rk_f16 inverse)
{
    return rk_f16_mul(rk_f16_sub(rk_f16_all(plane), origin), inverse);
}

/* The lanes that enter a child; see push_children. */
RK_INLINE uint32_t lanes_that_enter(const packet *p, const rk_wide_bvh *wide, uint32_t box)
{
    const float *sides = &wide->nodes[box / RK_WIDE_CHILDREN].side[0][0][box % RK_WIDE_CHILDREN];
    const side_places *at = &sides_of_signs[p->shaft.signs];
    const f16x3 o = f16x3_load(p->start), by = f16x3_load(p->inverse);
    rk_f16 enter = rk_f16_all(0), leave = rk_f16_load(p->far);
    enter = rk_f16_max(plane_hit(sides[at->near[0]], o.x, by.x), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[0]], o.x, by.x), leave);
    enter = rk_f16_max(plane_hit(sides[at->near[1]], o.y, by.y), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[1]], o.y, by.y), leave);
    enter = rk_f16_max(plane_hit(sides[at->near[2]], o.z, by.z), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[2]], o.z, by.z), leave);
    return p->active & rk_f16_le(rk_f16_mul(enter, rk_f16_all(below_1)), leave);
}

/* The last lanes without the shaft, below `child`. */
RK_INLINE void trace_apart(packet *p, query kind, const rk_wide_bvh *wide, uint32_t child,
                           uint32_t lanes, mask_packets *flying, work *done)
{
    start_masks(flying, p, child, lanes);
    trace_masks(flying, kind, wide, done);
    if (kind == CLOSEST)
        p->farthest = rk_f16_largest(rk_f16_load(p->far));
}

/* From a node on. The shaft is wider than its rays: it may enter a child that none of them does. */
RK_INLINE void trace_packet(packet *p, query kind, const rk_wide_bvh *wide, uint32_t start,
                            mask_packets *flying, work *done)
{
    child_stack stack;
    uint32_t child = start;
    start_stack(&stack);
    while (child != no_child) {
        const float farthest = p->farthest;
        uint32_t lanes = p->active;
        if (child != start)
            lanes = lanes_that_enter(p, wide, stack.box[stack.size]);
        if (lanes) {
            if (child & RK_WIDE_LEAF) {
                visit_leaf(p, kind, wide, child, lanes, &flying->pairs);
                test_pairs(&flying->pairs, kind, wide);
                if (kind == CLOSEST)
                    p->farthest = rk_f16_largest(rk_f16_load(p->far));
                done->blocks += rk_wide_leaf_count(child);
            } else {
                const uint32_t before = stack.size;
                push_children(&stack, &p->shaft, wide, child, p->farthest, true);
                done->nodes++;
                if (__builtin_popcount(lanes) <= apart_lanes &&
                    stack.size - before >= wide_children) {
                    stack.size = before;
                    trace_apart(p, kind, wide, child, lanes, flying, done);
                }
            }
            if (!p->active)
                return;
        }
        if (kind == CLOSEST && p->farthest < farthest)
            drop_farther(&stack, p->farthest, true);
        child = pop(&stack);
        fetch(wide, stack.child[stack.size ? stack.size - 1 : 0]); /* the one after it */
    }
}

/* Of packets alone and of a tile's: a second copy, inside the tile's loop, is slower. */
static __attribute__((noinline)) void
trace_closest(packet *p, const rk_wide_bvh *wide, uint32_t start, mask_packets *flying, work *done)
{
    trace_packet(p, CLOSEST, wide, start, flying, done);
}

#endif
