/* Memory that runs out: in the program of a suite that includes this, the n-th allocation fails. */
#ifndef RK_TESTS_SHORT_MEMORY_H
#define RK_TESTS_SHORT_MEMORY_H

#include "test.h"

#include "base/error.h"
#include "scene/bvh.h"

/* Replaces the library's, through which rk_allocate goes as well. */
void *rk_allocate_unset(size_t count, size_t size, const char *what, rk_error *error)
{
    size_t lines = (count * size + 63) / 64, bytes = 64 * (lines ? lines : 1);
    void *memory = rk_scarce_aligned_alloc(64, bytes);
    if (!memory)
        rk_fail(error, "%s: no memory, as this test demands", what);
    return memory;
}

/* A builder that goes on without memory, with a larger leaf, say, returns true and another tree. */
static inline void check_same_tree(const rk_bvh *got, const rk_bvh *want, size_t granted)
{
    rk_check(got->node_count == want->node_count,
             "allocation %zu failed: got true with a tree of %u nodes, want false, or the same %u "
             "nodes as with enough memory",
             granted + 1, got->node_count, want->node_count);
    for (uint32_t i = 0; i < got->node_count; i += i ? 1 : 2) /* node 1 is unused */
        rk_check(memcmp(&got->nodes[i], &want->nodes[i], sizeof got->nodes[i]) == 0,
                 "allocation %zu failed: got true with a tree whose node %u is another than with "
                 "enough memory, want false",
                 granted + 1, i);
}

/* `build` makes a tree over a mesh, and is called with memory for no allocation, then for one, and
 * so on, in larger steps after the 16th, until it succeeds. Each time before it returns false,
 * leaves a sentence in the error and an empty tree, and keeps nothing. */
static inline void check_allocations_failing(const rk_mesh *mesh,
                                             bool (*build)(rk_bvh *bvh, const rk_mesh *mesh,
                                                           rk_error *error))
{
    bool built = false;
    rk_bvh want = {0};
    rk_error no_memory = {""};
    rk_check_ok(build(&want, mesh, &no_memory), no_memory);
    for (size_t granted = 0; !built; granted += 1 + granted / 16) {
        rk_bvh bvh = {0};
        rk_error error = {""};
        size_t before = rk_allocations_kept;
        rk_allocations_left = granted;
        built = build(&bvh, mesh, &error);
        rk_allocations_left = SIZE_MAX;
        if (built) {
            rk_check(granted > 2,
                     "%zu allocations were enough, want more than 2: this test cannot tell",
                     granted);
            rk_check(bvh.nodes && bvh.triangles, "got no tree, but true");
            check_same_tree(&bvh, &want, granted);
            rk_bvh_free(&bvh);
        } else {
            rk_check(granted < 100000, "it failed, though %zu allocations succeeded: %s", granted,
                     error.text);
            rk_check(error.text[0],
                     "allocation %zu failed: got false, but no sentence in the error", granted + 1);
            rk_check(!bvh.nodes && !bvh.triangles && bvh.node_count == 0,
                     "allocation %zu failed: got false, but not an empty tree: rk_bvh_free makes "
                     "one of what there is",
                     granted + 1);
        }
        size_t kept = rk_allocations_kept - before;
        rk_check(
            kept == 0,
            "allocation %zu failed: %zu of the earlier ones are kept, want 0: free each of them "
            "before returning false",
            granted + 1, kept);
    }
    rk_bvh_free(&want);
}

/* With the later allocations failing, too, and with only one that fails. */
static inline void check_every_allocation_failing(const rk_mesh *mesh,
                                                  bool (*build)(rk_bvh *bvh, const rk_mesh *mesh,
                                                                rk_error *error))
{
    check_allocations_failing(mesh, build);
    rk_one_allocation_fails = true;
    check_allocations_failing(mesh, build);
    rk_one_allocation_fails = false;
}

#endif
