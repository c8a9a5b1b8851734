/* Triangulates a flat polygon, convex or not. Part of raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_POLYGON_H
#define RK_IO_MESH_HELPER_POLYGON_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Ear clipping takes seconds for as many, and minutes for ten times as many. */
enum { RK_POLYGON_CORNERS_MAX = 1 << 15 };

/* Writes corners - 2 triangles, rows of indices into `points`, with the polygon's orientation.
 * `points`: corners >= 3 of them, in order. `left`: workspace for as many indices. A polygon that
 * intersects itself or has no area still gives corners - 2 triangles. False for a polygon that is
 * not convex and has more than RK_POLYGON_CORNERS_MAX corners. */
bool rk_polygon_triangulate(const rk_vec3 *points, uint32_t corners, uint32_t (*triangles)[3],
                            uint32_t *left);

#endif
