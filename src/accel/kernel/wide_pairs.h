/* Pairs of a ray and a block. At a leaf a packet has few rays left; so the pairs of all packets are
 * collected, and a register of sixteen numbers tests four of them at a time: the triangles of four
 * blocks, each with a ray of its own. Narrower registers test one or two. Included by one file for
 * each instruction set (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_PAIRS_H
#define RK_ACCEL_KERNEL_WIDE_PAIRS_H

#include "accel/kernel/wide_packet.h"

/* Registers that hold the four triangles of one block or more. */
#ifdef RK_SIMD_SIXTEEN
#define QUADS(operation) rk_n16_##operation
typedef __m512 quads;
#elif defined RK_SIMD_PERMUTES
#define QUADS(operation) rk_n_##operation
typedef __m256 quads;
#else
#define QUADS(operation) rk_simd4_##operation
typedef rk_simd4 quads;
#endif

typedef int32_t quads_bits __attribute__((vector_size(sizeof(quads))));

enum {
    pairs_at_once = sizeof(quads) / sizeof(rk_simd4),
    few_lanes = pairs_at_once > 1 ? 4 : 6, /* so many rays in a block are faster tested as pairs */
    pairs_max = 64,
};

/* The numbers of a ray are copied: those of four pairs are then loaded at once. */
typedef struct pairs {
    uint32_t count, filled; /* now, and at most so far */
    packet *packet[pairs_max];
    const rk_wide_block *block[pairs_max];
    uint32_t lane[pairs_max];
    float origin[3][pairs_max], direction[3][pairs_max];
    float longest[pairs_max], edge[pairs_max], far[pairs_max];
} pairs;

typedef struct quads3 {
    quads x, y, z;
} quads3;

/* A number of each pair, four times. */
RK_INLINE quads repeated(const float *x)
{
#ifdef RK_SIMD_SIXTEEN
    const __m512i places = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    return _mm512_permutevar_ps(_mm512_broadcast_f32x4(_mm_loadu_ps(x)), places);
#elif defined RK_SIMD_PERMUTES
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(x[0])), _mm_set1_ps(x[1]), 1);
#else
    return rk_simd4_all(*x);
#endif
}

RK_INLINE quads3 repeated3(const float x[3][pairs_max], uint32_t first)
{
    return (quads3){repeated(&x[0][first]), repeated(&x[1][first]), repeated(&x[2][first])};
}

/* A coordinate of a corner of all triangles. */
RK_INLINE quads coordinate(const rk_wide_block *const *block, int k, int axis)
{
#ifdef RK_SIMD_SIXTEEN
    __m512 all = _mm512_castps128_ps512(_mm_loadu_ps(block[0]->corner[k][axis]));
    all = _mm512_insertf32x4(all, _mm_loadu_ps(block[1]->corner[k][axis]), 1);
    all = _mm512_insertf32x4(all, _mm_loadu_ps(block[2]->corner[k][axis]), 2);
    return _mm512_insertf32x4(all, _mm_loadu_ps(block[3]->corner[k][axis]), 3);
#elif defined RK_SIMD_PERMUTES
    const __m256 low = _mm256_castps128_ps256(_mm_loadu_ps(block[0]->corner[k][axis]));
    return _mm256_insertf128_ps(low, _mm_loadu_ps(block[1]->corner[k][axis]), 1);
#else
    return rk_simd4_load(block[0]->corner[k][axis]);
#endif
}

RK_INLINE quads3 corners(const rk_wide_block *const *block, int k)
{
    return (quads3){coordinate(block, k, 0), coordinate(block, k, 1), coordinate(block, k, 2)};
}

RK_INLINE quads3 quads3_sub(quads3 a, quads3 b)
{
    return (quads3){a.x - b.x, a.y - b.y, a.z - b.z};
}

RK_INLINE quads3 quads3_cross(quads3 a, quads3 b)
{
    return (quads3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

RK_INLINE quads quads3_dot(quads3 a, quads3 b)
{
    return a.x * b.x + (a.y * b.y + a.z * b.z);
}

/* Of pairs, with the bounds of their errors; see bounds_of and features/watertight.h. */
typedef struct determinants {
    quads u, v, w, det, t, bound, t_bound;
} determinants;

RK_INLINE determinants determinants_of(const pairs *q, uint32_t first)
{
    determinants found;
    const rk_wide_block *const *block = &q->block[first];
    const quads3 direction = repeated3(q->direction, first), a = corners(block, 0);
    const quads3 ab = quads3_sub(corners(block, 1), a), ac = quads3_sub(corners(block, 2), a);
    const quads3 s = quads3_sub(repeated3(q->origin, first), a);
    const quads3 p = quads3_cross(direction, ac), cross = quads3_cross(s, ab);
    found.u = quads3_dot(s, p);
    found.v = quads3_dot(direction, cross);
    found.w = quads3_dot(ab, p) - found.u - found.v;
    found.det = found.u + found.v + found.w;
    found.t = quads3_dot(ac, cross);
    const quads side = repeated(&q->edge[first]) + QUADS(all)(tiny);
    const quads reach = QUADS(abs)(s.x) + QUADS(abs)(s.y) + QUADS(abs)(s.z);
    const quads area = side * QUADS(all)(gamma) * (reach + side);
    found.t_bound = area * side;
    found.bound = area * repeated(&q->longest[first]);
    return found;
}

/* What float says about the triangles of pairs, a bit for each. */
typedef struct verdict {
    uint32_t may;   /* may be hit, at t_max or before */
    uint32_t hits;  /* of these are certainly hit, at a t between near and far */
    uint32_t close; /* of these are hit unless they are behind the origin */
    uint32_t back;
    float near[4 * pairs_at_once], far[4 * pairs_at_once];
} verdict;

RK_INLINE void test_quads(verdict *found, const pairs *q, uint32_t first)
{
    const determinants d = determinants_of(q, first);
    const quads bound = d.bound, half_w = d.w * QUADS(all)(part_of_w);
    const quads lowest = QUADS(min)(d.u, QUADS(min)(d.v, half_w));
    const quads highest = QUADS(max)(d.u, QUADS(max)(d.v, half_w));
    const uint32_t all = (1u << 4 * pairs_at_once) - 1;
    found->hits = found->close = found->back = 0;
    found->may = all & ~(QUADS(lt)(lowest, -bound) & QUADS(lt)(bound, highest));
    if (!found->may)
        return;
    const uint32_t front = QUADS(lt)(bound, lowest), inside = front | QUADS(lt)(highest, -bound);
    const quads det = QUADS(abs)(d.det);
    const quads t = (quads)((quads_bits)d.t ^ ((quads_bits)d.det & INT32_MIN));
    const quads near = (t - d.t_bound) / (det + bound) * QUADS(all)(below_1);
    const quads far = (t + d.t_bound) / (det - bound) * QUADS(all)(above_1);
    found->may &=
        ~(inside & (QUADS(lt)(t, -d.t_bound) | QUADS(lt)(repeated(&q->far[first]), near)));
    found->hits = found->may & inside & QUADS(lt)(QUADS(all)(least_t), near);
    found->close = found->may & inside & ~found->hits;
    found->back = ~front;
    memcpy(found->near, &near, sizeof near);
    memcpy(found->far, &far, sizeof far);
}

RK_INLINE void take_hit(packet *p, query kind, const rk_wide_bvh *wide, uint32_t place,
                        uint32_t lane, const verdict *found, uint32_t at)
{
    const bool is_hit = found->hits >> at & 1;
    const float near = found->near[at], far = found->far[at];
    if (kind == OCCLUSION) {
        if (is_hit && far <= p->far[lane])
            p->active &= ~(1u << lane);
        else
            decide_lane(p, kind, wide, place, lane);
    } else if (is_hit && far < p->near[lane]) {
        const best_hit best = {.near = near, .far = far, .place = place};
        set_lane_best(p, lane, &best);
    } else if (!is_hit || near <= p->far[lane]) {
        decide_lane(p, kind, wide, place, lane);
    }
}

RK_INLINE void judge_pair(const pairs *q, query kind, const rk_wide_bvh *wide, uint32_t pair,
                          const verdict *found, uint32_t shift)
{
    packet *p = q->packet[pair];
    const rk_wide_block *block = q->block[pair];
    const uint32_t lane = q->lane[pair], close = found->close >> shift & 15;
    uint32_t may = found->may >> shift & taken_places(block);
    if (close) {
        const rk_ray ray = rk_batch_ray(p->rays, p->first + lane);
        may &= ~(close & behind_in_double(&ray, block, found->back >> shift));
    }
    while (may && p->active >> lane & 1) {
        const uint32_t i = next_bit(&may);
        take_hit(p, kind, wide, place_of(wide, block, i), lane, found, shift + i);
    }
}

RK_INLINE void add_pair(pairs *q, packet *p, uint32_t lane, const rk_wide_block *block)
{
    const uint32_t i = q->count++, at = p->first + lane;
    const rk_ray_batch *rays = p->rays;
    q->packet[i] = p;
    q->block[i] = block;
    q->lane[i] = lane;
    q->origin[0][i] = rays->origin_x[at];
    q->origin[1][i] = rays->origin_y[at];
    q->origin[2][i] = rays->origin_z[at];
    q->direction[0][i] = rays->direction_x[at];
    q->direction[1][i] = rays->direction_y[at];
    q->direction[2][i] = rays->direction_z[at];
    q->longest[i] = p->longest;
    q->edge[i] = block->edge;
    q->far[i] = p->far[lane];
}

/* Registers are filled up with numbers of other pairs; what is found there counts for nothing. */
RK_INLINE void test_pairs(pairs *q, query kind, const rk_wide_bvh *wide)
{
    const uint32_t count = q->count;
    while (q->count % pairs_at_once && q->count >= q->filled)
        add_pair(q, q->packet[count - 1], q->lane[count - 1], q->block[count - 1]);
    q->filled = q->count > q->filled ? q->count : q->filled;
    for (uint32_t i = q->count; i % pairs_at_once; i++)
        q->block[i] = q->block[count - 1];
    for (uint32_t first = 0; first < count; first += pairs_at_once) {
        verdict found;
        test_quads(&found, q, first);
        for (uint32_t i = 0; found.may >> 4 * i && first + i < count; i++)
            if (found.may >> 4 * i & 15)
                judge_pair(q, kind, wide, first + i, &found, 4 * i);
    }
    q->count = 0;
}

/* Tests many rays at once; few become pairs, for test_pairs. */
RK_INLINE void visit_leaf(packet *p, query kind, const rk_wide_bvh *wide, uint32_t leaf,
                          uint32_t lanes, pairs *q)
{
    const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(leaf)];
    const uint32_t count = rk_wide_leaf_count(leaf);
    for (uint32_t k = 0; k < count; k++) {
        lanes &= p->active;
        if (__builtin_popcount(lanes) > few_lanes) {
            lanes_in_block(p, kind, wide, &block[k], lanes);
            continue;
        }
        for (uint32_t left = lanes; left;)
            add_pair(q, p, next_bit(&left), &block[k]);
        if (q->count > pairs_max - few_lanes)
            test_pairs(q, kind, wide);
    }
}

#endif
