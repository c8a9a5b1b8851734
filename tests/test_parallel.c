/* Threads: each item once, with separate storage, and really at the same time. `./configure
 * --enable-sanitizers=thread` finds the errors that this suite cannot. */
#ifdef __linux__
#define _GNU_SOURCE /* sched_setaffinity, pthread_setattr_default_np */
#endif
#include "test.h"

#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <time.h>

enum { most_items = 10000, most_threads = 8 };

typedef struct work_log {
    atomic_uint done[most_items + 1]; /* count per item; the last: out of range */
    unsigned done_by[most_threads];   /* not atomic: each thread has its own counter */
    atomic_uint strangers;            /* calls with a thread number out of range */
    uint32_t threads;
} work_log;

static void write_down(uint32_t index, uint32_t thread, void *context)
{
    work_log *log = context;
    atomic_fetch_add(&log->done[index < most_items ? index : most_items], 1);
    if (thread < log->threads)
        log->done_by[thread]++;
    else
        atomic_fetch_add(&log->strangers, 1);
}

static rk_pool *start(uint32_t threads)
{
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(threads, &error);
    rk_check_ok(pool != NULL, error);
    return pool;
}

static void check_run(rk_pool *pool, uint32_t count)
{
    static work_log log;
    memset(&log, 0, sizeof log);
    log.threads = rk_pool_threads(pool);
    rk_pool_run(pool, count, write_down, &log);
    for (uint32_t i = 0; i <= most_items; i++)
        rk_check(log.done[i] == (i < count), "%u threads, %u items: item %u was done %u times",
                 log.threads, count, i, log.done[i]);
    unsigned sum = 0;
    for (int i = 0; i < most_threads; i++)
        sum += log.done_by[i];
    rk_check_equal(log.strangers, 0, "thread numbers are 0 .. threads - 1");
    rk_check_equal(sum, count, "no two threads use a number at the same time");
}

static void a_pool_has_the_requested_threads(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= most_threads; threads++) {
        rk_pool *pool = start(threads);
        rk_check_equal(rk_pool_threads(pool), threads, "the caller counts");
        rk_pool_stop(pool);
    }
}

static void every_item_is_done_once(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 7, most_items};
    for (uint32_t threads = 1; threads <= most_threads; threads++) {
        rk_pool *pool = start(threads);
        for (int i = 0; i < 4; i++)
            check_run(pool, counts[i]);
        rk_pool_stop(pool);
    }
}

static void a_pool_runs_again_and_again(void **state)
{
    (void)state;
    rk_pool *pool = start(4);
    for (uint32_t round = 0; round < 300; round++)
        check_run(pool, round % 5);
    rk_pool_stop(pool);
}

static void tally(uint32_t index, uint32_t thread, void *context)
{
    (void)thread;
    ((unsigned char *)context)[index]++;
}

static void threads_in_a_hurry_take_no_item_twice(void **state)
{
    (void)state;
    enum { rounds = 100 };
    static unsigned char tallies[most_items];
    rk_pool *pool = start(4);
    for (int round = 0; round < rounds; round++)
        rk_pool_run(pool, most_items, tally, tallies);
    for (int i = 0; i < most_items; i++)
        rk_check_equal(tallies[i], rounds, "items so short that threads meet at the counter");
    rk_pool_stop(pool);
}

static void a_pool_that_never_ran_stops(void **state)
{
    (void)state;
    for (int i = 0; i < 100; i++)
        rk_pool_stop(start(3));
    rk_pool_stop(NULL);
}

typedef struct meeting {
    pthread_mutex_t lock;
    pthread_cond_t arrival;
    uint32_t present, expected;
} meeting;

/* Waits until all threads are here, but not for ever. */
static void meet(uint32_t index, uint32_t thread, void *context)
{
    (void)index, (void)thread;
    meeting *all = context;
    struct timespec deadline;
    clock_gettime(CLOCK_REALTIME, &deadline);
    deadline.tv_sec += 300; /* a busy machine takes seconds */
    pthread_mutex_lock(&all->lock);
    all->present++;
    pthread_cond_broadcast(&all->arrival);
    while (all->present < all->expected)
        if (pthread_cond_timedwait(&all->arrival, &all->lock, &deadline) != 0)
            break;
    pthread_mutex_unlock(&all->lock);
}

static void the_items_run_at_the_same_time(void **state)
{
    (void)state;
    rk_pool *pool = start(4);
    meeting all = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0, 4};
    time_t begin = time(NULL);
    rk_pool_run(pool, 4, meet, &all);
    rk_check(time(NULL) - begin < 9, "each of four threads should take one of four items");
    rk_pool_stop(pool);
}

static void write_plainly(uint32_t index, uint32_t thread, void *context)
{
    (void)thread;
    ((uint32_t *)context)[index] = index + 1;
}

static void the_caller_sees_what_the_threads_wrote(void **state)
{
    (void)state;
    static uint32_t results[most_items];
    rk_pool *pool = start(4);
    rk_pool_run(pool, most_items, write_plainly, results);
    for (uint32_t i = 0; i < most_items; i++)
        rk_check_equal(results[i], i + 1, "a run returns when all is done");
    rk_pool_stop(pool);
}

static void zero_threads_means_one_for_each_processor(void **state)
{
    (void)state;
    rk_check(rk_processor_count() >= 1 && rk_processor_count() <= RK_THREADS_MAX, "%u processors",
             rk_processor_count());
    rk_pool *pool = start(0);
    rk_check_equal(rk_pool_threads(pool), rk_processor_count(), "0 means all");
    rk_pool_stop(pool);
}

static void too_many_threads_are_refused(void **state)
{
    (void)state;
    const uint32_t counts[] = {RK_THREADS_MAX + 1, UINT32_MAX};
    for (int i = 0; i < 2; i++) {
        rk_error error = {""};
        rk_check(rk_pool_start(counts[i], &error) == NULL, "%u threads were started", counts[i]);
        rk_check_error_names(error, "1024");
    }
}

#ifdef __linux__
static void only_processors_available_to_this_process_count(void **state)
{
    (void)state;
    cpu_set_t before, one;
    rk_check(sched_getaffinity(0, sizeof before, &before) == 0, "the set can be read");
    CPU_ZERO(&one);
    for (size_t i = 0; CPU_COUNT(&one) == 0; i++)
        if (CPU_ISSET(i, &before))
            CPU_SET(i, &one);
    rk_check(sched_setaffinity(0, sizeof one, &one) == 0, "the set can be made smaller");
    uint32_t count = rk_processor_count();
    sched_setaffinity(0, sizeof before, &before);
    rk_check_equal(count, 1, "bound to one processor");
}
#endif

#ifdef __GLIBC__
static void note_stack(uint32_t index, uint32_t thread, void *context)
{
    (void)index;
    pthread_attr_t attributes;
    size_t size = 0;
    if (pthread_getattr_np(pthread_self(), &attributes) == 0) {
        pthread_attr_getstacksize(&attributes, &size);
        pthread_attr_destroy(&attributes);
    }
    atomic_size_t *least = context;
    if (thread > 0)
        atomic_store(least, size);
}

/* Some systems give a thread 128 KB. */
static void threads_have_two_megabytes_of_stack_or_the_larger_default(void **state)
{
    (void)state;
    const size_t megabyte = 1 << 20, defaults[] = {megabyte / 8, 16 * megabyte};
    const size_t want[] = {2 * megabyte, 16 * megabyte};
    for (int i = 0; i < 2; i++) {
        pthread_attr_t before, given;
        pthread_getattr_default_np(&before);
        pthread_attr_init(&given);
        pthread_attr_setstacksize(&given, defaults[i]);
        rk_check(pthread_setattr_default_np(&given) == 0, "the default can be set");
        rk_pool *pool = start(2);
        pthread_setattr_default_np(&before);
        atomic_size_t got = 0;
        while (got == 0) /* until the second thread gets an item */
            rk_pool_run(pool, 100, note_stack, &got);
        rk_pool_stop(pool);
        rk_check(got >= want[i] - megabyte / 8, "a default of %zu KB gave a stack of %zu KB",
                 defaults[i] / 1024, (size_t)got / 1024);
    }
}

static void a_system_that_refuses_threads_is_an_error(void **state)
{
    (void)state;
    pthread_attr_t before, huge;
    pthread_getattr_default_np(&before);
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, (size_t)1 << 50); /* more than the address space */
    rk_check(pthread_setattr_default_np(&huge) == 0, "the default can be set");
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(3, &error);
    pthread_setattr_default_np(&before);
    rk_check(!pool, "threads with stacks of 2^50 bytes were started");
    rk_check_error_names(error, "thread 2 of 3");
    rk_check_error_names(error, "--threads");
}
#endif

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_pool_has_the_requested_threads),
    cmocka_unit_test(every_item_is_done_once),
    cmocka_unit_test(a_pool_runs_again_and_again),
    cmocka_unit_test(threads_in_a_hurry_take_no_item_twice),
    cmocka_unit_test(a_pool_that_never_ran_stops),
    cmocka_unit_test(the_items_run_at_the_same_time),
    cmocka_unit_test(the_caller_sees_what_the_threads_wrote),
    cmocka_unit_test(zero_threads_means_one_for_each_processor),
    cmocka_unit_test(too_many_threads_are_refused),
#ifdef __linux__
    cmocka_unit_test(only_processors_available_to_this_process_count),
#endif
#ifdef __GLIBC__
    cmocka_unit_test(threads_have_two_megabytes_of_stack_or_the_larger_default),
    cmocka_unit_test(a_system_that_refuses_threads_is_an_error),
#endif
};

RK_SUITE("parallel", tests)
