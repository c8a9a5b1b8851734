/* Keeps raykit-mesh within limits that grow with the bytes of the files that it reads, and gives a
 * reason when they are exceeded: a small file that takes gigabytes is damaged, or made to harm. */
#ifndef RK_IO_MESH_HELPER_MESH_GUARD_H
#define RK_IO_MESH_HELPER_MESH_GUARD_H

#include "base/error.h"

#include <sys/stat.h>

/* Limits this process: no memory and processor time beyond those for nothing, until
 * rk_mesh_guard_allow. Exceeded time and recursion without end write one line that begins with
 * `path`, and end the process with status 1. `path` must outlive it. */
void rk_mesh_guard_begin(const char *path);

/* Raises the limits by what a file of this size may take. A file counts once, however often it is
 * opened. */
void rk_mesh_guard_allow(const struct stat *file);

/* Fails with the reason for an allocation that failed; `uses` are the file's usemtl lines. */
bool rk_mesh_guard_fail_memory(size_t uses, rk_error *error);

#endif
