/* Environment maps from picture files of any format (io/image_file.h), in the usual layouts. */
#ifndef RK_IO_ENVIRONMENT_FILE_H
#define RK_IO_ENVIRONMENT_FILE_H

#include "scene/environment.h"

/* Of one picture: a world of 11,585 x 5,792, whose pixels take 0.8 GB while it is read. */
enum { RK_ENVIRONMENT_FILE_PIXELS_MAX = 1 << 26 };

/* Reads a map. The width : height of a single file decides its layout:
 *
 *   4:3  the cross of scene/environment.h           6:1  six faces side by side
 *   3:4  that cross with its +z below -y, upside     1:6  six faces one below the other
 *        down, as when it is folded                  2:1  longitude and latitude: -z in the middle,
 *                                                         +x to its right, +y at the top; a row or
 *                                                         a column more or less is accepted
 *
 * Six files are either `path` with the one %s in it replaced by px, nx, py, ny, pz, nz, as in
 * "room_%s.jpg", or a folder that holds px.*, nx.* and so on. These names, and the order in a
 * strip, are OpenGL's, whose cube is left-handed: it looks at its +z, which is our -z, while x and
 * y agree. So pz, and the fifth face in a strip, is the one ahead, with px to its right; each face
 * has the orientation that it has in the cross. Instead of px and so on, all six may be named posx,
 * negx ...; pos_x ...; positivex, negativex ...; positive_x ...; +x, -x ...; x+, x- ...; xp, xn
 * ...; xpos, xneg ...; right, left, top or up, bottom or down, front, back; r, l, u, d, f, b; rt,
 * lf, up, dn, fr, bk, as OGRE names them; or 0 to 5; in upper case, too. In a folder their names
 * may begin with one that all six have, before one of _-. or a blank.
 *
 * Faces named rt, lf, up, dn, ft, bk are oriented as in Quake and its successors, where these names
 * are no directions: rt is ahead, with ft to its right, lf behind, and bk to its left.
 *
 * Colours are linear, as from rk_image_file_read. The empty parts of a cross are not read. False,
 * with an error that names the file, for other shapes, missing faces, faces of different sizes,
 * more than RK_CUBEMAP_SIDE_MAX texels per side or RK_ENVIRONMENT_FILE_PIXELS_MAX pixels, and files
 * that rk_image_file_read refuses. */
bool rk_environment_file_read(rk_cubemap *map, const char *path, rk_error *error);

/* The same for a view that needs no more than `least_side` texels per side of a face: of a larger
 * picture by longitude and latitude, squares of pixels are averaged, which keeps the mean radiance.
 * It costs a fraction of the time and the memory. */
bool rk_environment_file_read_for(rk_cubemap *map, const char *path, uint32_t least_side,
                                  rk_error *error);

#endif
