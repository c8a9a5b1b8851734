/* Memory that runs out: in the program of a suite that includes this, the n-th allocation fails. */
#ifndef RK_TESTS_SHORT_MEMORY_H
#define RK_TESTS_SHORT_MEMORY_H

#include "test.h"

#include "base/error.h"
#include "scene/bvh.h"

/* The allocations that still succeed. */
static size_t allocations_left = SIZE_MAX;

/* Replaces the library's, through which rk_allocate goes as well. */
void *rk_allocate_unset(size_t count, size_t size, const char *what, rk_error *error)
{
    if (allocations_left == 0) {
        rk_fail(error, "%s: no memory, as this test demands", what);
        return NULL;
    }
    allocations_left--;
    return aligned_alloc(64, (count * size + 64) / 64 * 64);
}

/* `build` makes a tree over a mesh, and is called with memory for no allocation, then for one, and
 * so on, until it succeeds. Each time before it returns false, leaves a sentence in the error, and
 * keeps nothing. */
static inline void check_every_allocation_failing(const rk_mesh *mesh,
                                                  bool (*build)(rk_bvh *bvh, const rk_mesh *mesh,
                                                                rk_error *error))
{
    bool built = false;
    for (size_t granted = 0; !built; granted++) {
        rk_bvh bvh = {0};
        rk_error error = {""};
        size_t before = rk_allocations_kept;
        allocations_left = granted;
        built = build(&bvh, mesh, &error);
        allocations_left = SIZE_MAX;
        if (built) {
            rk_check(granted > 2,
                     "%zu allocations were enough, want more than 2: this test cannot tell",
                     granted);
            rk_check(bvh.nodes && bvh.triangles, "got no tree, but true");
            rk_bvh_free(&bvh);
        } else {
            rk_check(granted < 100, "it failed, though 100 allocations succeeded: %s", error.text);
            rk_check(error.text[0],
                     "allocation %zu failed: got false, but no sentence in the error", granted + 1);
        }
        size_t kept = rk_allocations_kept - before;
        rk_check(
            kept == 0,
            "allocation %zu failed: %zu of the earlier ones are kept, want 0: free each of them "
            "before returning false",
            granted + 1, kept);
    }
}

#endif
