/* The pictures that mesh files use as textures. */
#ifndef RK_IO_TEXTURE_FILE_H
#define RK_IO_TEXTURE_FILE_H

#include "base/texture.h"

/* What of a picture is read. */
typedef enum rk_texture_file_part {
    RK_TEXTURE_COLOUR,
    RK_TEXTURE_ALPHA,   /* its alpha channel, as grey; no pixels if it has none, or is opaque */
    RK_TEXTURE_OPACITY, /* the same, or its grey if it has none */
} rk_texture_file_part;

typedef struct rk_texture_file_source {
    const char *name;          /* as the mesh file gives it */
    const unsigned char *data; /* the picture, if embedded in the mesh file, or NULL */
    size_t data_size;
    bool clamps; /* else it repeats */
    rk_texture_file_part part;
    struct rk_image_file_reader *reader; /* of io/image_file.h, or NULL */
} rk_texture_file_source;

/* Reads a mesh file's picture as a bilinear texture. Its texels are subtracted from `texels_left`;
 * a picture with more is refused before it is read. False with an error that begins with the
 * picture's path.
 *
 * The name is relative to the mesh file's folder unless it begins with a slash. Backslashes are
 * slashes, and %20 may be a space, as in glTF. If there is no such file, the name's last part is
 * looked up beside the mesh file: many files name a folder on the computer where they were made.
 *
 * Names may point anywhere, including /etc/passwd and ../../x: the file is opened with the user's
 * own rights and read only as a picture, so no other contents are shown. Devices and pipes, which
 * might never end, are refused. */
bool rk_texture_file_read(rk_texture *texture, const rk_texture_file_source *source,
                          const char *mesh_path, size_t *texels_left, rk_error *error);

#endif
