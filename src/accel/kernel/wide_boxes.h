/* Boxes of the wide tree, eight at a time, tested against a ray or against a shaft that contains
 * several (Haines and Wallace, "Shaft culling for efficient ray-cast radiosity", 1991). Included by
 * one file for each instruction set (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_BOXES_H
#define RK_ACCEL_KERNEL_WIDE_BOXES_H

#include "base/simd.h"
#include "scene/wide_tree.h"

#include <stdbool.h>

/* Of a tree, for all rays: its box, and the largest size of a coordinate on each axis. */
typedef struct tree_extent {
    rk_simd4 low, high, size;
} tree_extent;

RK_INLINE tree_extent extent_of(const rk_wide_bvh *wide)
{
    tree_extent e = {.low = rk_simd4_of(wide->box.corner[0]),
                     .high = rk_simd4_of(wide->box.corner[1])};
    e.size = rk_simd4_max(rk_simd4_abs(e.low), rk_simd4_abs(e.high));
    return e;
}

/* On each axis a near plane is hit at (plane - near_origin) near_inverse or later, and a far plane
 * at (plane - far_origin) far_inverse or earlier; see rk_slabs. The fourth numbers have no meaning.
 */
typedef struct shaft {
    rk_simd4 near_origin, near_inverse, far_origin, far_inverse;
    uint32_t signs; /* see rk_wide_node */
} shaft;

/* Planes are hit at distances divided by `fast` and `slow`. The reciprocals are pushed apart by
 * more than all roundings. */
RK_INLINE void set_speeds(shaft *s, rk_simd4 fast, rk_simd4 slow)
{
    const rk_simd4 one = rk_simd4_all(1);
    s->near_inverse = one / fast * rk_simd4_all(1 - 0x1p-21f);
    s->far_inverse = one / slow * rk_simd4_all(1 + 0x1p-21f);
}

/* Places of the near and of the far sides within a node, by the signs of directions. */
typedef struct side_places {
    uint32_t near[3], far[3];
} side_places;

#define SIDE(axis, is_high) ((axis) + ((is_high) ? 3 : 0)) * RK_WIDE_CHILDREN
#define SIDES(x, y, z)                                                                             \
    {                                                                                              \
        {SIDE(0, x), SIDE(1, y), SIDE(2, z)},                                                      \
        {                                                                                          \
            SIDE(0, !(x)), SIDE(1, !(y)), SIDE(2, !(z))                                            \
        }                                                                                          \
    }

static const side_places sides_of_signs[8] = {SIDES(0, 0, 0), SIDES(1, 0, 0), SIDES(0, 1, 0),
                                              SIDES(1, 1, 0), SIDES(0, 0, 1), SIDES(1, 0, 1),
                                              SIDES(0, 1, 1), SIDES(1, 1, 1)};

/* No leaf has so many blocks. Like every leaf it is fetched in advance, so there must be a block.
 */
static const uint32_t no_child = RK_WIDE_LEAF | 31u << RK_WIDE_BLOCK_BITS;

enum { stack_room = 1 + RK_WIDE_STACK_MAX + RK_WIDE_CHILDREN };

/* Children to visit, where they are entered, and where their boxes are: 8 node + place. Those to
 * visit first are last; the first one is no child. */
typedef struct child_stack {
    uint32_t size;
    float enter[stack_room];
    uint32_t child[stack_room], box[stack_room];
} child_stack;

RK_INLINE void start_stack(child_stack *stack)
{
    stack->size = 1;
    stack->enter[0] = 0;
    stack->child[0] = no_child;
    stack->box[0] = 0;
}

/* No child when none is left, but only once. */
RK_INLINE uint32_t pop(child_stack *stack)
{
    return stack->child[--stack->size];
}

#if defined __AVX2__ && !defined RK_SIMD_SCALAR
#define RK_SIMD_PERMUTES

/* Eight numbers of four bits each, the lowest first; three of them count. */
RK_INLINE __m256i from_nibbles(uint32_t nibbles)
{
    const __m256i places = _mm256_srlv_epi32(_mm256_set1_epi32((int)nibbles),
                                             _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
    return _mm256_and_si256(places, _mm256_set1_epi32(RK_WIDE_CHILDREN - 1));
}

RK_INLINE rk_f8 permuted(rk_f8 a, __m256i places)
{
    return (rk_f8){{_mm256_permutevar8x32_ps(a.part[0], places)}};
}

/* The numbers of the lanes that are set in the mask, without gaps. */
#ifdef __AVX512VL__
RK_INLINE __m256i packed(__m256i numbers, uint32_t mask)
{
    return _mm256_maskz_compress_epi32((__mmask8)mask, numbers);
}
#else
#define COUNT(m)                                                                                   \
    (((m) >> 0 & 1) + ((m) >> 1 & 1) + ((m) >> 2 & 1) + ((m) >> 3 & 1) + ((m) >> 4 & 1) +          \
     ((m) >> 5 & 1) + ((m) >> 6 & 1))
#define PUT(m, i) (((m) >> (i)&1u) * ((i) << 4 * COUNT((m) & ((1u << (i)) - 1))))
#define PLACES(m)                                                                                  \
    (PUT(m, 0u) | PUT(m, 1u) | PUT(m, 2u) | PUT(m, 3u) | PUT(m, 4u) | PUT(m, 5u) | PUT(m, 6u) |    \
     PUT(m, 7u))
#define PLACES4(m) PLACES(m), PLACES(m + 1u), PLACES(m + 2u), PLACES(m + 3u)
#define PLACES16(m) PLACES4(m), PLACES4(m + 4u), PLACES4(m + 8u), PLACES4(m + 12u)
#define PLACES64(m) PLACES16(m), PLACES16(m + 16u), PLACES16(m + 32u), PLACES16(m + 48u)

/* For each mask, the places of its bits: four bits for each place, the lowest first. */
static const uint32_t places_of_bits[256] = {PLACES64(0u), PLACES64(64u), PLACES64(128u),
                                             PLACES64(192u)};

RK_INLINE __m256i packed(__m256i numbers, uint32_t mask)
{
    return _mm256_permutevar8x32_epi32(numbers, from_nibbles(places_of_bits[mask]));
}
#endif
#endif

/* Drops the children that are entered beyond t_max. That is done when a hit is found, which is
 * rare; when a child is popped, the test would be one that no processor predicts. The first one
 * stays. */
RK_INLINE void drop_farther(child_stack *stack, float t_max, bool with_boxes)
{
    uint32_t left = 0;
#ifdef RK_SIMD_PERMUTES
    const __m256i every = from_nibbles(0x76543210);
    for (uint32_t i = 0; i < stack->size; i += RK_WIDE_CHILDREN) {
        const rk_f8 enter = rk_f8_load(&stack->enter[i]);
        const __m256i child = _mm256_loadu_si256((const void *)&stack->child[i]);
        const __m256i box = _mm256_loadu_si256((const void *)&stack->box[i]);
        const uint32_t there = stack->size - i < 8 ? (1u << (stack->size - i)) - 1 : 0xff;
        const uint32_t nearer = (there & rk_f8_le(enter, rk_f8_all(t_max))) | (i == 0);
        const __m256i chosen = packed(every, nearer);
        rk_f8_store(&stack->enter[left], permuted(enter, chosen));
        _mm256_storeu_si256((void *)&stack->child[left],
                            _mm256_permutevar8x32_epi32(child, chosen));
        if (with_boxes)
            _mm256_storeu_si256((void *)&stack->box[left],
                                _mm256_permutevar8x32_epi32(box, chosen));
        left += (uint32_t)__builtin_popcount(nearer);
    }
#else
    for (uint32_t i = 0; i < stack->size; i++) {
        const bool is_nearer = stack->enter[i] <= t_max || i == 0;
        stack->enter[left] = stack->enter[i];
        stack->child[left] = stack->child[i];
        if (with_boxes)
            stack->box[left] = stack->box[i];
        left += is_nearer;
    }
#endif
    stack->size = left;
}

/* Pushes the children that are entered at t_max or before, in the order in which they are likely to
 * be hit. Returns their number. */
RK_INLINE uint32_t push_children(child_stack *stack, const shaft *s, const rk_wide_bvh *wide,
                                 uint32_t index, float t_max, bool with_boxes)
{
    const rk_wide_node *node = &wide->nodes[index];
    const side_places *at = &sides_of_signs[s->signs];
    const float *sides = &node->side[0][0][0];
    rk_f8 enter = rk_f8_all(0), leave = rk_f8_all(t_max);
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
        rk_f8 near = rk_f8_sub(rk_f8_load(&sides[at->near[k]]), rk_f8_all(s->near_origin[k]));
        rk_f8 far = rk_f8_sub(rk_f8_load(&sides[at->far[k]]), rk_f8_all(s->far_origin[k]));
        enter = rk_f8_max(rk_f8_mul(near, rk_f8_all(s->near_inverse[k])), enter);
        leave = rk_f8_min(rk_f8_mul(far, rk_f8_all(s->far_inverse[k])), leave);
    }
    const uint32_t before = stack->size;
    uint32_t order = node->order[s->signs];
#ifdef RK_SIMD_PERMUTES
    const __m256i places = from_nibbles(order), mine = _mm256_set1_epi32((int)(8 * index));
    const __m256i child = _mm256_loadu_si256((const void *)node->child);
    const uint32_t entered = rk_f8_le(permuted(enter, places), permuted(leave, places));
    const __m256i chosen = packed(places, entered);
    rk_f8_store(&stack->enter[before], permuted(enter, chosen));
    _mm256_storeu_si256((void *)&stack->child[before], _mm256_permutevar8x32_epi32(child, chosen));
    if (with_boxes)
        _mm256_storeu_si256((void *)&stack->box[before], _mm256_add_epi32(chosen, mine));
    stack->size += (uint32_t)__builtin_popcount(entered);
#else
    uint32_t entered = rk_f8_le(enter, leave);
    float enter_at[RK_WIDE_CHILDREN];
    rk_f8_store(enter_at, enter);
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++, order >>= 4) {
        const uint32_t place = order & 7;
        stack->enter[stack->size] = enter_at[place];
        stack->child[stack->size] = node->child[place];
        if (with_boxes)
            stack->box[stack->size] = index * RK_WIDE_CHILDREN + place;
        stack->size += entered >> place & 1;
    }
#endif
    return stack->size - before;
}

/* Asks for the memory of a node or a leaf, which is there when it is its turn. */
RK_INLINE void fetch(const rk_wide_bvh *wide, uint32_t child)
{
    const uintptr_t node = (uintptr_t)wide->nodes + sizeof(rk_wide_node) * (uintptr_t)child;
    const uintptr_t block =
        (uintptr_t)wide->blocks + sizeof(rk_wide_block) * (uintptr_t)rk_wide_leaf_first(child);
    const uintptr_t is_leaf =
        (uintptr_t)0 - (child / RK_WIDE_LEAF); /* all bits; no branch guesses well */
    const char *from = (const char *)(node ^ ((node ^ block) & is_leaf));
    __builtin_prefetch(from);
    __builtin_prefetch(from + 64);
    __builtin_prefetch(from + 128);
    __builtin_prefetch(from + 192);
}

#endif
