/* rk_pyramid_is_empty of accel/query/pyramid.h: a search of the scene's trees for what reaches in.
 */
#include "accel/query/pyramid_outline.h"
#include "accel/query/tree.h"

/* What is done, and for which pyramid. */
typedef struct search {
    const rk_pyramid *pyramid;
    rk_pyramid_obstacle *obstacle;
    rk_counters *counters;
} search;

static bool is_obstacle(const search *s, const rk_triangle *triangle)
{
    s->counters->triangle_tests++;
    if (rk_pyramid_excludes_triangle(s->pyramid, triangle))
        return false;
    *s->obstacle = (rk_pyramid_obstacle){true, *triangle};
    return true;
}

static bool has_obstacle(const search *s, const outline *o, const rk_wide_block *block)
{
    for (uint32_t inside = triangles_inside(o, block); inside; inside &= inside - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(inside);
        const rk_triangle triangle = rk_wide_triangle(block, i);
        if (is_obstacle(s, &triangle))
            return true;
    }
    return false;
}

static uint32_t children_inside(const outline *o, const rk_wide_node *node)
{
    uint32_t inside = 0;
    for (int half = 0; half < 2; half++) {
        four_boxes boxes;
        for (int k = 0; k < 3; k++) {
            boxes.side[0][k] = rk_simd4_load(&node->side[0][k][4 * half]);
            boxes.side[1][k] = rk_simd4_load(&node->side[1][k][4 * half]);
        }
        inside |= boxes_inside(o, &boxes) << 4 * half;
    }
    return inside;
}

static bool is_wide_tree_outside(const search *s, const rk_wide_bvh *wide)
{
    const outline o = outline_of(s->pyramid, reach_of(s->pyramid, wide->box));
    uint32_t stack[RK_WIDE_STACK_MAX + RK_WIDE_CHILDREN], left = 0;
    stack[left++] = 0;
    while (left > 0) {
        const uint32_t child = stack[--left];
        const uint32_t blocks = child & RK_WIDE_LEAF ? rk_wide_leaf_count(child) : 0;
        for (uint32_t k = 0; k < blocks; k++)
            if (has_obstacle(s, &o, &wide->blocks[rk_wide_leaf_first(child) + k]))
                return false;
        if (child & RK_WIDE_LEAF)
            continue;
        const rk_wide_node *node = &wide->nodes[child];
        s->counters->box_tests += RK_WIDE_CHILDREN;
        for (uint32_t inside = children_inside(&o, node); inside; inside &= inside - 1)
            stack[left++] = node->child[__builtin_ctz(inside)];
    }
    return true;
}

/* The boxes of two nodes, each twice. */
static four_boxes boxes_of(const rk_bvh_node *pair)
{
    four_boxes boxes;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3; k++) {
            const float a = rk_axis(pair[0].box.corner[side], k);
            const float b = rk_axis(pair[1].box.corner[side], k);
            boxes.side[side][k] = (rk_simd4){a, b, a, b};
        }
    return boxes;
}

static bool is_binary_tree_outside(const search *s, const rk_bvh *bvh)
{
    const outline o = outline_of(s->pyramid, reach_of(s->pyramid, bvh->nodes[0].box));
    const rk_bvh_node *stack[RK_BVH_LEVELS_MAX + 2];
    uint32_t left = 0;
    stack[left++] = &bvh->nodes[0];
    while (left > 0) {
        const rk_bvh_node *node = stack[--left];
        for (uint32_t k = 0; k < node->count; k++)
            if (is_obstacle(s, &bvh->triangles[node->first + k]))
                return false;
        if (node->count > 0)
            continue;
        const rk_bvh_node *pair = &bvh->nodes[node->first];
        const four_boxes boxes = boxes_of(pair);
        const uint32_t inside = boxes_inside(&o, &boxes);
        s->counters->box_tests += 2;
        stack[left] = &pair[0];
        left += inside & 1;
        stack[left] = &pair[1];
        left += inside >> 1 & 1;
    }
    return true;
}

static bool is_tree_outside(const search *s, rk_tree tree)
{
    if (tree.kernel)
        return tree.wide->node_count == 0 || is_wide_tree_outside(s, tree.wide);
    return tree.bvh->node_count == 0 || is_binary_tree_outside(s, tree.bvh);
}

bool rk_pyramid_is_empty(const rk_pyramid *pyramid, const rk_accel *accel,
                         rk_pyramid_obstacle *obstacle, rk_counters *counters)
{
    const search s = {pyramid, obstacle, counters};
    const rk_scene *scene = accel->scene;
    /* Where float could overflow or lose digits; not so with NaN, either. */
    if (!(pyramid->slack > 0x1p-120 && pyramid->slack < 0x1p80))
        return false;
    if (obstacle->known && is_obstacle(&s, &obstacle->triangle))
        return false;
    for (uint32_t i = 0; i < scene->sphere_count; i++) {
        counters->sphere_tests++;
        if (!rk_pyramid_excludes_sphere(pyramid, &scene->spheres[i]))
            return false;
    }
    bool is_empty = is_tree_outside(&s, rk_accel_static_tree(accel));
    for (uint32_t i = 0; i < scene->moving_count && is_empty; i++)
        is_empty = is_tree_outside(&s, rk_accel_moving_tree(accel, i));
    return is_empty;
}
