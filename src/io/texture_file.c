/* A picture is looked for as it is named, then with escapes decoded, then beside the mesh, since
 * exporters write paths of their own machine. One that is embedded in the mesh is written to a
 * temporary file. */
#include "io/texture_file.h"

#include "io/image_file.h"
#include "io/png.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Every path here is shorter; longer ones are refused. */
typedef struct long_path {
    char text[4096];
} long_path;

/* --- finding --------------------------------------------------------------------------------- */

/* Builds the file's path. False with the reason if there is no readable file. */
static bool find_at(long_path *path, const char *mesh_path, const char *name, rk_error *error)
{
    const char *slash = strrchr(mesh_path, '/');
    int folder = slash && name[0] != '/' ? (int)(slash - mesh_path) + 1 : 0;
    int length = snprintf(path->text, sizeof path->text, "%.*s%s", folder, mesh_path, name);
    if (length < 0 || (size_t)length >= sizeof path->text)
        return rk_fail(error, "%.300s...: the path is too long: give it a shorter name",
                       path->text);
    struct stat status;
    if (stat(path->text, &status) != 0)
        return rk_fail(error, "%s: %s: put it beside the mesh file", path->text, strerror(errno));
    return S_ISREG(status.st_mode) ||
           rk_fail(error, "%s: is not a regular file: copy the picture to one", path->text);
}

static void turn_slashes(char *name)
{
    for (; *name; name++)
        if (*name == '\\')
            *name = '/';
}

/* Decodes each % with two hexadecimal digits to one character. */
static void unescape(char *name)
{
    char *to = name;
    for (const char *from = name; *from; from++) {
        if (from[0] == '%' && isxdigit((unsigned char)from[1]) &&
            isxdigit((unsigned char)from[2])) {
            const char digits[3] = {from[1], from[2], '\0'};
            *to++ = (char)strtoul(digits, NULL, 16);
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = '\0';
}

static bool find_file(long_path *path, const char *mesh_path, const char *given, rk_error *error)
{
    long_path name;
    if (snprintf(name.text, sizeof name.text, "%s", given) >= (int)sizeof name.text)
        return rk_fail(error, "%.300s...: the path is too long: give it a shorter name", given);
    turn_slashes(name.text);
    if (find_at(path, mesh_path, name.text, error))
        return true;
    unescape(name.text);
    if (find_at(path, mesh_path, name.text, NULL))
        return true;
    const char *slash = strrchr(name.text, '/');
    return slash && slash[1] && find_at(path, mesh_path, slash + 1, NULL);
}

/* --- reading --------------------------------------------------------------------------------- */

/* Writes the bytes to a temporary file, whose path it completes. */
static bool write_temporary(long_path *path, const rk_texture_file_source *source)
{
    const char *folder = getenv("TMPDIR");
    if (snprintf(path->text, sizeof path->text, "%s/raykit-picture-XXXXXX",
                 folder && *folder ? folder : "/tmp") >= (int)sizeof path->text) {
        errno = ENAMETOOLONG;
        return false;
    }
    int file = mkstemp(path->text);
    FILE *stream = file >= 0 ? fdopen(file, "wb") : NULL;
    if (!stream)
        return false;
    bool written = fwrite(source->data, 1, source->data_size, stream) == source->data_size;
    written = fclose(stream) == 0 && written;
    if (!written)
        unlink(path->text);
    return written;
}

static bool read_part(rk_image *image, const rk_texture_file_source *source, const char *path,
                      bool is_png, size_t most_texels, rk_error *error)
{
    const bool alpha_only = source->part == RK_TEXTURE_ALPHA;
    const rk_image_file_wish wish = {.most_pixels = most_texels, .reader = source->reader};
    if (source->part == RK_TEXTURE_COLOUR)
        return is_png ? rk_png_read_within(image, path, most_texels, error)
                      : rk_image_file_read_wished(image, path, &wish, error);
    return is_png ? rk_png_read_opacity(image, path, most_texels, alpha_only, error)
                  : rk_image_file_read_opacity(image, path, &wish, alpha_only, error);
}

/* A picture that is opaque everywhere need not be looked up. */
static void drop_opaque(rk_image *opacity)
{
    for (size_t i = 0; i < opacity->width * opacity->height; i++)
        if (opacity->pixels[i].x < 1)
            return;
    rk_image_free(opacity);
}

/* Our readers need files. The first bytes identify a PNG, which needs no helper program. */
static bool read_embedded(rk_image *image, const rk_texture_file_source *source, size_t most_texels,
                          rk_error *error)
{
    static const unsigned char png[] = {0x89, 'P', 'N', 'G'};
    long_path path;
    rk_error reason;
    *image = (rk_image){0};
    if (!write_temporary(&path, source))
        return rk_fail(error, "picture %s in the mesh file: no temporary file: %s: set TMPDIR",
                       source->name, strerror(errno));
    bool is_png = source->data_size >= sizeof png && memcmp(source->data, png, sizeof png) == 0;
    most_texels = rk_image_file_budget(most_texels, source->data_size);
    bool ok = read_part(image, source, path.text, is_png, most_texels, &reason);
    unlink(path.text);
    size_t length = strlen(path.text);
    if (ok)
        return true;
    return rk_fail(error, "picture %s in the mesh file%.700s", source->name,
                   strncmp(reason.text, path.text, length) == 0 ? reason.text + length
                                                                : " is lost: try again");
}

bool rk_texture_file_read(rk_texture *texture, const rk_texture_file_source *source,
                          const char *mesh_path, size_t *texels_left, rk_error *error)
{
    long_path path;
    *texture = (rk_texture){.wrap = source->clamps ? RK_TEXTURE_CLAMP : RK_TEXTURE_REPEAT,
                            .filter = RK_TEXTURE_BILINEAR};
    bool ok = source->data
                  ? read_embedded(&texture->image, source, *texels_left, error)
                  : find_file(&path, mesh_path, source->name, error) &&
                        read_part(&texture->image, source, path.text, false, *texels_left, error);
    if (ok && source->part != RK_TEXTURE_COLOUR)
        drop_opaque(&texture->image);
    if (ok)
        *texels_left -= texture->image.width * texture->image.height;
    return ok;
}
