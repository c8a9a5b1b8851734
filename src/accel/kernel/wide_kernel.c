/* Chooses the kernel when a program runs: the fastest that both the processor and this build have,
 * or the one that RAYKIT_ISA names. */
#include "accel/kernel/wide_kernel.h"

#include "accel/kernel/machine.h"

#include <stdlib.h>
#include <string.h>

typedef struct choice {
    const char *isa;
    const rk_wide_kernel *(*kernel)(void);
    bool is_known; /* to the machine */
} choice;

enum { choices = 4 };

/* The fastest first. */
static const rk_wide_kernel *pick(const char *isa, bool *is_name)
{
    const choice all[choices] = {{"avx512", rk_wide_kernel_avx512, rk_machine_has_avx512()},
                                 {"avx2", rk_wide_kernel_avx2, rk_machine_has_avx2()},
                                 {"sse2", rk_wide_kernel_sse2, true},
                                 {"scalar", rk_wide_kernel_scalar, true}};
    *is_name = false;
    for (int i = 0; i < choices; i++) {
        if (isa && strcmp(isa, all[i].isa) != 0)
            continue;
        *is_name = true;
        if (all[i].is_known && all[i].kernel())
            return all[i].kernel();
    }
    return NULL;
}

const rk_wide_kernel *rk_wide_kernel_named(const char *isa, rk_error *error)
{
    bool is_name;
    const rk_wide_kernel *kernel = pick(isa, &is_name);
    if (isa && !is_name)
        rk_fail(error,
                "RAYKIT_ISA=%s: choose scalar, sse2, avx2 or avx512, or leave it unset for "
                "the fastest",
                isa);
    else if (isa && !kernel)
        rk_fail(error,
                "RAYKIT_ISA=%s: this machine or this build does not have it; leave "
                "RAYKIT_ISA unset for the fastest that it has",
                isa);
    return kernel;
}

const rk_wide_kernel *rk_wide_kernel_chosen(rk_error *error)
{
    const char *isa = getenv("RAYKIT_ISA");
    return rk_wide_kernel_named(isa && *isa ? isa : NULL, error);
}

const rk_wide_kernel *rk_wide_kernel_best(void)
{
    const rk_wide_kernel *kernel = rk_wide_kernel_chosen(NULL);
    return kernel ? kernel : rk_wide_kernel_named(NULL, NULL);
}
