/* The binary tree over a mesh's triangles that all builders make and all traversals read. */
#ifndef RK_SCENE_BVH_H
#define RK_SCENE_BVH_H

#include "base/box.h"
#include "base/error.h"
#include "base/triangle.h"
#include "scene/mesh.h"

/* 32 bytes, so that a pair of children fills one cache line. */
typedef struct rk_bvh_node {
    rk_box box;
    uint32_t first; /* inner: the left child, before the right one; leaf: its first triangle */
    uint32_t count; /* triangles of a leaf; 0 for an inner node */
} rk_bvh_node;

typedef struct rk_bvh {
    uint32_t node_count; /* entries of `nodes` in use; 0 for a tree without triangles */
    uint32_t triangle_count;
    rk_bvh_node *nodes; /* nodes[0] is the root; nodes[1] is unused: pairs start at even indices */
    rk_triangle *triangles; /* triangle_count, in the order of the leaves */
} rk_bvh;

enum {
    /* For builders that do not compute costs: up to about four triangles, testing them all costs
     * less than testing two more boxes and choosing. */
    RK_BVH_LEAF_TARGET = 4,
    /* No builder may make a larger leaf, whatever the costs: splitting even this one adds no more
     * than 1.5 to the 64 tests, some of which it may save. */
    RK_BVH_LEAF_MAX = 64,
    /* No builder may go deeper, so a traversal stack fits an array of this size. */
    RK_BVH_LEVELS_MAX = 64,
};

/* Nodes that a traversal has still to visit, the next one last. */
typedef struct rk_traversal_stack {
    uint32_t size;
    struct {
        const rk_bvh_node *node;
        float enter; /* where the ray enters the node's box */
    } entries[RK_BVH_LEVELS_MAX];
} rk_traversal_stack;

/* The cost of visiting an inner node and of testing a triangle, as the classic course weights
 * them. */
#define RK_BVH_TRAVERSAL_COST 1.5
#define RK_BVH_INTERSECTION_COST 1.0

/* Allocates `triangles` triangles and nodes for up to `leaves` leaves, both uninitialized;
 * node_count is 0. False when memory is short. */
bool rk_bvh_init(rk_bvh *bvh, uint32_t triangles, uint32_t leaves, rk_error *error);
void rk_bvh_free(rk_bvh *bvh);

typedef struct rk_bvh_measures {
    uint32_t levels; /* 0 without triangles, 1 for a single leaf */
    uint32_t leaves;
    double sah_cost; /* expected cost of a ray that hits the root: 1.5 per inner node and 1 per
                        triangle, each weighted by its node's area over the root's */
} rk_bvh_measures;

rk_bvh_measures rk_bvh_measure(const rk_bvh *bvh);

/* Visits all nodes, parents before children and left before right: the callback gets each node and
 * its level (root: 0). */
typedef void rk_bvh_visitor(const rk_bvh_node *node, uint32_t level, void *context);
void rk_bvh_visit(const rk_bvh *bvh, rk_bvh_visitor *visitor, void *context);

/* The triangles below a node of a valid tree: bvh->triangles[begin .. begin + count - 1]. */
typedef struct rk_bvh_range {
    uint32_t begin, count;
} rk_bvh_range;

rk_bvh_range rk_bvh_range_of(const rk_bvh *bvh, uint32_t node);

/* True if the tree is valid: boxes nest and contain their triangles, every triangle is in exactly
 * one leaf and equal to the mesh's, every node has one parent, no leaf is too large and no path too
 * deep. Otherwise false with the first fault. */
bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error);

#endif
