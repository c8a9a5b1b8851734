/* Assimp reads through callbacks. Only regular files are opened, because a pipe would block for
 * ever; a byte order mark is skipped by an offset that all positions leave out. Of material files
 * it is given the lines that it understands. */
#include "io/mesh_helper/mesh_io.h"

#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_guard.h"
#include "io/mesh_helper/mesh_mtl.h"
#include "io/mesh_helper/text_encoding.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* `file` comes first: Assimp knows only that. */
typedef struct opened {
    struct aiFile file;
    FILE *stream;
    long skipped; /* bytes before the text */
    size_t size;
    char *text; /* that the stream reads, if it is no file; or NULL */
} opened;

static struct {
    const char *path;
    char *text;
    size_t size;
} replaced;

void rk_mesh_io_replace(const char *path, char *text, size_t size)
{
    replaced.path = path;
    replaced.text = text;
    replaced.size = size;
}

static size_t read_items(struct aiFile *file, char *to, size_t size, size_t count)
{
    return fread(to, size, count, ((opened *)file)->stream);
}

static size_t write_nothing(struct aiFile *file, const char *from, size_t size, size_t count)
{
    (void)file, (void)from, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    const opened *o = (opened *)file;
    return (size_t)(ftell(o->stream) - o->skipped);
}

static size_t size_of(struct aiFile *file)
{
    const opened *o = (opened *)file;
    return o->size - (size_t)o->skipped;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    const opened *o = (opened *)file;
    int from = origin == aiOrigin_SET ? SEEK_SET : origin == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
    long place = (long)offset + (from == SEEK_SET ? o->skipped : 0);
    return fseek(o->stream, place, from) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
}

static void flush(struct aiFile *file)
{
    (void)file;
}

static bool has_ending(const char *path, const char *ending)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, ending) == 0;
}

static bool is_text_with_mark(FILE *stream, const char *path)
{
    char first[3];
    return (has_ending(path, ".obj") || has_ending(path, ".mtl") || has_ending(path, ".ply") ||
            has_ending(path, ".gltf")) &&
           fread(first, 1, 3, stream) == 3 && memcmp(first, "\xef\xbb\xbf", 3) == 0;
}

static char mtls[RK_MESH_IO_MTLS][4096];
static int mtl_count;

static void keep_mtl(const char *path)
{
    if (has_ending(path, ".mtl") && mtl_count < RK_MESH_IO_MTLS)
        snprintf(mtls[mtl_count++], sizeof *mtls, "%s", path);
}

const char *rk_mesh_io_mtl(int i)
{
    return i < mtl_count ? mtls[i] : NULL;
}

/* The stream is closed; NULL if memory is short. */
static FILE *open_known_lines(FILE *file, opened *o)
{
    FILE *stream = NULL, *text = rk_text_encoding_open(file);
    if (!text)
        return NULL;
    if (rk_mesh_mtl_copy_known(text, &o->text, &o->size))
        stream = fmemopen(o->text, o->size, "rb");
    fclose(text);
    return stream;
}

static FILE *open_stream(const char *path, opened *o)
{
    const bool is_replaced = replaced.path && strcmp(path, replaced.path) == 0;
    if (is_replaced)
        o->size = replaced.size;
    FILE *stream = is_replaced ? fmemopen(replaced.text, replaced.size, "rb") : fopen(path, "rb");
    if (!stream)
        return NULL;
    o->skipped = is_text_with_mark(stream, path) ? 3 : 0;
    fseek(stream, o->skipped, SEEK_SET);
    if (!has_ending(path, ".mtl"))
        return stream;
    o->skipped = 0;
    return open_known_lines(stream, o);
}

/* In glTF, %20 may be a blank. */
static const char *unescaped(char to[4096], const char *path)
{
    struct stat status;
    if (stat(path, &status) == 0 || strlen(path) >= 4096)
        return path;
    strcpy(to, path);
    rk_mesh_files_unescape(to);
    return to;
}

static struct aiFile *open_file(struct aiFileIO *io, const char *given, const char *mode)
{
    (void)io;
    struct stat status;
    char other[4096];
    const char *path = unescaped(other, given);
    if (mode[0] != 'r' || stat(path, &status) != 0 || !S_ISREG(status.st_mode))
        return NULL;
    rk_mesh_guard_allow(&status);
    opened *o = malloc(sizeof *o);
    if (!o)
        return NULL;
    *o = (opened){{read_items, write_nothing, tell, size_of, seek, flush, NULL},
                  .size = (size_t)status.st_size};
    o->stream = open_stream(path, o);
    if (!o->stream) {
        free(o->text);
        free(o);
        return NULL;
    }
    keep_mtl(path);
    return &o->file;
}

static void close_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    opened *o = (opened *)file;
    fclose(o->stream);
    free(o->text);
    free(o);
}

struct aiFileIO rk_mesh_io = {open_file, close_file, NULL};
