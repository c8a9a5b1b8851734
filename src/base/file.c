#define _GNU_SOURCE /* O_TMPFILE, of Linux */
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct short_path {
    char text[40];
} short_path;

static short_path descriptor_path(int descriptor)
{
    short_path path;
    snprintf(path.text, sizeof path.text, "/proc/self/fd/%d", descriptor);
    return path;
}

/* Opens a file without a name in the folder of file->path: if this process dies, so does the file.
 * NULL where the file system does not support that, or the file could not be named later because
 * the name is too long or /proc is missing. */
static FILE *open_unnamed(const rk_file *file)
{
    char folder[sizeof file->path];
    const char *slash = strrchr(file->path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - file->path) + 1 : 1,
             slash ? file->path : ".");
    if (access(file->temporary, F_OK) != 0 && errno != ENOENT)
        return NULL;
#ifdef O_TMPFILE
    int descriptor = open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
#else
    int descriptor = -1;
#endif
    if (descriptor < 0)
        return NULL;
    FILE *stream =
        access(descriptor_path(descriptor).text, F_OK) == 0 ? fdopen(descriptor, "wb") : NULL;
    if (!stream)
        close(descriptor);
    return stream;
}

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
    /* Renaming would replace /dev/null or a pipe by a plain file. */
    if (exists && !S_ISREG(status.st_mode))
        return rk_fail(error, "%s: is a device or a pipe; name a file", path);
    snprintf(file->path, sizeof file->path, "%s", path);
    snprintf(file->temporary, sizeof file->temporary, "%s.part-%ld", path, (long)getpid());
    file->stream = open_unnamed(file);
    file->unnamed = file->stream != NULL;
    if (!file->stream)
        file->stream = fopen(file->temporary, "wb");
    if (!file->stream)
        return rk_fail(error,
                       "%s: cannot be written: %s; choose an existing folder with write permission",
                       path, strerror(errno));
    return true;
}

/* Flushes the stream and gives the file its temporary name. */
static bool finish(const rk_file *file)
{
    if (ferror(file->stream) || fflush(file->stream) != 0)
        return false;
    if (!file->unnamed)
        return true;
    unlink(file->temporary); /* perhaps left by a dead process with the same number */
    return linkat(AT_FDCWD, descriptor_path(fileno(file->stream)).text, AT_FDCWD, file->temporary,
                  AT_SYMLINK_FOLLOW) == 0;
}

bool rk_file_commit(rk_file *file, rk_error *error)
{
    errno = 0;
    bool finished = finish(file);
    int reason = errno;
    bool closed = fclose(file->stream) == 0;
    file->stream = NULL;
    if (finished && !closed)
        reason = errno;
    if (finished && closed) {
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
        if (!file->unnamed)
            unlink(file->temporary);
        file->stream = NULL;
    }
}

bool rk_file_make_folder(const char *path, rk_error *error)
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
