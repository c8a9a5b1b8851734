/* base/parallel.h where there are no threads: the caller does all work, in order. */
#include "base/parallel.h"

#include <stdlib.h>

struct rk_pool {
    uint32_t threads;
};

uint32_t rk_processor_count(void)
{
    return 1;
}

rk_pool *rk_pool_start(uint32_t threads, rk_error *error)
{
    (void)threads;
    rk_pool *pool = rk_allocate(1, sizeof *pool, "threads", error);
    if (pool)
        pool->threads = 1;
    return pool;
}

void rk_pool_stop(rk_pool *pool)
{
    free(pool);
}

uint32_t rk_pool_threads(const rk_pool *pool)
{
    return pool->threads;
}

void rk_pool_join(rk_pool *pool, rk_team *team)
{
    (void)pool;
    (void)team;
}

rk_team *rk_pool_team(const rk_pool *pool)
{
    (void)pool;
    return NULL;
}

void rk_pool_run(rk_pool *pool, uint32_t count, rk_task *task, void *context)
{
    (void)pool;
    for (uint32_t i = 0; i < count; i++)
        task(i, 0, context);
}
