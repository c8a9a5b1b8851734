/* Each node stores the order of its children for the eight combinations of a ray's signs, so that a
 * traversal sorts nothing. The same tree in binary serves the views that draw boxes. */
#include "scene/wide_tree.h"

#include <stdlib.h>
#include <string.h>

bool rk_wide_bvh_init(rk_wide_bvh *wide, uint32_t triangles, uint32_t nodes, uint32_t blocks,
                      rk_error *error)
{
    *wide = (rk_wide_bvh){.triangle_count = triangles};
    wide->nodes = rk_allocate_unset(nodes, sizeof *wide->nodes, "tree", error);
    wide->blocks = rk_allocate_unset(blocks, sizeof *wide->blocks, "tree", error);
    if (wide->nodes && wide->blocks)
        return true;
    rk_wide_bvh_free(wide);
    return false;
}

void rk_wide_bvh_free(rk_wide_bvh *wide)
{
    free(wide->nodes);
    free(wide->blocks);
    *wide = (rk_wide_bvh){0};
}

/* The order along the diagonal that points away from rays with these signs: a box whose middle is
 * nearer is hit first, if not always. A place's number is how many others are farther away, of
 * equal ones those before it. */
static uint32_t order_for(const rk_simd4 along[2])
{
    const rk_simd4_mask places[2] = {{0, 1, 2, 3}, {4, 5, 6, 7}};
    rk_simd4_mask number[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
    for (int i = 0; i < RK_WIDE_CHILDREN; i++) {
        const rk_simd4 other = rk_simd4_all(along[i / 4][i % 4]);
        for (int half = 0; half < 2; half++)
            number[half] -= (other > along[half]) | ((other == along[half]) & (places[half] > i));
    }
    uint32_t order = 0;
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++)
        order |= i << (4 * number[i / 4][i % 4]);
    return order;
}

/* Places without a child are the farthest away for all. */
void rk_wide_node_finish(rk_wide_node *node)
{
    const rk_simd4 half_of = rk_simd4_all(0.5f);
    rk_simd4 middle[3][2];
    for (int axis = 0; axis < 3; axis++)
        for (int half = 0; half < 2; half++)
            middle[axis][half] = rk_simd4_load(&node->side[0][axis][4 * half]) * half_of +
                                 rk_simd4_load(&node->side[1][axis][4 * half]) * half_of;
    for (uint32_t signs = 0; signs < 8; signs++) {
        rk_simd4 along[2];
        for (int half = 0; half < 2; half++) {
            const rk_simd4 x = middle[0][half], y = middle[1][half], z = middle[2][half];
            along[half] = (signs & 1 ? -x : x) + (signs & 2 ? -y : y) + (signs & 4 ? -z : z);
            along[half] =
                rk_simd4_select(along[half] == along[half], along[half], rk_simd4_all(INFINITY));
        }
        node->order[signs] = order_for(along);
    }
}

void rk_wide_block_finish(rk_wide_block *block)
{
    double largest = 0;
    for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
        rk_triangle triangle = rk_wide_triangle(block, i);
        rk_dvec3 a = rk_widen(triangle.a);
        double ab = rk_dvec3_size(rk_dmadd(rk_widen(triangle.b), a, -1));
        double ac = rk_dvec3_size(rk_dmadd(rk_widen(triangle.c), a, -1));
        largest = ab > largest ? ab : largest;
        largest = ac > largest ? ac : largest;
    }
    block->edge = nextafterf((float)largest, INFINITY);
    memset(block->unused, 0, sizeof block->unused);
}

/* --- The same in binary ----------------------------------------------------------------------- */

/* Some children of a node. */
typedef struct siblings {
    const rk_wide_node *node;
    uint32_t count, place[RK_WIDE_CHILDREN];
} siblings;

static siblings children_of(const rk_wide_node *node)
{
    siblings s = {.node = node};
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++)
        if (!(node->child[i] & RK_WIDE_LEAF) || rk_wide_leaf_count(node->child[i]) > 0)
            s.place[s.count++] = i;
    return s;
}

static void copy_blocks(rk_bvh *bvh, const rk_wide_bvh *wide, uint32_t leaf)
{
    const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(leaf)];
    for (uint32_t k = 0; k < rk_wide_leaf_count(leaf); k++)
        for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++)
            if (i == 0 || block[k].index[i] != block[k].index[i - 1])
                bvh->triangles[bvh->triangle_count++] = rk_wide_triangle(&block[k], i);
}

static void copy_leaves(rk_bvh *bvh, const rk_wide_bvh *wide, const siblings *s)
{
    for (uint32_t i = 0; i < s->count; i++) {
        const uint32_t child = s->node->child[s->place[i]];
        if (child & RK_WIDE_LEAF) {
            copy_blocks(bvh, wide, child);
            continue;
        }
        const siblings below = children_of(&wide->nodes[child]);
        copy_leaves(bvh, wide, &below);
    }
}

/* Fills in the node at `at` for siblings that it has below itself. */
static void copy_siblings(rk_bvh *bvh, uint32_t at, const rk_wide_bvh *wide, siblings s,
                          uint32_t level)
{
    rk_box box = rk_wide_box(s.node, s.place[0]);
    for (uint32_t i = 1; i < s.count; i++)
        box = rk_box_merge(box, rk_wide_box(s.node, s.place[i]));
    const uint32_t child = s.node->child[s.place[0]], first = bvh->triangle_count;
    if ((s.count == 1 && child & RK_WIDE_LEAF) || level == RK_BVH_LEVELS_MAX) {
        copy_leaves(bvh, wide, &s);
        bvh->nodes[at] = (rk_bvh_node){box, first, bvh->triangle_count - first};
        return;
    }
    if (s.count == 1) {
        copy_siblings(bvh, at, wide, children_of(&wide->nodes[child]), level);
        return;
    }
    const uint32_t pair = bvh->node_count;
    bvh->node_count += 2;
    siblings half[2] = {{.node = s.node}, {.node = s.node}};
    for (uint32_t i = 0; i < s.count; i++) {
        siblings *h = &half[i >= s.count / 2];
        h->place[h->count++] = s.place[i];
    }
    bvh->nodes[at] = (rk_bvh_node){box, pair, 0};
    copy_siblings(bvh, pair, wide, half[0], level + 1);
    copy_siblings(bvh, pair + 1, wide, half[1], level + 1);
}

bool rk_bvh_of_wide(rk_bvh *bvh, const rk_wide_bvh *wide, rk_error *error)
{
    if (!rk_bvh_init(bvh, wide->triangle_count, wide->triangle_count, error))
        return false;
    bvh->triangle_count = 0;
    if (wide->node_count == 0)
        return true;
    bvh->node_count = 2;
    copy_siblings(bvh, 0, wide, children_of(&wide->nodes[0]), 1);
    return true;
}
