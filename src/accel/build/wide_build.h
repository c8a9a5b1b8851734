/* Builds the wide tree straight from a mesh, without a binary one. Not installed. */
#ifndef RK_ACCEL_BUILD_WIDE_BUILD_H
#define RK_ACCEL_BUILD_WIDE_BUILD_H

#include "accel/build/bvh_parts.h"
#include "scene/wide_tree.h"

/* The tree over the triangles first .. first + count - 1 of a valid mesh (rk_mesh_validate), which
 * keep their indices; the same tree for any number of threads. The pool may be NULL: then the
 * caller works alone. False, with an empty tree, if memory is short. Release with
 * rk_wide_bvh_free. */
bool rk_wide_bvh_build_parts(rk_wide_bvh *wide, const rk_mesh *mesh, uint32_t first, uint32_t count,
                             rk_build_quality quality, rk_pool *pool, rk_error *error);

#endif
