/* Counts calls of malloc and related functions, and what of it is not freed yet: by wrapping
 * glibc's malloc, or by the sanitizer's hook (which gcc and clang announce differently). A separate
 * file, because it must be built like the program in which it counts, with sanitizers or without.
 */
#include "test.h"

size_t rk_allocations, rk_allocations_kept;

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
    rk_allocations_kept++;
}

void __sanitizer_free_hook(const volatile void *memory);
void __sanitizer_free_hook(const volatile void *memory)
{
    rk_allocations_kept -= memory != NULL;
}

const bool rk_allocations_are_counted = true;
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
    return counted(__libc_malloc(size));
}

void *calloc(size_t count, size_t size)
{
    return counted(__libc_calloc(count, size));
}

void *realloc(void *old, size_t size)
{
    rk_allocations++;
    rk_allocations_kept += old == NULL;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return counted(__libc_memalign(alignment, size));
}

void free(void *memory)
{
    rk_allocations_kept -= memory != NULL;
    __libc_free(memory);
}

const bool rk_allocations_are_counted = true;
#else
const bool rk_allocations_are_counted = false;
#endif
