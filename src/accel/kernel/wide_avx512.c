/* Registers of sixteen floats (accel/kernel/wide_kernel.h). */
#include "accel/kernel/wide_kernel.h"

#if defined __AVX512VL__ && defined __AVX512DQ__ && defined __AVX512BW__
#include "accel/kernel/wide_trace.h"

static const rk_wide_kernel kernel = {RK_SIMD_ISA, closest_of_batch, occluded_of_batch,
                                      visit_leaves};
const rk_wide_kernel *rk_wide_kernel_avx512(void)
{
    return &kernel;
}
#else
const rk_wide_kernel *rk_wide_kernel_avx512(void)
{
    return NULL;
}
#endif
