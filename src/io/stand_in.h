/* Stand-ins for a file: a text of three lines, if Git LFS has not fetched it yet, or
 * the web page about it; not installed. Format: Git LFS specification, "The Pointer". */
#ifndef RK_IO_STAND_IN_H
#define RK_IO_STAND_IN_H

#include "base/error.h"

#include <stdbool.h>
#include <string.h>
#include <strings.h>

enum { RK_STAND_IN_MARK = 24 };

static inline bool rk_stand_in_is_page(const char *first, size_t size)
{
    static const char *const begins[] = {"<!doctype html", "<html>", "<html "};
    size_t at = size >= 3 && memcmp(first, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (at < size && first[at] && strchr(" \t\r\n", first[at]))
        at++;
    for (int i = 0; i < 3; i++)
        if (size - at >= strlen(begins[i]) &&
            strncasecmp(first + at, begins[i], strlen(begins[i])) == 0)
            return true;
    return false;
}

/* False with an error if the file, of which these are the first bytes, is one of them. */
static inline bool rk_stand_in_check(const char *path, const void *first, size_t size,
                                     rk_error *error)
{
    static const char pointer[] = "version https://git-lfs.";
    if (size >= sizeof pointer - 1 && memcmp(first, pointer, sizeof pointer - 1) == 0)
        return rk_fail(error, "%s: is a Git LFS pointer, not the file: run git lfs pull", path);
    return !rk_stand_in_is_page(first, size) ||
           rk_fail(error, "%s: is a web page, not the file: download the file itself", path);
}

#endif
