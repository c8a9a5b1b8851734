/* Checks that it is a regular file of a readable size, maps it, and passes its bytes to the checker
 * of its format: OBJ, PLY, OFF or GLB. */
#include "io/mesh_helper/mesh_syntax.h"

#include "io/mesh_helper/mesh_guard.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* Assimp keeps the file and its own data in memory at the same time. */
static const off_t largest_file = (off_t)4 << 30;

static bool has_ending(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, ending) == 0;
}

static bool check_kind(const char *path, const struct stat *status, rk_error *error)
{
    if (S_ISDIR(status->st_mode))
        return rk_fail(error, "%s: is a folder: name a mesh file in it", path);
    if (!S_ISREG(status->st_mode))
        return rk_fail(error, "%s: is not a regular file: copy the mesh to one", path);
    if (status->st_size == 0)
        return rk_fail(error, "%s: is empty: export the mesh again", path);
    if (status->st_size > largest_file)
        return rk_fail(error, "%s: is larger than 4 GB: simplify the mesh", path);
    return true;
}

static bool parse_bytes(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    if (has_ending(path, "obj"))
        return rk_mesh_syntax_obj(path, text, size, hints, error);
    if (has_ending(path, "ply"))
        return rk_mesh_syntax_ply(path, text, size, hints, error);
    if (has_ending(path, "off"))
        return rk_mesh_syntax_off(path, text, size, hints, error);
    if (has_ending(path, "glb"))
        return rk_mesh_syntax_glb(path, text, size, error);
    return true;
}

bool rk_mesh_syntax_check(const char *path, rk_mesh_hints *hints, rk_error *error)
{
    *hints = (rk_mesh_hints){0};
    struct stat status;
    /* Opening a pipe without a writer would block for ever. */
    int file = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0)
        return rk_fail(error, "%s: cannot be read: %s", path, strerror(errno));
    bool ok = fstat(file, &status) == 0 ? check_kind(path, &status, error)
                                        : rk_fail(error, "%s: %s", path, strerror(errno));
    if (ok) {
        rk_mesh_guard_allow(&status);
        size_t size = (size_t)status.st_size;
        void *text = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
        if (text == MAP_FAILED)
            ok = rk_fail(error, "%s: cannot be read: %s", path, strerror(errno));
        else
            ok = parse_bytes(path, text, size, hints, error);
        if (text != MAP_FAILED)
            munmap(text, size);
    }
    close(file);
    return ok;
}
