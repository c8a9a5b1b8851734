/* What a tree is made of: nodes, blocks, and the steps that a ray is expected to take; and the
 * table of
 * --occupancy. */
#include "driver.h"

#include <stdio.h>

/* --- Binary ----------------------------------------------------------------------------------- */

static void add_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    tree_shape *tree = context;
    const double area = rk_box_area(node->box);
    const uint32_t full = node->count / RK_WIDE_BLOCK, left = node->count % RK_WIDE_BLOCK;
    const double blocks = full + (left ? 1 : 0);
    (void)level;
    tree->nodes += node->count == 0;
    tree->blocks += blocks;
    tree->steps += node->count ? blocks * area : area;
    tree->triangles_of[RK_WIDE_BLOCK] += full;
    tree->triangles_of[left] += left ? 1 : 0;
}

tree_shape shape_of_binary(const rk_bvh *bvh)
{
    tree_shape tree = {.bytes = (double)bvh->node_count * sizeof *bvh->nodes +
                                (double)bvh->triangle_count * sizeof *bvh->triangles};
    rk_bvh_visit(bvh, add_node, &tree);
    tree.children = 2 * tree.nodes;
    tree.children_of[2] = tree.nodes;
    if (bvh->node_count)
        tree.steps /= rk_box_area(bvh->nodes[0].box);
    return tree;
}

/* --- Wide ------------------------------------------------------------------------------------- */

static void add_wide_node(tree_shape *tree, const rk_wide_node *node)
{
    uint32_t children = 0;
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        const uint32_t child = node->child[i];
        if (is_vacant(node, i))
            continue;
        children++;
        tree->steps += rk_box_area(rk_wide_box(node, i)) *
                       (child & RK_WIDE_LEAF ? rk_wide_leaf_count(child) : 1);
    }
    tree->children += children;
    tree->children_of[children]++;
}

static uint32_t triangles_in(const rk_wide_block *block)
{
    uint32_t count = 1;
    for (uint32_t i = 1; i < RK_WIDE_BLOCK; i++)
        count += block->index[i] != block->index[i - 1];
    return count;
}

tree_shape shape_of_wide(const rk_wide_bvh *wide)
{
    tree_shape tree = {.nodes = wide->node_count,
                       .blocks = wide->block_count,
                       .bytes = (double)wide->node_count * sizeof *wide->nodes +
                                (double)wide->block_count * sizeof *wide->blocks,
                       .steps = rk_box_area(wide->box)};
    for (uint32_t i = 0; i < wide->node_count; i++)
        add_wide_node(&tree, &wide->nodes[i]);
    for (uint32_t i = 0; i < wide->block_count; i++)
        tree.triangles_of[triangles_in(&wide->blocks[i])]++;
    tree.steps /= rk_box_area(wide->box);
    return tree;
}

/* --- Occupancy -------------------------------------------------------------------------------- */

static bool put_share(const rk_driver *driver, const char *what, uint32_t number, double part,
                      double all, rk_error *error)
{
    static const char *const header[] = {"scene", "method", "what", "number", "share"};
    const rk_accel asked = {.kind = driver->split, .bins = driver->bins};
    const rk_accel_title method = rk_accel_name(&asked);
    char path[4096], texts[2][32];
    snprintf(texts[0], sizeof texts[0], "%u", number);
    snprintf(texts[1], sizeof texts[1], "%.4g", all > 0 ? 100 * part / all : 0);
    const char *cells[] = {driver->scene.name, method.text, what, texts[0], texts[1]};
    if (!driver->quiet)
        printf("%s with %u: %s %%\n", what, number, texts[1]);
    return rk_driver_table(driver, "wide_bvh_occupancy", path, error) &&
           rk_table_put(path, header, cells, 5, 4, error);
}

bool put_occupancy(rk_driver *driver, rk_error *error)
{
    const tree_shape tree = shape_of_wide(wide_tree(driver));
    bool ok = true;
    for (uint32_t i = 1; ok && i <= RK_WIDE_CHILDREN; i++)
        ok = put_share(driver, "nodes", i, tree.children_of[i], tree.nodes, error);
    for (uint32_t i = 1; ok && i <= RK_WIDE_BLOCK; i++)
        ok = put_share(driver, "blocks", i, tree.triangles_of[i], tree.blocks, error);
    return ok;
}
