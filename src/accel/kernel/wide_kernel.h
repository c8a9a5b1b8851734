/* Batches of rays through the wide tree, by the widest instructions of the machine. The same source
 * (accel/kernel/wide_trace.h) is compiled for each instruction set, and one is chosen when a
 * program runs; all find the same hits to the bit. Not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_KERNEL_H
#define RK_ACCEL_KERNEL_WIDE_KERNEL_H

#include "accel/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "scene/wide_tree.h"

/* What is done in the leaves of a tree that a ray enters. */
typedef struct rk_leaf_visitor rk_leaf_visitor;

struct rk_leaf_visitor {
    /* Sees the triangles of a leaf; may lower `end`. */
    void (*visit)(rk_leaf_visitor *visitor, const rk_triangle *triangles, uint32_t count);
    float end; /* of the ray: leaves that it enters beyond are left out */
};

typedef struct rk_wide_kernel {
    const char *isa;
    void (*closest)(const rk_wide_bvh *wide, const rk_ray_batch *rays, rk_hit_batch *hits,
                    rk_counters *counters);
    void (*occluded)(const rk_wide_bvh *wide, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                     rk_counters *counters);
    /* See rk_tree_visit_leaves. */
    void (*visit_leaves)(const rk_wide_bvh *wide, const rk_ray *ray, rk_leaf_visitor *visitor,
                         rk_counters *counters);
} rk_wide_kernel;

/* One ray after the other by features/wide_bvh.h: the readable traversal, for RK_ACCEL_COLLAPSED.
 */
const rk_wide_kernel *rk_wide_kernel_plain(void);

/* NULL where the compiler does not know the instruction set, or configure left it out. */
const rk_wide_kernel *rk_wide_kernel_scalar(void);
const rk_wide_kernel *rk_wide_kernel_sse2(void);
const rk_wide_kernel *rk_wide_kernel_avx2(void);
const rk_wide_kernel *rk_wide_kernel_avx512(void);

/* The kernel by its name; NULL, with the error, if there is none of this name or the machine lacks
 * the instructions. */
const rk_wide_kernel *rk_wide_kernel_named(const char *isa, rk_error *error);

/* The one that RAYKIT_ISA names, else the fastest that the machine has. NULL as above. */
const rk_wide_kernel *rk_wide_kernel_chosen(rk_error *error);

/* The same; a wrong RAYKIT_ISA counts as none. */
const rk_wide_kernel *rk_wide_kernel_best(void);

#endif
