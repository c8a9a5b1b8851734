/* The traversal of a student's wide_bvh in the place of a kernel (accel/kernel/wide_kernel.h):
 * batches are traced ray by ray. */
#include "accel/kernel/wide_kernel.h"
#include "features/wide_bvh.h"

static void closest_one_by_one(const rk_wide_bvh *wide, const rk_ray_batch *rays,
                               rk_hit_batch *hits, rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_wide_bvh_closest(wide, &ray, counters);
        rk_batch_put_hit(hits, i, &hit);
    }
}

static void occluded_one_by_one(const rk_wide_bvh *wide, const rk_ray_batch *rays,
                                rk_occlusion_batch *answers, rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->occluded[i] = rk_wide_bvh_occluded(wide, &ray, counters);
    }
}

static void leaves_in_plain_c(const rk_wide_bvh *wide, const rk_ray *ray, rk_leaf_visitor *visitor,
                              rk_counters *counters)
{
    rk_wide_kernel_scalar()->visit_leaves(wide, ray, visitor, counters);
}

const rk_wide_kernel *rk_wide_kernel_plain(void)
{
    static const rk_wide_kernel kernel = {"scalar", closest_one_by_one, occluded_one_by_one,
                                          leaves_in_plain_c};
    return &kernel;
}
