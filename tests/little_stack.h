/* How much stack a tree's builder takes: it runs in a thread whose stack is fresh memory, all
 * zeros, and what is not zero afterwards was written. */
#ifndef RK_TESTS_LITTLE_STACK_H
#define RK_TESTS_LITTLE_STACK_H

#include "test.h"

#include "base/error.h"
#include "scene/bvh.h"

#include <pthread.h>
#include <sys/mman.h>

typedef bool tree_builder(rk_bvh *bvh, const rk_mesh *mesh, rk_error *error);

typedef struct build_in_thread {
    tree_builder *build;
    const rk_mesh *mesh;
    rk_bvh bvh;
    rk_error error;
    bool built;
} build_in_thread;

static inline void *build_on_fresh_stack(void *context)
{
    build_in_thread *work = context;
    work->built = work->build(&work->bvh, work->mesh, &work->error);
    return NULL;
}

static inline size_t stack_to_build(const rk_mesh *mesh, tree_builder *build)
{
    const size_t bytes = (size_t)16 << 20, words = bytes / sizeof(uint64_t);
    uint64_t *stack = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    rk_check(stack != MAP_FAILED, "no memory for a stack of %zu bytes", bytes);
    build_in_thread work = {.build = build, .mesh = mesh};
    pthread_attr_t attributes;
    pthread_t thread;
    bool run = pthread_attr_init(&attributes) == 0 &&
               pthread_attr_setstack(&attributes, stack, bytes) == 0 &&
               pthread_create(&thread, &attributes, build_on_fresh_stack, &work) == 0 &&
               pthread_join(thread, NULL) == 0;
    rk_check(run, "no thread could be started: this test cannot tell");
    pthread_attr_destroy(&attributes);
    rk_check_ok(work.built, work.error);
    rk_bvh_free(&work.bvh);
    size_t untouched = 0;
    while (untouched < words && stack[untouched] == 0)
        untouched++;
    munmap(stack, bytes);
    return bytes - untouched * sizeof *stack;
}

/* For each triangle of the larger mesh, of 25,000 or more, a copy of its reference takes 40 bytes,
 * a key 8, a flag 1; a few levels more take a few kB in all. */
static inline void check_stack_does_not_grow(const rk_mesh *small, const rk_mesh *large,
                                             tree_builder *build)
{
    size_t few = stack_to_build(small, build), many = stack_to_build(large, build);
    rk_check(many <= few + 20000,
             "%u triangles took %zu bytes of stack, and %u took %zu: want at most 20,000 more. An "
             "array for all triangles of a node overflows the stack where the mesh is large: move "
             "them in place",
             small->triangle_count, few, large->triangle_count, many);
}

#endif
