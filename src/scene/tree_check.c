/* Is a tree sound? rk_bvh_validate of scene/bvh.h, and the same for scene/wide_tree.h: each node
 * has one parent, each triangle of the mesh is in one leaf, as a copy within the leaf's box. Of
 * several faults the first is told. */
#include "scene/wide_tree.h"

#include <stdlib.h>

typedef struct validation {
    const char *tree;  /* its kind, for messages */
    const rk_bvh *bvh; /* one of the two */
    const rk_wide_bvh *wide;
    const rk_mesh *mesh;
    rk_error *error;
    unsigned char *reached; /* per node: was it visited? */
    unsigned char *seen;    /* per triangle of the mesh: is it in a leaf? */
    bool sound;
} validation;

/* A sound tree has at most two nodes per triangle. What counts more is no tree, and asks for memory
 * that the machine may not have. */
static bool begin(validation *v, const void *nodes, uint32_t node_count)
{
    if ((node_count && !nodes) || node_count / 2 > v->mesh->triangle_count + 1)
        return rk_fail(v->error, "%s: %s (nodes %u)", v->tree,
                       nodes ? "there are more nodes than triangles need"
                             : "nodes are counted, but there are none",
                       node_count);
    v->reached = rk_allocate(node_count, 1, "tree check", v->error);
    v->seen = rk_allocate(v->mesh->triangle_count, 1, "tree check", v->error);
    v->sound = v->reached && v->seen;
    return v->sound;
}

static void fault(validation *v, const char *what, const char *unit, uint32_t number)
{
    if (v->sound)
        v->sound = rk_fail(v->error, "%s: %s (%s %u)", v->tree, what, unit, number);
}

static bool reach(validation *v, uint32_t index)
{
    if (v->reached[index]) {
        fault(v, "a node has two parents, or the nodes form a cycle", "node", index);
        return false;
    }
    v->reached[index] = 1;
    return true;
}

static bool box_holds(const rk_box *outer, const rk_box *inner)
{
    const rk_vec3 *o = outer->corner, *i = inner->corner;
    return o[0].x <= i[0].x && o[0].y <= i[0].y && o[0].z <= i[0].z && o[1].x >= i[1].x &&
           o[1].y >= i[1].y && o[1].z >= i[1].z;
}

static void check_box(validation *v, const rk_box *parent, const rk_box *child, uint32_t index)
{
    if (!box_holds(parent, child))
        fault(v, "a child's box sticks out of its parent's", "node", index);
}

static bool same_point(rk_vec3 a, rk_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool is_copy(const rk_triangle *triangle, const rk_mesh *mesh)
{
    const uint32_t *corner = mesh->triangles[triangle->index];
    return same_point(triangle->a, mesh->positions[corner[0]]) &&
           same_point(triangle->b, mesh->positions[corner[1]]) &&
           same_point(triangle->c, mesh->positions[corner[2]]);
}

static rk_box box_of(const rk_triangle *triangle)
{
    return rk_box_add(rk_box_add(rk_box_add(rk_box_empty(), triangle->a), triangle->b),
                      triangle->c);
}

static void check_triangle(validation *v, const rk_triangle *triangle, const rk_box *leaf,
                           bool again)
{
    const uint32_t index = triangle->index;
    if (index >= v->mesh->triangle_count) {
        fault(v, "a leaf has a triangle that the mesh does not have", "triangle", index);
        return;
    }
    const rk_box box = box_of(triangle);
    if (!is_copy(triangle, v->mesh))
        fault(v, "a leaf's copy of a triangle differs from the mesh's", "triangle", index);
    if (!box_holds(leaf, &box))
        fault(v, "a triangle sticks out of its leaf's box", "triangle", index);
    if (v->seen[index] && !again)
        fault(v, "a triangle is in the leaves twice", "triangle", index);
    v->seen[index] = 1;
}

static bool end(validation *v)
{
    for (uint32_t i = 0; v->sound && i < v->mesh->triangle_count; i++)
        if (!v->seen[i])
            fault(v, "a triangle is in no leaf", "triangle", i);
    free(v->reached);
    free(v->seen);
    return v->sound;
}

/* --- binary trees --- */

static void check_leaf(validation *v, const rk_bvh_node *node)
{
    if (node->count > RK_BVH_LEAF_MAX)
        fault(v, "a leaf holds too many triangles", "it has", node->count);
    if (node->first > v->bvh->triangle_count ||
        node->count > v->bvh->triangle_count - node->first) {
        fault(v, "a leaf points past the triangles", "first", node->first);
        return;
    }
    for (uint32_t i = node->first; i < node->first + node->count; i++)
        check_triangle(v, &v->bvh->triangles[i], &node->box, false);
}

static void check_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    validation *v = context;
    reach(v, (uint32_t)(node - v->bvh->nodes));
    if (node->count)
        check_leaf(v, node);
    else if (level + 1 >= RK_BVH_LEVELS_MAX)
        fault(v, "a path is deeper than a traversal's stack", "level", level + 1);
    else if (node->first < 2 || node->first % 2 || node->first + 1 >= v->bvh->node_count)
        fault(v, "an inner node's children are beyond node_count, or at an odd index", "first",
              node->first);
    else
        for (uint32_t child = node->first; child < node->first + 2; child++)
            check_box(v, &node->box, &v->bvh->nodes[child].box, child);
}

bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    validation v = {.tree = "tree", .bvh = bvh, .mesh = mesh, .error = error};
    if (begin(&v, bvh->nodes, bvh->node_count))
        rk_bvh_visit(bvh, check_node, &v);
    return end(&v);
}

/* --- wide trees --- */

static void check_block(validation *v, const rk_wide_block *block, const rk_box *box)
{
    for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
        const rk_triangle triangle = rk_wide_triangle(block, i);
        check_triangle(v, &triangle, box, i > 0 && triangle.index == block->index[i - 1]);
    }
}

static void check_wide_leaf(validation *v, uint32_t leaf, const rk_box *box)
{
    uint32_t first = rk_wide_leaf_first(leaf), count = rk_wide_leaf_count(leaf);
    if (count > RK_BVH_LEAF_MAX / RK_WIDE_BLOCK)
        fault(v, "a leaf has too many blocks", "blocks", count);
    if (first > v->wide->block_count || count > v->wide->block_count - first) {
        fault(v, "a leaf points past the blocks", "first", first);
        return;
    }
    for (uint32_t i = first; i < first + count; i++)
        check_block(v, &v->wide->blocks[i], box);
}

/* Recurses no deeper than RK_BVH_LEVELS_MAX. */
static void check_wide_node(validation *v, uint32_t index, const rk_box *box, uint32_t level)
{
    if (index >= v->wide->node_count) {
        fault(v, "a child is outside the nodes", "node", index);
        return;
    }
    if (!reach(v, index))
        return;
    if (level >= RK_BVH_LEVELS_MAX) {
        fault(v, "a path is deeper than a traversal's stack", "level", level);
        return;
    }
    const rk_wide_node *node = &v->wide->nodes[index];
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        const rk_box child = rk_wide_box(node, i);
        if (node->child[i] == rk_wide_leaf(0, 0))
            continue;
        check_box(v, box, &child, index);
        if (node->child[i] & RK_WIDE_LEAF)
            check_wide_leaf(v, node->child[i], &child);
        else
            check_wide_node(v, node->child[i], &child, level + 1);
    }
}

bool rk_wide_bvh_validate(const rk_wide_bvh *wide, const rk_mesh *mesh, rk_error *error)
{
    const rk_box everything = {{{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}}};
    validation v = {.tree = "wide tree", .wide = wide, .mesh = mesh, .error = error};
    if (begin(&v, wide->nodes, wide->node_count) && wide->node_count)
        check_wide_node(&v, 0, &everything, 0);
    return end(&v);
}
