/* A pool of POSIX threads around one atomic counter: an idle thread takes the next number. */
#ifdef __linux__
#define _GNU_SOURCE /* sched_getaffinity */
#endif
#include "base/parallel.h"

#include "base/table.h"

#include <assert.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct rk_pool {
    uint32_t threads; /* the caller included */
    rk_team *team;
    uint32_t started; /* running entries of `workers` */
    pthread_t *workers;
    pthread_mutex_t lock;
    pthread_cond_t wake, done;
    double awake_seconds; /* how long a thread waits before it sleeps */
    atomic_uint round;    /* grows by one with each run */
    atomic_uint working;  /* workers that take part in this round, and have not finished it */
    bool open;            /* whether workers may still join it */
    bool stopping;
    atomic_uint next;
    uint32_t count;
    rk_task *task;
    void *context;
};

typedef struct worker_start {
    rk_pool *pool;
    uint32_t thread;
} worker_start;

uint32_t rk_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
#ifdef __linux__
    /* taskset, batch systems and containers may restrict a process to some of the processors. */
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0)
        count = CPU_COUNT(&allowed);
#endif
    return count < 1 ? 1 : count > RK_THREADS_MAX ? RK_THREADS_MAX : (uint32_t)count;
}

static void take_items(rk_pool *pool, uint32_t thread)
{
    for (;;) {
        uint32_t index = atomic_fetch_add(&pool->next, 1);
        if (index >= pool->count)
            return;
        pool->task(index, thread, pool->context);
    }
}

/* Waits awake for a moment, until the number is or is not `value`: to wake up a sleeping thread
 * takes longer than a short round, most of all on a virtual machine. */
static void watch(const rk_pool *pool, const atomic_uint *number, unsigned value, bool is_awaited)
{
    const double start = rk_clock_wall();
    while ((atomic_load_explicit(number, memory_order_acquire) == value) != is_awaited &&
           rk_clock_wall() - start < pool->awake_seconds)
        ;
}

static void *work(void *argument)
{
    worker_start start = *(worker_start *)argument;
    free(argument);
    rk_pool *pool = start.pool;
    unsigned seen = 0;
    for (;;) {
        watch(pool, &pool->round, seen, false);
        pthread_mutex_lock(&pool->lock);
        while (pool->round == seen && !pool->stopping)
            pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->stopping)
            break;
        seen = pool->round;
        const bool joins = pool->open; /* no longer, if it took long to wake up */
        pool->working += joins;
        pthread_mutex_unlock(&pool->lock);
        if (joins) {
            take_items(pool, start.thread);
            pthread_mutex_lock(&pool->lock);
            if (--pool->working == 0)
                pthread_cond_signal(&pool->done);
            pthread_mutex_unlock(&pool->lock);
        }
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* The system's default may be as little as 128 KB, and a picture with all features takes a MB. */
enum { least_stack = 2 << 20 };

static int start_thread(pthread_t *thread, void *argument)
{
    pthread_attr_t attributes;
    int failure = pthread_attr_init(&attributes);
    if (failure)
        return failure;
    size_t stack = 0;
    pthread_attr_getstacksize(&attributes, &stack);
    if (stack < least_stack)
        failure = pthread_attr_setstacksize(&attributes, least_stack);
    if (!failure)
        failure = pthread_create(thread, &attributes, work, argument);
    pthread_attr_destroy(&attributes);
    return failure;
}

static bool start_worker(rk_pool *pool, uint32_t thread, rk_error *error)
{
    worker_start *start = malloc(sizeof *start);
    if (!start)
        return rk_fail(error, "threads: no memory");
    *start = (worker_start){pool, thread};
    int failure = start_thread(&pool->workers[pool->started], start);
    if (failure) {
        free(start);
        return rk_fail(error, "thread %u of %u cannot be started: %s; choose fewer with --threads",
                       thread + 1, pool->threads, strerror(failure));
    }
    pool->started++;
    return true;
}

rk_pool *rk_pool_start(uint32_t threads, rk_error *error)
{
    if (threads == 0)
        threads = rk_processor_count();
    if (threads > RK_THREADS_MAX) {
        rk_fail(error, "%u threads: choose at most %d", threads, RK_THREADS_MAX);
        return NULL;
    }
    rk_pool *pool = rk_allocate(1, sizeof *pool, "threads", error);
    if (!pool)
        return NULL;
    pool->threads = threads;
    /* Of more threads than processors, those that wait would keep the others from work. */
    pool->awake_seconds = threads > rk_processor_count() ? 0 : 50e-6;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    pool->workers = rk_allocate(threads, sizeof *pool->workers, "threads", error);
    bool ok = pool->workers != NULL;
    for (uint32_t i = 1; ok && i < threads; i++)
        ok = start_worker(pool, i, error);
    if (!ok) {
        rk_pool_stop(pool);
        return NULL;
    }
    return pool;
}

void rk_pool_stop(rk_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 0; i < pool->started; i++)
        pthread_join(pool->workers[i], NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->lock);
    free(pool->workers);
    free(pool);
}

uint32_t rk_pool_threads(const rk_pool *pool)
{
    return pool->threads;
}

void rk_pool_join(rk_pool *pool, rk_team *team)
{
    pool->team = team;
}

rk_team *rk_pool_team(const rk_pool *pool)
{
    return pool->team;
}

void rk_pool_run(rk_pool *pool, uint32_t count, rk_task *task, void *context)
{
    assert(count <= RK_POOL_ITEMS_MAX && "the item counter must not wrap around");
    pthread_mutex_lock(&pool->lock);
    pool->count = count;
    pool->task = task;
    pool->context = context;
    atomic_store(&pool->next, 0);
    pool->open = true;
    pool->round++;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    take_items(pool, 0);
    pthread_mutex_lock(&pool->lock);
    pool->open = false;
    pthread_mutex_unlock(&pool->lock);
    watch(pool, &pool->working, 0, true);
    pthread_mutex_lock(&pool->lock);
    while (pool->working)
        pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}
