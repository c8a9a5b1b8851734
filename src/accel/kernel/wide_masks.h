/* Packets with masks: for rays that part soon. Sixteen rays of equal signs (wide_packet.h) without
 * a shaft, which would be much wider than they are; the stack keeps which rays enter which child.
 * All packets of a batch are on their way at a time. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_MASKS_H
#define RK_ACCEL_KERNEL_WIDE_MASKS_H

#include "accel/kernel/wide_pairs.h"

enum {
    packets_max = 16,          /* on their way at a time */
    always = 1 << packet_rays, /* a lane that enters the last of the stack, which is no child */
};

/* A packet on its way, the child that it visits next, and the lanes that enter it. */
typedef struct mask_packet {
    packet *packet;
    uint32_t child, lanes, waiting;
    uint32_t children[stack_room], entering[stack_room]; /* with their lanes: the stack */
} mask_packet;

typedef struct mask_packets {
    uint32_t count;
    pairs pairs;
    mask_packet all[packets_max];
} mask_packets;

/* Below a node. */
RK_INLINE void start_masks(mask_packets *flying, packet *p, uint32_t child, uint32_t lanes)
{
    mask_packet *m = &flying->all[flying->count++];
    m->packet = p;
    m->child = child;
    m->lanes = lanes;
    m->waiting = 1;
    m->children[0] = no_child;
    m->entering[0] = always;
}

/* --- Nodes ------------------------------------------------------------------------------------ */

/* Which lanes enter a node's children; push_entered pushes these children, in the order in which
 * they are likely to be hit. */
#ifdef RK_SIMD_PERMUTES
typedef __m256i child_lanes;

RK_INLINE child_lanes no_lanes(void)
{
    return _mm256_setzero_si256();
}

RK_INLINE void add_lane(child_lanes *lanes, uint32_t lane, rk_f8 enter, rk_f8 leave)
{
    const __m256 entered = _mm256_cmp_ps(enter.part[0], leave.part[0], _CMP_LE_OQ);
    const __m256i bit = _mm256_set1_epi32((int)(1u << lane));
    *lanes = _mm256_or_si256(*lanes, _mm256_and_si256(_mm256_castps_si256(entered), bit));
}

RK_INLINE void push_entered(mask_packet *m, const rk_wide_node *node, child_lanes lanes)
{
    const __m256i places = from_nibbles(node->order[m->packet->shaft.signs]);
    const __m256i child = _mm256_loadu_si256((const void *)node->child);
    const __m256i sorted = _mm256_permutevar8x32_epi32(lanes, places);
    const __m256i none = _mm256_cmpeq_epi32(sorted, _mm256_setzero_si256());
    const uint32_t entered = 0xff & ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(none));
    _mm256_storeu_si256((void *)&m->children[m->waiting],
                        packed(_mm256_permutevar8x32_epi32(child, places), entered));
    _mm256_storeu_si256((void *)&m->entering[m->waiting], packed(sorted, entered));
    m->waiting += (uint32_t)__builtin_popcount(entered);
}
#else
typedef struct child_lanes {
    rk_simd4_mask half[2];
} child_lanes;

RK_INLINE child_lanes no_lanes(void)
{
    return (child_lanes){{{0}}};
}

RK_INLINE void add_lane(child_lanes *lanes, uint32_t lane, rk_f8 enter, rk_f8 leave)
{
    float from[RK_WIDE_CHILDREN], to[RK_WIDE_CHILDREN];
    rk_f8_store(from, enter);
    rk_f8_store(to, leave);
    for (int h = 0; h < 2; h++)
        lanes->half[h] |=
            (rk_simd4_load(&from[4 * h]) <= rk_simd4_load(&to[4 * h])) & (int32_t)(1u << lane);
}

RK_INLINE void push_entered(mask_packet *m, const rk_wide_node *node, child_lanes lanes)
{
    uint32_t order = node->order[m->packet->shaft.signs], of[RK_WIDE_CHILDREN];
    memcpy(of, &lanes, sizeof of);
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++, order >>= 4) {
        const uint32_t place = order & 7;
        m->children[m->waiting] = node->child[place];
        m->entering[m->waiting] = of[place];
        m->waiting += of[place] != 0;
    }
}
#endif

/* Each ray that enters the node, and its eight boxes; see lanes_that_enter. */
RK_INLINE child_lanes test_one_by_one(const mask_packet *m, const rk_wide_node *node)
{
    const packet *p = m->packet;
    const side_places *at = &sides_of_signs[p->shaft.signs];
    const float *sides = &node->side[0][0][0];
    child_lanes lanes = no_lanes();
    for (uint32_t left = m->lanes; left;) {
        const uint32_t lane = next_bit(&left);
        rk_f8 enter = rk_f8_all(0), leave = rk_f8_all(p->far[lane]);
#pragma GCC unroll 3
        for (int k = 0; k < 3; k++) {
            const rk_f8 o = rk_f8_all(p->start[k][lane]), by = rk_f8_all(p->inverse[k][lane]);
            const rk_f8 near = rk_f8_sub(rk_f8_load(&sides[at->near[k]]), o);
            const rk_f8 far = rk_f8_sub(rk_f8_load(&sides[at->far[k]]), o);
            enter = rk_f8_max(rk_f8_mul(near, by), enter);
            leave = rk_f8_min(rk_f8_mul(far, by), leave);
        }
        add_lane(&lanes, lane, rk_f8_mul(enter, rk_f8_all(below_1)), leave);
    }
    return lanes;
}

#ifdef RK_SIMD_SIXTEEN
enum { few_enter = 6 }; /* so many rays are faster tested one by one */

RK_INLINE f16x3 f16x3_minus(f16x3 a)
{
    const rk_f16 zero = rk_f16_all(0);
    return (f16x3){rk_f16_sub(zero, a.x), rk_f16_sub(zero, a.y), rk_f16_sub(zero, a.z)};
}

RK_INLINE rk_f16 turned_plane_hit(float plane, rk_f16 origin, rk_f16 minus_inverse)
{
    return rk_f16_mul(rk_f16_sub(origin, rk_f16_all(plane)), minus_inverse);
}

/* Eight numbers of 16 bits. */
RK_INLINE child_lanes eight_words(const uint32_t *a)
{
    uint64_t four[2];
    for (int i = 0; i < 2; i++)
        four[i] = a[4 * i] | (uint64_t)a[4 * i + 1] << 16 | (uint64_t)a[4 * i + 2] << 32 |
                  (uint64_t)a[4 * i + 3] << 48;
    return _mm256_cvtepu16_epi32(_mm_set_epi64x((long long)four[1], (long long)four[0]));
}

/* All rays and all boxes, without a branch. The signs of differences and reciprocals are turned,
 * because then the plane is subtracted straight from memory. */
RK_INLINE child_lanes test_together(const mask_packet *m, const rk_wide_node *node)
{
    const packet *p = m->packet;
    const side_places *at = &sides_of_signs[p->shaft.signs];
    const float *sides = &node->side[0][0][0];
    const f16x3 o = f16x3_load(p->start), by = f16x3_minus(f16x3_load(p->inverse));
    const rk_f16 t_max = rk_f16_load(p->far);
    uint32_t lanes[RK_WIDE_CHILDREN];
#pragma GCC unroll 8
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        rk_f16 enter = rk_f16_all(0), leave = t_max;
        enter = rk_f16_max(turned_plane_hit(sides[at->near[0] + i], o.x, by.x), enter);
        leave = rk_f16_min(turned_plane_hit(sides[at->far[0] + i], o.x, by.x), leave);
        enter = rk_f16_max(turned_plane_hit(sides[at->near[1] + i], o.y, by.y), enter);
        leave = rk_f16_min(turned_plane_hit(sides[at->far[1] + i], o.y, by.y), leave);
        enter = rk_f16_max(turned_plane_hit(sides[at->near[2] + i], o.z, by.z), enter);
        leave = rk_f16_min(turned_plane_hit(sides[at->far[2] + i], o.z, by.z), leave);
        lanes[i] = m->lanes & rk_f16_le(rk_f16_mul(enter, rk_f16_all(below_1)), leave);
    }
    return eight_words(lanes);
}

#endif

RK_INLINE void visit_node(mask_packet *m, const rk_wide_bvh *wide)
{
    const rk_wide_node *node = &wide->nodes[m->child];
#ifdef RK_SIMD_SIXTEEN
    if (__builtin_popcount(m->lanes) > few_enter) {
        push_entered(m, node, test_together(m, node));
        return;
    }
#endif
    push_entered(m, node, test_one_by_one(m, node));
}

/* --- Traversal -------------------------------------------------------------------------------- */

/* Numbers of packets, by what they visit next. */
typedef struct packet_list {
    uint32_t nodes, leaves;
    unsigned char node[packets_max], leaf[packets_max];
} packet_list;

/* Pops the next child that rays enter which are not occluded yet, and puts the packet on its list,
 * if there is one. Rays that have a hit before the child leave it in its node: to test them when it
 * is popped takes longer. */
RK_INLINE void go_on(packet_list *list, mask_packets *flying, unsigned char at,
                     const rk_wide_bvh *wide)
{
    mask_packet *m = &flying->all[at];
    do
        m->lanes = m->entering[--m->waiting] & (m->packet->active | always);
    while (!m->lanes);
    m->child = m->children[m->waiting];
    fetch(wide, m->child);
    const uint32_t is_end = m->child == no_child, is_leaf = m->child / RK_WIDE_LEAF;
    list->node[list->nodes] = at;
    list->leaf[list->leaves] = at;
    list->nodes += 1 - is_leaf;
    list->leaves += is_leaf - is_end;
}

/* One step of each packet in turn: while one waits, for memory or for the results of comparisons,
 * the others' steps are done. First those at a node, then those at a leaf, because a processor
 * predicts branches well that go the same way as before. */
RK_INLINE void trace_in_turn(mask_packets *flying, query kind, const rk_wide_bvh *wide, work *done)
{
    packet_list lists[2] = {{.nodes = flying->count}}, *now = &lists[0], *next = &lists[1];
    for (uint32_t i = 0; i < flying->count; i++)
        now->node[i] = (unsigned char)i;
    while (now->nodes + now->leaves > 0) {
        next->nodes = next->leaves = 0;
        done->nodes += now->nodes;
        for (uint32_t j = 0; j < now->nodes; j++) {
            visit_node(&flying->all[now->node[j]], wide);
            go_on(next, flying, now->node[j], wide);
        }
        for (uint32_t j = 0; j < now->leaves; j++) {
            const mask_packet *m = &flying->all[now->leaf[j]];
            done->blocks += rk_wide_leaf_count(m->child);
            visit_leaf(m->packet, kind, wide, m->child, m->lanes, &flying->pairs);
        }
        test_pairs(&flying->pairs, kind, wide);
        for (uint32_t j = 0; j < now->leaves; j++)
            go_on(next, flying, now->leaf[j], wide);
        packet_list *last = now;
        now = next;
        next = last;
    }
    flying->count = 0;
}

static __attribute__((noinline)) void closest_together(mask_packets *flying,
                                                       const rk_wide_bvh *wide, work *done)
{
    trace_in_turn(flying, CLOSEST, wide, done);
}

static __attribute__((noinline)) void occluded_together(mask_packets *flying,
                                                        const rk_wide_bvh *wide, work *done)
{
    trace_in_turn(flying, OCCLUSION, wide, done);
}

RK_INLINE void trace_masks(mask_packets *flying, query kind, const rk_wide_bvh *wide, work *done)
{
    if (kind == CLOSEST)
        closest_together(flying, wide, done);
    else
        occluded_together(flying, wide, done);
}

#endif
