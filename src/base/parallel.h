/* Work divided among threads: a pool that hands out the numbers 0 .. count - 1. */
#ifndef RK_BASE_PARALLEL_H
#define RK_BASE_PARALLEL_H

#include "base/team.h"

#include <stdint.h>

typedef struct rk_pool rk_pool;

/* Processes item `index`; `thread`, in 0 .. threads - 1, selects a thread's own storage. */
typedef void rk_task(uint32_t index, uint32_t thread, void *context);

/* The number of processors that this process may use, at least 1. */
uint32_t rk_processor_count(void);

enum { RK_THREADS_MAX = 1024 };

/* Starts threads - 1 threads; the caller is the last one. 0 means rk_processor_count().
 * NULL with an error when the system refuses. */
rk_pool *rk_pool_start(uint32_t threads, rk_error *error);

/* Ends the threads; accepts NULL. */
void rk_pool_stop(rk_pool *pool);

uint32_t rk_pool_threads(const rk_pool *pool);

/* Renderings by this pool are shared with other processes, of the team that it joined; NULL: they
 * are not. */
void rk_pool_join(rk_pool *pool, rk_team *team);
rk_team *rk_pool_team(const rk_pool *pool);

/* Every thread increments the counter once beyond the last item, so this many fit 32 bits. */
#define RK_POOL_ITEMS_MAX (UINT32_MAX - RK_THREADS_MAX)

/* Runs task(0) .. task(count - 1), each once, in no fixed order, and returns when all are done.
 * `count` is at most RK_POOL_ITEMS_MAX. One run at a time, from the thread that started the pool.
 */
void rk_pool_run(rk_pool *pool, uint32_t count, rk_task *task, void *context);

#endif
