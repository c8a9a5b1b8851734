#include "base/file.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool rk_file_begin(rk_file *file, const char *path, rk_error *error)
{
    *file = (rk_file){0};
    if (strlen(path) >= sizeof file->path)
        return rk_fail(error, "%.60s...: the path is longer than %zu bytes", path,
                       sizeof file->path - 1);
    struct stat status;
    bool exists = stat(path, &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        return rk_fail(error, "%s: is a folder; name a file in it", path);
    /* Renaming would put a plain file in the place of /dev/null or of a pipe. */
    if (exists && !S_ISREG(status.st_mode))
        return rk_fail(error, "%s: is a device or a pipe; name a file", path);
    snprintf(file->path, sizeof file->path, "%s", path);
    snprintf(file->temporary, sizeof file->temporary, "%s.part-%ld", path, (long)getpid());
    file->stream = fopen(file->temporary, "wb");
    if (!file->stream)
        return rk_fail(
            error, "%s: cannot be written: %s; choose a folder that is there and may be written to",
            path, strerror(errno));
    return true;
}

bool rk_file_commit(rk_file *file, rk_error *error)
{
    errno = 0;
    bool written = !ferror(file->stream) && fflush(file->stream) == 0;
    int reason = errno;
    bool closed = fclose(file->stream) == 0;
    file->stream = NULL;
    if (written && !closed)
        reason = errno;
    if (written && closed) {
        if (rename(file->temporary, file->path) == 0)
            return true;
        reason = errno;
    }
    unlink(file->temporary);
    return rk_fail(error,
                   "%s: could not be written whole: %s; free some space, or choose another place",
                   file->path, reason ? strerror(reason) : "write error");
}

void rk_file_abort(rk_file *file)
{
    if (file->stream) {
        fclose(file->stream);
        unlink(file->temporary);
        file->stream = NULL;
    }
}

bool rk_make_folder(const char *path, rk_error *error)
{
    char partial[4096];
    size_t length = strlen(path);
    if (length == 0 || length >= sizeof partial)
        return rk_fail(error, "%.60s: not a usable folder name", path);
    for (size_t i = 1; i <= length; i++) {
        if (path[i] != '/' && path[i] != '\0')
            continue;
        memcpy(partial, path, i);
        partial[i] = '\0';
        if (mkdir(partial, 0777) != 0 && errno != EEXIST)
            return rk_fail(error, "%s: the folder cannot be made: %s; choose another with --out",
                           partial, strerror(errno));
    }
    struct stat status;
    if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode))
        return rk_fail(error, "%s: is a file, not a folder; choose another with --out", path);
    return true;
}
