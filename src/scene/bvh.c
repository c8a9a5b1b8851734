/* Memory; a visit of all nodes that survives invalid trees, such as a student's builder may make;
 * and the measures of a tree, which such a visit finds. */
#include "scene/bvh.h"

#include <stdlib.h>

bool rk_bvh_init(rk_bvh *bvh, uint32_t triangles, uint32_t leaves, rk_error *error)
{
    *bvh = (rk_bvh){.triangle_count = triangles};
    bvh->nodes = rk_allocate_unset(2 * (size_t)leaves, sizeof *bvh->nodes, "tree", error);
    bvh->triangles = rk_allocate_unset(triangles, sizeof *bvh->triangles, "tree", error);
    if (bvh->nodes && bvh->triangles)
        return true;
    rk_bvh_free(bvh);
    return false;
}

void rk_bvh_free(rk_bvh *bvh)
{
    free(bvh->nodes);
    free(bvh->triangles);
    *bvh = (rk_bvh){0};
}

typedef struct stack_entry {
    uint32_t node, level;
} stack_entry;

void rk_bvh_visit(const rk_bvh *bvh, rk_bvh_visitor *visitor, void *context)
{
    if (bvh->node_count == 0)
        return;
    stack_entry stack[RK_BVH_LEVELS_MAX];
    uint32_t size = 0;
    stack[size++] = (stack_entry){0, 0};
    /* An invalid tree may have cycles or children outside the array: visit no more nodes than there
     * are, and only existing ones. */
    for (uint32_t visits = 0; size && visits < bvh->node_count; visits++) {
        stack_entry top = stack[--size];
        const rk_bvh_node *node = &bvh->nodes[top.node];
        visitor(node, top.level, context);
        if (node->count || top.level + 1 >= RK_BVH_LEVELS_MAX || node->first >= bvh->node_count - 1)
            continue;
        stack[size++] = (stack_entry){node->first + 1, top.level + 1};
        stack[size++] = (stack_entry){node->first, top.level + 1};
    }
}

typedef struct measuring {
    rk_bvh_measures measures;
    double weighted_cost; /* the sum of cost times area */
} measuring;

static void measure_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    measuring *m = context;
    if (level + 1 > m->measures.levels)
        m->measures.levels = level + 1;
    if (node->count)
        m->measures.leaves++;
    m->weighted_cost +=
        rk_box_area(node->box) *
        (node->count ? RK_BVH_INTERSECTION_COST * node->count : RK_BVH_TRAVERSAL_COST);
}

rk_bvh_measures rk_bvh_measure(const rk_bvh *bvh)
{
    measuring m = {{0}, 0};
    rk_bvh_visit(bvh, measure_node, &m);
    double root = bvh->node_count ? rk_box_area(bvh->nodes[0].box) : 0;
    m.measures.sah_cost = root > 0 ? m.weighted_cost / root : 0;
    return m.measures;
}

rk_bvh_range rk_bvh_range_of(const rk_bvh *bvh, uint32_t node)
{
    uint32_t first = node, last = node;
    while (bvh->nodes[first].count == 0)
        first = bvh->nodes[first].first;
    while (bvh->nodes[last].count == 0)
        last = bvh->nodes[last].first + 1;
    uint32_t begin = bvh->nodes[first].first;
    return (rk_bvh_range){begin, bvh->nodes[last].first + bvh->nodes[last].count - begin};
}
