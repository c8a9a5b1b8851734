/* Plain numbers, for any machine (accel/kernel/wide_kernel.h). */
#define RK_SIMD_SCALAR
#include "accel/kernel/wide_kernel.h"

#include "accel/kernel/wide_trace.h"

static const rk_wide_kernel kernel = {RK_SIMD_ISA, closest_of_batch, occluded_of_batch,
                                      visit_leaves};
const rk_wide_kernel *rk_wide_kernel_scalar(void)
{
    return &kernel;
}
