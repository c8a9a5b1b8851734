/* Whole files or none: output goes to a temporary file beside its destination, which is renamed
 * when everything, including closing, has succeeded. Where the file system supports files without a
 * name, the temporary name is given only to the complete file, so a process that dies before leaves
 * nothing. */
#ifndef RK_BASE_FILE_H
#define RK_BASE_FILE_H

#include "base/error.h"

#include <stdio.h>

typedef struct rk_file {
    FILE *stream; /* where to write; NULL when not open */
    char path[4096];
    char temporary[4096 + 32];
    bool unnamed; /* the temporary file has no name yet */
} rk_file;

/* Opens a temporary file for `path`. False with an error when the folder is missing or read-only.
 */
bool rk_file_begin(rk_file *file, const char *path, rk_error *error);

/* Flushes, closes and renames. On failure (a full disk, a lost folder) nothing is left behind, an
 * older file at `path` is untouched, and the error gives the reason. */
bool rk_file_commit(rk_file *file, rk_error *error);

/* Closes the temporary file and removes it; accepts a file that is not open. */
void rk_file_abort(rk_file *file);

/* Makes `path` and its missing parents. An existing folder is success. */
bool rk_file_make_folder(const char *path, rk_error *error);

#endif
