/* Single rays through the wide tree. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_SINGLE_H
#define RK_ACCEL_KERNEL_WIDE_SINGLE_H

#include "accel/kernel/wide_boxes.h"
#include "accel/kernel/wide_hits.h"

RK_INLINE shaft shaft_of_ray(const rk_ray *ray)
{
    const rk_slabs slabs = rk_slabs_of(ray);
    return (shaft){.near_origin = slabs.origin4,
                   .near_inverse = slabs.inverse_near,
                   .far_origin = slabs.origin4,
                   .far_inverse = slabs.inverse_far,
                   .signs = rk_simd4_movemask(slabs.is_backward) & 7};
}

/* Tests triangles one by one, by features/watertight.h alone: for numbers so large or so small that
 * products could overflow, for a direction of 0, and for NaN. */
static __attribute__((noinline)) rk_hit trace_carefully(const rk_wide_bvh *wide, const rk_ray *ray,
                                                        work *done)
{
    const shaft s = shaft_of_ray(ray);
    best_hit best = {.near = ray->t_max, .far = ray->t_max, .triangle = RK_MISS};
    child_stack stack;
    start_stack(&stack);
    for (uint32_t child = 0; child != no_child; child = pop(&stack)) {
        if (!(child & RK_WIDE_LEAF)) {
            push_children(&stack, &s, wide, child, best.far, false);
            done->nodes++;
            continue;
        }
        const uint32_t first = rk_wide_leaf_first(child), count = rk_wide_leaf_count(child);
        for (uint32_t i = 0; i < count * RK_WIDE_BLOCK; i++)
            decide_exactly(&best, wide, first * RK_WIDE_BLOCK + i, ray);
        drop_farther(&stack, best.far, false);
        done->blocks += count;
    }
    return final_hit(&best, wide, ray);
}

#endif
