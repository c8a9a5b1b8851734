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

/* Opens a temporary file for `path`, or for the file that it links to. False with an error when the
 * folder is missing or read-only, or the older file is. */
bool rk_file_begin(rk_file *file, const char *path, rk_error *error);

/* Flushes, closes and renames. On failure (a full disk, a lost folder) nothing is left behind, an
 * older file at `path` is untouched, and the error gives the reason. */
bool rk_file_commit(rk_file *file, rk_error *error);

/* Closes the temporary file and removes it; accepts a file that is not open. */
void rk_file_abort(rk_file *file);

/* The place where output for `path` goes: the file that it links to, if it is a symbolic link, even
 * if there is no such file yet. False with an error when that is a folder, a device or a pipe, or
 * must not be written. */
typedef struct rk_file_place {
    char text[4096];
} rk_file_place;

bool rk_file_destination(rk_file_place *place, const char *path, rk_error *error);

/* Waits until no other caller, in any process, holds the lock on the folder of `path`. Returns its
 * number for rk_file_unlock, or -1 where folders cannot be locked; nothing is left in the folder.
 */
int rk_file_lock_folder(const char *path);
void rk_file_unlock(int lock);

/* Makes `path` and its missing parents. An existing folder is success. */
bool rk_file_make_folder(const char *path, rk_error *error);

#endif
