/* Messages are one line each. Memory is aligned to cache lines; large blocks are on huge pages
 * where the system has them. */
#define _DEFAULT_SOURCE /* madvise */
#include "base/error.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { cache_line = 64, huge_page = 2 << 20 };

/* A tree of many megabytes is read all over: on pages of 4 KB each visit would wait for the
 * address, too. */
static void *allocate_pages(size_t bytes)
{
    void *memory = aligned_alloc(huge_page, (bytes + huge_page - 1) / huge_page * huge_page);
#ifdef MADV_HUGEPAGE
    if (memory)
        madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
#endif
    return memory;
}

bool rk_fail(rk_error *error, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(error->text, sizeof error->text, format, arguments);
        va_end(arguments);
        for (char *c = error->text; *c; c++)
            if (*c == '\n' || *c == '\r')
                *c = ' ';
    }
    return false;
}

/* Weak, so that a suite can let memory run out (tests/short_memory.h). */
__attribute__((weak)) void *rk_allocate_unset(size_t count, size_t size, const char *what,
                                              rk_error *error)
{
    if (size && count > (SIZE_MAX - cache_line) / size) {
        rk_fail(error,
                "%s: %zu elements of %zu bytes are more than this machine can address: choose a "
                "smaller size",
                what, count, size);
        return NULL;
    }
    size_t bytes = (count * size + cache_line - 1) / cache_line * cache_line;
    if (bytes == 0)
        bytes = cache_line;
    void *memory = bytes < 2 * huge_page ? aligned_alloc(cache_line, bytes) : allocate_pages(bytes);
    if (!memory) {
        rk_fail(error, "%s: no memory for %.1f MB: choose a smaller size, or close other programs",
                what, (double)bytes / 1e6);
        return NULL;
    }
    return memory;
}

void *rk_allocate(size_t count, size_t size, const char *what, rk_error *error)
{
    void *memory = rk_allocate_unset(count, size, what, error);
    return memory ? memset(memory, 0, count * size) : NULL;
}
