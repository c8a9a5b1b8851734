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

/* Names come from files, and would act on a terminal. In UTF-8, those from 0x80 on have two bytes.
 */
static bool is_control(const char *from, size_t at)
{
    const unsigned char c = (unsigned char)from[at], next = (unsigned char)from[at + 1];
    const unsigned char before = at > 0 ? (unsigned char)from[at - 1] : 0;
    return (c < 0x20 && c != '\t') || c == 0x7f || (c == 0xc2 && next >= 0x80 && next < 0xa0) ||
           (before == 0xc2 && c >= 0x80 && c < 0xa0);
}

/* Line breaks become spaces. */
static void copy_printable(char *to, size_t room, const char *from)
{
    for (size_t at = 0; from[at] && room > 1; at++) {
        const bool is_break = from[at] == '\n' || from[at] == '\r';
        if (is_break || !is_control(from, at)) {
            *to++ = is_break ? ' ' : from[at];
            room--;
            continue;
        }
        if (room <= 4)
            break;
        snprintf(to, room, "\\x%02x", (unsigned)(unsigned char)from[at]);
        to += 4;
        room -= 4;
    }
    *to = '\0';
}

bool rk_fail(rk_error *error, const char *format, ...)
{
    if (error) {
        char text[sizeof error->text];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        copy_printable(error->text, sizeof error->text, text);
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
