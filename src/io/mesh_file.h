/* Mesh files (OBJ with MTL, PLY, OFF, glTF and what else Assimp reads). */
#ifndef RK_IO_MESH_FILE_H
#define RK_IO_MESH_FILE_H

#include "scene/mesh.h"

/* Reads and validates a mesh: polygons cut into triangles, points and lines dropped, all its parts
 * merged, equal vertices joined, unused vertices and materials left out. Coordinates are the
 * file's own; see rk_mesh_normalize. False with an error that names the file and the place (the
 * line in OBJ, ASCII PLY and OFF) when it is missing, empty, truncated or malformed; the mesh is
 * then empty. On success error->text is "" or a note worth printing, such as a missing MTL.
 *
 * Materials bring the picture that multiplies their diffuse colour: map_Kd in MTL, the base colour
 * in glTF, TextureFile in PLY. Its name counts from the mesh's folder; where nothing is there, the
 * file of that name beside the mesh serves. It repeats unless it is clamped both ways. One that
 * cannot be read is a note, and its surfaces are plain. Scales and offsets of texture coordinates
 * and a picture's opacity are not read. */
bool rk_mesh_read(rk_mesh *mesh, const char *path, rk_error *error);

#endif
