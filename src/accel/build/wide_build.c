/* Parts are split until a node has eight children, always the child with the largest area first.
 * The top of the tree is built alone; parts below it are tasks for threads, whose subtrees are then
 * appended in order: the tree is the same for any number of threads. */
#include "accel/build/wide_build.h"

#include <stdlib.h>

enum {
    tasks_max = 1 << 14,    /* enough for 100 million triangles */
    tasks_wanted = 32,      /* so many that threads end at nearly the same time */
    smallest_task = 1 << 9, /* triangles; a mesh of less than eight such is built in one piece */
};

/* A part of the tree, whose children and leaves count from its own first node and block. */
typedef struct subtree {
    rk_bvh_part part;
    rk_wide_node *nodes;
    rk_wide_block *blocks;
    uint32_t node_count, node_room, block_count, block_room;
    uint32_t parent, place;           /* the child of the top that it is */
    bool shares_nodes, shares_blocks; /* in memory of all tasks, see share_memory */
    bool failed;                      /* memory was short */
} subtree;

typedef struct wide_builder {
    const rk_mesh *mesh;
    const rk_bvh_parts *parts;
    uint32_t task_size; /* parts up to this size are tasks; 0: none is */
    uint32_t task_count;
    rk_wide_node *nodes; /* that tasks share */
    rk_wide_block *blocks;
    subtree tasks[tasks_max];
} wide_builder;

/* --- Memory ----------------------------------------------------------------------------------- */

/* Of scanned surfaces there are a seventeenth as many nodes as triangles, and a quarter as many
 * blocks. */
static uint32_t node_guess(const subtree *tree)
{
    return tree->part.count / 14 + 4;
}

static uint32_t block_guess(const subtree *tree)
{
    return tree->part.count / 7 * 2 + 4;
}

/* Makes room for one more element; it moves the others. The first room is a guess. */
static void *grow(void *elements, uint32_t count, uint32_t *room, uint32_t guess, size_t size,
                  bool *is_shared)
{
    if (count < *room)
        return elements;
    rk_error error = {{0}};
    const uint32_t more = *room == 0 ? guess : *room + *room / 2;
    void *moved = rk_allocate_unset(more, size, "tree", &error);
    if (!moved)
        return NULL;
    if (count)
        memcpy(moved, elements, count * size);
    if (!*is_shared)
        free(elements);
    *is_shared = false;
    *room = more;
    return moved;
}

static bool reserve_node(subtree *tree)
{
    void *nodes = grow(tree->nodes, tree->node_count, &tree->node_room, node_guess(tree),
                       sizeof *tree->nodes, &tree->shares_nodes);
    tree->failed = !nodes;
    tree->nodes = nodes ? nodes : tree->nodes;
    return nodes;
}

static bool reserve_block(subtree *tree)
{
    void *blocks = grow(tree->blocks, tree->block_count, &tree->block_room, block_guess(tree),
                        sizeof *tree->blocks, &tree->shares_blocks);
    tree->failed = !blocks;
    tree->blocks = blocks ? blocks : tree->blocks;
    return blocks;
}

/* --- Leaves ----------------------------------------------------------------------------------- */

/* Places from `count` on repeat the last triangle. */
static void fill_block(rk_wide_block *block, const wide_builder *b, const rk_bvh_part *part,
                       uint32_t first)
{
    for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
        const uint32_t last = part->count - 1, at = first + i < last ? first + i : last;
        const uint32_t triangle = rk_bvh_part_triangle(b->parts, part, at);
        block->index[i] = triangle;
        for (int k = 0; k < 3; k++) {
            const rk_vec3 corner = b->mesh->positions[b->mesh->triangles[triangle][k]];
            block->corner[k][0][i] = corner.x;
            block->corner[k][1][i] = corner.y;
            block->corner[k][2][i] = corner.z;
        }
    }
    rk_wide_block_finish(block);
}

static bool add_leaf(subtree *tree, const wide_builder *b, const rk_bvh_part *part, uint32_t *child)
{
    const uint32_t first = tree->block_count;
    for (uint32_t i = 0; i < part->count; i += RK_WIDE_BLOCK) {
        if (!reserve_block(tree))
            return false;
        fill_block(&tree->blocks[tree->block_count++], b, part, i);
    }
    *child = rk_wide_leaf(first, tree->block_count - first);
    return true;
}

/* --- Nodes ------------------------------------------------------------------------------------ */

typedef struct part_family {
    uint32_t count;
    rk_bvh_part parts[RK_WIDE_CHILDREN];
    float area[RK_WIDE_CHILDREN]; /* 0: cannot be split */
} part_family;

static void set_member(part_family *family, uint32_t i, const rk_bvh_part *part,
                       const rk_bvh_parts *parts)
{
    family->parts[i] = *part;
    family->area[i] = part->count > RK_WIDE_BLOCK ? rk_bvh_part_area(parts, part) : -1;
}

static uint32_t largest_member(const part_family *family)
{
    uint32_t largest = 0;
    for (uint32_t i = 1; i < family->count; i++)
        if (family->area[i] > family->area[largest])
            largest = i;
    return largest;
}

/* Splits a part in up to eight, always the one that most rays hit. */
static void split_in_eight(const rk_bvh_parts *parts, const rk_bvh_part halves[2],
                           part_family *family)
{
    family->count = 2;
    set_member(family, 0, &halves[0], parts);
    set_member(family, 1, &halves[1], parts);
    while (family->count < RK_WIDE_CHILDREN) {
        const uint32_t i = largest_member(family);
        rk_bvh_part two[2];
        if (family->area[i] < 0 || !rk_bvh_part_split(parts, &family->parts[i], two))
            return;
        set_member(family, i, &two[0], parts);
        set_member(family, family->count++, &two[1], parts);
    }
}

static void put_child(rk_wide_node *node, uint32_t place, const rk_box *box, uint32_t child)
{
    for (int side = 0; side < 2; side++)
        for (int axis = 0; axis < 3; axis++)
            node->side[side][axis][place] = rk_axis(box->corner[side], axis);
    node->child[place] = child;
}

static bool add_part(subtree *tree, wide_builder *b, const rk_bvh_part *part, uint32_t *child);

/* A child that becomes a task is filled in later. */
static bool is_task(subtree *tree, wide_builder *b, const rk_bvh_part *part, uint32_t node,
                    uint32_t place)
{
    if (tree != &b->tasks[0] || part->count > b->task_size || part->count <= RK_PART_LEAF_MAX ||
        b->task_count == tasks_max)
        return false;
    b->tasks[b->task_count++] = (subtree){.part = *part, .parent = node, .place = place};
    return true;
}

static bool add_node(subtree *tree, wide_builder *b, const rk_bvh_part halves[2], uint32_t *child)
{
    const rk_box nothing = rk_box_empty();
    const uint32_t node = tree->node_count;
    part_family family;
    if (!reserve_node(tree))
        return false;
    tree->node_count++;
    *child = node;
    split_in_eight(b->parts, halves, &family);
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        const bool is_child = i < family.count;
        const rk_box box = is_child ? rk_bvh_part_box(&family.parts[i]) : nothing;
        put_child(&tree->nodes[node], i, &box, rk_wide_leaf(0, 0));
    }
    for (uint32_t i = 0; i < family.count; i++) {
        uint32_t below = 0;
        if (is_task(tree, b, &family.parts[i], node, i))
            continue;
        if (!add_part(tree, b, &family.parts[i], &below))
            return false;
        tree->nodes[node].child[i] = below; /* the nodes may have moved */
    }
    rk_wide_node_finish(&tree->nodes[node]);
    return true;
}

/* Recurses no deeper than RK_BVH_LEVELS_MAX. */
static bool add_part(subtree *tree, wide_builder *b, const rk_bvh_part *part, uint32_t *child)
{
    rk_bvh_part halves[2];
    if (rk_bvh_part_split(b->parts, part, halves) &&
        rk_bvh_part_should_split(b->parts, part, halves))
        return add_node(tree, b, halves, child);
    return add_leaf(tree, b, part, child);
}

/* The root is a node, so a root that is a leaf is its only child. */
static bool build_root(subtree *tree, wide_builder *b)
{
    uint32_t child;
    if (!add_part(tree, b, &tree->part, &child) || !(child & RK_WIDE_LEAF))
        return !tree->failed;
    const rk_box nothing = rk_box_empty(), box = rk_bvh_part_box(&tree->part);
    if (!reserve_node(tree))
        return false;
    tree->node_count = 1;
    put_child(&tree->nodes[0], 0, &box, child);
    for (uint32_t i = 1; i < RK_WIDE_CHILDREN; i++)
        put_child(&tree->nodes[0], i, &nothing, rk_wide_leaf(0, 0));
    rk_wide_node_finish(&tree->nodes[0]);
    return true;
}

/* --- All together ----------------------------------------------------------------------------- */

static void run_task(uint32_t index, uint32_t thread, void *context)
{
    wide_builder *b = context;
    (void)thread;
    build_root(&b->tasks[index + 1], b);
}

/* The tree's memory, of which each task gets a part, so that new pages, which take time, are not
 * taken twice. Without it each task makes its own room. */
static void share_memory(wide_builder *b)
{
    size_t nodes = b->tasks[0].node_count, blocks = b->tasks[0].block_count;
    rk_error error = {{0}};
    for (uint32_t i = 1; i < b->task_count; i++) {
        nodes += node_guess(&b->tasks[i]);
        blocks += block_guess(&b->tasks[i]);
    }
    b->nodes = rk_allocate_unset(nodes, sizeof *b->nodes, "tree", &error);
    b->blocks = b->nodes ? rk_allocate_unset(blocks, sizeof *b->blocks, "tree", &error) : NULL;
    nodes = b->tasks[0].node_count;
    blocks = b->tasks[0].block_count;
    for (uint32_t i = 1; b->blocks && i < b->task_count; i++) {
        subtree *tree = &b->tasks[i];
        tree->nodes = b->nodes + nodes;
        tree->blocks = b->blocks + blocks;
        nodes += tree->node_room = node_guess(tree);
        blocks += tree->block_room = block_guess(tree);
        tree->shares_nodes = tree->shares_blocks = true;
    }
}

static void free_tasks(wide_builder *b)
{
    for (uint32_t i = 0; i < b->task_count; i++) {
        if (!b->tasks[i].shares_nodes)
            free(b->tasks[i].nodes);
        if (!b->tasks[i].shares_blocks)
            free(b->tasks[i].blocks);
    }
    free(b->nodes);
    free(b->blocks);
}

/* A child of a subtree, counted from the first node and block of all. */
static uint32_t moved_child(uint32_t child, uint32_t nodes_before, uint32_t blocks_before)
{
    const bool is_empty = child == rk_wide_leaf(0, 0);
    return is_empty ? child : child + (child & RK_WIDE_LEAF ? blocks_before : nodes_before);
}

/* The top's nodes come first, then the subtrees', in order; in shared memory they move down. */
static void append(rk_wide_bvh *wide, const subtree *tree)
{
    const uint32_t nodes = wide->node_count, blocks = wide->block_count;
    for (uint32_t i = 0; i < tree->node_count; i++) {
        rk_wide_node *node = &wide->nodes[nodes + i];
        *node = tree->nodes[i];
        for (int k = 0; k < RK_WIDE_CHILDREN; k++)
            node->child[k] = moved_child(node->child[k], nodes, blocks);
    }
    if (tree->block_count)
        memmove(&wide->blocks[blocks], tree->blocks, tree->block_count * sizeof *tree->blocks);
    wide->node_count += tree->node_count;
    wide->block_count += tree->block_count;
}

/* Can subtrees move down one after the other, none of them to where the next ones still are? */
static bool fits_shared_memory(const wide_builder *b)
{
    uint64_t nodes = b->tasks[0].node_count, blocks = b->tasks[0].block_count;
    uint64_t node_room = nodes, block_room = blocks;
    bool fits = b->blocks;
    for (uint32_t i = 1; i < b->task_count; i++) {
        nodes += b->tasks[i].node_count;
        blocks += b->tasks[i].block_count;
        node_room += node_guess(&b->tasks[i]);
        block_room += block_guess(&b->tasks[i]);
        fits &= nodes <= node_room && blocks <= block_room;
    }
    return fits;
}

static bool count_all(const wide_builder *b, uint32_t *node_count, uint32_t *block_count,
                      rk_error *error)
{
    uint64_t nodes = 0, blocks = 0;
    for (uint32_t i = 0; i < b->task_count; i++) {
        if (b->tasks[i].failed)
            return rk_fail(error,
                           "tree: no memory for %u triangles: choose a smaller mesh, or close "
                           "other programs",
                           b->tasks[0].part.count);
        nodes += b->tasks[i].node_count;
        blocks += b->tasks[i].block_count;
    }
    *node_count = (uint32_t)nodes;
    *block_count = (uint32_t)blocks;
    return blocks >> RK_WIDE_BLOCK_BITS == 0 ||
           rk_fail(error,
                   "tree: %llu blocks of triangles are more than %u: choose a mesh with "
                   "fewer triangles",
                   (unsigned long long)blocks, 1u << RK_WIDE_BLOCK_BITS);
}

static bool join(rk_wide_bvh *wide, wide_builder *b, rk_error *error)
{
    const bool in_place = fits_shared_memory(b);
    uint32_t nodes = 0, blocks = 0;
    if (!count_all(b, &nodes, &blocks, error))
        return false;
    *wide = (rk_wide_bvh){.triangle_count = b->tasks[0].part.count};
    if (in_place) {
        wide->nodes = b->nodes;
        wide->blocks = b->blocks;
        b->nodes = NULL;
        b->blocks = NULL;
    } else if (!rk_wide_bvh_init(wide, b->tasks[0].part.count, nodes, blocks, error)) {
        return false;
    }
    wide->box = rk_bvh_part_box(&b->tasks[0].part);
    for (uint32_t i = 0; i < b->task_count; i++) {
        const subtree *tree = &b->tasks[i];
        if (i > 0)
            wide->nodes[tree->parent].child[tree->place] = wide->node_count;
        append(wide, tree);
    }
    return true;
}

/* The same for any number of threads, so that the tree is, too. Never so large that the pool would
 * split the task: it is busy with the tasks. */
static uint32_t task_size(uint32_t count)
{
    const uint32_t size = count / tasks_wanted;
    return count < 8 * smallest_task ? 0
           : size < smallest_task    ? smallest_task
           : size < RK_PART_LARGE    ? size
                                     : RK_PART_LARGE - 1;
}

static void build_subtrees(wide_builder *b, const rk_bvh_part *root, rk_pool *pool)
{
    b->task_size = task_size(root->count);
    b->task_count = 1;
    b->tasks[0] = (subtree){.part = *root};
    b->nodes = NULL;
    b->blocks = NULL;
    build_root(&b->tasks[0], b);
    if (b->task_count > 1)
        share_memory(b);
    if (pool && b->task_count > 1)
        rk_pool_run(pool, b->task_count - 1, run_task, b);
    else
        for (uint32_t i = 0; i + 1 < b->task_count; i++)
            run_task(i, 0, b);
}

bool rk_wide_bvh_build_parts(rk_wide_bvh *wide, const rk_mesh *mesh, uint32_t first, uint32_t count,
                             rk_build_quality quality, rk_pool *pool, rk_error *error)
{
    *wide = (rk_wide_bvh){0};
    if (count == 0)
        return true;
    wide_builder *b = rk_allocate_unset(1, sizeof *b, "tree", error);
    rk_bvh_part root;
    rk_bvh_parts *parts =
        b ? rk_bvh_parts_start(mesh, first, count, quality, pool, &root, error) : NULL;
    bool ok = parts;
    if (ok) {
        b->mesh = mesh;
        b->parts = parts;
        build_subtrees(b, &root, pool);
        rk_bvh_parts_free(parts);
        ok = join(wide, b, error);
        free_tasks(b);
    }
    free(b);
    return ok;
}
