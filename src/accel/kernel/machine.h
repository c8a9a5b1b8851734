/* Which instruction sets with a kernel (accel/kernel/wide_kernel.h) this machine has besides those
 * of its whole family. configure asks, too; not installed. */
#ifndef RK_ACCEL_KERNEL_MACHINE_H
#define RK_ACCEL_KERNEL_MACHINE_H

#if defined __x86_64__ || defined __i386__
static inline _Bool rk_machine_has_avx2(void)
{
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

static inline _Bool rk_machine_has_avx512(void)
{
    return rk_machine_has_avx2() && __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw");
}
#else
static inline _Bool rk_machine_has_avx2(void)
{
    return 0;
}

static inline _Bool rk_machine_has_avx512(void)
{
    return 0;
}
#endif

#endif
