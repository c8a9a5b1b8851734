/* The tree of eight children per node, for traversals that test eight boxes at once. */
#ifndef RK_SCENE_WIDE_TREE_H
#define RK_SCENE_WIDE_TREE_H

#include "scene/bvh.h"

enum {
    RK_WIDE_CHILDREN = 8,
    RK_WIDE_BLOCK = 4,
    /* The nodes on the way down leave at most seven children each on a traversal's stack. */
    RK_WIDE_STACK_MAX = RK_BVH_LEVELS_MAX * (RK_WIDE_CHILDREN - 1) + 1,
};

/* 256 bytes, four cache lines. The boxes of its children as a structure of arrays: four or eight
 * children are loaded by one instruction. Places without a child have empty boxes, and leaves
 * without blocks. */
typedef struct rk_wide_node {
    float side[2][3][RK_WIDE_CHILDREN]; /* lowest and highest; x, y, z; child */
    uint32_t child[RK_WIDE_CHILDREN];   /* see rk_wide_leaf */
    /* In which order rays hit the boxes, by the signs of their directions (bit 0: x is negative,
     * bit 1: y, bit 2: z): the place of a child in each four bits, the farthest in the lowest. */
    uint32_t order[8];
} rk_wide_node;

/* Up to four triangles of a leaf as a structure of arrays. Places without a triangle repeat the one
 * before them. 176 bytes. */
typedef struct rk_wide_block {
    float corner[3][3][RK_WIDE_BLOCK]; /* a, b, c; x, y, z; triangle */
    uint32_t index[RK_WIDE_BLOCK];     /* of the triangle in its mesh */
    float edge;                        /* the sizes |x| + |y| + |z| of all edges are at most this */
    float unused[3];
} rk_wide_block;

typedef struct rk_wide_bvh {
    uint32_t node_count, block_count; /* 0 for a tree without triangles */
    uint32_t triangle_count;
    rk_box box;
    rk_wide_node *nodes; /* nodes[0] is the root */
    rk_wide_block *blocks;
} rk_wide_bvh;

/* A child is the index of a node, or a leaf: its first block, and its number of blocks. */
#define RK_WIDE_LEAF 0x80000000u
#define RK_WIDE_BLOCK_BITS 26 /* for the index of a block, 268 million triangles in all */

static inline uint32_t rk_wide_leaf(uint32_t first_block, uint32_t blocks)
{
    return RK_WIDE_LEAF | blocks << RK_WIDE_BLOCK_BITS | first_block;
}

static inline uint32_t rk_wide_leaf_first(uint32_t leaf)
{
    return leaf & ((1u << RK_WIDE_BLOCK_BITS) - 1);
}

static inline uint32_t rk_wide_leaf_count(uint32_t leaf)
{
    return (leaf & ~RK_WIDE_LEAF) >> RK_WIDE_BLOCK_BITS;
}

/* Allocates nodes and blocks, both uninitialized; their counts are 0. False when memory is short.
 */
bool rk_wide_bvh_init(rk_wide_bvh *wide, uint32_t triangles, uint32_t nodes, uint32_t blocks,
                      rk_error *error);
void rk_wide_bvh_free(rk_wide_bvh *wide);

/* Fill in what traversals need besides boxes and children, and besides corners. */
void rk_wide_node_finish(rk_wide_node *node);
void rk_wide_block_finish(rk_wide_block *block);

/* The triangle at a place of a block, with the mesh's corners to the bit. */
static inline rk_triangle rk_wide_triangle(const rk_wide_block *block, uint32_t i)
{
    const float(*corner)[3][RK_WIDE_BLOCK] = block->corner;
    return (rk_triangle){{corner[0][0][i], corner[0][1][i], corner[0][2][i]},
                         {corner[1][0][i], corner[1][1][i], corner[1][2][i]},
                         {corner[2][0][i], corner[2][1][i], corner[2][2][i]},
                         block->index[i]};
}

/* The box of a child. */
static inline rk_box rk_wide_box(const rk_wide_node *node, uint32_t child)
{
    const float(*low)[RK_WIDE_CHILDREN] = node->side[0], (*high)[RK_WIDE_CHILDREN] = node->side[1];
    return (rk_box){{{low[0][child], low[1][child], low[2][child]},
                     {high[0][child], high[1][child], high[2][child]}}};
}

/* Makes a binary tree of the same leaves, for those who need its boxes; deeper than
 * RK_BVH_LEVELS_MAX a whole subtree is one leaf. False when memory is short. Release with
 * rk_bvh_free. */
bool rk_bvh_of_wide(rk_bvh *bvh, const rk_wide_bvh *wide, rk_error *error);

/* True if every triangle of the mesh is in the leaves exactly once and equal to the mesh's, boxes
 * nest, and no path is deeper than RK_BVH_LEVELS_MAX; otherwise false with the first fault. */
bool rk_wide_bvh_validate(const rk_wide_bvh *wide, const rk_mesh *mesh, rk_error *error);

#endif
