/* Single rays through the wide tree, several at a time. One alone would wait at each step for
 * memory and for the results of comparisons; while it waits, the others' steps are done. First
 * those that are at a node, then those at a leaf, because a processor predicts branches well that
 * go the same way as before. Which list a ray goes to is decided without a branch. Included by one
 * file for each instruction set (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_FLIGHTS_H
#define RK_ACCEL_KERNEL_WIDE_FLIGHTS_H

#include "accel/kernel/wide_single.h"

enum { flights_max = 32 };

typedef struct flight {
    rk_ray ray;
    float longest;
    uint32_t index; /* in its batch */
    uint32_t child; /* to visit next, or no_child */
    bool is_occluded;
    shaft shaft;
    best_hit best;
    child_stack stack;
} flight;

/* Numbers of flights. */
typedef struct flight_list {
    uint32_t count;
    unsigned char at[flights_max];
} flight_list;

typedef struct flights {
    flight_list nodes, leaves; /* by what they visit next */
    flight_list ended;         /* in the last step */
    flight all[flights_max];
} flights;

/* A flight that has not begun: the ray below `child`, a node. */
RK_INLINE void start_flight(flights *flying, unsigned char at, const rk_ray *ray, float longest,
                            uint32_t child)
{
    flight *f = &flying->all[at];
    f->ray = *ray;
    f->longest = longest;
    f->child = child;
    f->is_occluded = false;
    f->shaft = shaft_of_ray(ray);
    f->best = (best_hit){.near = ray->t_max, .far = ray->t_max, .triangle = RK_MISS};
    start_stack(&f->stack);
    flying->nodes.at[flying->nodes.count++] = at;
}

RK_INLINE void leaf_step(flight *f, query kind, const rk_wide_bvh *wide, work *done)
{
    const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(f->child)];
    const uint32_t count = rk_wide_leaf_count(f->child);
    const float farthest = f->best.far;
    done->blocks += count;
    f->child = no_child;
    for (uint32_t k = 0; k < count; k++)
        if (kind == CLOSEST) {
            closest_in_block(&f->best, wide, &block[k], &f->ray, f->longest);
        } else if (block_occludes(wide, &block[k], &f->ray, f->longest)) {
            f->is_occluded = true;
            return;
        }
    if (f->best.far < farthest)
        drop_farther(&f->stack, f->best.far, false);
    f->child = pop(&f->stack);
}

/* Puts a flight on the list for its next child. */
RK_INLINE void put_in_list(flights *flying, unsigned char at)
{
    const uint32_t child = flying->all[at].child;
    const uint32_t is_end = child == no_child, is_leaf = child / RK_WIDE_LEAF;
    flying->nodes.at[flying->nodes.count] = at;
    flying->leaves.at[flying->leaves.count] = at;
    flying->ended.at[flying->ended.count] = at;
    flying->nodes.count += 1 - is_leaf;
    flying->leaves.count += is_leaf - is_end;
    flying->ended.count += is_end;
}

RK_INLINE bool step_of(flights *flying, query kind, const rk_wide_bvh *wide, work *done)
{
    const flight_list nodes = flying->nodes, leaves = flying->leaves;
    flying->nodes.count = flying->leaves.count = flying->ended.count = 0;
    done->nodes += nodes.count;
    for (uint32_t j = 0; j < nodes.count; j++) {
        flight *f = &flying->all[nodes.at[j]];
        push_children(&f->stack, &f->shaft, wide, f->child, f->best.far, false);
        f->child = pop(&f->stack);
        fetch(wide, f->child);
        put_in_list(flying, nodes.at[j]);
    }
    for (uint32_t j = 0; j < leaves.count; j++) {
        flight *f = &flying->all[leaves.at[j]];
        leaf_step(f, kind, wide, done);
        fetch(wide, f->child);
        put_in_list(flying, leaves.at[j]);
    }
    return nodes.count + leaves.count > 0;
}

static __attribute__((noinline)) bool step_closest(flights *flying, const rk_wide_bvh *wide,
                                                   work *done)
{
    return step_of(flying, CLOSEST, wide, done);
}

static __attribute__((noinline)) bool step_occlusion(flights *flying, const rk_wide_bvh *wide,
                                                     work *done)
{
    return step_of(flying, OCCLUSION, wide, done);
}

/* One step of each flight. Returns false if there was none. */
RK_INLINE bool step(flights *flying, query kind, const rk_wide_bvh *wide, work *done)
{
    return kind == CLOSEST ? step_closest(flying, wide, done) : step_occlusion(flying, wide, done);
}

#endif
