/* A bounding volume hierarchy sorts triangles into a tree of boxes, so that a ray that misses a box
 * misses everything in it. This one splits every node at the median of its longest axis: half of
 * the triangles go left, half right, whatever their shape.
 * Kay and Kajiya, "Ray tracing complex scenes", 1986; Pharr, Jakob, Humphreys, "Physically Based
 * Rendering", 4th edition, section 7.3. */
#include "features/bvh_median.h"

#include "base/random.h"
#include "scene/bvh_build.h"

#include <stdlib.h>
#include <string.h>

/* Contents, in the order of the chapter. */
static rk_box box_of(const rk_bvh_reference *references, const uint64_t *keys, uint32_t count);
static uint32_t split_at_median(const rk_bvh_reference *references, uint64_t *keys, uint32_t count,
                                const rk_box *box);
static uint32_t split_range_at_median(void *context, uint32_t begin, uint32_t count,
                                      uint32_t depth_left, rk_box *box);
static void fill_leaves(rk_bvh *bvh, const rk_mesh *mesh, const uint64_t *keys);
static inline uint64_t sort_key(float coordinate, uint32_t triangle);
static inline uint32_t triangle_of(uint64_t key);
static void select_lowest(uint64_t *keys, uint32_t count, uint32_t wanted);
static void sort_few(uint64_t *keys, uint32_t count);
static inline void swap_keys(uint64_t *a, uint64_t *b);
static inline const rk_bvh_node *push_far_return_near(rk_traversal_stack *stack,
                                                      const rk_bvh_node *children,
                                                      const rk_slabs *slabs, float t_max);
static inline const rk_bvh_node *pop_nearer(rk_traversal_stack *stack, float t_max);

/* --- Building --------------------------------------------------------------------------------- */

static rk_box box_of(const rk_bvh_reference *references, const uint64_t *keys, uint32_t count)
{
    /* solution */
    rk_box box = rk_box_empty();
    for (uint32_t i = 0; i < count; i++)
        box = rk_box_merge(box, references[triangle_of(keys[i])].box);
    return box;
    /* starter
    // First step: the smallest box around the boxes of all these triangles.
    return rk_box_empty();
    end */
}

/* Orders keys so that the lower half, ceil(count / 2) of them, comes first; returns its size. */
static uint32_t split_at_median(const rk_bvh_reference *references, uint64_t *keys, uint32_t count,
                                const rk_box *box)
{
    /* solution */
    int axis = rk_box_longest_axis(*box);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t triangle = triangle_of(keys[i]);
        keys[i] = sort_key(rk_axis(references[triangle].centroid, axis), triangle);
    }
    uint32_t half = count - count / 2;
    select_lowest(keys, count, half);
    return half;
    /* starter
    // Second step: give each triangle its sort key on the longest axis of the box, then select.
    return count;
    end */
}

/* A node that still has no box, over `count` triangles from `begin` on. */
typedef struct unbuilt {
    uint32_t node, begin, count;
    uint32_t depth_left; /* levels that may follow below */
} unbuilt;

/* The stack never holds more entries than the tree has levels. */
void rk_bvh_build_nodes(rk_bvh *bvh, rk_bvh_split split, void *builder)
{
    /* solution */
    unbuilt stack[RK_BVH_LEVELS_MAX];
    uint32_t size = 0;
    stack[size++] = (unbuilt){0, 0, bvh->triangle_count, RK_BVH_LEVELS_MAX - 1};
    bvh->node_count = 2;
    while (size) {
        unbuilt part = stack[--size];
        rk_bvh_node *node = &bvh->nodes[part.node];
        uint32_t left_count = split(builder, part.begin, part.count, part.depth_left, &node->box);
        if (left_count == 0 || part.depth_left == 0) {
            node->first = part.begin;
            node->count = part.count;
            continue;
        }
        uint32_t left = bvh->node_count, levels = part.depth_left - 1;
        bvh->node_count += 2;
        node->first = left;
        node->count = 0;
        stack[size++] =
            (unbuilt){left + 1, part.begin + left_count, part.count - left_count, levels};
        stack[size++] = (unbuilt){left, part.begin, left_count, levels};
    }
    /* starter
    // First step: the root is a leaf with all triangles; `split` gives it its box. Second step:
    // where `split` returns more than 0, and levels may follow, reserve two children and build
    // them likewise.
    bvh->node_count = 2;
    bvh->nodes[0] = (rk_bvh_node){rk_box_empty(), 0, bvh->triangle_count};
    end */
}

/* The context of split_range_at_median. */
typedef struct median_builder {
    const rk_bvh_reference *references;
    uint64_t *keys;
} median_builder;

/* Halving 2^32 triangles down to leaves takes 31 levels, so depth_left needs no check. */
static uint32_t split_range_at_median(void *context, uint32_t begin, uint32_t count,
                                      uint32_t depth_left, rk_box *box)
{
    const median_builder *builder = context;
    (void)depth_left;
    *box = box_of(builder->references, builder->keys + begin, count);
    if (count <= RK_BVH_LEAF_TARGET)
        return 0;
    return split_at_median(builder->references, builder->keys + begin, count, box);
}

/* Copies the triangles in the order of the leaves, so that a leaf reads one range of memory. */
static void fill_leaves(rk_bvh *bvh, const rk_mesh *mesh, const uint64_t *keys)
{
    for (uint32_t i = 0; i < bvh->triangle_count; i++)
        bvh->triangles[i] = rk_bvh_triangle_of(mesh, triangle_of(keys[i]));
}

bool rk_bvh_build_median(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error)
{
    uint32_t count = mesh->triangle_count;
    if (!rk_bvh_init(bvh, count, count, error) || count == 0)
        return count == 0 && bvh->nodes;
    rk_bvh_reference *references = rk_allocate_unset(count, sizeof *references, "tree", error);
    uint64_t *keys = rk_allocate_unset(count, sizeof *keys, "tree", error);
    bool ok = references && keys;
    if (ok) {
        for (uint32_t i = 0; i < count; i++) {
            references[i] = rk_bvh_reference_of(mesh, i);
            keys[i] = i;
        }
        rk_bvh_build_nodes(bvh, split_range_at_median, &(median_builder){references, keys});
        fill_leaves(bvh, mesh, keys);
    } else {
        rk_bvh_free(bvh);
    }
    free(references);
    free(keys);
    return ok;
}

/* --- Selecting -------------------------------------------------------------------------------- */

/* A triangle's sort key on an axis: the centroid's coordinate in the upper half, the triangle's
 * index in the lower. One comparison then orders all triangles strictly, even if centroids
 * coincide, and the tree is the same on every machine. The bits of floats sort as integers once all
 * bits of negative floats are flipped, and the sign bit of the others. */
static inline uint64_t sort_key(float coordinate, uint32_t triangle)
{
    uint32_t bits;
    memcpy(&bits, &coordinate, sizeof bits);
    bits ^= bits >> 31 ? 0xffffffffu : 0x80000000u;
    return (uint64_t)bits << 32 | triangle;
}

static inline uint32_t triangle_of(uint64_t key)
{
    return (uint32_t)key;
}

/* Moves the `wanted` lowest keys to the front (Hoare's FIND). A hash picks the pivots, so that no
 * order of the mesh is slow: linear time on average. The partition (Lomuto's) moves every key and
 * adds the result of the comparison, because a branch on it could not be predicted. */
static void select_lowest(uint64_t *keys, uint32_t count, uint32_t wanted)
{
    /* solution */
    const uint32_t few = 16; /* sorting so few costs less than partitioning them */
    uint32_t begin = 0, end = count;
    while (end - begin > few) {
        swap_keys(&keys[begin], &keys[begin + rk_hash(begin, end, 0, 0) % (end - begin)]);
        uint64_t pivot = keys[begin];
        uint32_t boundary = begin; /* keys[begin + 1 .. boundary] are below the pivot */
        for (uint32_t i = begin + 1; i < end; i++) {
            uint64_t key = keys[i];
            keys[i] = keys[boundary + 1];
            keys[boundary + 1] = key;
            boundary += key < pivot;
        }
        swap_keys(&keys[begin], &keys[boundary]);
        if (wanted <= boundary)
            end = boundary;
        else
            begin = boundary + 1;
    }
    sort_few(keys + begin, end - begin);
    /* starter
    // Third step: nothing moves yet. Sorting all keys by sort_few would be right, but far too
    // slow.
    end */
}

static void sort_few(uint64_t *keys, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t j = i; j > 0 && keys[j] < keys[j - 1]; j--)
            swap_keys(&keys[j], &keys[j - 1]);
}

static inline void swap_keys(uint64_t *a, uint64_t *b)
{
    uint64_t t = *a;
    *a = *b;
    *b = t;
}

/* --- Traversal -------------------------------------------------------------------------------- */

/* Returns the child that the ray enters first and pushes the other one, which a hit in the first
 * may make unnecessary. NULL if the ray enters neither. A miss is INFINITY, which is no greater
 * than a t_max of INFINITY: compare with INFINITY itself. */
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
    // Fourth step: rk_box_enter returns the t at which a ray enters a box, INFINITY for a miss.
    // Push one of two entered children and return the other. Fifth step: return the nearer.
    return NULL;
    end */
}

/* Pops nodes down to one that the ray enters at t_max or before; NULL if none is left. */
static inline const rk_bvh_node *pop_nearer(rk_traversal_stack *stack, float t_max)
{
    /* solution */
    while (stack->size)
        if (stack->entries[--stack->size].enter <= t_max)
            return stack->entries[stack->size].node;
    return NULL;
    /* starter
    // Fourth step: pop a node. Fifth step: those that the ray enters beyond t_max need no visit.
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
        } else {
            rk_triangles_closest(&bvh->triangles[node->first], node->count, ray, &hit);
        }
        triangle_tests += node->count;
        node = next ? next : pop_nearer(&stack, hit.t);
    }
    counters->box_tests += box_tests;
    counters->triangle_tests += triangle_tests;
    /* starter
    // Fourth step: traverse from the root; leaves by rk_triangles_closest. Count the tests.
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
        } else {
            uint32_t first_hit =
                rk_triangles_first_hit(&bvh->triangles[node->first], node->count, ray);
            found = first_hit < node->count;
            triangle_tests += first_hit + found;
        }
        node = next ? next : pop_nearer(&stack, ray->t_max);
    }
    counters->box_tests += box_tests;
    counters->triangle_tests += triangle_tests;
    return found;
    /* starter
    // Sixth step: as above, by rk_triangles_first_hit. The first hit ends the search.
    return false;
    end */
}
