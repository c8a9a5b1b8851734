/* Counts calls of malloc and related functions, and what of it is not freed yet: by wrapping
 * glibc's malloc, or by the sanitizer's hook (which gcc and clang announce differently). Lets them
 * fail: wrapped ones do; units that a grader builds call the scarce ones below in their place. A
 * separate file, because it must be built like the program in which it counts, with sanitizers or
 * without. */
#include "judge_hooks.h"
#include "test.h"

#include <stdatomic.h>
#include <stdint.h>

_Atomic size_t rk_allocations, rk_allocations_kept;

_Atomic size_t rk_allocations_left = SIZE_MAX;
_Atomic bool rk_one_allocation_fails;

static bool is_left(void)
{
    size_t left = rk_allocations_left;
    while (left > 0)
        if (left == SIZE_MAX || atomic_compare_exchange_weak(&rk_allocations_left, &left, left - 1))
            return true;
    if (rk_one_allocation_fails)
        rk_allocations_left = SIZE_MAX;
    return false;
}

#ifdef RK_SANITIZED
void __sanitizer_malloc_hook(const volatile void *memory, size_t size);
void __sanitizer_malloc_hook(const volatile void *memory, size_t size)
{
    (void)memory, (void)size;
    rk_allocations++;
    rk_allocations_kept++;
}

void __sanitizer_free_hook(const volatile void *memory);
void __sanitizer_free_hook(const volatile void *memory)
{
    if (rk_judge_forget)
        rk_judge_forget((const void *)memory);
    rk_allocations_kept -= memory != NULL;
}

const bool rk_allocations_are_counted = true;
#define is_left_here is_left()
#elif defined(__GLIBC__)
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void *memory);

static void *counted(void *memory)
{
    rk_allocations++;
    rk_allocations_kept += memory != NULL;
    return memory;
}

void *malloc(size_t size)
{
    return is_left() ? counted(__libc_malloc(size)) : NULL;
}

void *calloc(size_t count, size_t size)
{
    return is_left() ? counted(__libc_calloc(count, size)) : NULL;
}

void *realloc(void *old, size_t size)
{
    if (!is_left())
        return NULL;
    if (rk_judge_forget)
        rk_judge_forget(old);
    rk_allocations++;
    rk_allocations_kept += old == NULL;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return is_left() ? counted(__libc_memalign(alignment, size)) : NULL;
}

void free(void *memory)
{
    if (rk_judge_forget)
        rk_judge_forget(memory);
    rk_allocations_kept -= memory != NULL;
    __libc_free(memory);
}

const bool rk_allocations_are_counted = true;
#define is_left_here true
#else
const bool rk_allocations_are_counted = false;
#define is_left_here is_left()
#endif

void *rk_scarce_malloc(size_t size)
{
    return is_left_here ? malloc(size) : NULL;
}

void *rk_scarce_calloc(size_t count, size_t size)
{
    return is_left_here ? calloc(count, size) : NULL;
}

void *rk_scarce_realloc(void *old, size_t size)
{
    return is_left_here ? realloc(old, size) : NULL;
}

void *rk_scarce_aligned_alloc(size_t alignment, size_t size)
{
    return is_left_here ? aligned_alloc(alignment, size) : NULL;
}
