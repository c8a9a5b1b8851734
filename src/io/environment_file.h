/* Environment maps from picture files of any format (io/image_file.h), in the usual layouts. */
#ifndef RK_IO_ENVIRONMENT_FILE_H
#define RK_IO_ENVIRONMENT_FILE_H

#include "scene/environment.h"

/* Of one picture: a face of the largest map, or a world whose pixels take 3 GB. */
enum { RK_ENVIRONMENT_FILE_PIXELS_MAX = 1 << 28 };

/* Reads a map. The width : height of a single file decides its layout:
 *
 *   4:3  the cross of scene/environment.h           6:1  six faces side by side
 *   3:4  that cross with its +z below -y, upside     1:6  six faces one below the other
 *        down, as when it is folded                  2:1  longitude and latitude: -z in the middle,
 *                                                         +x to its right, +y at the top
 *
 * Six files are either `path` with the one %s in it replaced by px, nx, py, ny, pz, nz, as in
 * "room_%s.jpg", or a folder that holds px.*, nx.* and so on. These names, and the order in a
 * strip, are OpenGL's, whose cube is left-handed: it looks at its +z, which is our -z, while x and
 * y agree. So pz, and the fifth face in a strip, is the one ahead, with px to its right; each face
 * has the orientation that it has in the cross.
 *
 * Colours are linear, as from rk_image_file_read. The empty parts of a cross are not read. False,
 * with an error that names the file, for other shapes, missing faces, faces of different sizes,
 * more than RK_CUBEMAP_SIDE_MAX texels per side or RK_ENVIRONMENT_FILE_PIXELS_MAX pixels, and files
 * that rk_image_file_read refuses. */
bool rk_environment_file_read(rk_cubemap *map, const char *path, rk_error *error);

#endif
