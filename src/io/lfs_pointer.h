/* Git LFS leaves a text of three lines where it has not fetched a file yet; not installed. Format:
 * Git LFS specification, "The Pointer". */
#ifndef RK_IO_LFS_POINTER_H
#define RK_IO_LFS_POINTER_H

#include "base/error.h"

#include <stdbool.h>
#include <string.h>

enum { RK_LFS_POINTER_MARK = 24 };

/* False with an error if the file, of which these are the first bytes, is such a text. */
static inline bool rk_lfs_pointer_check(const char *path, const void *first, size_t size,
                                        rk_error *error)
{
    return size < RK_LFS_POINTER_MARK ||
           memcmp(first, "version https://git-lfs.", RK_LFS_POINTER_MARK) != 0 ||
           rk_fail(error, "%s: is a Git LFS pointer, not the file: run git lfs pull", path);
}

#endif
