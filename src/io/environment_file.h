/* Environment maps from picture files of any format (io/image_file.h), in the layouts that are in
 * use. */
#ifndef RK_IO_ENVIRONMENT_FILE_H
#define RK_IO_ENVIRONMENT_FILE_H

#include "scene/environment.h"

/* Reads a map. One file is taken for what its width : height says:
 *
 *   4:3  the cross of scene/environment.h           6:1  six faces beside each other
 *   3:4  that cross with its +z below -y, upside     1:6  six faces below each other
 *        down, as it comes when it is folded         2:1  longitude and latitude: the middle is -z,
 *                                                         to its right +x, the top +y
 *
 * Six files are either `path` with the one %s in it replaced by px, nx, py, ny, pz, nz, as in
 * "room_%s.jpg", or a folder that holds px.*, nx.* and so on. These names, and the order in a
 * strip, are OpenGL's, whose cube is left-handed: it looks at its +z, which is our -z, while x and
 * y agree. So pz, and the fifth in a strip, is the face ahead, with px to its right; each face is
 * turned as in the cross.
 *
 * Colours come as rk_image_read gives them: linear. What a cross leaves empty is not read. False,
 * with an error that names the file, for other shapes, for missing faces, faces of different sizes,
 * more than RK_CUBEMAP_SIDE_MAX texels a side, and whatever rk_image_read refuses. */
bool rk_environment_read(rk_cubemap *map, const char *path, rk_error *error);

#endif
