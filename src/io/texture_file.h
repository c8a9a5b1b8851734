/* The pictures that mesh files name for their surfaces. */
#ifndef RK_IO_TEXTURE_FILE_H
#define RK_IO_TEXTURE_FILE_H

#include "base/texture.h"

typedef struct rk_texture_source {
    const char *name;          /* as the mesh file gives it */
    const unsigned char *data; /* the picture itself where the mesh file holds it, or NULL */
    size_t data_size;
    bool clamps; /* else it repeats */
} rk_texture_source;

/* Reads a mesh file's picture, to be filtered bilinearly. Its texels are taken from `texels_left`;
 * a picture that has more is refused. False with an error that begins with the picture's path.
 *
 * The name counts from the mesh file's folder unless it begins with a slash. Backslashes are
 * slashes, %20 may be a blank, as in glTF, and where no such file is, the last part of the name
 * beside the mesh file serves: many files name a folder on the computer where they were made.
 *
 * Names may lead anywhere, /etc/passwd and ../../x too: the file is opened with the user's own
 * rights, is read only as a picture, and nothing of another kind is shown. Devices and pipes, which
 * might never end, are refused. */
bool rk_texture_read(rk_texture *texture, const rk_texture_source *source, const char *mesh_path,
                     size_t *texels_left, rk_error *error);

#endif
