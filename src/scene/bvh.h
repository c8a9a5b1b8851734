/* The binary tree over a mesh's triangles that all binary builders make and all binary traversals
 * walk. */
#ifndef RK_SCENE_BVH_H
#define RK_SCENE_BVH_H

#include "base/box.h"
#include "base/error.h"
#include "base/triangle.h"
#include "scene/mesh.h"

/* 32 bytes, so that a pair of children fills one cache line. */
typedef struct rk_bvh_node {
    rk_box box;
    uint32_t first; /* inner: the left child, the right one follows; leaf: its first triangle */
    uint32_t count; /* 0 for an inner node, else the triangles of the leaf */
} rk_bvh_node;

typedef struct rk_bvh {
    uint32_t node_count; /* entries of `nodes` in use; 0 for a tree without triangles */
    uint32_t triangle_count;
    rk_bvh_node *nodes; /* nodes[0] is the root; nodes[1] is left out, so that pairs start even */
    rk_triangle *triangles; /* triangle_count, in the order of the leaves */
} rk_bvh;

enum {
    /* A leaf is a handful: below about four triangles, testing them all costs less than testing
     * two more boxes and choosing. For builders that do not weigh the costs. */
    RK_BVH_LEAF_TARGET = 4,
    /* No builder may make a larger leaf, whatever it weighs: cutting even these in two adds no more
     * than 1.5 to the 64 tests that it may spare. */
    RK_BVH_LEAF_MAX = 64,
    /* No builder may go deeper, so a traversal can keep its stack in an array of this many. */
    RK_BVH_LEVELS_MAX = 64,
};

/* What a step costs, by the classic course's weights: opening an inner node, testing a triangle. */
#define RK_BVH_TRAVERSAL_COST 1.5
#define RK_BVH_INTERSECTION_COST 1.0

/* Makes room for `triangles` triangles and up to `leaves` leaves, and leaves both arrays unset;
 * node_count is 0. False when memory is short. */
bool rk_bvh_init(rk_bvh *bvh, uint32_t triangles, uint32_t leaves, rk_error *error);
void rk_bvh_free(rk_bvh *bvh);

typedef struct rk_bvh_measures {
    uint32_t levels; /* 0 without triangles, 1 for a single leaf */
    uint32_t leaves;
    double sah_cost; /* expected cost of a ray that meets the root: 1.5 an inner node and 1 a
                        triangle met, each weighted by its node's area over the root's */
} rk_bvh_measures;

rk_bvh_measures rk_bvh_measure(const rk_bvh *bvh);

/* Visits all nodes, parents before children and left before right: the callback gets each node
 * with its level (root: 0). */
typedef void rk_bvh_visitor(const rk_bvh_node *node, uint32_t level, void *context);
void rk_bvh_visit(const rk_bvh *bvh, rk_bvh_visitor *visitor, void *context);

/* The triangles below a node of a sound tree: bvh->triangles[begin .. begin + count - 1]. */
typedef struct rk_bvh_range {
    uint32_t begin, count;
} rk_bvh_range;

rk_bvh_range rk_bvh_range_of(const rk_bvh *bvh, uint32_t node);

/* True if the tree is sound: boxes nest and hold their triangles, every triangle is in one leaf
 * and the same as in the mesh, every node has one parent, no leaf is over-full, no path is too
 * deep. Otherwise false with the first fault found. */
bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error);

#endif
