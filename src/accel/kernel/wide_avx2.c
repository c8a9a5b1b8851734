/* Registers of eight floats (accel/kernel/wide_kernel.h). */
#include "accel/kernel/wide_kernel.h"

#if defined __AVX2__
#include "accel/kernel/wide_trace.h"

static const rk_wide_kernel kernel = {RK_SIMD_ISA, closest_of_batch, occluded_of_batch,
                                      visit_leaves};
const rk_wide_kernel *rk_wide_kernel_avx2(void)
{
    return &kernel;
}
#else
const rk_wide_kernel *rk_wide_kernel_avx2(void)
{
    return NULL;
}
#endif
