/* Occlusion tests of coherent rays: packets of sixteen (wide_packet.h), all those of a batch on
 * their way at a time. Shadow rays to a light with an extent part soon; a shaft around them would
 * be much wider than they are. So all eight boxes of a node are tested against all rays of a
 * packet, without a branch, and the stack keeps which rays enter which child. Needs AVX2; narrower
 * instructions are faster with shafts. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_SHADOW_H
#define RK_ACCEL_KERNEL_WIDE_SHADOW_H

#include "accel/kernel/wide_packet.h"

#ifdef RK_SIMD_SIXTEEN

enum {
    packets_per_sixteen = packet_rays / least_lanes, /* at most */
    shadow_packets_max = 20,
    always = 1 << packet_rays, /* a lane that enters the last of the stack, which is no child */
};

/* A packet on its way, the child that it visits next, and the lanes that enter it. */
typedef struct shadow_packet {
    packet packet;
    uint32_t child, lanes, waiting;
    uint32_t children[stack_room], entering[stack_room]; /* with their lanes: the stack */
} shadow_packet;

/* Numbers of packets, by what they visit next. */
typedef struct packet_list {
    uint32_t nodes, leaves;
    unsigned char node[shadow_packets_max], leaf[shadow_packets_max];
} packet_list;

typedef struct shadow_packets {
    uint32_t count;
    shadow_packet all[shadow_packets_max];
} shadow_packets;

/* From the root on. */
RK_INLINE void start_shadow_packet(shadow_packet *s)
{
    s->child = 0;
    s->lanes = s->packet.active;
    s->waiting = 1;
    s->children[0] = no_child;
    s->entering[0] = always;
}

/* --- Nodes ------------------------------------------------------------------------------------ */

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
RK_INLINE __m256i eight_words(const uint32_t *a)
{
    uint64_t four[2];
    for (int i = 0; i < 2; i++)
        four[i] = a[4 * i] | (uint64_t)a[4 * i + 1] << 16 | (uint64_t)a[4 * i + 2] << 32 |
                  (uint64_t)a[4 * i + 3] << 48;
    return _mm256_cvtepu16_epi32(_mm_set_epi64x((long long)four[1], (long long)four[0]));
}

/* Pushes the children that lanes enter, in the order in which they are likely to be hit. */
RK_INLINE void push_entered(shadow_packet *s, const rk_wide_node *node,
                            const uint32_t lanes[RK_WIDE_CHILDREN])
{
    const __m256i places = from_nibbles(node->order[s->packet.shaft.signs]);
    const __m256i child = _mm256_loadu_si256((const void *)node->child);
    const __m256i mine = _mm256_and_si256(eight_words(lanes), _mm256_set1_epi32((int)s->lanes));
    const __m256i sorted = _mm256_permutevar8x32_epi32(mine, places);
    const __m256i none = _mm256_cmpeq_epi32(sorted, _mm256_setzero_si256());
    const uint32_t entered = 0xff & ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(none));
    _mm256_storeu_si256((void *)&s->children[s->waiting],
                        packed(_mm256_permutevar8x32_epi32(child, places), entered));
    _mm256_storeu_si256((void *)&s->entering[s->waiting], packed(sorted, entered));
    s->waiting += (uint32_t)__builtin_popcount(entered);
}

/* See lanes_that_enter; the signs of differences and reciprocals are turned, because then the
 * plane is subtracted straight from memory. */
RK_INLINE void visit_node(shadow_packet *s, const rk_wide_bvh *wide)
{
    const packet *p = &s->packet;
    const rk_wide_node *node = &wide->nodes[s->child];
    const side_places *at = &sides_of_signs[p->shaft.signs];
    const float *sides = &node->side[0][0][0];
    const f16x3 o = p->start, by = f16x3_minus(p->inverse);
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
        lanes[i] = rk_f16_le(rk_f16_mul(enter, rk_f16_all(below_1)), leave);
    }
    push_entered(s, node, lanes);
}

/* --- Traversal -------------------------------------------------------------------------------- */

/* Pops the next child that rays enter which are not occluded yet, and puts the packet on its list,
 * if there is one. */
RK_INLINE void go_on(packet_list *list, shadow_packets *flying, unsigned char at,
                     const rk_wide_bvh *wide)
{
    shadow_packet *s = &flying->all[at];
    do
        s->lanes = s->entering[--s->waiting] & (s->packet.active | always);
    while (!s->lanes);
    s->child = s->children[s->waiting];
    fetch(wide, s->child);
    const uint32_t is_end = s->child == no_child, is_leaf = s->child / RK_WIDE_LEAF;
    list->node[list->nodes] = at;
    list->leaf[list->leaves] = at;
    list->nodes += 1 - is_leaf;
    list->leaves += is_leaf - is_end;
}

/* One step of each packet in turn: while one waits, for memory or for the results of comparisons,
 * the others' steps are done; see wide_flights.h. */
RK_INLINE void trace_shadow_packets(shadow_packets *flying, const rk_wide_bvh *wide, work *done)
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
            shadow_packet *s = &flying->all[now->leaf[j]];
            visit_leaf(&s->packet, OCCLUSION, wide, s->child, s->lanes);
            done->blocks += rk_wide_leaf_count(s->child);
            go_on(next, flying, now->leaf[j], wide);
        }
        packet_list *last = now;
        now = next;
        next = last;
    }
}

/* --- Sorting ---------------------------------------------------------------------------------- */

/* Have rays of the batch different signs, and yet more than half of them nearly one direction? Then
 * packets of equal signs gain more, being full, than they lose by origins that are farther apart.
 */
RK_INLINE bool gain_by_sorting(const rk_ray_batch *rays)
{
    const float *d[3] = {rays->direction_x, rays->direction_y, rays->direction_z};
    const f16x3 axis = {rk_f16_all(d[0][0]), rk_f16_all(d[1][0]), rk_f16_all(d[2][0])};
    const rk_f16 zero = rk_f16_all(0), half = rk_f16_mul(f16x3_dot(axis, axis), rk_f16_all(0.5f));
    uint32_t backward[3], differ = 0, near = 0;
    for (int k = 0; k < 3; k++)
        backward[k] = d[k][0] < 0 ? 0xffff : 0;
    for (uint32_t first = 0; first < rays->count; first += packet_rays) {
        const uint32_t all = lanes_of(rays, first);
        const f16x3 b = {rk_f16_load(&d[0][first]), rk_f16_load(&d[1][first]),
                         rk_f16_load(&d[2][first])};
        const rk_f16 cos = f16x3_dot(axis, b), square = rk_f16_mul(cos, cos);
        differ |=
            all & ((rk_f16_lt(b.x, zero) ^ backward[0]) | (rk_f16_lt(b.y, zero) ^ backward[1]) |
                   (rk_f16_lt(b.z, zero) ^ backward[2]));
        near += (uint32_t)__builtin_popcount(all & rk_f16_lt(zero, cos) &
                                             rk_f16_le(rk_f16_mul(f16x3_dot(b, b), half), square));
    }
    return differ && near > rays->count / 2;
}

typedef struct sorted_rays {
    rk_ray_batch rays;
    uint16_t index[RK_BATCH_MAX]; /* in the batch */
} sorted_rays;

/* By the signs of directions, else in the order of the batch. */
RK_INLINE void sort_by_signs(sorted_rays *sorted, const rk_ray_batch *rays)
{
    uint32_t next[9] = {0};
    unsigned char signs[RK_BATCH_MAX];
    for (uint32_t i = 0; i < rays->count; i++) {
        signs[i] = (unsigned char)((rays->direction_x[i] < 0) | (rays->direction_y[i] < 0) << 1 |
                                   (rays->direction_z[i] < 0) << 2);
        next[signs[i] + 1]++;
    }
    for (int k = 0; k < 8; k++)
        next[k + 1] += next[k];
    for (uint32_t i = 0; i < rays->count; i++)
        sorted->index[next[signs[i]]++] = (uint16_t)i;
    sorted->rays.count = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        const rk_ray ray = rk_batch_ray(rays, sorted->index[i]);
        rk_batch_push(&sorted->rays, &ray);
    }
}

#endif

#endif
