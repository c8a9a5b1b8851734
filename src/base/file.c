/* On Linux the file has no name until it is complete (O_TMPFILE); elsewhere it is written under a
 * temporary name. What would fail at the end, such as a folder in its place, is found at the
 * beginning. */
#define _GNU_SOURCE /* O_TMPFILE, of Linux */
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
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

/* With the last slash; "." for a path without one. */
static void copy_folder(char *folder, size_t size, const char *path)
{
    const char *slash = strrchr(path, '/');
    snprintf(folder, size, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
}

/* Opens a file without a name in the folder of file->path: if this process dies, so does the file.
 * NULL where the file system does not support that, or the file could not be named later because
 * the name is too long or /proc is missing. */
static FILE *open_unnamed(const rk_file *file)
{
    char folder[sizeof file->path];
    copy_folder(folder, sizeof folder, file->path);
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

enum { links_max = 40 }; /* as in Linux */

/* Renaming would replace a symbolic link. A link is relative to the folder that it is in. */
static bool follow_links(rk_file_place *place, rk_error *error)
{
    for (int links = 0; links < links_max; links++) {
        rk_file_place to;
        ssize_t length = readlink(place->text, to.text, sizeof to.text - 1);
        if (length < 0)
            return true;
        to.text[length] = '\0';
        const char *slash = strrchr(place->text, '/');
        size_t kept = slash && to.text[0] != '/' ? (size_t)(slash - place->text) + 1 : 0;
        if (kept + (size_t)length >= sizeof place->text)
            return rk_fail(error, "%.60s...: links to a path that is too long", place->text);
        memcpy(place->text + kept, to.text, (size_t)length + 1);
    }
    return rk_fail(error, "%.800s: %s; name a file", place->text, strerror(ELOOP));
}

bool rk_file_destination(rk_file_place *place, const char *path, rk_error *error)
{
    if (strlen(path) >= sizeof place->text)
        return rk_fail(error, "%.60s...: the path is longer than %zu bytes", path,
                       sizeof place->text - 1);
    strcpy(place->text, path);
    if (!follow_links(place, error))
        return false;
    path = place->text;
    struct stat status;
    bool exists = stat(path, &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        return rk_fail(error, "%s: is a folder; name a file in it", path);
    /* Renaming would replace /dev/null or a pipe by a plain file. */
    if (exists && !S_ISREG(status.st_mode))
        return rk_fail(error, "%s: is a device or a pipe; name a file", path);
    if (exists && faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0)
        return rk_fail(error, "%s: is read-only: %s; name another, or make it writable", path,
                       strerror(errno));
    return true;
}

bool rk_file_begin(rk_file *file, const char *path, rk_error *error)
{
    *file = (rk_file){0};
    rk_file_place place;
    if (!rk_file_destination(&place, path, error))
        return false;
    path = place.text;
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

int rk_file_lock_folder(const char *path)
{
    char folder[4096];
    copy_folder(folder, sizeof folder, path);
    int lock = open(folder, O_RDONLY | O_CLOEXEC);
#ifdef LOCK_EX /* flock is not in POSIX */
    if (lock < 0)
        return -1;
    while (flock(lock, LOCK_EX) != 0)
        if (errno != EINTR) {
            close(lock);
            return -1;
        }
#endif
    return lock;
}

void rk_file_unlock(int lock)
{
    if (lock >= 0)
        close(lock);
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
