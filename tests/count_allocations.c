/* Counts calls of malloc and related functions: by wrapping glibc's malloc, or by the sanitizer's
 * hook (which gcc and clang announce differently). A separate file, because it must be built like
 * the program in which it counts, with sanitizers or without. */
#include "test.h"

size_t rk_allocations;

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RK_MALLOC_HAS_HOOK
#endif
#endif
#if defined(RK_MALLOC_HAS_HOOK) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
void __sanitizer_malloc_hook(const volatile void *memory, size_t size);
void __sanitizer_malloc_hook(const volatile void *memory, size_t size)
{
    (void)memory, (void)size;
    rk_allocations++;
}
const bool rk_allocations_are_counted = true;
#elif defined(__GLIBC__)
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size)
{
    rk_allocations++;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    rk_allocations++;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    rk_allocations++;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    rk_allocations++;
    return __libc_memalign(alignment, size);
}
const bool rk_allocations_are_counted = true;
#else
const bool rk_allocations_are_counted = false;
#endif
