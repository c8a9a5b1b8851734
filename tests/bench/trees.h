/* Trees with leaves of another size, to measure what the size costs. */
#ifndef RK_TESTS_TREES_H
#define RK_TESTS_TREES_H

#include "accel/accel.h"

/* Replaces the tree over static triangles by one whose leaves have at most `most` triangles:
 * subtrees of no more become a leaf, and larger leaves are halved at the median of the centroids.
 */
bool trees_resize_leaves(rk_accel *accel, uint32_t most, rk_error *error);

#endif
