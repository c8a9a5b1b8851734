/* References in the order of a curve through the cells of a grid (accel/build/bvh_parts.h), by
 * Morton codes. Not installed. */
#ifndef RK_ACCEL_BUILD_BVH_MORTON_H
#define RK_ACCEL_BUILD_BVH_MORTON_H

#include "accel/build/bvh_reference.h"

enum { RK_MORTON_CELLS = 1 << 10 }; /* of the grid, on each axis */

/* Sorts references[0] by the codes of its centres in the grid, into references[1]; uses both. */
void rk_morton_sort(reference *references[2], uint32_t count, const binning *grid);

/* Where, in sorted references, the highest bit in which codes differ becomes 1: the first index on
 * the right. The middle, if all codes are equal. */
uint32_t rk_morton_boundary(const reference *r, uint32_t count, const binning *grid);

#endif
