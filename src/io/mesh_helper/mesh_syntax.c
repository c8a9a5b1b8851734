/* Checks that it is a regular file of a readable size, maps it, and passes its bytes to the checker
 * of its format. */
#include "io/mesh_helper/mesh_syntax.h"

#include "io/mesh_helper/mesh_files.h"
#include "io/mesh_helper/mesh_gltf_sets.h"
#include "io/mesh_helper/mesh_guard.h"
#include "io/mesh_helper/mesh_ply_names.h"
#include "io/mesh_helper/mesh_unread.h"
#include "io/mesh_helper/mesh_x3d_groups.h"
#include "io/mesh_helper/text_encoding.h"
#include "io/stand_in.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* Assimp keeps the file and its own data in memory at the same time. */
static const off_t largest_file = (off_t)4 << 30;

void rk_mesh_hints_note(rk_mesh_hints *hints, const char *path, const char *format, ...)
{
    char *text = hints->note.text;
    size_t length = strlen(text), room = sizeof hints->note.text;
    length += (size_t)snprintf(text + length, room - length, length ? "; " : "%.800s: ", path);
    va_list arguments;
    va_start(arguments, format);
    if (length < room)
        vsnprintf(text + length, room - length, format, arguments);
    va_end(arguments);
    const rk_error whole = hints->note;
    rk_fail(&hints->note, "%s", whole.text); /* on one line */
}

/* Line ends of old Macintosh programs. */
static bool ends_lines_by_returns(const char *text, size_t size)
{
    return memchr(text, '\r', size) && !memchr(text, '\n', size);
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

static bool is_text(const char *path)
{
    static const char *const endings[] = {"obj", "ply", "off", "stl",     "gltf", "dae",
                                          "x3d", "amf", "irr", "irrmesh", "xml",  "ac",
                                          "ase", "ask", "dxf", "md5mesh", "nff",  "smd"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (rk_mesh_files_has_ending(path, endings[i]))
            return true;
    return false;
}

static char *copy_with_feeds(const char *path, const char *text, size_t size, rk_error *error)
{
    char *turned = rk_allocate_unset(size, 1, path, error);
    for (size_t i = 0; turned && i < size; i++)
        turned[i] = text[i] == '\r' ? '\n' : text[i];
    return turned;
}

/* In DirectX's text, with a blank after each comma before a digit, or Assimp takes it for the point
 * of a number. */
static bool space_commas(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                         rk_error *error)
{
    FILE *out = open_memstream(&hints->text, &hints->size);
    for (size_t i = 0; out && i < size; i++) {
        fputc(text[i], out);
        if (text[i] == ',' && i + 1 < size && isdigit((unsigned char)text[i + 1]))
            fputc(' ', out);
    }
    return (out && fclose(out) == 0) ||
           rk_fail(error, "%s: no memory for its text: simplify the mesh", path);
}

static bool has_word(const char *text, size_t size, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = text, *end = text + size;
         (at = memchr(at, *word, (size_t)(end - at))) && (size_t)(end - at) >= length; at++)
        if (memcmp(at, word, length) == 0)
            return true;
    return false;
}

static bool check_packing(const char *path, const char *text, size_t size, rk_error *error)
{
    if (size >= 4 && memcmp(text, "\x28\xb5\x2f\xfd", 4) == 0)
        return rk_fail(error, "%s: is compressed by Zstandard: save it uncompressed", path);
    if (size < 2 || memcmp(text, "\x1f\x8b", 2) != 0 || rk_mesh_files_has_ending(path, "blend"))
        return true;
    if (rk_mesh_files_has_ending(path, "gz"))
        return rk_fail(
            error, "%s: is compressed by gzip: gunzip it, and name the file that it makes", path);
    return rk_fail(error, "%s: is compressed by gzip: rename it to end in .gz and gunzip it", path);
}

static bool parse_bytes(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error);

/* `changed` may be NULL after an error. */
static bool parse_changed(const char *path, char *changed, size_t size, rk_mesh_hints *hints,
                          rk_error *error)
{
    bool ok = changed && parse_bytes(path, changed, size, hints, error);
    if (hints->text) {
        free(changed);
    } else {
        hints->text = changed;
        hints->size = size;
    }
    return ok;
}

static bool parse_bytes(const char *path, const char *text, size_t size, rk_mesh_hints *hints,
                        rk_error *error)
{
    size_t utf8_size = 0, mended_size = 0;
    char *mended = NULL;
    if (!rk_stand_in_check(path, text, size, error))
        return false;
    if (!has_word(text, size < 4096 ? size : 4096, "'IFC") &&
        !rk_mesh_unread_check(path, text, size, error))
        return false; /* a STEP file may hold a building (IFC), which Assimp reads */
    if (!check_packing(path, text, size, error))
        return false;
    if (is_text(path) && rk_text_encoding_is_utf16(text, size)) {
        char *utf8 = rk_text_encoding_to_utf8(path, text, size, &utf8_size, error);
        return parse_changed(path, utf8, utf8_size, hints, error);
    }
    if (rk_mesh_files_has_ending(path, "obj") && ends_lines_by_returns(text, size))
        return parse_changed(path, copy_with_feeds(path, text, size, error), size, hints, error);
    if (rk_mesh_files_has_ending(path, "obj"))
        return rk_mesh_syntax_obj(path, text, size, hints, error);
    if ((rk_mesh_files_has_ending(path, "ply") || rk_mesh_files_has_ending(path, "off")) &&
        ends_lines_by_returns(text, size))
        return rk_fail(
            error, "%s: its lines end in carriage returns alone: save it with line feeds", path);
    const bool is_gltf =
        rk_mesh_files_has_ending(path, "glb") || rk_mesh_files_has_ending(path, "gltf");
    if ((rk_mesh_files_has_ending(path, "ply") &&
         !rk_mesh_ply_names_mend(text, size, &mended, &mended_size)) ||
        (is_gltf && !rk_mesh_gltf_sets_mend(text, size, &mended, &mended_size)))
        return rk_fail(error, "%s: no memory for its text: simplify the mesh", path);
    if (rk_mesh_files_has_ending(path, "x3d") &&
        !rk_mesh_x3d_groups_mend(path, text, size, &mended, &mended_size, error))
        return false;
    if (mended)
        return parse_changed(path, mended, mended_size, hints, error);
    if (rk_mesh_files_has_ending(path, "ply"))
        return rk_mesh_syntax_ply(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "off"))
        return rk_mesh_syntax_off(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "stl"))
        return rk_mesh_syntax_stl(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "3mf"))
        return rk_mesh_syntax_3mf(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "amf"))
        return rk_mesh_syntax_amf(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "ac") || rk_mesh_files_has_ending(path, "acc") ||
        rk_mesh_files_has_ending(path, "ac3d"))
        return rk_mesh_syntax_ac(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "x3d"))
        return rk_mesh_syntax_x3d(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "3ds"))
        return rk_mesh_syntax_3ds(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "fbx"))
        return rk_mesh_syntax_fbx(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "dae"))
        return rk_mesh_syntax_dae(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "x") && size > 16 && memcmp(text, "xof ", 4) == 0 &&
        memcmp(text + 8, "txt ", 4) == 0)
        return space_commas(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "glb"))
        return rk_mesh_syntax_glb(path, text, size, hints, error);
    if (rk_mesh_files_has_ending(path, "gltf"))
        return rk_mesh_syntax_gltf(path, text, size, hints, error);
    return true;
}

bool rk_mesh_syntax_check(const char *path, rk_mesh_hints *hints, rk_error *error)
{
    *hints = (rk_mesh_hints){0};
    struct stat status;
    /* Opening a pipe without a writer would block for ever. */
    int file = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0)
        return rk_fail(error, "%s: cannot be read: %s: check its name and permissions", path,
                       strerror(errno));
    bool ok = fstat(file, &status) == 0
                  ? check_kind(path, &status, error)
                  : rk_fail(error, "%s: cannot be read: %s: try again", path, strerror(errno));
    if (ok) {
        rk_mesh_guard_allow(&status);
        size_t size = (size_t)status.st_size;
        void *text = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
        if (text == MAP_FAILED)
            ok = rk_fail(error, "%s: cannot be read: %s: check its name and permissions", path,
                         strerror(errno));
        else
            ok = parse_bytes(path, text, size, hints, error);
        if (text != MAP_FAILED)
            munmap(text, size);
    }
    close(file);
    return ok;
}
