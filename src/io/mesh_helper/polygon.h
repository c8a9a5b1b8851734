/* Cuts a flat polygon, convex or not, into triangles. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_POLYGON_H
#define RK_IO_MESH_HELPER_POLYGON_H

#include "base/vec3.h"

#include <stddef.h>
#include <stdint.h>

/* Writes corners - 2 triangles, rows of places in `points`, turning the way the polygon turns.
 * `points`: corners >= 3 of them, in order around. `left`: corners places to work in. A polygon
 * that crosses itself or has no area still gives corners - 2 triangles. */
void rk_polygon_cut(const rk_vec3 *points, uint32_t corners, uint32_t (*triangles)[3],
                    uint32_t *left);

#endif
