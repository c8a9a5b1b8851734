/* A bounding volume hierarchy sorts triangles into a tree of boxes, so that a ray which misses a
 * box misses all that is in it. This one cuts every node at the median of its longest axis: half
 * of the triangles go left, half right, whatever they look like.
 * Kay and Kajiya, "Ray tracing complex scenes", 1986; Pharr, Jakob, Humphreys, "Physically Based
 * Rendering", 4th edition, section 7.3. */
#include "features/bvh_median.h"

#include "base/random.h"
#include "scene/bvh_build.h"

#include <stdlib.h>
#include <string.h>

/* Contents, in the order of the chapter. */
static rk_box box_of(const rk_bvh_reference *references, const uint64_t *ranks, uint32_t count);
static uint32_t split_at_median(const rk_bvh_reference *references, uint64_t *ranks, uint32_t count,
                                const rk_box *box);
static uint32_t split_range_at_median(void *context, uint32_t begin, uint32_t count,
                                      uint32_t depth_left, rk_box *box);
static void fill_leaves(rk_bvh *bvh, const rk_mesh *mesh, const uint64_t *ranks);
static inline uint64_t sort_key(float coordinate, uint32_t triangle);
static inline uint32_t triangle_of(uint64_t rank);
static void select_lowest(uint64_t *ranks, uint32_t count, uint32_t wanted);
static void sort_few(uint64_t *ranks, uint32_t count);
static inline void swap_keys(uint64_t *a, uint64_t *b);
static inline const rk_bvh_node *push_far_return_near(rk_traversal_stack *stack,
                                                      const rk_bvh_node *children,
                                                      const rk_slabs *slabs, float t_max);
static inline const rk_bvh_node *pop_nearer(rk_traversal_stack *stack, float t_max);

/* --- Building --------------------------------------------------------------------------------- */

static rk_box box_of(const rk_bvh_reference *references, const uint64_t *ranks, uint32_t count)
{
    /* solution */
    rk_box box = rk_box_empty();
    for (uint32_t i = 0; i < count; i++)
        box = rk_box_merge(box, references[triangle_of(ranks[i])].box);
    return box;
    /* starter
    // First step: the smallest box around the boxes of all these triangles.
    return rk_box_empty();
    end */
}

/* Orders ranks so that the lower half, ceil(count / 2) of them, comes first; returns its size. */
static uint32_t split_at_median(const rk_bvh_reference *references, uint64_t *ranks, uint32_t count,
                                const rk_box *box)
{
    /* solution */
    int axis = rk_box_longest_axis(*box);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t triangle = triangle_of(ranks[i]);
        ranks[i] = sort_key(rk_axis(references[triangle].centroid, axis), triangle);
    }
    uint32_t half = count - count / 2;
    select_lowest(ranks, count, half);
    return half;
    /* starter
    // Second step: give each triangle its rank along the longest axis of the box, then select.
    return count;
    end */
}

/* A node that still has no box, over `count` triangles from `begin` on. */
typedef struct unbuilt {
    uint32_t node, begin, count;
    uint32_t depth_left; /* that there may be */
} unbuilt;

/* The stack never holds more than one node a level, and the last one's sibling. */
void rk_bvh_build_nodes(rk_bvh *bvh, rk_bvh_split cut, void *builder)
{
    /* solution */
    unbuilt stack[RK_BVH_LEVELS_MAX];
    uint32_t size = 0;
    stack[size++] = (unbuilt){0, 0, bvh->triangle_count, RK_BVH_LEVELS_MAX - 1};
    bvh->node_count = 2;
    while (size) {
        unbuilt part = stack[--size];
        rk_bvh_node *node = &bvh->nodes[part.node];
        uint32_t half = cut(builder, part.begin, part.count, part.depth_left, &node->box);
        if (half == 0) {
            node->first = part.begin;
            node->count = part.count;
            continue;
        }
        uint32_t left = bvh->node_count, levels = part.depth_left - 1;
        bvh->node_count += 2;
        node->first = left;
        node->count = 0;
        stack[size++] = (unbuilt){left + 1, part.begin + half, part.count - half, levels};
        stack[size++] = (unbuilt){left, part.begin, half, levels};
    }
    /* starter
    // First step: the root is a leaf with all triangles in it; `cut` gives it its box. Second step:
    // where `cut` returns more than 0, reserve two children, and build them in the same way.
    bvh->node_count = 2;
    bvh->nodes[0] = (rk_bvh_node){rk_box_empty(), 0, bvh->triangle_count};
    end */
}

/* What cuts nodes at the median. */
typedef struct median_builder {
    const rk_bvh_reference *references;
    uint64_t *ranks;
} median_builder;

/* Halving 2^32 triangles takes 31 levels, so there are always enough below. */
static uint32_t split_range_at_median(void *context, uint32_t begin, uint32_t count,
                                      uint32_t depth_left, rk_box *box)
{
    const median_builder *builder = context;
    (void)depth_left;
    *box = box_of(builder->references, builder->ranks + begin, count);
    if (count <= RK_BVH_LEAF_TARGET)
        return 0;
    return split_at_median(builder->references, builder->ranks + begin, count, box);
}

/* Copies the triangles in the order of the leaves, so that a leaf reads one stretch of memory. */
static void fill_leaves(rk_bvh *bvh, const rk_mesh *mesh, const uint64_t *ranks)
{
    for (uint32_t i = 0; i < bvh->triangle_count; i++)
        bvh->triangles[i] = rk_bvh_triangle_of(mesh, triangle_of(ranks[i]));
}

bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    uint32_t count = mesh->triangle_count;
    if (!rk_bvh_init(bvh, count, count, error) || count == 0)
        return count == 0 && bvh->nodes;
    rk_bvh_reference *references = rk_allocate_unset(count, sizeof *references, "tree", error);
    uint64_t *ranks = rk_allocate_unset(count, sizeof *ranks, "tree", error);
    bool ok = references && ranks;
    if (ok) {
        for (uint32_t i = 0; i < count; i++) {
            references[i] = rk_bvh_reference_of(mesh, i);
            ranks[i] = i;
        }
        rk_bvh_build_nodes(bvh, split_range_at_median, &(median_builder){references, ranks});
        fill_leaves(bvh, mesh, ranks);
    } else {
        rk_bvh_free(bvh);
    }
    free(references);
    free(ranks);
    return ok;
}

/* --- Selecting -------------------------------------------------------------------------------- */

/* A triangle's rank along an axis, as one integer: the centroid's coordinate above, the triangle's
 * index below. One comparison then orders all triangles strictly, coinciding centroids too, and
 * the tree is the same on every machine. A float's bits order like an integer once negative values
 * are flipped whole and the others in their sign. */
static inline uint64_t sort_key(float coordinate, uint32_t triangle)
{
    uint32_t bits;
    memcpy(&bits, &coordinate, sizeof bits);
    bits ^= bits >> 31 ? 0xffffffffu : 0x80000000u;
    return (uint64_t)bits << 32 | triangle;
}

static inline uint32_t triangle_of(uint64_t rank)
{
    return (uint32_t)rank;
}

/* Moves the `wanted` lowest ranks to the front (Hoare's FIND). A hash picks the pivots, so that no
 * order in which a mesh comes is a slow one: linear time on average. The partition (Lomuto's)
 * moves every rank and counts, where a branch could not be predicted. */
static void select_lowest(uint64_t *ranks, uint32_t count, uint32_t wanted)
{
    /* solution */
    const uint32_t few = 16; /* sorting these costs less than choosing pivots among them */
    uint32_t begin = 0, end = count;
    while (end - begin > few) {
        swap_keys(&ranks[begin], &ranks[begin + rk_hash(begin, end, 0, 0) % (end - begin)]);
        uint64_t pivot = ranks[begin];
        uint32_t cut = begin; /* ranks[begin + 1 .. cut] are below the pivot */
        for (uint32_t i = begin + 1; i < end; i++) {
            uint64_t rank = ranks[i];
            ranks[i] = ranks[cut + 1];
            ranks[cut + 1] = rank;
            cut += rank < pivot;
        }
        swap_keys(&ranks[begin], &ranks[cut]);
        if (wanted <= cut)
            end = cut;
        else
            begin = cut + 1;
    }
    sort_few(ranks + begin, end - begin);
    /* starter
    // Third step: nothing moves yet. Sorting them all, sort_few, would be right, but far too slow.
    end */
}

static void sort_few(uint64_t *ranks, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t j = i; j > 0 && ranks[j] < ranks[j - 1]; j--)
            swap_keys(&ranks[j], &ranks[j - 1]);
}

static inline void swap_keys(uint64_t *a, uint64_t *b)
{
    uint64_t t = *a;
    *a = *b;
    *b = t;
}

/* --- Traversal -------------------------------------------------------------------------------- */

/* Of the two children, the one that the ray enters first: what lies in it may spare us the other,
 * which is pushed. NULL if the ray enters neither. Not entered is INFINITY, which is no greater
 * than a t_max of infinity: compare with INFINITY itself. */
static inline const rk_bvh_node *push_far_return_near(rk_traversal_stack *stack,
                                                      const rk_bvh_node *children,
                                                      const rk_slabs *slabs, float t_max)
{
    /* solution */
    const rk_bvh_node *near = &children[0], *far = &children[1];
    float enter_near = rk_box_enter(&near->box, slabs, t_max);
    float enter_far = rk_box_enter(&far->box, slabs, t_max);
    if (enter_far < enter_near) {
        near = &children[1], far = &children[0];
        float t = enter_near;
        enter_near = enter_far;
        enter_far = t;
    }
    if (enter_far < INFINITY) {
        stack->entries[stack->size].node = far;
        stack->entries[stack->size++].enter = enter_far;
    }
    return enter_near < INFINITY ? near : NULL;
    /* starter
    // Fourth step: rk_box_enter tells where a ray enters a box; INFINITY says that it does not.
    return NULL;
    end */
}

/* The last of those that the ray enters at t_max or before, or NULL. */
static inline const rk_bvh_node *pop_nearer(rk_traversal_stack *stack, float t_max)
{
    /* solution */
    while (stack->size)
        if (stack->entries[--stack->size].enter <= t_max)
            return stack->entries[stack->size].node;
    return NULL;
    /* starter
    // Fourth step: what the ray enters only behind t_max is not worth a visit.
    return NULL;
    end */
}

rk_hit rk_bvh_closest(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    if (bvh->node_count == 0)
        return hit;
    /* solution */
    const rk_slabs slabs = rk_slabs_of(ray);
    rk_traversal_stack stack;
    stack.size = 0;
    uint64_t box_tests = 1, triangle_tests = 0;
    const rk_bvh_node *root = &bvh->nodes[0];
    const rk_bvh_node *node = rk_box_enter(&root->box, &slabs, hit.t) < INFINITY ? root : NULL;
    while (node) {
        const rk_bvh_node *next = NULL;
        if (node->count == 0) {
            next = push_far_return_near(&stack, &bvh->nodes[node->first], &slabs, hit.t);
            box_tests += 2;
        }
        for (uint32_t i = 0; i < node->count; i++)
            rk_triangle_closest(&bvh->triangles[node->first + i], ray, &hit);
        triangle_tests += node->count;
        node = next ? next : pop_nearer(&stack, hit.t);
    }
    counters->box_tests += box_tests;
    counters->triangle_tests += triangle_tests;
    /* starter
    // Fourth step: from the root down, leaves by rk_triangle_closest. Count the tests.
    end */
    return hit;
}

bool rk_bvh_occluded(const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{
    if (bvh->node_count == 0)
        return false;
    /* solution */
    const rk_slabs slabs = rk_slabs_of(ray);
    rk_traversal_stack stack;
    stack.size = 0;
    uint64_t box_tests = 1, triangle_tests = 0;
    bool found = false;
    const rk_bvh_node *root = &bvh->nodes[0];
    const rk_bvh_node *node = rk_box_enter(&root->box, &slabs, ray->t_max) < INFINITY ? root : NULL;
    while (node && !found) {
        const rk_bvh_node *next = NULL;
        if (node->count == 0) {
            next = push_far_return_near(&stack, &bvh->nodes[node->first], &slabs, ray->t_max);
            box_tests += 2;
        }
        for (uint32_t i = 0; i < node->count && !found; i++) {
            found = rk_triangle_occludes(&bvh->triangles[node->first + i], ray);
            triangle_tests++;
        }
        node = next ? next : pop_nearer(&stack, ray->t_max);
    }
    counters->box_tests += box_tests;
    counters->triangle_tests += triangle_tests;
    return found;
    /* starter
    // Fifth step: as above, by rk_triangle_occludes. The first triangle found ends the search.
    return false;
    end */
}
