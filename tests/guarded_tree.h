/* A copy of a tree with each pair of nodes and each leaf on memory pages of its own, all closed
 * until a test opens them. A traversal that reads one that needs no look is stopped there, whatever
 * it counts. */
#ifndef RK_TESTS_GUARDED_TREE_H
#define RK_TESTS_GUARDED_TREE_H

#include "test.h"

#include "base/box.h"
#include "base/counters.h"
#include "scene/bvh.h"

#include <sys/mman.h>
#include <unistd.h>

/* The address sanitizer names the line that reads closed memory; without it, the system's page
 * protection ends the test. */
#ifdef __ELF__
__attribute__((weak)) void __asan_poison_memory_region(const volatile void *start, size_t size);
__attribute__((weak)) void __asan_unpoison_memory_region(const volatile void *start, size_t size);
#else
static void (*const __asan_poison_memory_region)(const volatile void *, size_t);
static void (*const __asan_unpoison_memory_region)(const volatile void *, size_t);
#endif

static inline void guard_close(void *pages, size_t bytes)
{
    rk_check(mprotect(pages, bytes, PROT_NONE) == 0, "%zu bytes cannot be closed", bytes);
    if (__asan_poison_memory_region)
        __asan_poison_memory_region(pages, bytes);
}

static inline void guard_open(void *pages, size_t bytes)
{
    if (__asan_unpoison_memory_region)
        __asan_unpoison_memory_region(pages, bytes);
    rk_check(mprotect(pages, bytes, PROT_READ | PROT_WRITE) == 0, "%zu bytes cannot be opened",
             bytes);
}

typedef struct guarded_tree {
    const rk_bvh *original;
    rk_bvh copy;
    size_t page, node_bytes, triangle_bytes;
} guarded_tree;

/* Where a node and a leaf's first triangle of the original are in the copy. */
static inline uint32_t guarded_node(const guarded_tree *tree, uint32_t node)
{
    return node / 2 * (uint32_t)(tree->page / sizeof(rk_bvh_node)) + node % 2;
}

static inline uint32_t guarded_triangle(const guarded_tree *tree, uint32_t first)
{
    /* A page is a power of two, so this many triangles of 40 bytes are five pages. */
    return first * (uint32_t)(tree->page / 8);
}

static inline void guarded_close(guarded_tree *tree)
{
    guard_close(tree->copy.nodes, tree->node_bytes);
    guard_close(tree->copy.triangles, tree->triangle_bytes);
}

static inline void *guarded_pages(size_t bytes)
{
    void *pages = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    rk_check(pages != MAP_FAILED, "no memory for %zu bytes", bytes);
    return pages;
}

/* The original is a valid tree, and is kept as long as the copy. */
static inline guarded_tree guard_tree(const rk_bvh *original)
{
    guarded_tree tree = {.original = original, .page = (size_t)sysconf(_SC_PAGESIZE)};
    tree.copy.node_count = guarded_node(&tree, original->node_count);
    tree.copy.triangle_count = guarded_triangle(&tree, original->triangle_count);
    tree.node_bytes = tree.copy.node_count * sizeof *tree.copy.nodes;
    tree.triangle_bytes = tree.copy.triangle_count * sizeof *tree.copy.triangles;
    tree.copy.nodes = guarded_pages(tree.node_bytes);
    tree.copy.triangles = guarded_pages(tree.triangle_bytes);
    for (uint32_t i = 0; i < original->node_count; i += i ? 1 : 2) { /* node 1 is unused */
        rk_bvh_node *node = &tree.copy.nodes[guarded_node(&tree, i)];
        *node = original->nodes[i];
        node->first =
            node->count ? guarded_triangle(&tree, node->first) : guarded_node(&tree, node->first);
        if (node->count)
            memcpy(&tree.copy.triangles[node->first],
                   &original->triangles[original->nodes[i].first],
                   node->count * sizeof(rk_triangle));
    }
    guarded_close(&tree);
    return tree;
}

static inline void guarded_free(guarded_tree *tree)
{
    guard_open(tree->copy.nodes, tree->node_bytes);
    guard_open(tree->copy.triangles, tree->triangle_bytes);
    munmap(tree->copy.nodes, tree->node_bytes);
    munmap(tree->copy.triangles, tree->triangle_bytes);
}

/* Opens the contents of boxes that the ray enters at t or before, and their children's boxes;
 * returns the tests that looking at all of it takes, without the root's box. */
static inline rk_counters guarded_open_below(guarded_tree *tree, uint32_t node,
                                             const rk_slabs *slabs, float t)
{
    const rk_bvh_node *original = &tree->original->nodes[node];
    rk_counters tests = {0};
    if (!(rk_box_enter(&original->box, slabs, t) < INFINITY))
        return tests;
    if (original->count) {
        guard_open(&tree->copy.triangles[guarded_triangle(tree, original->first)], tree->page);
        tests.triangle_tests = original->count;
        return tests;
    }
    guard_open(&tree->copy.nodes[guarded_node(tree, original->first)], tree->page);
    tests.box_tests = 2;
    for (uint32_t child = original->first; child < original->first + 2; child++) {
        rk_counters below = guarded_open_below(tree, child, slabs, t);
        tests.box_tests += below.box_tests;
        tests.triangle_tests += below.triangle_tests;
    }
    return tests;
}

/* Closes all, then opens what a ray needs that looks no farther than t. Returns the tests that
 * looking at all of it takes. */
static inline rk_counters guarded_open_for(guarded_tree *tree, const rk_ray *ray, float t)
{
    const rk_slabs slabs = rk_slabs_of(ray);
    guarded_close(tree);
    guard_open(tree->copy.nodes, tree->page);
    rk_counters tests = guarded_open_below(tree, 0, &slabs, t);
    tests.box_tests++;
    return tests;
}

#endif
