/* Mesh files (OBJ with MTL, PLY, OFF, glTF and Assimp's other formats). */
#ifndef RK_IO_MESH_FILE_H
#define RK_IO_MESH_FILE_H

#include "scene/mesh.h"

/* Reads and validates a mesh: polygons are triangulated, points and lines dropped, parts merged,
 * equal vertices joined, unused vertices and materials left out. Coordinates are the file's; but if
 * those of an OBJ, PLY or OFF file are 64 times the mesh's extent or more, its first vertex becomes
 * the origin, because single precision would lose details; and an FBX file whose axis points down
 * is turned. See rk_mesh_normalize. False with an
 * error that names the file and the place (the line in OBJ, ASCII PLY and OFF) when it is missing,
 * empty, truncated or malformed; the mesh is then empty. On success error->text is "" or notes
 * worth printing, in one line: a missing MTL, faces of an OBJ file that have two corners, or what
 * the mesh lacks of the file, such as normal maps, emission, animation, points and lines.
 *
 * Colours of vertices and faces are read, too: of vertices in PLY, OBJ (v x y z r g b), COFF and
 * glTF (COLOR_0), of faces in OFF and STL. In glTF they are linear and multiply the base colour, as
 * its specification says. Elsewhere they are sRGB-encoded, by custom, and from 0 to 255 if one
 * exceeds 1. In X3D and scans (PLY, OBJ, OFF, STL) they are the diffuse colour, except where there
 * is a texture, which then is. A file whose vertices are all white has none.
 *
 * A material's diffuse texture is read, too: map_Kd in MTL, the base colour in glTF, TextureFile in
 * PLY. Its path is relative to the folder of the mesh or of the MTL; if there is no such file, the
 * one of that name in one of these is used. Case of letters does not matter where nothing else
 * fits. It repeats unless it is clamped in both directions. A picture that
 * cannot be read gives a note and untextured surfaces. Texture coordinates are moved as map_Kd's
 * -s and -o and KHR_texture_transform say. Its opacity is map_d in MTL, or else the picture's alpha
 * channel, which glTF's alphaMode may ignore; below MASK's cutoff the surface is cut out. */
bool rk_mesh_file_read(rk_mesh *mesh, const char *path, rk_error *error);

#endif
