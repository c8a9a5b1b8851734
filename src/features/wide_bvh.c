/* A step of a traversal costs nearly the same whether it tests two boxes or eight, because it
 * waits: for memory, for the result of a comparison, for a branch that was guessed wrong. So a tree
 * of fewer, wider steps is faster. This one is a binary tree of which two levels of three are left
 * out: a node adopts the children of its children until it has eight.
 * Wald, Benthin, Boulos, "Getting rid of packets: efficient SIMD single-ray traversal using
 * multi-branching BVHs", 2008; Dammertz, Hanika, Keller, "Shallow bounding volume hierarchies for
 * fast SIMD ray tracing of incoherent rays", 2008. */
#include "features/wide_bvh.h"

#include <stdlib.h>

/* The cost of visiting a node, and of testing a block, both of which take about as long. */
static const double node_cost = 1, block_cost = 1;

/* What is best to do with a node of the binary tree. */
typedef struct plan {
    uint32_t begin, count; /* its triangles */
    bool is_leaf;          /* as a single child: a leaf or a node? */
    /* Where up to i children may stand for the node, so many of them stand for its left child and
     * for its right one; 0 if it is better a single child itself. */
    unsigned char left[RK_WIDE_CHILDREN + 1], right[RK_WIDE_CHILDREN + 1];
    double cost[RK_WIDE_CHILDREN]; /* of up to i children */
} plan;

/* The children of a wide node, as nodes of the binary tree. */
typedef struct brood {
    uint32_t count;
    uint32_t nodes[RK_WIDE_CHILDREN];
} brood;

/* What the tree will need. */
typedef struct part_count {
    uint32_t nodes;
    uint64_t blocks;
} part_count;

/* A node of the binary tree that becomes a wide one. */
typedef struct unbuilt {
    uint32_t binary, wide;
} unbuilt;

/* Children that a traversal has still to visit, the next one last. */
typedef struct wide_stack {
    uint32_t size;
    struct {
        uint32_t child;
        float enter; /* where the ray enters its box */
    } entries[RK_WIDE_STACK_MAX];
} wide_stack;

/* Contents, in the order of the chapter. */
static uint32_t blocks_of(uint32_t triangles);
static double leaf_cost(const rk_bvh_node *node, uint32_t count);
static double share(plan *p, const plan *left, const plan *right, uint32_t children);
static void make_plan(plan *plans, const rk_bvh *bvh, uint32_t node);
static void add_children(brood *children, const plan *plans, const rk_bvh *bvh, uint32_t node,
                         uint32_t most);
static brood children_of(const plan *plans, const rk_bvh *bvh, uint32_t node);
static part_count count_parts(const plan *plans, const rk_bvh *bvh);
static void fill_block(rk_wide_block *block, const rk_triangle *triangles, uint32_t count);
static uint32_t add_leaf(rk_wide_bvh *wide, const rk_bvh *bvh, const plan *p);
static void put_child(rk_wide_node *node, uint32_t place, const rk_box *box, uint32_t child);
static void collapse(rk_wide_bvh *wide, const plan *plans, const rk_bvh *bvh);
static inline uint32_t enter_children(const rk_wide_node *node, const rk_slabs *slabs, float t_max,
                                      float enter[RK_WIDE_CHILDREN]);
static inline void push_sorted(wide_stack *stack, const rk_wide_node *node, uint32_t entered,
                               const float enter[RK_WIDE_CHILDREN]);
static inline uint32_t may_hit(const rk_wide_block *block, const rk_ray *ray, float t_max);
static void closest_in_block(const rk_wide_block *block, const rk_ray *ray, rk_hit *hit);
static bool block_occludes(const rk_wide_block *block, const rk_ray *ray);

/* --- Which nodes to keep ---------------------------------------------------------------------- */

static uint32_t blocks_of(uint32_t triangles)
{
    return (triangles + RK_WIDE_BLOCK - 1) / RK_WIDE_BLOCK;
}

/* Of the rays that hit the root, the part that hits a node is proportional to its area. */
static double leaf_cost(const rk_bvh_node *node, uint32_t count)
{
    /* solution */
    if (count > RK_BVH_LEAF_MAX)
        return INFINITY;
    return rk_box_area(node->box) * block_cost * blocks_of(count);
    /* starter
    // First step: a block costs the same however many of its places are taken.
    return node->count ? 0 : INFINITY + 0 * (double)count;
    end */
}

/* Finds the cheapest way to share `children` children among the two halves of a node. */
static double share(plan *p, const plan *left, const plan *right, uint32_t children)
{
    double best = INFINITY;
    /* solution */
    for (uint32_t k = 1; k < children; k++) {
        double cost = left->cost[k] + right->cost[children - k];
        if (cost < best || k == 1) {
            best = cost;
            p->left[children] = (unsigned char)k;
            p->right[children] = (unsigned char)(children - k);
        }
    }
    return best;
    /* starter
    // First step: for now each half is one child, however many there may be.
    (void)left, (void)right;
    p->left[children] = p->right[children] = 1;
    return best;
    end */
}

/* From the leaves up. A node that is kept costs its visit, and its eight children below. What fits
 * a block is a leaf, because smaller ones would waste memory. */
static void make_plan(plan *plans, const rk_bvh *bvh, uint32_t node)
{
    const rk_bvh_node *from = &bvh->nodes[node];
    plan *p = &plans[node];
    *p = (plan){.begin = from->first, .count = from->count, .is_leaf = true};
    if (from->count == 0) {
        make_plan(plans, bvh, from->first);
        make_plan(plans, bvh, from->first + 1);
        p->begin = plans[from->first].begin;
        p->count = plans[from->first].count + plans[from->first + 1].count;
    }
    p->cost[1] = leaf_cost(from, p->count);
    bool splits = from->count == 0 && p->count > RK_WIDE_BLOCK;
    const plan *left = &plans[from->first], *right = left + 1;
    if (splits) {
        double kept = rk_box_area(from->box) * node_cost + share(p, left, right, RK_WIDE_CHILDREN);
        p->is_leaf = p->cost[1] <= kept && p->count <= RK_BVH_LEAF_MAX;
        p->cost[1] = p->is_leaf ? p->cost[1] : kept;
    }
    for (uint32_t i = 2; i < RK_WIDE_CHILDREN; i++) {
        p->cost[i] = splits ? share(p, left, right, i) : INFINITY;
        if (p->cost[i] < p->cost[i - 1])
            continue;
        p->cost[i] = p->cost[i - 1];
        p->left[i] = p->left[i - 1];
        p->right[i] = p->right[i - 1];
    }
}

static void add_children(brood *children, const plan *plans, const rk_bvh *bvh, uint32_t node,
                         uint32_t most)
{
    const plan *p = &plans[node];
    if (p->left[most] == 0) {
        children->nodes[children->count++] = node;
        return;
    }
    add_children(children, plans, bvh, bvh->nodes[node].first, p->left[most]);
    add_children(children, plans, bvh, bvh->nodes[node].first + 1, p->right[most]);
}

/* A root that is a leaf is its own child. */
static brood children_of(const plan *plans, const rk_bvh *bvh, uint32_t node)
{
    brood children = {0};
    add_children(&children, plans, bvh, node, plans[node].is_leaf ? 1 : RK_WIDE_CHILDREN);
    return children;
}

static part_count count_parts(const plan *plans, const rk_bvh *bvh)
{
    uint32_t stack[RK_WIDE_STACK_MAX], size = 0;
    part_count parts = {0, 0};
    stack[size++] = 0;
    while (size) {
        brood children = children_of(plans, bvh, stack[--size]);
        parts.nodes++;
        for (uint32_t i = 0; i < children.count; i++)
            if (plans[children.nodes[i]].is_leaf)
                parts.blocks += blocks_of(plans[children.nodes[i]].count);
            else
                stack[size++] = children.nodes[i];
    }
    return parts;
}

/* --- Blocks ----------------------------------------------------------------------------------- */

static void fill_block(rk_wide_block *block, const rk_triangle *triangles, uint32_t count)
{
    /* solution */
    for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
        const rk_triangle *triangle = &triangles[i < count ? i : count - 1];
        const rk_vec3 corners[3] = {triangle->a, triangle->b, triangle->c};
        for (uint32_t k = 0; k < 3; k++) {
            block->corner[k][0][i] = corners[k].x;
            block->corner[k][1][i] = corners[k].y;
            block->corner[k][2][i] = corners[k].z;
        }
        block->index[i] = triangle->index;
    }
    /* starter
    // Second step: `count` triangles are left for this block and for those behind it. Places for
    // which none is left repeat the last one.
    *block = (rk_wide_block){0};
    (void)triangles, (void)count;
    end */
}

/* Returns the child that stands for a subtree of the binary tree. */
static uint32_t add_leaf(rk_wide_bvh *wide, const rk_bvh *bvh, const plan *p)
{
    uint32_t first = wide->block_count, end = p->begin + p->count;
    for (uint32_t i = p->begin; i < end; i += RK_WIDE_BLOCK)
        fill_block(&wide->blocks[wide->block_count++], &bvh->triangles[i], end - i);
    for (uint32_t i = first; i < wide->block_count; i++)
        rk_wide_block_finish(&wide->blocks[i]);
    return rk_wide_leaf(first, wide->block_count - first);
}

static void put_child(rk_wide_node *node, uint32_t place, const rk_box *box, uint32_t child)
{
    for (uint32_t i = 0; i < 2; i++)
        for (int axis = 0; axis < 3; axis++)
            node->side[i][axis][place] = rk_axis(box->corner[i], axis);
    node->child[place] = child;
}

/* Parents come before their children, and siblings side by side. A node waits for the nodes below
 * its earlier sibling only, so no more wait than a traversal's stack holds. */
static void collapse(rk_wide_bvh *wide, const plan *plans, const rk_bvh *bvh)
{
    const rk_box nothing = rk_box_empty();
    unbuilt stack[RK_WIDE_STACK_MAX];
    uint32_t size = 0;
    stack[size++] = (unbuilt){0, 0};
    wide->node_count = 1;
    wide->box = bvh->nodes[0].box;
    while (size) {
        unbuilt part = stack[--size];
        rk_wide_node *node = &wide->nodes[part.wide];
        brood children = children_of(plans, bvh, part.binary);
        for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
            uint32_t child = i < children.count ? children.nodes[i] : 0;
            if (i >= children.count) {
                put_child(node, i, &nothing, rk_wide_leaf(0, 0));
            } else if (plans[child].is_leaf) {
                put_child(node, i, &bvh->nodes[child].box, add_leaf(wide, bvh, &plans[child]));
            } else {
                stack[size++] = (unbuilt){child, wide->node_count};
                put_child(node, i, &bvh->nodes[child].box, wide->node_count++);
            }
        }
        rk_wide_node_finish(node);
    }
}

bool rk_wide_bvh_build(rk_wide_bvh *wide, const rk_bvh *bvh, rk_error *error)
{
    *wide = (rk_wide_bvh){0};
    if (bvh->node_count == 0)
        return true;
    plan *plans = rk_allocate_unset(bvh->node_count, sizeof *plans, "tree", error);
    if (!plans)
        return false;
    make_plan(plans, bvh, 0);
    part_count parts = count_parts(plans, bvh);
    bool ok = !(parts.blocks >> RK_WIDE_BLOCK_BITS) ||
              rk_fail(error,
                      "tree: %llu blocks of triangles are more than %u: choose a mesh with "
                      "fewer triangles",
                      (unsigned long long)parts.blocks, 1u << RK_WIDE_BLOCK_BITS);
    ok = ok &&
         rk_wide_bvh_init(wide, bvh->triangle_count, parts.nodes, (uint32_t)parts.blocks, error);
    if (ok)
        collapse(wide, plans, bvh);
    free(plans);
    return ok;
}

/* --- Eight boxes ------------------------------------------------------------------------------ */

/* Fills in where the ray enters each child, and sets a bit for each that it enters at t_max or
 * before; rk_box_enter of eight boxes, four at a time. The ray's sign says which sides are near. */
static inline uint32_t enter_children(const rk_wide_node *node, const rk_slabs *slabs, float t_max,
                                      float enter[RK_WIDE_CHILDREN])
{
    /* solution */
    uint32_t entered = 0;
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i += 4) {
        rk_simd4 latest = rk_simd4_all(0), first = rk_simd4_all(t_max);
        for (int axis = 0; axis < 3; axis++) {
            int far = slabs->is_backward[axis] ? 0 : 1;
            rk_simd4 origin = rk_simd4_all(slabs->origin4[axis]);
            rk_simd4 near = rk_simd4_load(&node->side[1 - far][axis][i]) - origin;
            rk_simd4 leave = rk_simd4_load(&node->side[far][axis][i]) - origin;
            latest = rk_simd4_max(near * rk_simd4_all(slabs->inverse_near[axis]), latest);
            first = rk_simd4_min(leave * rk_simd4_all(slabs->inverse_far[axis]), first);
        }
        memcpy(&enter[i], &latest, sizeof latest);
        entered |= rk_simd4_movemask(latest <= first) << i;
    }
    return entered;
    /* starter
    // Third step: rk_box_enter (base/box.h) says how, for one box.
    (void)node, (void)slabs, (void)t_max, (void)enter;
    return 0;
    end */
}

/* --- Traversal -------------------------------------------------------------------------------- */

/* Pushes the children that the ray enters, the nearest last. */
static inline void push_sorted(wide_stack *stack, const rk_wide_node *node, uint32_t entered,
                               const float enter[RK_WIDE_CHILDREN])
{
    /* solution */
    uint32_t bottom = stack->size;
    for (uint32_t i = 0; entered; i++, entered >>= 1) {
        if (!(entered & 1))
            continue;
        uint32_t place = stack->size++;
        for (; place > bottom && stack->entries[place - 1].enter < enter[i]; place--)
            stack->entries[place] = stack->entries[place - 1];
        stack->entries[place].child = node->child[i];
        stack->entries[place].enter = enter[i];
    }
    /* starter
    // Third step: in this order all hits are found, but the far ones first.
    for (uint32_t i = 0; entered; i++, entered >>= 1)
        if (entered & 1) {
            stack->entries[stack->size].child = node->child[i];
            stack->entries[stack->size++].enter = enter[i];
        }
    end */
}

/* Sets a bit for each triangle that the ray may hit up to t_max. */
static inline uint32_t may_hit(const rk_wide_block *block, const rk_ray *ray, float t_max)
{
    rk_simd4x3 corner[3];
    for (int k = 0; k < 3; k++)
        corner[k] =
            (rk_simd4x3){rk_simd4_load(block->corner[k][0]), rk_simd4_load(block->corner[k][1]),
                         rk_simd4_load(block->corner[k][2])};
    return rk_watertight_may_hit(
        rk_simd4x3_sub(rk_simd4x3_all(ray->origin), corner[0]), rk_simd4x3_all(ray->direction),
        rk_simd4_all(rk_watertight_longest(ray)), rk_simd4_all(t_max),
        rk_simd4x3_sub(corner[1], corner[0]), rk_simd4x3_sub(corner[2], corner[0]));
}

static void closest_in_block(const rk_wide_block *block, const rk_ray *ray, rk_hit *hit)
{
    /* solution */
    uint32_t may = may_hit(block, ray, hit->t);
    for (uint32_t i = 0; may; i++, may >>= 1)
        if (may & 1) {
            rk_triangle triangle = rk_wide_triangle(block, i);
            rk_triangle_closest(&triangle, ray, hit);
        }
    /* starter
    // Third step: rk_triangle_closest decides about those that may be hit.
    (void)block, (void)ray, (void)hit;
    end */
}

rk_hit rk_wide_bvh_closest(const rk_wide_bvh *wide, const rk_ray *ray, rk_counters *counters)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    if (wide->node_count == 0)
        return hit;
    /* solution */
    const rk_slabs slabs = rk_slabs_of(ray);
    wide_stack stack;
    stack.size = 1;
    stack.entries[0].child = 0;
    stack.entries[0].enter = 0;
    while (stack.size) {
        uint32_t child = stack.entries[--stack.size].child;
        if (stack.entries[stack.size].enter > hit.t)
            continue;
        if (child & RK_WIDE_LEAF) {
            const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(child)];
            for (uint32_t k = 0; k < rk_wide_leaf_count(child); k++)
                closest_in_block(&block[k], ray, &hit);
            counters->triangle_tests += RK_WIDE_BLOCK * (uint64_t)rk_wide_leaf_count(child);
        } else {
            float enter[RK_WIDE_CHILDREN];
            const rk_wide_node *node = &wide->nodes[child];
            push_sorted(&stack, node, enter_children(node, &slabs, hit.t, enter), enter);
            counters->box_tests += RK_WIDE_CHILDREN;
        }
    }
    /* starter
    // Third step: the root is the first child on the stack. Children that the ray enters beyond
    // the nearest hit need no visit. Count the tests.
    (void)may_hit, (void)enter_children, (void)push_sorted, (void)closest_in_block, (void)counters;
    end */
    return hit;
}

static bool block_occludes(const rk_wide_block *block, const rk_ray *ray)
{
    /* solution */
    uint32_t may = may_hit(block, ray, ray->t_max);
    for (uint32_t i = 0; may; i++, may >>= 1) {
        rk_triangle triangle = rk_wide_triangle(block, i);
        if ((may & 1) && rk_triangle_occludes(&triangle, ray))
            return true;
    }
    return false;
    /* starter
    // Fourth step, by rk_triangle_occludes.
    (void)block, (void)ray;
    return false;
    end */
}

bool rk_wide_bvh_occluded(const rk_wide_bvh *wide, const rk_ray *ray, rk_counters *counters)
{
    if (wide->node_count == 0)
        return false;
    /* solution */
    const rk_slabs slabs = rk_slabs_of(ray);
    wide_stack stack;
    stack.size = 1;
    stack.entries[0].child = 0;
    while (stack.size) {
        uint32_t child = stack.entries[--stack.size].child;
        if (child & RK_WIDE_LEAF) {
            const rk_wide_block *block = &wide->blocks[rk_wide_leaf_first(child)];
            for (uint32_t k = 0; k < rk_wide_leaf_count(child); k++) {
                counters->triangle_tests += RK_WIDE_BLOCK;
                if (block_occludes(&block[k], ray))
                    return true;
            }
        } else {
            float enter[RK_WIDE_CHILDREN];
            const rk_wide_node *node = &wide->nodes[child];
            push_sorted(&stack, node, enter_children(node, &slabs, ray->t_max, enter), enter);
            counters->box_tests += RK_WIDE_CHILDREN;
        }
    }
    return false;
    /* starter
    // Fourth step: as above; the first hit ends the search.
    (void)block_occludes, (void)counters;
    return false;
    end */
}
