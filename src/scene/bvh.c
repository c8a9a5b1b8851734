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

static bool box_holds(const rk_box *outer, const rk_box *inner)
{
    const rk_vec3 *o = outer->corner, *i = inner->corner;
    return o[0].x <= i[0].x && o[0].y <= i[0].y && o[0].z <= i[0].z && o[1].x >= i[1].x &&
           o[1].y >= i[1].y && o[1].z >= i[1].z;
}

static rk_box triangle_box(const rk_mesh *mesh, uint32_t index)
{
    rk_box box = rk_box_empty();
    for (int k = 0; k < 3; k++)
        box = rk_box_add(box, mesh->positions[mesh->triangles[index][k]]);
    return box;
}

typedef struct validation {
    const rk_bvh *bvh;
    const rk_mesh *mesh;
    unsigned char *reached; /* per node: was it visited? */
    unsigned char *seen;    /* per triangle of the mesh: is it in a leaf? */
    bool sound;
    rk_error *error;
} validation;

static void fault(validation *v, const char *what, const char *unit, uint32_t number)
{
    if (v->sound)
        v->sound = rk_fail(v->error, "tree: %s (%s %u)", what, unit, number);
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

static void validate_leaf(validation *v, const rk_bvh_node *node)
{
    if (node->count > RK_BVH_LEAF_MAX)
        fault(v, "a leaf holds too many triangles", "it has", node->count);
    if (node->first > v->bvh->triangle_count ||
        node->count > v->bvh->triangle_count - node->first) {
        fault(v, "a leaf points past the triangles", "first", node->first);
        return;
    }
    for (uint32_t i = node->first; i < node->first + node->count; i++) {
        uint32_t index = v->bvh->triangles[i].index;
        if (index >= v->mesh->triangle_count) {
            fault(v, "a leaf has a triangle that the mesh does not have", "triangle", index);
            continue;
        }
        if (v->seen[index])
            fault(v, "a triangle is in the leaves twice", "triangle", index);
        v->seen[index] = 1;
        if (!is_copy(&v->bvh->triangles[i], v->mesh))
            fault(v, "a leaf's copy of a triangle differs from the mesh's", "triangle", index);
        rk_box box = triangle_box(v->mesh, index);
        if (!box_holds(&node->box, &box))
            fault(v, "a triangle sticks out of its leaf's box", "triangle", index);
    }
}

static void validate_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    validation *v = context;
    uint32_t place = (uint32_t)(node - v->bvh->nodes);
    if (v->reached[place])
        fault(v, "a node has two parents, or the nodes form a cycle", "node", place);
    v->reached[place] = 1;
    if (node->count) {
        validate_leaf(v, node);
        return;
    }
    if (level + 1 >= RK_BVH_LEVELS_MAX) {
        fault(v, "a path is deeper than a traversal's stack", "level", level + 1);
        return;
    }
    if (node->first < 2 || node->first % 2 || node->first + 1 >= v->bvh->node_count) {
        fault(v, "an inner node's children are outside the nodes, or at an odd index", "first",
              node->first);
        return;
    }
    for (uint32_t child = node->first; child < node->first + 2; child++)
        if (!box_holds(&node->box, &v->bvh->nodes[child].box))
            fault(v, "a child's box sticks out of its parent's", "node", child);
}

bool rk_bvh_validate(const rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    validation v = {bvh, mesh, NULL, NULL, true, error};
    v.reached = rk_allocate(bvh->node_count, 1, "tree check", error);
    v.seen = rk_allocate(mesh->triangle_count, 1, "tree check", error);
    v.sound = v.reached && v.seen;
    if (v.sound)
        rk_bvh_visit(bvh, validate_node, &v);
    for (uint32_t i = 0; v.sound && i < mesh->triangle_count; i++)
        if (!v.seen[i])
            fault(&v, "a triangle is in no leaf", "triangle", i);
    free(v.reached);
    free(v.seen);
    return v.sound;
}
