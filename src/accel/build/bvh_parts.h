/* The fast builder's work: a mesh's triangles, split again and again, by one thread or several.
 * Where a ray's expected cost is lowest (SAH, 16 bins on each axis): the readable form of the same
 * idea is features/sah_binning.h; this one keeps a triangle in 32 bytes, bins all axes at once, and
 * counts a leaf's cost in blocks of four triangles. Or, faster, along a Morton curve.
 * Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007; Lauterbach and
 * others, "Fast BVH construction on GPUs", 2009 (Morton codes). Not installed. */
#ifndef RK_ACCEL_BUILD_BVH_PARTS_H
#define RK_ACCEL_BUILD_BVH_PARTS_H

#include "base/box.h"
#include "base/parallel.h"
#include "scene/mesh.h"

typedef enum rk_build_quality {
    RK_BUILD_SAH,    /* where a ray's expected cost is lowest */
    RK_BUILD_MORTON, /* by cells of a grid: a third of the time, for a tree that costs more to trace
                      */
} rk_build_quality;

enum {
    RK_PART_BLOCK = 4,       /* triangles that a leaf tests together */
    RK_PART_LEAF_MAX = 8,    /* a larger part is always split */
    RK_PART_LARGE = 1 << 13, /* a part of so many is split by the pool */
};

/* Neighbouring triangles of the order found so far. */
typedef struct rk_bvh_part {
    rk_simd4 low, high;                 /* the box, in x, y and z */
    rk_simd4 centres_low, centres_high; /* the box around a quarter of the boxes' corner sums */
    uint32_t begin, count;
    uint32_t buffer;
    uint32_t depth_left; /* this many levels may follow below */
} rk_bvh_part;

typedef struct rk_bvh_parts rk_bvh_parts;

/* Starts with one part, `root`, of the triangles first .. first + count - 1 of a valid mesh; count
 * is at least 1. The pool, which may be NULL, works on large parts. NULL if memory is short.
 * Release with rk_bvh_parts_free, which takes NULL, too. */
rk_bvh_parts *rk_bvh_parts_start(const rk_mesh *mesh, uint32_t first, uint32_t count,
                                 rk_build_quality quality, rk_pool *pool, rk_bvh_part *root,
                                 rk_error *error);
void rk_bvh_parts_free(rk_bvh_parts *parts);

/* Splits a part in two, neither of them empty; returns false for a part of one block, which is a
 * leaf. The part stays as it is, for callers who then find that it should be a leaf. The same
 * result for any number of threads. Several threads may split different parts at once, but large
 * ones (RK_PART_LARGE) only the thread that started the pool, while it is idle. */
bool rk_bvh_part_split(const rk_bvh_parts *parts, const rk_bvh_part *part, rk_bvh_part halves[2]);

/* Does a node with these halves cost less than a leaf with the part? Always true beyond
 * RK_PART_LEAF_MAX triangles. A node that has room for more children takes them in any case. */
bool rk_bvh_part_should_split(const rk_bvh_parts *parts, const rk_bvh_part *part,
                              const rk_bvh_part halves[2]);

/* The index in the mesh of a part's triangle, i < part->count. */
uint32_t rk_bvh_part_triangle(const rk_bvh_parts *parts, const rk_bvh_part *part, uint32_t i);

rk_box rk_bvh_part_box(const rk_bvh_part *part);

/* Half of the box's area, in units of the same size for all parts of a tree. */
float rk_bvh_part_area(const rk_bvh_parts *parts, const rk_bvh_part *part);

#endif
